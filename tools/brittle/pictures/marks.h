// The faults found by an inspection as coloured lines, one colour per kind of fault.
#pragma once

#include <array>
#include <string>
#include <vector>

#include <glm/vec3.hpp>

#include "fracture/doctor/inspect.h"
#include "fracture/io/model.h"

namespace brittle::tools {

struct Marks {
    std::string kind;      // "open edges", ...
    glm::uvec3 colour{0u}; // sRGB, 0 to 255
    std::string colour_name;
    std::vector<std::array<glm::dvec3, 2>> segments;
};

// Returns one entry per kind of fault that occurs: edges as segments, triangles as outlines, vertices as crosses.
[[nodiscard]] std::vector<Marks> marks_of(const fracture::TriangleMesh& mesh, const fracture::Inspection& inspection);

// Returns the mesh in a translucent material, with the marks as thin bars in one material per kind.
[[nodiscard]] fracture::Model marked_model(const fracture::TriangleMesh& mesh, const std::vector<Marks>& marks);

} // namespace brittle::tools
