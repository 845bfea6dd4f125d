#include "fracture/pieces/certificate.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include <doctest/doctest.h>

#include "fracture/base/random.h"
#include "fracture/shapes/shapes.h"

using namespace brittle::fracture;

namespace {

// Makes one piece of each mesh, with its index as the site. A certificate does not depend on the origin of pieces.
Fragments fragments_of(const std::vector<TriangleMesh>& meshes) {
    Fragments fragments;
    for (const TriangleMesh& mesh : meshes) {
        Piece piece;
        piece.site = static_cast<uint32_t>(fragments.pieces.size());
        piece.vertices.begin = static_cast<uint32_t>(fragments.positions.size());
        piece.triangles.begin = static_cast<uint32_t>(fragments.triangles.size());
        fragments.positions.insert(fragments.positions.end(), mesh.positions.begin(), mesh.positions.end());
        fragments.triangles.insert(fragments.triangles.end(), mesh.triangles.begin(), mesh.triangles.end());
        fragments.triangle_source.resize(fragments.triangles.size());
        piece.vertices.end = static_cast<uint32_t>(fragments.positions.size());
        piece.triangles.end = static_cast<uint32_t>(fragments.triangles.size());
        piece.exterior_triangles = piece.triangles.size() - 2;
        fragments.pieces.push_back(piece);
    }
    return fragments;
}

TriangleMesh half_cube(double sign) {
    TriangleMesh mesh = cube(2.0);
    for (glm::dvec3& p : mesh.positions) p.x = p.x * 0.5 + sign * 0.5;
    return mesh;
}

} // namespace

TEST_CASE("a result without pieces has an empty certificate") {
    const Certificate c = certify({}, {});
    CHECK(c.pieces == 0);
    CHECK(c.closed);
    CHECK(c.volume_error == 0.0);
    CHECK(c.smallest_piece == 0.0);
}

TEST_CASE("a piece with ranges or indices out of bounds counts as open") {
    const Fragments sound = fragments_of({cube()});
    const auto open_after = [&](auto&& damage) {
        Fragments fragments = sound;
        damage(fragments);
        const Certificate c = certify(cube(), fragments);
        CHECK_FALSE(c.closed);
        return c.open_pieces;
    };
    CHECK(open_after([](Fragments& f) { f.triangles[5].y = 8; }) == 1);
    CHECK(open_after([](Fragments& f) { f.triangles[5].y = 0xffffffffu; }) == 1);
    CHECK(open_after([](Fragments& f) { f.pieces[0].vertices.end = 9; }) == 1);
    CHECK(open_after([](Fragments& f) { f.pieces[0].triangles = {4, 2}; }) == 1);
    CHECK(open_after([](Fragments& f) { f.pieces[0].exterior_triangles = 13; }) == 1);
    CHECK(open_after([](Fragments& f) { f.triangles.clear(); }) == 1);
    CHECK(open_after([](Fragments& f) { f.pieces[0].triangles.end = 0, f.pieces[0].exterior_triangles = 0; }) == 1);
}

TEST_CASE("two halves of a cube have exact volumes in their certificate") {
    const Certificate c = certify(cube(), fragments_of({half_cube(-1), half_cube(1)}));
    CHECK(c.pieces == 2);
    CHECK(c.cells == 2);
    CHECK(c.closed);
    CHECK(c.open_pieces == 0);
    CHECK(c.volume_input == 8.0);
    CHECK(c.volume_sum == 8.0);
    CHECK(c.volume_error == 0.0);
    CHECK(c.smallest_piece == 4.0);
    CHECK(c.triangles_in == 12);
    CHECK(c.triangles_out == 24);
    CHECK(c.cap_triangles == 4);
}

