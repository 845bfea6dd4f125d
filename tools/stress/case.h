// One fracture to try: a mesh, sites, and what is expected of it.
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
    pieces,  // sound input: closed pieces, exact volumes
    refusal, // not the boundary of a solid: a named error
    either   // nobody knows: no crash, and what comes out is closed
};

struct Case {
    std::string family; // how it was made, for people
    Expect expect = Expect::pieces;
    bool simple = false;  // the mesh neither crosses nor touches itself: pieces have volume and lie in their cells
    bool generic = false; // no coincidences, no self-intersections: `sequential` must find the same pieces
    fracture::TriangleMesh mesh;
    std::vector<glm::dvec3> sites;
    std::vector<uint32_t> groups; // of sites; or none
    std::vector<double> weights;  // of sites; or none
    double min_volume = 0.0;
};

// Names of mesh families, for --family.
[[nodiscard]] std::span<const std::string_view> mesh_families();

// The case of that seed; of one mesh family, or of any where `family` is empty.
[[nodiscard]] Case random_case(uint64_t seed, std::string_view family = {});

// Corpus files: text, exact to the bit (hexadecimal floats), whole in themselves.
[[nodiscard]] std::string to_text(const Case& c);
[[nodiscard]] fracture::Result<Case> read_case(const std::filesystem::path& file);

} // namespace brittle::stress
