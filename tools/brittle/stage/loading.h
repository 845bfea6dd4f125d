// Meshes and scenes for the program: Ctrl+C ends their loading within half a second, wherever it is, and a note on
// standard error says what was done to a file.
//
//     const Host host = drawing_host();
//     LoadedScene scene = open_scene(options, host);
//     stage.stand(prepare_scene(scene, host, payload_maker(renderer)), scene.world);
#pragma once

#include "tools/scenario/recipe/host.h"
#include "tools/scenario/recipe/input.h"
#include "tools/scenario/run/scene.h"

namespace brittle::tools {

[[nodiscard]] Host program_host(); // without looks, for scenes that nobody draws
[[nodiscard]] Host drawing_host();

// As load_input() and load_scene().
[[nodiscard]] Input open_input(const FractureOptions& options, bool with_looks = false);
[[nodiscard]] LoadedScene open_scene(const FractureOptions& options, const Host& host, SceneCache* cache = nullptr,
                                     bool with_looks = false);

} // namespace brittle::tools
