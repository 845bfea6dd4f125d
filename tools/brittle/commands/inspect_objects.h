// The objects of a scene, or the nodes of a glTF file, as `brittle inspect` lists them.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include <glm/vec3.hpp>
#include <nlohmann/json_fwd.hpp>

#include "tools/scenario/run/scene.h"

namespace brittle::tools {

struct InspectedObject {
    std::string name{};
    std::string kind{}; // "fixed", "breakable", "bonded, anchored", ...
    uint64_t triangles = 0;
    uint32_t copies = 0;   // objects of the scene that share its mesh, itself included
    glm::dvec3 size{0.0};  // m, of the box in the world
    std::string refusal{}; // why its mesh cannot be broken; empty where it can
};

// Inspects each mesh once. The result is the same for any number of threads; 0 is one a core.
[[nodiscard]] std::vector<InspectedObject> inspect_objects(const LoadedScene& scene, uint32_t threads = 0);

// A line for each object. `with_kinds`: as the recipe says, for scenes.
[[nodiscard]] std::string describe(const std::vector<InspectedObject>& objects, bool with_kinds);
[[nodiscard]] nlohmann::ordered_json to_json(const std::vector<InspectedObject>& objects, bool with_kinds);

// The nodes of a file that show meshes as objects; nothing for other formats, and where a single node does. Throws a
// Failure.
[[nodiscard]] std::optional<LoadedScene> nodes_of(const std::string& mesh);

} // namespace brittle::tools
