// Voronoi sites: at random, or from a text file. Coordinates are in metres. All functions are reentrant.
//
//     const std::vector<glm::dvec3> sites = uniform_sites(bounds(mesh), 100, 1); // 100 sites, seed 1
//     Result<SiteList> list = read_sites("sites.txt");
#pragma once

#include <cstdint>
#include <filesystem>
#include <vector>

#include <glm/vec3.hpp>

#include "fracture/base/error.h"
#include "fracture/mesh/mesh.h"

namespace brittle::fracture {

// Returns `count` sites uniform in the box. Equal seeds give equal sites on every machine, and the first k of n sites
// are uniform_sites(box, k, seed).
[[nodiscard]] std::vector<glm::dvec3> uniform_sites(const Box& box, uint32_t count, uint64_t seed);

struct SiteList {
    std::vector<glm::dvec3> sites;
    // For Settings::weights: squared radii, m^2; empty if no site of the file has a radius.
    std::vector<double> weights;
};

// Reads lines of the form `x y z` or `x y z radius`, separated by spaces, tabs or one comma. `#` starts a comment;
// empty lines are skipped. A site with a radius extends its cell as a ball of that radius would; sites without one have
// radius 0 if others have one. Errors, with file, line and offending text: file_not_found, malformed_file, and
// invalid_sites (no site, too many sites, a number that is not finite, a negative radius).
[[nodiscard]] Result<SiteList> read_sites(const std::filesystem::path& file);

} // namespace brittle::fracture
