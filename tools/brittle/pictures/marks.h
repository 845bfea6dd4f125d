// What an inspection found, to be seen: lines in a colour for each kind.
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

// Kinds of which there are none are left out. Edges as they are, triangles by their outlines, vertices by crosses.
[[nodiscard]] std::vector<Marks> marks_of(const fracture::TriangleMesh& mesh, const fracture::Inspection& inspection);

// The mesh, translucent, with the marks as thin bars, each kind in a material of its own.
[[nodiscard]] fracture::Model marked_model(const fracture::TriangleMesh& mesh, const std::vector<Marks>& marks);

} // namespace brittle::tools
