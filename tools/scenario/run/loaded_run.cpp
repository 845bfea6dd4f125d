#include "tools/scenario/run/loaded_run.h"

#include "tools/scenario/run/stage_placement.h"

namespace brittle::tools {

namespace {

// An object as it is known after the start: without bodies.
PreparedObject description_of(const PreparedObject& object) {
    return {.name = object.name,
            .fragments = object.fragments,
            .surface = object.surface,
            .world = object.world,
            .material = object.material,
            .rigid = object.rigid,
            .looks = object.looks,
            .placement = object.placement};
}

} // namespace

std::string LoadedRun::name() const {
    return of_scene() ? std::to_string(scene.objects.size()) + " objects" : source.name;
}

void LoadedRun::start(Simulation& simulation, const Host& host, const std::function<void(double)>& progress) {
    objects_.clear();
    if (!of_scene()) {
        simulation.start(*fragments, world);
        objects_.push_back({.name = source.name, .fragments = fragments, .world = world, .material = recipe.material});
        return;
    }
    std::vector<PreparedObject> objects = prepare_scene(scene, host, {}, progress);
    for (const PreparedObject& object : objects) objects_.push_back(description_of(object));
    simulation.start(std::move(objects), scene.world);
}

LoadedRun load_run(const FractureOptions& recipe, const Host& host, bool with_looks,
                   const std::function<void(double)>& progress) {
    LoadedRun run;
    run.recipe = recipe;
    if (run.of_scene()) {
        run.scene = load_scene(recipe, host, nullptr, with_looks);
        return run;
    }
    run.source = load_input(recipe, with_looks, host);
    run.input = placed_on_stage(run.source, recipe.world);
    run.fragments = std::make_shared<const fracture::Fragments>(
        break_input(run.input, recipe, progress, nullptr, host.cancelled).fragments);
    run.world = world_of(recipe, run.input.scale);
    return run;
}

} // namespace brittle::tools
