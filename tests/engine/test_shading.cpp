// Smooth normals, smooth shading and the wireframe.
#include <algorithm>
#include <cmath>

#include <glm/geometric.hpp>

#include "engine/render/smooth_normals.h"
#include "renderer_fixture.h"

using namespace brittle::engine;
using namespace brittle::engine::test;

namespace {

SmoothSurface smooth(const Shape& shape) {
    return smooth_normals(shape.positions, shape.positions.size(), shape.triangles);
}

double mean_difference(const Bitmap& a, const Bitmap& b) {
    double sum = 0.0;
    for (size_t i = 0; i < a.pixels.size(); ++i) sum += std::abs(int{a.pixels[i]} - int{b.pixels[i]});
    return sum / static_cast<double>(a.pixels.size());
}

} // namespace

TEST_CASE("smooth normals: no triangles, and triangles without area") {
    const SmoothSurface nothing = smooth_normals({}, 0, {});
    CHECK(nothing.triangles.empty());
    CHECK(nothing.normals.empty());
    const glm::vec3 corners[] = {glm::vec3(0.0f), glm::vec3(1.0f), glm::vec3(2.0f), glm::vec3(7.0f)};
    const glm::uvec3 triangles[] = {{0, 1, 2}, {1, 1, 1}};
    const SmoothSurface flat = smooth_normals(corners, std::size(corners), triangles);
    REQUIRE(flat.normals.size() == 4 + flat.copies.size());
    for (const glm::vec3& normal : flat.normals) CHECK(normal == glm::vec3(0.0f));
    for (const glm::uvec3& t : flat.triangles) CHECK(std::max({t.x, t.y, t.z}) < flat.normals.size());
}

TEST_CASE("smooth normals: a box keeps its creases, with the normals of three faces at each corner") {
    const Shape cube = box(glm::vec3(1.0f));
    const SmoothSurface surface = smooth(cube);
    CHECK(surface.copies.size() == 16);
    for (size_t t = 0; t < cube.triangles.size(); ++t)
        for (int k = 0; k < 3; ++k) {
            const uint32_t vertex = surface.triangles[t][k], old = cube.triangles[t][k];
            CHECK((vertex < 8 ? vertex : surface.copies[vertex - 8]) == old);
            const glm::vec3 normal = surface.normals[vertex];
            CHECK(glm::length(normal) == doctest::Approx(1.0f));
            CHECK(std::max({std::abs(normal.x), std::abs(normal.y), std::abs(normal.z)}) == 1.0f);
            CHECK(glm::dot(normal, cube.positions[old]) == doctest::Approx(1.0f)); // outwards
        }
}

TEST_CASE("smooth normals: a ball has no split vertex, and its normals are radial") {
    const Shape ball = icosphere(2.0f, 3);
    const SmoothSurface surface = smooth(ball);
    CHECK(surface.copies.empty());
    CHECK(surface.triangles == ball.triangles);
    for (size_t v = 0; v < ball.positions.size(); ++v)
        CHECK(glm::dot(surface.normals[v], ball.positions[v] / 2.0f) > 0.999f);
}

TEST_CASE("smooth normals: a vertex of ten thousand triangles takes linear time") {
    Shape fan;
    fan.positions.push_back({0.0f, 1.0f, 0.0f});
    const uint32_t count = 10000;
    for (uint32_t i = 0; i < count; ++i) {
        const float angle = 6.2831853f * static_cast<float>(i) / count;
        fan.positions.emplace_back(std::cos(angle), 0.0f, std::sin(angle));
        fan.triangles.emplace_back(0, 1 + (i + 1) % count, 1 + i);
    }
    const SmoothSurface surface = smooth(fan);
    CHECK(std::ranges::all_of(surface.triangles, [&](const glm::uvec3& t) {
        return std::min({surface.normals[t.x].y, surface.normals[t.y].y, surface.normals[t.z].y}) > 0.5f;
    }));
}

TEST_CASE("smooth shading brings a coarse ball near a fine one") {
    const Fixture f;
    if (!f) return;
    const auto draw = [&](int levels, bool smooth_shading) {
        const Shape ball = icosphere(0.9f, levels);
        const PieceMesh piece = ball.piece(0);
        REQUIRE(f.renderer->set_pieces({&piece, 1}));
        Scene scene = empty_stage();
        scene.smooth = smooth_shading;
        scene.look.to_light = {0.3f, 0.2f, 1.0f}; // from the camera, so that no shadow is visible
        return f.draw(scene);
    };
    const Bitmap fine = draw(5, false);
    const double facets = mean_difference(draw(3, false), fine), bent = mean_difference(draw(3, true), fine);
    CHECK(facets > 0.15);
    CHECK(bent < 0.5 * facets);
}

TEST_CASE("smooth shading does not change boxes and interiors") {
    const Fixture f;
    if (!f) return;
    KnownScene known;
    const Shape cube = box({0.5f, 0.6f, 0.4f}, 3), ball = icosphere(0.5f, 2);
    PieceMesh pieces[] = {cube.piece(0), ball.piece(1), ball.piece(2), cube.piece(3)};
    for (PieceMesh& piece : pieces)
        if (piece.body == 1 || piece.body == 2) piece.exterior_triangles = 0;
    REQUIRE(f.renderer->set_pieces(pieces));
    const Bitmap facets = f.draw(known.scene);
    known.scene.smooth = true;
    const Bitmap bent = f.draw(known.scene);
    int largest = 0;
    for (size_t i = 0; i < facets.pixels.size(); ++i)
        largest = std::max(largest, std::abs(int{facets.pixels[i]} - int{bent.pixels[i]}));
    CHECK(largest <= 1); // normals from derivatives are rounded
}

TEST_CASE("the wireframe shows the edges of front faces only") {
    const Fixture f;
    if (!f) return;
    if (!f.device->has_line_mode()) return;
    const Shape cube = box(glm::vec3(0.7f));
    const PieceMesh piece = cube.piece(0);
    REQUIRE(f.renderer->set_pieces({&piece, 1}));
    Scene scene = empty_stage();
    const Bitmap plain = f.draw(scene);
    scene.wireframe = true;
    const Bitmap edges = f.draw(scene);
    CHECK(f.renderer->stats().indirect_calls == 3); // shadow, faces and edges
    uint32_t drawn = 0;
    for (uint32_t y = 0; y < small.y; ++y)
        for (uint32_t x = 0; x < small.x; ++x) drawn += pixel(edges, x, y) != pixel(plain, x, y);
    // The front face has an outline of 5.6 m and a diagonal of 2 m; 64 pixels are 2.7 m at its distance of 4.3 m.
    CHECK(drawn > 80);
    CHECK(drawn < 200);
    scene.pieces_visible = false;
    const Bitmap nothing = f.draw(scene);
    CHECK(pixel(nothing, small.x / 2, small.y / 2) == pixel(nothing, 0, small.y / 2));
}
