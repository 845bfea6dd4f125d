// Voronoi sites: the points whose cells become pieces.
#pragma once

#include <cstdint>
#include <filesystem>
#include <vector>

#include <glm/vec3.hpp>

#include "fracture/error.h"
#include "fracture/mesh.h"

namespace brittle::fracture {

// count sites uniform in the box; equal for equal seeds on every machine. The first k of n sites are the k
// sites.
[[nodiscard]] std::vector<glm::dvec3> uniform_sites(const Box& box, uint32_t count, uint64_t seed);

// Reads lines of `x y z` (spaces, tabs or commas between); `#` starts a comment, empty lines are skipped. An
// error names the file, the line and the text it could not read.
[[nodiscard]] Result<std::vector<glm::dvec3>> read_sites(const std::filesystem::path& file);

} // namespace brittle::fracture
