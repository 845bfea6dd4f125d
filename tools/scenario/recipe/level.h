// A level: the nodes of a glTF file that show meshes, each an object of a scene. Rules say what the nodes are.
//
//     "level": {"mesh": "level.glb",
//               "rules": [{"node": "Wall*", "then": {"fixed": true}},
//                         {"material": "Glass*", "then": {"material": "glass", "anchored": true}},
//                         {"extras": {"kind": "vase"}, "then": {"material": "ceramic", "min_size": 0.02}}]}
//
// The keys of an object under `brittle` in the extras of a node, or else of its mesh, come before all rules, as an
// object or as its JSON in a text. Else the first rule whose conditions all hold decides. A node of which nothing says
// what it is becomes fixed.
#pragma once

#include <set>
#include <string>
#include <vector>

#include "fracture/io/mesh_scene.h"
#include "tools/scenario/recipe/input.h"

namespace brittle::tools {

struct LevelObjects {
    std::vector<SceneObject> objects; // one a node, in the order of the file
    // For people: nodes that are fixed because their extras are faulty, nodes that are left out because their transform
    // flattens them, and rules that decide for no node.
    std::vector<std::string> notes;
};

// `file` is the content of level.mesh, and `metres` the length of its unit. Objects are named by their nodes, with a
// number where the name is among `taken`. Nodes of one mesh whose scales differ by rounding alone get equal ones. Throws
// a Failure with exit_input where there are over max_objects nodes.
[[nodiscard]] LevelObjects level_objects(const Level& level, const fracture::MeshScene& file, double metres,
                                         std::set<std::string> taken = {});

} // namespace brittle::tools
