// The run of a recipe: its mesh or its scene, broken where it starts in pieces, in a simulation.
//
//     LoadedRun run = load_run(options, host);
//     Simulation simulation(options.material);
//     run.start(simulation, host);
#pragma once

#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "fracture/mesh/mesh.h"
#include "fracture/pieces/fragments.h"
#include "tools/scenario/recipe/host.h"
#include "tools/scenario/recipe/input.h"
#include "tools/scenario/recipe/world_options.h"
#include "tools/scenario/run/scene.h"
#include "tools/scenario/run/simulation.h"

namespace brittle::tools {

struct LoadedRun {
    FractureOptions recipe{};
    // Of one mesh: in the coordinates of its file, and on the stage.
    Input source{}, input{};
    std::shared_ptr<const fracture::Fragments> fragments{}; // of one mesh, on the stage
    WorldOptions world{};                                   // of one mesh
    LoadedScene scene{};

    [[nodiscard]] bool of_scene() const { return is_scene(recipe); }
    [[nodiscard]] std::string name() const; // for people

    // Starts the run in a simulation that nobody draws. `progress` is that of prepare_scene(). Throws a Failure.
    void start(Simulation& simulation, const Host& host = {}, const std::function<void(double)>& progress = {});

    // The objects of the last start, without their bodies; one for a mesh.
    [[nodiscard]] const std::vector<PreparedObject>& objects() const { return objects_; }

  private:
    std::vector<PreparedObject> objects_{};
};

// Loads a recipe, and breaks the mesh of one that is no scene. `with_looks` is that of load_input() and load_scene(),
// `progress` that of break_input(). Throws a Failure.
[[nodiscard]] LoadedRun load_run(const FractureOptions& recipe, const Host& host = {}, bool with_looks = false,
                                 const std::function<void(double)>& progress = {});

} // namespace brittle::tools
