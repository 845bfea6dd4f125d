#include <memory>
#include <string>
#include <utility>

#include "tools/brittle/commands/command_line.h"
#include "tools/brittle/commands/option_groups.h"
#include "tools/brittle/commands/option_values.h"

namespace brittle::tools {

void add_demo(CLI::App& app, Run& run) {
    const auto command = std::make_shared<DemoCommand>();
    command->fracture.mesh = "shape:animal";
    CLI::App& demo = *app.add_subcommand(
        "demo", "Break meshes in a window with tools, panels and a preview. Space breaks, H lists all keys.");
    add_fracture_options(demo, command->fracture);
    add_pieces_option(demo, command->fracture);
    demo.get_option("mesh")->capture_default_str();
    add_world_options(demo, command->fracture.world);
    start_group(demo, "Window");
    demo.add_option("--ui-scale", command->ui_scale,
                    "Scale of text and panels; 2 suits a display of high density. The default is the display's.")
        ->check(number_from(0.5, 4.0));
    add_record_option(demo, command->record);
    add_view_options(demo, command->view);
    add_threads_option(demo, command->fracture.threads);
    add_classify_option(demo, command->classify);
    add_general_options(demo, nullptr);
    demo.footer("Examples:\n"
                "  brittle demo\n"
                "  brittle demo bunny.obj --material glass -n 200\n"
                "  brittle demo shape:wall --material brick --bonded --anchored\n"
                "  brittle demo assets/worlds/room_with_a_view.json --record run.log");
    demo.callback([&run, &demo, command] {
        refuse_standard_input(demo, command->fracture.mesh);
        command->recipe = recipe_file(demo);
        run = [command] {
            command->fracture = scene_of_pieces(std::move(command->fracture));
            return run_demo(*command);
        };
    });
}

} // namespace brittle::tools
