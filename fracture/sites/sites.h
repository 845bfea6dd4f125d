// Voronoi sites: the points whose cells become pieces.
#pragma once

#include <cstdint>
#include <filesystem>
#include <vector>

#include <glm/vec3.hpp>

#include "fracture/base/error.h"
#include "fracture/mesh/mesh.h"

namespace brittle::fracture {

// count sites uniform in the box; equal for equal seeds on every machine. The first k of n sites are the k
// sites.
[[nodiscard]] std::vector<glm::dvec3> uniform_sites(const Box& box, uint32_t count, uint64_t seed);

struct SiteList {
    std::vector<glm::dvec3> sites;
    std::vector<double> weights; // for Settings::weights: squared radii; empty where the file has none
};

// Reads lines of `x y z`, or `x y z radius` (spaces, tabs or commas between); `#` starts a comment, empty lines are
// skipped. A site reaches as far as a ball of its radius would; those without one have radius 0. An error names the file,
// the line and the text it could not read.
[[nodiscard]] Result<SiteList> read_sites(const std::filesystem::path& file);

} // namespace brittle::fracture