TEST_CASE("a missing half, an open piece and a wrong mass are detected") {
    CHECK(certify(cube(), fragments_of({half_cube(1)})).volume_error == 0.5);

    Fragments fragments = fragments_of({half_cube(-1), half_cube(1)});
    for (Piece& piece : fragments.pieces) piece.mass.volume = 1000.0;
    CHECK(certify(cube(), fragments).volume_sum == 8.0);

    std::swap(fragments.triangles[0].x, fragments.triangles[0].y);
    const Certificate c = certify(cube(), fragments);
    CHECK(c.open_pieces == 1);
    CHECK_FALSE(c.closed);
}

TEST_CASE("several pieces of one site are one cell") {
    Fragments fragments = fragments_of({half_cube(-1), half_cube(1), cube()});
    fragments.pieces[1].site = 0;
    CHECK(certify(cube(), fragments).cells == 2);
}

TEST_CASE("the hash depends on every bit of positions, every index and every range, but not on the sign of zero") {
    const Fragments sound = fragments_of({half_cube(-1), icosphere(1)});
    const uint64_t before = hash(sound);
    CHECK(hash(Fragments(sound)) == before);
    const auto differs = [&](auto&& change) {
        Fragments fragments = sound;
        change(fragments);
        return hash(fragments) != before;
    };
    CHECK(differs([](Fragments& f) { f.positions[9].y = std::nextafter(f.positions[9].y, 10.0); }));
    CHECK(differs([](Fragments& f) { f.positions[9].y = -f.positions[9].y; }));
    CHECK(differs([](Fragments& f) { std::swap(f.positions[0], f.positions[1]); }));
    CHECK(differs([](Fragments& f) { std::swap(f.triangles[3].x, f.triangles[3].y); }));
    CHECK(differs([](Fragments& f) { std::swap(f.pieces[0], f.pieces[1]); }));
    CHECK(differs([](Fragments& f) { f.pieces[0].site = 7; }));
    CHECK(differs([](Fragments& f) { f.pieces[0].exterior_triangles = 0; }));

    Fragments zeros = fragments_of({half_cube(1)});
    REQUIRE(zeros.positions[0].x == 0.0);
    zeros.positions[0].x = 0.0;
    const uint64_t plus = hash(zeros);
    zeros.positions[0].x = -0.0;
    CHECK(hash(zeros) == plus);
}

TEST_CASE("the hashes of many random fragments are distinct") {
    Random random(1);
    std::vector<uint64_t> hashes;
    Fragments fragments = fragments_of({cube()});
    for (int i = 0; i < 5000; ++i) {
        fragments.positions[random.next() % 8][static_cast<int>(random.next() % 3)] = random.uniform();
        hashes.push_back(hash(fragments));
    }
    std::sort(hashes.begin(), hashes.end());
    CHECK(std::adjacent_find(hashes.begin(), hashes.end()) == hashes.end());
}

TEST_CASE("the hash of a fixed input is constant across compilers and versions") {
    CHECK(hash({}) == 12479642235849220231ull);
    CHECK(hash(fragments_of({cube(), lattice_cube(3)})) == 6243463692793084084ull);
}

TEST_CASE("a certificate does not depend on the number of threads") {
    std::vector<TriangleMesh> meshes;
    for (uint32_t k = 0; k < 50; ++k) meshes.push_back(icosphere(k % 3, 0.1 + 0.37 * k));
    Fragments fragments = fragments_of(meshes);
    std::swap(fragments.triangles[500].x, fragments.triangles[500].y); // one piece is not oriented
    const Certificate one = certify(icosphere(3), fragments, 1);
    CHECK(one.open_pieces == 1);
    for (const uint32_t threads : {2u, 3u, 8u, 0u}) {
        const Certificate several = certify(icosphere(3), fragments, threads);
        CHECK(several.open_pieces == one.open_pieces);
        CHECK(several.volume_sum == one.volume_sum);
        CHECK(several.volume_input == one.volume_input);
        CHECK(several.smallest_piece == one.smallest_piece);
        CHECK(several.cap_triangles == one.cap_triangles);
        CHECK(several.hash == one.hash);
    }
}
