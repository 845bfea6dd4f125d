// Where a fracture's classification may run instead of the CPU: on a GPU, or any other device.
//
// A classifier may guess, in whatever precision it likes, as long as it marks what rounding could have
// changed. What is marked is decided exactly on the CPU, so any classifier, or none, gives the same pieces
// bit for bit.
//
//     settings.classifier = &classifier; // start() runs before the Voronoi cells are built, finish() after
#pragma once

#include <cstdint>
#include <span>

#include <glm/vec3.hpp>

#include "fracture/mesh.h"

namespace brittle::fracture {

class Classifier {
  public:
    static constexpr uint32_t uncertain = 0x80000000u; // a bit of a vertex's answer
    static constexpr uint32_t crossing = 0xffffffffu;  // a triangle's answer

    // Coordinates are scaled so that the mesh is about one unit long; vertices lie in the box, sites
    // anywhere.
    struct Problem {
        std::span<const glm::dvec3> positions;
        std::span<const Triangle> triangles; // of indices below positions.size()
        std::span<const glm::dvec3> sites;   // fewer than 2^31
        Box box;
    };

    virtual ~Classifier() = default;

    // Begins, and need not wait for the result: what the problem points to stays until finish() or the next
    // start(). False: not now, and finish() is not called.
    virtual bool start(const Problem& problem) = 0;

    // For each vertex the nearest site, with the bit `uncertain` unless rounding cannot have changed the
    // answer: |x - s_l| must exceed |x - s_c| for all l in exact arithmetic; of equal sites it must be the
    // lowest index, or uncertain. For each triangle the site of its corners where they all have one, beyond
    // doubt; else `crossing`. False: nothing was written, or it is worth nothing.
    virtual bool finish(std::span<uint32_t> site_of_vertex, std::span<uint32_t> site_of_triangle) = 0;
};

} // namespace brittle::fracture
