#include "fracture/pieces/cap_pairs.h"

#include <array>
#include <vector>

#include <doctest/doctest.h>

#include "fracture/fracture.h"
#include "fracture/shapes/shapes.h"
#include "tests/fracture/lattice.h"

using namespace brittle::fracture;
using namespace brittle::fracture::test;

namespace {

bool always(uint32_t, uint32_t) {
    return true;
}

// Adds a piece that is one cap triangle towards another site, with the given point numbers.
void add_cap(Fragments& f, uint32_t site, uint32_t other, const std::array<uint32_t, 3>& points) {
    Piece piece;
    piece.site = site;
    piece.vertices.begin = static_cast<uint32_t>(f.vertex_point.size());
    piece.triangles.begin = static_cast<uint32_t>(f.triangles.size());
    f.vertex_point.insert(f.vertex_point.end(), points.begin(), points.end());
    f.triangles.push_back({0, 1, 2});
    f.triangle_source.push_back(other);
    piece.vertices.end = static_cast<uint32_t>(f.vertex_point.size());
    piece.triangles.end = static_cast<uint32_t>(f.triangles.size());
    f.pieces.push_back(piece);
}

} // namespace

TEST_CASE("cap pairs: no fragments, no pairs") {
    CHECK_NOTHROW(CapPairs({}, always));
}

TEST_CASE("cap pairs: the two sides of a triangle have its points in opposite order, whichever comes first") {
    for (const auto& reversed : {std::array{7u, 9u, 8u}, std::array{9u, 8u, 7u}, std::array{8u, 7u, 9u}}) {
        Fragments f;
        add_cap(f, 4, 2, {7, 8, 9});
        add_cap(f, 2, 4, reversed);
        add_cap(f, 2, 3, reversed);   // towards another site
        add_cap(f, 2, 4, {7, 8, 9});  // the same order
        add_cap(f, 2, 4, {7, 10, 8}); // another triangle
        const CapPairs pairs(f, always);
        CHECK(pairs.across(0) == 1);
        CHECK(pairs.across(1) == 0);
        for (uint32_t t = 2; t < 5; ++t) CHECK(pairs.across(t) == no_index);
        for (uint32_t t = 0; t < 5; ++t) CHECK(pairs.piece_of(t) == t);
        CHECK(CapPairs(f, [](uint32_t a, uint32_t b) { return a == 2 && b == 3; }).across(0) == no_index);
        CHECK(CapPairs(f, [](uint32_t a, uint32_t b) { return a == 2 && b == 4; }).across(0) == 1);
    }
}

TEST_CASE("cap pairs: a side without a partner stays alone") {
    for (const uint32_t lower : {0u, 1u, 2u, 3u}) {
        for (const uint32_t upper : {0u, 1u, 2u, 3u}) {
            CAPTURE(lower);
            CAPTURE(upper);
            Fragments f;
            for (uint32_t k = 0; k < lower; ++k) add_cap(f, 0, 1, {5, 6, 7});
            for (uint32_t k = 0; k < upper; ++k) add_cap(f, 1, 0, {5, 7, 6});
            const CapPairs pairs(f, always);
            uint32_t alone = 0;
            for (uint32_t t = 0; t < lower + upper; ++t) {
                const uint32_t across = pairs.across(t);
                if (across == no_index) {
                    ++alone;
                    continue;
                }
                CHECK(pairs.across(across) == t);
                CHECK(f.pieces[pairs.piece_of(across)].site != f.pieces[pairs.piece_of(t)].site);
            }
            CHECK(alone == (lower > upper ? lower - upper : upper - lower));
        }
    }
}

TEST_CASE("cap pairs: in a fracture every cap triangle has its other side, and no exterior triangle") {
    const auto f = fracture(lattice_cube(3), lattice(3));
    REQUIRE(f);
    const CapPairs pairs(*f, always);
    for (const Piece& piece : f->pieces) {
        for (uint32_t t = piece.triangles.begin; t < piece.triangles.end; ++t) {
            const uint32_t across = pairs.across(t);
            CHECK((across == no_index) == (t < piece.triangles.begin + piece.exterior_triangles));
            if (across != no_index) CHECK(f->triangle_source[t] == f->pieces[pairs.piece_of(across)].site);
        }
    }
}
