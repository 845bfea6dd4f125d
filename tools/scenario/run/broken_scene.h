// The pieces of a scene as `brittle fracture` makes those of one mesh: each object that can break is broken by its
// pattern, and nothing is simulated.
//
//     LoadedScene scene = load_scene(with_cuts(options), host);
//     std::vector<BrokenObject> objects = break_scene(scene, host);
//     fracture::ObjectExport file;
//     add_pieces(file, settings, scene, objects);
//     must(file.write("pieces.glb"));
#pragma once

#include <functional>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "fracture/io/export.h"
#include "fracture/pieces/certificate.h"
#include "fracture/pieces/fragments.h"
#include "tools/scenario/recipe/export_settings.h"
#include "tools/scenario/recipe/host.h"
#include "tools/scenario/recipe/input.h"
#include "tools/scenario/run/scene.h"

namespace brittle::tools {

struct BrokenObject {
    fracture::Fragments fragments{};                    // in the object's coordinates; of a fixed object its surface
    std::optional<fracture::Certificate> certificate{}; // none of a fixed object
    double milliseconds = 0.0;                          // duration of the fracture
    std::string overlap{};                              // see overlap_of(); empty for a mesh that was united
};

// Returns a scene whose objects are cut at the start, but for fixed and rigid ones and those that come in pieces, and
// are not glued. The scene has no level (expand_level()).
[[nodiscard]] FractureOptions with_cuts(FractureOptions scene);

// Breaks the objects, side by side; the result is in their order, and the same for any number of threads. An object that
// cannot be cut becomes fixed, with a note in the scene. `progress` is called as by prepare_scene(). Throws a Failure:
// that of the first object that cannot be broken.
[[nodiscard]] std::vector<BrokenObject> break_scene(LoadedScene& scene, const Host& host = {},
                                                    const std::function<void(double)>& progress = {});

// Adds the pieces at the places of their objects. The scene must outlive the file. Throws a Failure.
void add_pieces(fracture::ObjectExport& file, const ExportSettings& settings, const LoadedScene& scene,
                std::span<const BrokenObject> objects);

} // namespace brittle::tools
