// What the program around a scenario is asked and told. By default nobody cancels, listens or draws.
//
//     LoadedScene scene = load_scene(options, {.cancelled = [&] { return stop.load(); }});
#pragma once

#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "fracture/io/model.h"
#include "fracture/mesh/mesh.h"
#include "tools/scenario/base/failure.h"

namespace brittle::engine {
struct MaterialSet;
}

namespace brittle::tools {

struct MeshLooks;

// Makes what a renderer draws meshes with, so that a scenario that is drawn decodes each file once. Empty functions
// make nothing. Notes are for people.
struct LooksMaker {
    std::function<std::shared_ptr<const engine::MaterialSet>(const fracture::Model& model,
                                                             std::vector<std::string>& notes)>
        materials{};
    // `mesh` has the triangles of the model's mesh, moved and scaled; `turned`: mirrored, with the last two corners of
    // each triangle exchanged. Not called without materials.
    std::function<std::shared_ptr<const MeshLooks>(const fracture::Model& model, const fracture::TriangleMesh& mesh,
                                                   std::shared_ptr<const engine::MaterialSet> materials, bool turned)>
        looks{};
};

struct Host {
    std::function<bool()> cancelled{}; // true ends the call by a Failure with exit_interrupted
    std::function<void(const std::string& text)>
        report{}; // what was done to a file, for people; lines without the last '\n'
    LooksMaker looks{};
    // Reads the mesh "-", which stands for standard input, in a format such as "glb"; an empty one: told by its bytes.
    // Without it "-" is the name of a file. Throws a Failure.
    std::function<fracture::Model(const std::string& format)> standard_input{};
};

// Throws a Failure with exit_interrupted if the host has cancelled.
inline void throw_if_cancelled(const Host& host) {
    if (host.cancelled && host.cancelled()) throw Failure(exit_interrupted, "interrupted");
}

} // namespace brittle::tools
