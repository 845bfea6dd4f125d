#include "engine/core/window.h"
#include "tools/brittle/base/console.h"
#include "tools/brittle/base/device_failure.h"
#include "tools/brittle/base/interrupt.h"
#include "tools/brittle/commands/commands.h"
#include "tools/brittle/pictures/view.h"
#include "tools/brittle/stage/classify_choice.h"
#include "tools/brittle/studio/studio.h"
#include "tools/brittle/studio/style.h"
#include "tools/scenario/base/failure.h"
#include "tools/scenario/recipe/recipe.h"
#include "tools/scenario/run/scene.h"

namespace brittle::tools {

int run_demo(const DemoCommand& command) {
    catch_interrupts();
    const auto window =
        must(engine::Window::create({.title = "Brittle", .width = command.view.width, .height = command.view.height}));
    FractureOptions options = command.fracture;
    for (const std::string& note : expand_level(options)) tell("%s", note.c_str());
    const auto object = Object::open(options);
    if (!options.save_recipe.empty()) write_recipe(options.save_recipe, options);
    const std::unique_ptr<engine::Device> device = open_device(command.view);
    {
        const ClassifyPath path = object->is_scene() ? ClassifyPath::cpu : classify_path(command.classify);
        const Input input = object->is_scene() ? Input{} : object->with_sites(options);
        const ClassifyChoice choice = choose_classifier(path, *device, input, options);
        tell("classification on the %s", choice.why.c_str());
        const auto renderer = must(engine::Renderer::create(*device, renderer_settings(command.view)));
        const float scale = command.ui_scale > 0.0 ? static_cast<float>(command.ui_scale) : window->content_scale();
        must(renderer->attach(*window, [scale] { apply_style(scale); }));
        must(renderer->warm_up()); // before there are pieces, which it would draw
        Session session(options, object, *renderer, choice.classifier.get());
        if (!command.record.empty()) session.files().record(command.record);
        session.recipe_file = command.recipe;
        Studio(*window, *device, *renderer, session, scale).run();
        session.files().finish_recording();
    }
    check_validation(*device);
    return exit_success;
}

} // namespace brittle::tools
