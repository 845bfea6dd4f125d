// A case of the stress test: a mesh, sites, fracture settings, and the expected outcome.
#pragma once

#include <cstdint>
#include <filesystem>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "fracture/base/error.h"
#include "fracture/mesh/mesh.h"

namespace brittle::stress {

enum class Expect {
    pieces,  // valid input: closed pieces with exact volumes
    refusal, // the mesh bounds no solid: an error
    either   // undecided: no crash, and any pieces are closed
};

struct Case {
    std::string family; // how the case was made, for reports
    Expect expect = Expect::pieces;
    bool simple = false;  // the mesh neither crosses nor touches itself, so pieces have volume and lie in their cells
    bool generic = false; // no coincidences and no self-intersections, so `sequential` must find equal pieces
    fracture::TriangleMesh mesh;
    std::vector<glm::dvec3> sites;
    std::vector<uint32_t> groups; // by site, or empty
    std::vector<double> weights;  // by site, or empty
    double min_volume = 0.0;
};

// The names that --family accepts.
[[nodiscard]] std::span<const std::string_view> mesh_families();

// The case of a seed, with a mesh of `family`; of any family if it is empty.
[[nodiscard]] Case random_case(uint64_t seed, std::string_view family = {});

// Corpus files: self-contained text; hexadecimal floats keep every bit.
[[nodiscard]] std::string to_text(const Case& c);
[[nodiscard]] fracture::Result<Case> read_case(const std::filesystem::path& file);

} // namespace brittle::stress
