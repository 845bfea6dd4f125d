// Tangents of normal maps: by analytic surfaces, and through a fracture into a GLB file. tests/engines compares them with
// the reference implementation of MikkTSpace.
#include <algorithm>
#include <cmath>
#include <cstring>
#include <numbers>

#include <doctest/doctest.h>
#include <glm/geometric.hpp>
#include <nlohmann/json.hpp>

#include "fracture/fracture.h"
#include "fracture/io/export.h"
#include "fracture/io/import.h"
#include "fracture/io/tangents.h"
#include "fracture/pieces/certificate.h"
#include "fracture/shapes/shapes.h"
#include "fracture/sites/sites.h"
#include "tests/fracture/mesh_checks.h"

using namespace brittle::fracture;
using nlohmann::json;

namespace {

// A mesh with one material, which has a normal map, and texture coordinates by a function of the position.
template<class Uv>
Model mapped(const TriangleMesh& mesh, Uv uv) {
    Model model;
    model.mesh = mesh;
    model.images.push_back({.mime_type = "image/png"});
    model.textures.push_back({.image = 0});
    model.materials.push_back({.name = "skin", .normal_texture = TextureUse{}});
    model.material_of.assign(mesh.triangles.size(), 0);
    for (const Triangle& t : mesh.triangles)
        for (int k = 0; k < 3; ++k) model.uv[0].push_back(uv(mesh.positions[t[k]]));
    return model;
}

// Two triangles in the plane z = 0, and a third one that folds up at x = 1.
TriangleMesh folded() {
    return {{{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}, {1, 0, 1}}, {{0, 1, 2}, {0, 2, 3}, {2, 1, 4}}};
}

// The tangents of the first two triangles.
std::vector<glm::vec4> first_quad(const Model& model) {
    std::vector<glm::vec4> tangents = corner_tangents(model);
    REQUIRE(tangents.size() >= 6);
    tangents.resize(6);
    return tangents;
}

void check_unit(const std::vector<glm::vec4>& tangents) {
    for (const glm::vec4& t : tangents) {
        CHECK(std::abs(glm::length(glm::vec3(t)) - 1.0f) < 1e-5f);
        CHECK(std::abs(t.w) == 1.0f);
    }
}

} // namespace

TEST_CASE("tangents: degenerate texture coordinates give unit vectors, and no normal map gives none") {
    Model model = mapped(folded(), [](const glm::dvec3&) { return glm::vec2(0.25f); });
    const auto tangents = corner_tangents(model);
    REQUIRE(tangents.size() == 9);
    check_unit(tangents);
    CHECK(std::abs(tangents[0].z) < 1e-6f);          // perpendicular to the normal of the triangle
    model.mesh.positions.assign(5, glm::dvec3(1.0)); // triangles without area, too
    check_unit(corner_tangents(model));
    model.materials[0].normal_texture->uv_set = 1; // which the model does not have
    CHECK(corner_tangents(model).empty());
    CHECK_FALSE(uses_tangents(model, 0));
    model.materials[0].normal_texture.reset();
    CHECK(corner_tangents(model).empty());
    model.materials[0].extensions = R"({"KHR_materials_clearcoat": {"clearcoatNormalTexture": {"index": 0}}})";
    CHECK(corner_tangents(model).size() == 9);
    CHECK_FALSE(uses_tangents(model, no_material));
    model.material_of.assign(3, no_material);
    CHECK(corner_tangents(model).empty());
    CHECK(corner_tangents({}).empty());
}

TEST_CASE("tangents: they follow u, and the bitangent points up in the image") {
    // u along x and the image upright along y; glTF's v points down.
    Model model = mapped(folded(), [](const glm::dvec3& p) { return glm::vec2(p.x + p.z, 1.0 - p.y); });
    for (const glm::vec4& t : first_quad(model)) CHECK(glm::distance(t, glm::vec4(1.0f, 0.0f, 0.0f, 1.0f)) < 1e-6f);
    CHECK(glm::distance(corner_tangents(model)[6], glm::vec4(0.0f, 0.0f, 1.0f, 1.0f)) < 1e-6f);
    for (glm::vec2& uv : model.uv[0]) uv.x = -uv.x; // mirrored
    for (const glm::vec4& t : first_quad(model)) CHECK(glm::distance(t, glm::vec4(-1.0f, 0.0f, 0.0f, -1.0f)) < 1e-6f);
}

