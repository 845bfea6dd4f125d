// Solids in the cavities of solids, in one cell; and the triangles that cut polygons are divided into.
#include <doctest/doctest.h>

#include <algorithm>
#include <array>
#include <map>
#include <vector>

#include <glm/geometric.hpp>

#include "fracture/fracture.h"
#include "fracture/shapes/shapes.h"
#include "fracture/sites/sites.h"
#include "tests/fracture/repair_checks.h"

using namespace brittle::fracture;
using namespace brittle::fracture::test;

TEST_CASE("islands: each cavity belongs to the smallest solid around it, in any order of the parts") {
    // Cubes of edge 10 to 2 around one another, by turns solid and cavity.
    std::array<int, 5> order{0, 1, 2, 3, 4};
    do {
        TriangleMesh mesh;
        for (const int k : order) {
            TriangleMesh part = plain_cube();
            for (glm::dvec3& p : part.positions) p *= 5.0 - k;
            if (k % 2 == 1)
                for (Triangle& t : part.triangles) turn(t);
            append(mesh, part);
        }
        for (const Algorithm algorithm : {Algorithm::exact, Algorithm::sequential})
            for (const std::vector<glm::dvec3>& sites :
                 {std::vector<glm::dvec3>{{0, 0, 0}}, std::vector<glm::dvec3>{{1, 1, 1}, {90, 0, 0}}}) {
                const Result<Fragments> pieces = fracture(mesh, sites, {.algorithm = algorithm});
                REQUIRE(pieces);
                std::vector<double> volumes;
                for (const Piece& piece : pieces->pieces) volumes.push_back(piece.mass.volume);
                std::sort(volumes.begin(), volumes.end());
                CHECK(volumes == std::vector<double>{8.0, 216.0 - 64.0, 1000.0 - 512.0});
            }
    } while (std::next_permutation(order.begin(), order.end()));
}

TEST_CASE("assemble: a quad that a cut leaves of a triangle is divided along its shorter diagonal") {
    uint32_t quads = 0;
    for (const glm::dvec3& shift : {glm::dvec3(0.0), glm::dvec3(5.0, -3.0, 2.0)}) {
        TriangleMesh mesh = icosphere(2);
        for (glm::dvec3& p : mesh.positions) p = p * glm::dvec3(1.0, 2.0, 0.5) + shift;
        const Result<Fragments> pieces = fracture(mesh, uniform_sites(bounds(mesh), 6, 4));
        REQUIRE(pieces);
        for (const Piece& piece : pieces->pieces) {
            const auto positions = pieces->positions_of(piece);
            const auto triangles = pieces->triangles_of(piece);
            std::map<uint32_t, std::vector<Triangle>> parts; // by triangle of the mesh
            for (uint32_t t = 0; t < piece.exterior_triangles; ++t)
                parts[pieces->triangle_source[piece.triangles.begin + t]].push_back(triangles[t]);
            for (const auto& [source, both] : parts) {
                if (both.size() != 2) continue;
                const auto is_in = [](uint32_t v, const Triangle& t) { return v == t.x || v == t.y || v == t.z; };
                std::vector<uint32_t> ends, others;
                for (int k = 0; k < 3; ++k) {
                    (is_in(both[0][k], both[1]) ? ends : others).push_back(both[0][k]);
                    if (!is_in(both[1][k], both[0])) others.push_back(both[1][k]);
                }
                if (ends.size() != 2) continue;
                ++quads;
                const auto length = [&](uint32_t a, uint32_t b) { return glm::distance(positions[a], positions[b]); };
                CHECK(length(ends[0], ends[1]) <= length(others[0], others[1]) * (1.0 + 1e-12));
            }
        }
    }
    CHECK(quads > 100);
}