TEST_CASE("tangents: triangles of one handedness share the mean at a vertex, weighted by angle") {
    Model model = mapped(folded(), [](const glm::dvec3& p) { return glm::vec2(p.x + p.z, 1.0 - p.y); });
    const glm::vec3 bent = glm::normalize(glm::vec3(-1.0f, 0.0f, 1.0f)); // the normal where the mesh folds
    model.normals.assign(9, glm::vec3(0.0f, 0.0f, 1.0f));
    model.normals[8] = glm::vec3(-1.0f, 0.0f, 0.0f);
    for (const size_t corner : {1u, 2u, 4u, 6u, 7u}) model.normals[corner] = bent;
    // Both sides have the direction (1, 0, 1) in the plane of the common normal.
    const auto smooth = corner_tangents(model);
    for (const size_t corner : {1u, 2u, 4u, 6u, 7u})
        CHECK(glm::distance(smooth[corner], glm::vec4(glm::normalize(glm::vec3(1.0f, 0.0f, 1.0f)), 1.0f)) < 1e-6f);

    // A quad whose second triangle has u along -y, by the coordinates of its last corner. Both have angles of 45 degrees
    // at the diagonal.
    Model turned = mapped(folded(), [](const glm::dvec3& p) { return glm::vec2(p.x, 1.0 - p.y); });
    turned.mesh.triangles.pop_back();
    turned.material_of.pop_back();
    turned.uv[0].resize(6);
    turned.uv[0][5] = glm::vec2(-1.0f, 1.0f);
    const auto mean = corner_tangents(turned);
    const float half = std::numbers::sqrt2_v<float> / 2.0f;
    for (const size_t corner : {0u, 2u, 3u, 4u})
        CHECK(glm::distance(mean[corner], glm::vec4(half, -half, 0.0f, 1.0f)) < 1e-6f);
    CHECK(glm::distance(mean[1], glm::vec4(1.0f, 0.0f, 0.0f, 1.0f)) < 1e-6f);
    CHECK(glm::distance(mean[5], glm::vec4(0.0f, -1.0f, 0.0f, 1.0f)) < 1e-6f);

    // Mirrored halves share no tangent, though their points are equal.
    Model mirrored = mapped(folded(), [](const glm::dvec3& p) { return glm::vec2(std::abs(p.x - p.y), 1.0 - p.y); });
    mirrored.mesh.triangles.pop_back();
    mirrored.material_of.pop_back();
    mirrored.uv[0].resize(6);
    const auto halves = corner_tangents(mirrored);
    CHECK(halves[0].w == -halves[3].w);
    CHECK(halves[2].w == -halves[4].w);
}

TEST_CASE("tangents: pieces of a sphere have those of the sphere") {
    const test::Folder folder;
    const auto longitude = [](const glm::dvec3& p) { return std::atan2(p.x, p.z) / (2.0 * std::numbers::pi); };
    Model ball = mapped(icosphere(3), [&](const glm::dvec3& p) {
        return glm::vec2(longitude(p), std::acos(std::clamp(p.y / glm::length(p), -1.0, 1.0)) / std::numbers::pi);
    });
    for (size_t t = 0; t < ball.mesh.triangles.size(); ++t) { // no triangle spans the seam in the image
        float* const u[] = {&ball.uv[0][3 * t].x, &ball.uv[0][3 * t + 1].x, &ball.uv[0][3 * t + 2].x};
        const float most = std::max({*u[0], *u[1], *u[2]});
        for (float* one : u)
            if (most - *one > 0.5f) *one += 1.0f;
    }
    for (const Triangle& t : ball.mesh.triangles)
        for (int k = 0; k < 3; ++k) ball.normals.emplace_back(glm::normalize(ball.mesh.positions[t[k]]));
    const auto sites = uniform_sites(bounds(ball.mesh), 12, 3);
    const Result<Fragments> pieces = fracture(ball.mesh, sites);
    REQUIRE(pieces);
    const auto file = folder.path / "ball.glb";
    REQUIRE(export_pieces(file, *pieces, certify(ball.mesh, *pieces), {.source = &ball, .sites = sites}));
    const std::string bytes = test::read_text(file);
    uint32_t size = 0;
    std::memcpy(&size, bytes.data() + 12, 4);
    const json document = json::parse(bytes.substr(20, size));
    const auto read = [&](const json& attributes, const char* name, size_t components) {
        const json& accessor = document["accessors"][attributes[name].get<size_t>()];
        const json& view = document["bufferViews"][accessor["bufferView"].get<size_t>()];
        std::vector<float> values(accessor["count"].get<size_t>() * components);
        std::memcpy(values.data(),
                    bytes.data() + 28 + size + view["byteOffset"].get<size_t>() + accessor["byteOffset"].get<size_t>(),
                    values.size() * 4);
        return values;
    };
    size_t exteriors = 0, vertices = 0;
    double worst = 1.0;
    for (const json& mesh : document["meshes"])
        for (const json& primitive : mesh["primitives"]) {
            const json& attributes = primitive["attributes"];
            const bool is_exterior = document["materials"][primitive["material"].get<size_t>()]["name"] == "skin";
            CHECK(attributes.contains("TANGENT") == is_exterior); // the material of cuts has no normal map
            if (!is_exterior) continue;
            ++exteriors;
            const auto normals = read(attributes, "NORMAL", 3), tangents = read(attributes, "TANGENT", 4);
            REQUIRE(tangents.size() / 4 == normals.size() / 3);
            for (size_t v = 0; 3 * v < normals.size(); ++v) {
                const glm::vec3 n(normals[3 * v], normals[3 * v + 1], normals[3 * v + 2]);
                const glm::vec3 t(tangents[4 * v], tangents[4 * v + 1], tangents[4 * v + 2]);
                CHECK(std::abs(glm::length(t) - 1.0f) < 1e-5f);
                CHECK(std::abs(glm::dot(t, n)) < 1e-5f);
                CHECK(tangents[4 * v + 3] == 1.0f);
                if (std::abs(n.y) > 0.8f) continue; // towards the poles, triangles are too coarse
                const glm::vec3 east = glm::normalize(glm::vec3(n.z, 0.0f, -n.x));
                worst = std::min(worst, static_cast<double>(glm::dot(t, east)));
                ++vertices;
            }
        }
    CHECK(exteriors == pieces->pieces.size());
    CHECK(vertices > 1000);
    CHECK(worst > 0.98);
}
