#include "fracture/io/export.h"

#include <cmath>
#include <cstring>
#include <limits>
#include <map>
#include <set>

#include <doctest/doctest.h>
#include <glm/geometric.hpp>
#include <nlohmann/json.hpp>

#include "fracture/fracture.h"
#include "fracture/io/import.h"
#include "fracture/shapes/shapes.h"
#include "fracture/sites/sites.h"
#include "tests/fracture/mesh_checks.h"

using namespace brittle::fracture;
namespace fs = std::filesystem;
using nlohmann::json;

namespace {

// The box min .. max as a piece. Of its six quads the one at x = inner_x is interior.
void add_box(Fragments& fragments, const glm::dvec3& min, const glm::dvec3& max, double inner_x) {
    Piece piece;
    piece.site = static_cast<uint32_t>(fragments.pieces.size());
    piece.vertices.begin = static_cast<uint32_t>(fragments.positions.size());
    piece.triangles.begin = static_cast<uint32_t>(fragments.triangles.size());
    for (int v = 0; v < 8; ++v) {
        fragments.positions.emplace_back(v & 4 ? max.x : min.x, v & 2 ? max.y : min.y, v & 1 ? max.z : min.z);
    }
    const Triangle faces[] = {{4, 6, 7}, {4, 7, 5}, {0, 1, 3}, {0, 3, 2}, {2, 3, 7}, {2, 7, 6},
                              {0, 4, 5}, {0, 5, 1}, {1, 5, 7}, {1, 7, 3}, {0, 2, 6}, {0, 6, 4}};
    for (const bool interior : {false, true}) {
        for (uint32_t t = 0; t < 12; ++t) {
            const bool inner = t < 4 && (t < 2 ? max.x : min.x) == inner_x;
            if (inner != interior) continue;
            fragments.triangles.push_back(faces[t]);
            fragments.triangle_source.push_back(interior ? 1 - piece.site : t / 2);
            piece.exterior_triangles += interior ? 0 : 1;
        }
    }
    piece.vertices.end = static_cast<uint32_t>(fragments.positions.size());
    piece.triangles.end = static_cast<uint32_t>(fragments.triangles.size());
    const glm::dvec3 size = max - min;
    piece.mass.volume = size.x * size.y * size.z;
    piece.mass.area = 2.0 * (size.x * size.y + size.y * size.z + size.z * size.x);
    piece.mass.centre_of_mass = (min + max) * 0.5;
    piece.mass.inertia = glm::dmat3(1, 2, 3, 4, 5, 6, 7, 8, 9);
    fragments.pieces.push_back(piece);
}

// Two parts of a box, cut off the middle at a coordinate that float cannot represent.
Fragments two_halves() {
    const glm::dvec3 min{-1.1, -0.7, -0.3}, max{1.3, 0.9, 0.7};
    Fragments fragments;
    add_box(fragments, min, {0.1, max.y, max.z}, 0.1);
    add_box(fragments, {0.1, min.y, min.z}, max, 0.1);
    return fragments;
}

Certificate certificate() {
    Certificate c;
    c.pieces = 2;
    c.closed = true;
    c.volume_input = 3.84;
    c.hash = 0xfedcba9876543210ull;
    return c;
}

struct Glb {
    json document;
    std::string binary;
};

uint32_t word(const std::string& bytes, size_t at) {
    uint32_t value = 0;
    REQUIRE(at + 4 <= bytes.size());
    std::memcpy(&value, bytes.data() + at, 4);
    return value;
}

// Parses the container and checks it.
Glb read_glb(const fs::path& file) {
    const std::string bytes = test::read_text(file);
    REQUIRE(bytes.substr(0, 4) == "glTF");
    CHECK(word(bytes, 4) == 2);
    CHECK(word(bytes, 8) == bytes.size());
    const uint32_t json_size = word(bytes, 12);
    CHECK(json_size % 4 == 0);
    CHECK(bytes.substr(16, 4) == "JSON");
    Glb glb{json::parse(bytes.substr(20, json_size)), {}};
    if (20 + json_size == bytes.size()) return glb;
    const uint32_t binary_size = word(bytes, 20 + json_size);
    CHECK(binary_size % 4 == 0);
    CHECK(bytes.substr(24 + json_size, 4) == std::string("BIN\0", 4));
    CHECK(28 + json_size + binary_size == bytes.size());
    glb.binary = bytes.substr(28 + json_size);
    return glb;
}

// The float vectors of an accessor.
std::vector<glm::vec3> vectors(const Glb& glb, size_t accessor) {
    const json& a = glb.document["accessors"][accessor];
    const json& view = glb.document["bufferViews"][a["bufferView"].get<size_t>()];
    REQUIRE(a["componentType"] == 5126);
    REQUIRE(view["byteStride"] == 12);
    std::vector<glm::vec3> result(a["count"].get<size_t>());
    const size_t at = view["byteOffset"].get<size_t>() + a["byteOffset"].get<size_t>();
    REQUIRE(at + result.size() * 12 <= glb.binary.size());
    std::memcpy(result.data(), glb.binary.data() + at, result.size() * 12);
    return result;
}

fs::path exported(const test::Folder& folder, const Fragments& fragments, const ExportOptions& options = {}) {
    const fs::path file = folder.path / "pieces.glb";
    const auto result = export_pieces(file, fragments, certificate(), options);
    if (!result) FAIL(result.error().message);
    return file;
}

} // namespace

TEST_CASE("export: no pieces give a file with only the root") {
    const test::Folder folder;
    const Glb glb = read_glb(exported(folder, {}));
    CHECK(glb.binary.empty());
    CHECK(glb.document["nodes"].size() == 1);
    CHECK(!glb.document.contains("meshes"));
    CHECK(!glb.document["nodes"][0].contains("children"));
}

TEST_CASE("export: a recipe that is not a JSON object is refused, and the old file stays") {
    const test::Folder folder;
    const fs::path file = exported(folder, two_halves());
    const std::string before = test::read_text(file);
    for (const std::string& recipe :
         {std::string("{"), std::string("[1]"), std::string(), "{\"a\":" + std::string(100000, '[')}) {
        const auto result = export_pieces(file, {}, {}, {.recipe = recipe});
        REQUIRE(!result);
        CHECK(result.error().status == Status::invalid_setting);
    }
    CHECK(test::read_text(file) == before);
    CHECK(folder.files() == 1);
}

TEST_CASE("export: coordinates that floats cannot hold are refused") {
    const test::Folder folder;
    Fragments fragments;
    add_box(fragments, glm::dvec3(-1e300), glm::dvec3(1.0), 1.0);
    const auto result = export_pieces(folder.path / "big.glb", fragments, {});
    REQUIRE(!result);
    CHECK(result.error().status == Status::write_failed);
    CHECK(result.error().message.find("mesh_000") != std::string::npos);
    CHECK(folder.files() == 0);
}

TEST_CASE("export: a folder that does not exist is an error with its name") {
    const auto result = export_pieces("/nonexistent/pieces.glb", two_halves(), {});
    REQUIRE(!result);
    CHECK(result.error().status == Status::write_failed);
    CHECK(result.error().message.find("/nonexistent/pieces.glb") != std::string::npos);
}

TEST_CASE("export: one root, one child per piece with its properties in the extras") {
    const test::Folder folder;
    const Glb glb = read_glb(exported(folder, two_halves(), {"vase", R"({"pattern": {"seed": 7}})"}));
    const json& nodes = glb.document["nodes"];
    REQUIRE(nodes.size() == 3);
    CHECK(glb.document["asset"]["generator"].get<std::string>().starts_with("Brittle "));
    CHECK(glb.document["scenes"] == json::parse(R"([{"nodes": [0]}])"));
    CHECK(nodes[0]["name"] == "vase");
    CHECK(nodes[0]["children"] == json({1, 2}));
    CHECK(nodes[0]["extras"]["brittle"]["recipe"]["pattern"]["seed"] == 7);
    CHECK(nodes[0]["extras"]["brittle"]["certificate"]["closed"] == true);
    CHECK(nodes[0]["extras"]["brittle"]["certificate"]["hash"] == "fedcba9876543210");
    CHECK(nodes[2]["name"] == "vase_001");
    CHECK(!nodes[2].contains("rotation"));
    CHECK(!nodes[2].contains("scale"));
    CHECK(nodes[2]["translation"][0].get<double>() == static_cast<float>(0.7));
    const json& extras = nodes[2]["extras"]["brittle"];
    CHECK(extras["site"] == 1);
    CHECK(extras["volume"].get<double>() == two_halves().pieces[1].mass.volume);
    CHECK(extras["centre_of_mass"][0].get<double>() == two_halves().pieces[1].mass.centre_of_mass.x);
    CHECK(extras["inertia"] == json({1.0, 4.0, 7.0, 2.0, 5.0, 8.0, 3.0, 6.0, 9.0}));
    CHECK(extras["exterior_triangles"] == 10);
    CHECK(extras["interior_triangles"] == 2);
}

TEST_CASE("export: exterior and interior are primitives 0 and 1 with different materials") {
    const test::Folder folder;
    const Glb glb = read_glb(exported(folder, two_halves()));
    for (const json& mesh : glb.document["meshes"]) {
        REQUIRE(mesh["primitives"].size() == 2);
        CHECK(glb.document["materials"][mesh["primitives"][0]["material"].get<size_t>()]["name"] == "exterior");
        CHECK(glb.document["materials"][mesh["primitives"][1]["material"].get<size_t>()]["name"] == "interior");
        CHECK(glb.document["accessors"][mesh["primitives"][0]["indices"].get<size_t>()]["count"] == 30);
        CHECK(glb.document["accessors"][mesh["primitives"][1]["indices"].get<size_t>()]["count"] == 6);
    }
}

TEST_CASE("export: an empty primitive is omitted") {
    const test::Folder folder;
    Fragments whole;
    add_box(whole, glm::dvec3(-1.0), glm::dvec3(1.0), 5.0);
    const Glb glb = read_glb(exported(folder, whole));
    CHECK(glb.document["meshes"][0]["primitives"].size() == 1);
    CHECK(glb.document["meshes"][0]["primitives"][0]["material"] == 0);
}

TEST_CASE("export: normals are those of the faces, coplanar triangles share vertices, bounds are exact") {
    const test::Folder folder;
    const Glb glb = read_glb(exported(folder, two_halves()));
    for (const json& mesh : glb.document["meshes"]) {
        for (const json& primitive : mesh["primitives"]) {
            const size_t position = primitive["attributes"]["POSITION"].get<size_t>();
            const std::vector<glm::vec3> positions = vectors(glb, position);
            const std::vector<glm::vec3> normals = vectors(glb, primitive["attributes"]["NORMAL"].get<size_t>());
            CHECK((positions.size() == 20 || positions.size() == 4)); // four per quad
            REQUIRE(positions.size() == normals.size());
            glm::vec3 least(1e9f), greatest(-1e9f);
            for (size_t v = 0; v < positions.size(); ++v) {
                // The centre of the box is the origin, so the outward normal points to the side of the vertex.
                CHECK(glm::dot(positions[v], normals[v]) > 0.0f);
                CHECK(std::abs(normals[v].x) + std::abs(normals[v].y) + std::abs(normals[v].z) == 1.0f);
                for (int k = 0; k < 3; ++k) {
                    least[k] = std::min(least[k], positions[v][k]);
                    greatest[k] = std::max(greatest[k], positions[v][k]);
                }
            }
            const json& accessor = glb.document["accessors"][position];
            for (int k = 0; k < 3; ++k) {
                CHECK(accessor["min"][static_cast<size_t>(k)].get<double>() == least[k]);
                CHECK(accessor["max"][static_cast<size_t>(k)].get<double>() == greatest[k]);
            }
        }
    }
}

TEST_CASE("export: within a piece equal positions are equal bit for bit, and true to the original within "
          "rounding") {
    const test::Folder folder;
    const Fragments fragments = two_halves();
    const Glb glb = read_glb(exported(folder, fragments));
    for (size_t p = 0; p < 2; ++p) {
        const json& mesh = glb.document["meshes"][p];
        std::set<std::array<float, 3>> distinct;
        for (const json& primitive : mesh["primitives"]) {
            for (const glm::vec3& v : vectors(glb, primitive["attributes"]["POSITION"].get<size_t>())) {
                distinct.insert({v.x, v.y, v.z});
            }
        }
        CHECK(distinct.size() == 8);
        const json& translation = glb.document["nodes"][p + 1]["translation"];
        for (const glm::dvec3& original : fragments.positions_of(fragments.pieces[p])) {
            double nearest = 1e9;
            for (const std::array<float, 3>& v : distinct) {
                double distance = 0.0;
                for (size_t k = 0; k < 3; ++k) {
                    const double stored = translation[k].get<double>() + v[k];
                    distance = std::max(distance, std::abs(stored - original[static_cast<int>(k)]));
                }
                nearest = std::min(nearest, distance);
            }
            CHECK(nearest < 1e-7);
        }
    }
}

TEST_CASE("export: each piece comes back closed with its volume, all pieces with their triangles") {
    const test::Folder folder;
    const Fragments both = two_halves();
    const Result<TriangleMesh> all = import_mesh(exported(folder, both));
    REQUIRE(all);
    CHECK(all->triangles.size() == 24);
    CHECK(test::signed_volume(*all) == doctest::Approx(3.84).epsilon(1e-6));

    for (const Piece& piece : both.pieces) {
        Fragments one = both;
        one.pieces = {piece};
        const Result<TriangleMesh> mesh = import_mesh(exported(folder, one));
        REQUIRE(mesh);
        CHECK(mesh->positions.size() == 8);
        CHECK(mesh->triangles.size() == 12);
        CHECK(test::is_closed(mesh->triangles));
        CHECK(test::signed_volume(*mesh) == doctest::Approx(piece.mass.volume).epsilon(1e-6));
    }
}

TEST_CASE("export: a piece of over 65,535 vertices has 32-bit indices and comes back whole") {
    // A closed double cone over a ring of n corners. Every triangle has a plane of its own, so none shares vertices.
    constexpr uint32_t n = 12'000;
    Fragments fragments;
    for (uint32_t k = 0; k < n; ++k) {
        const double angle = 2.0 * 3.14159265358979 * k / n;
        fragments.positions.emplace_back(std::cos(angle), 0.0, -std::sin(angle));
    }
    fragments.positions.insert(fragments.positions.end(), {{0, 1, 0}, {0, -1, 0}});
    for (uint32_t k = 0; k < n; ++k) {
        fragments.triangles.insert(fragments.triangles.end(), {{k, (k + 1) % n, n}, {(k + 1) % n, k, n + 1}});
        fragments.triangle_source.insert(fragments.triangle_source.end(), {2 * k, 2 * k + 1});
    }
    Piece piece;
    piece.vertices = {0, n + 2};
    piece.triangles = {0, 2 * n};
    piece.exterior_triangles = 2 * n;
    fragments.pieces = {piece};
    const test::Folder folder;
    const fs::path file = exported(folder, fragments);
    CHECK(read_glb(file).document["accessors"][2]["componentType"] == 5125);
    const Result<TriangleMesh> mesh = import_mesh(file);
    REQUIRE(mesh);
    CHECK(mesh->triangles.size() == 2 * n);
    CHECK(test::is_closed(mesh->triangles));
}

TEST_CASE("export: pieces without area, odd names and unknown bytes still give a readable file") {
    const test::Folder folder;
    Fragments flat;
    add_box(flat, {0, 0, 0}, {0, 0, 0}, 5.0);
    const Glb glb = read_glb(exported(folder, flat, {"na\xffme \"quoted\"", "{}"}));
    CHECK(glb.document["nodes"][0]["name"] == "na\xEF\xBF\xBDme \"quoted\"");
    for (const glm::vec3& normal : vectors(glb, 1)) CHECK(normal == glm::vec3(0, 1, 0));
}

TEST_CASE("export: cuts have texture coordinates in metres where the sites are given") {
    const test::Folder folder;
    const std::vector<glm::dvec3> sites = {{0.0, 0.0, 0.0}, {0.2, 0.0, 0.0}};
    const Glb plain = read_glb(exported(folder, two_halves()));
    for (const json& mesh : plain.document["meshes"])
        for (const json& primitive : mesh["primitives"]) CHECK_FALSE(primitive["attributes"].contains("TEXCOORD_0"));

    const Glb glb = read_glb(exported(folder, two_halves(), {.sites = sites}));
    for (const json& mesh : glb.document["meshes"]) {
        CHECK_FALSE(mesh["primitives"][0]["attributes"].contains("TEXCOORD_0"));
        const json& attributes = mesh["primitives"][1]["attributes"];
        const json& accessor = glb.document["accessors"][attributes["TEXCOORD_0"].get<size_t>()];
        const json& view = glb.document["bufferViews"][accessor["bufferView"].get<size_t>()];
        CHECK(accessor["type"] == "VEC2");
        CHECK(view["byteStride"] == 8);
        const auto positions = vectors(glb, attributes["POSITION"].get<size_t>());
        REQUIRE(accessor["count"] == positions.size());
        std::vector<glm::vec2> uv(positions.size());
        const size_t at = view["byteOffset"].get<size_t>() + accessor["byteOffset"].get<size_t>();
        REQUIRE(at + uv.size() * 8 <= glb.binary.size());
        std::memcpy(uv.data(), glb.binary.data() + at, uv.size() * 8);
        for (size_t a = 0; a < uv.size(); ++a)
            for (size_t b = 0; b < a; ++b)
                CHECK(glm::distance(uv[a], uv[b]) == doctest::Approx(glm::distance(positions[a], positions[b])));
    }
}

TEST_CASE("export: merged pieces keep the normals of all their cuts") {
    const TriangleMesh ball = icosphere(3);
    const auto sites = uniform_sites(bounds(ball), 40, 2);
    Settings settings;
    for (uint32_t k = 0; k < sites.size(); ++k) settings.groups.push_back(k % 2);
    const auto fragments = fracture(ball, sites, settings);
    REQUIRE(fragments);
    const test::Folder folder;
    const Glb glb = read_glb(exported(folder, *fragments, {.sites = sites}));
    size_t triangles = 0;
    for (const json& mesh : glb.document["meshes"]) {
        for (const json& primitive : mesh["primitives"]) {
            const auto positions = vectors(glb, primitive["attributes"]["POSITION"].get<size_t>());
            const auto normals = vectors(glb, primitive["attributes"]["NORMAL"].get<size_t>());
            const json& accessor = glb.document["accessors"][primitive["indices"].get<size_t>()];
            REQUIRE(accessor["componentType"] == 5123);
            const json& view = glb.document["bufferViews"][accessor["bufferView"].get<size_t>()];
            std::vector<uint16_t> indices(accessor["count"].get<size_t>());
            std::memcpy(indices.data(),
                        glb.binary.data() + view["byteOffset"].get<size_t>() + accessor["byteOffset"].get<size_t>(),
                        indices.size() * 2);
            for (size_t k = 0; k < indices.size(); k += 3) {
                const glm::vec3 &a = positions[indices[k]], &b = positions[indices[k + 1]],
                                &c = positions[indices[k + 2]];
                const glm::vec3 own = glm::cross(b - a, c - a);
                if (glm::length(own) < 1e-4f) continue; // too small for float
                CHECK(glm::dot(glm::normalize(own), normals[indices[k]]) > 0.999f);
                ++triangles;
            }
        }
    }
    CHECK(triangles > 1000);
}

TEST_CASE("export: equal input gives equal bytes") {
    const test::Folder folder;
    const std::string first = test::read_text(exported(folder, two_halves()));
    CHECK(test::read_text(exported(folder, two_halves())) == first);
}

TEST_CASE("export objects: bad objects are refused, and those before them are written") {
    const test::Folder folder;
    const fs::path file = folder.path / "scene.glb";
    ObjectExport scene;
    CHECK(scene.write(file).error().status == Status::invalid_setting);
    REQUIRE(scene.add(two_halves(), {.name = "a"}));
    const std::vector<PiecePose> one_pose(1);
    Fragments negative = two_halves();
    negative.pieces[1].mass.volume = -1.0;
    CHECK(scene.add(two_halves(), {.name = "b", .poses = one_pose}).error().status == Status::invalid_setting);
    CHECK(scene.add(two_halves(), {.name = "b", .recipe = "[]"}).error().status == Status::invalid_setting);
    CHECK(scene.add(negative, {.name = "b"}).error().status == Status::inverted_part);
    REQUIRE(scene.add({}, {.name = "nothing left"}));
    REQUIRE(scene.write(file));
    const Glb glb = read_glb(file);
    CHECK(glb.document["nodes"].size() == 4);
    CHECK(glb.document["scenes"][0]["nodes"] == json({0, 3}));
    CHECK(glb.document["nodes"][3]["name"] == "nothing left");
    CHECK_FALSE(glb.document["nodes"][3].contains("children"));
}

TEST_CASE("export objects: each is a root with its pieces as one file has them, and equal materials are written once") {
    const test::Folder folder;
    const fs::path file = folder.path / "scene.glb";
    const Image stone{"stone", "image/png", {std::byte{1}, std::byte{2}}}, wood{"wood", "image/png", {std::byte{3}}};
    Fragments bonded = two_halves();
    bonded.bonds.push_back({0, 1, 1.6, {0.1, 0.1, 0.2}, {1.0, 0.0, 0.0}});
    const std::vector<PiecePose> poses{{{1.0, 2.0, 3.0}, glm::dquat(0.6, 0.0, 0.8, 0.0)}, {}};
    ObjectExport scene;
    REQUIRE(scene.add(bonded, {.name = "a", .recipe = R"({"x":1})", .interior_image = stone}));
    REQUIRE(scene.add(two_halves(), {.name = "b", .poses = poses, .interior_image = wood}));
    REQUIRE(scene.add(two_halves(), {.name = "c", .interior_image = stone}));
    REQUIRE(scene.write(file));
    const Glb glb = read_glb(file), alone = read_glb(exported(folder, bonded, {.name = "a", .interior_image = stone}));
    const json &nodes = glb.document["nodes"], &of_one = alone.document["nodes"];
    CHECK(glb.document["scenes"][0]["nodes"] == json({0, 3, 6}));
    CHECK(nodes[0]["extras"]["brittle"] == json({{"object", "a"}, {"recipe", {{"x", 1}}}}));
    CHECK(nodes[0]["children"] == json({1, 2}));
    CHECK(nodes[1] == of_one[1]); // with its bond
    CHECK(nodes[2] == of_one[2]);
    CHECK(nodes[4]["name"] == "b_000");
    CHECK(nodes[4]["translation"] == json({1.0, 2.0, 3.0}));
    CHECK_FALSE(nodes[7]["extras"]["brittle"].contains("bonds")); // those of a are a's
    const auto interior = [&](size_t node) {
        const json& mesh = glb.document["meshes"][nodes[node]["mesh"].get<size_t>()];
        const json& material = glb.document["materials"][mesh["primitives"].back()["material"].get<size_t>()];
        const json& texture = material["pbrMetallicRoughness"]["baseColorTexture"]["index"];
        return glb.document["images"][glb.document["textures"][texture.get<size_t>()]["source"].get<size_t>()]["name"];
    };
    CHECK(interior(1) == "stone");
    CHECK(interior(4) == "wood");
    CHECK(interior(7) == "stone");
    CHECK(glb.document["materials"].size() == 3); // an exterior and two interiors
    CHECK(glb.document["textures"].size() == 2);
    CHECK(glb.document["images"].size() == 2);
    CHECK(glb.document["samplers"].size() == 1);
    for (const size_t node : {1u, 2u, 7u, 8u}) {
        const auto positions = [](const Glb& of, const json& at) {
            const json& mesh = of.document["meshes"][at["mesh"].get<size_t>()];
            return vectors(of, mesh["primitives"][0]["attributes"]["POSITION"].get<size_t>());
        };
        CHECK(positions(glb, nodes[node]) == positions(alone, of_one[node > 2 ? node - 6 : node]));
    }
}

namespace {

Image image_of(const std::string& name, unsigned char byte) {
    // The first bytes of a PNG file, by which readers know it.
    Image image{name, "image/png", {}};
    for (const unsigned char one : {0x89, 0x50, 0x4e, 0x47, 0x0d, 0x0a, 0x1a, 0x0a, int{byte}})
        image.bytes.push_back(std::byte{one});
    return image;
}

// A cube whose triangles have the materials in turn.
Model cube_of(const std::vector<Material>& materials, const std::vector<Image>& images,
              const std::vector<uint32_t>& in_turn) {
    Model model;
    model.mesh = cube();
    model.materials = materials;
    model.images = images;
    for (uint32_t k = 0; k < images.size(); ++k) model.textures.push_back({.image = k});
    for (uint32_t t = 0; t < model.mesh.triangles.size(); ++t) {
        model.material_of.push_back(in_turn[t % in_turn.size()]);
        for (int k = 0; k < 3; ++k) model.uv[0].emplace_back(t, k);
    }
    return model;
}

// The image of a texture of a model; empty where it has none.
std::string image_named(const Model& looks, const std::optional<TextureUse>& use) {
    if (!use) return {};
    const std::optional<uint32_t> image = looks.textures.at(use->texture).image;
    return image ? looks.images.at(*image).name : "none";
}

} // namespace

TEST_CASE("export objects: each has the materials of its source, and equal ones, with their images, are written once") {
    const test::Folder folder;
    const auto on = [](uint32_t texture) { return TextureUse{.texture = texture}; };
    const Image oak = image_of("oak", 1), tin = image_of("tin", 2), unused = image_of("unused", 3);
    const std::vector<Material> materials{{.name = "oak", .base_colour_texture = on(0)},
                                          {.name = "tin", .metallic = 1.0, .base_colour_texture = on(1)}};
    // The same in another order, between others; a clear coat refers to a texture by its number.
    const std::vector<Material> others{
        {.name = "unused", .base_colour_texture = on(0)},
        {.name = "tin", .metallic = 1.0, .base_colour_texture = on(2)},
        {.name = "coat",
         .extensions = R"({"KHR_materials_clearcoat": {"clearcoatFactor": 1, "clearcoatTexture": {"index": 1}}})"}};
    const Model first = cube_of(materials, {oak, tin}, {0, 1, no_material});
    Model second = cube_of(others, {}, {1, 2});
    const std::vector<Image> images{unused, oak, tin}; // apart from their model
    for (uint32_t k = 0; k < 3; ++k) second.textures.push_back({.image = k});
    const glm::dvec3 sites[] = {{-0.2, 0.0, 0.0}, {0.3, 0.1, 0.0}};
    ObjectExport scene;
    for (const char* name : {"a", "b"})
        REQUIRE(scene.add(*fracture(first.mesh, sites), {.name = name, .source = &first, .uv_by_plane = true}));
    REQUIRE(scene.add(*fracture(second.mesh, sites),
                      {.name = "c", .source = &second, .images = &images, .uv_by_plane = true}));
    REQUIRE(scene.add(*fracture(first.mesh, sites), {.name = "d"}));
    const fs::path file = folder.path / "scene.glb";
    REQUIRE(scene.write(file));

    const Glb glb = read_glb(file);
    CHECK(glb.document["images"].size() == 2); // what is not used is left out
    CHECK(glb.document["textures"].size() == 2);
    CHECK(glb.document["materials"].size() == 5); // oak, tin, exterior, interior, coat
    CHECK(glb.document["extensionsUsed"] == json({"KHR_materials_clearcoat"}));

    const auto read = import_scene(file, true);
    REQUIRE(read);
    CHECK(read->notes.empty());
    REQUIRE(read->nodes.size() == 8);
    const std::map<std::string, std::set<std::string>> expected{
        {"a", {"exterior", "interior", "oak of oak", "tin of tin"}},
        {"b", {"exterior", "interior", "oak of oak", "tin of tin"}},
        {"c", {"coat", "interior", "tin of tin"}},
        {"d", {"exterior", "interior"}}};
    for (const SceneNode& node : read->nodes) {
        CAPTURE(node.name);
        std::set<std::string> shown;
        for (const uint32_t m : read->meshes[node.mesh].looks.material_of) {
            REQUIRE(m != no_material);
            const Material& material = read->looks.materials[m];
            const std::string image = image_named(read->looks, material.base_colour_texture);
            shown.insert(material.name + (image.empty() ? "" : " of " + image));
            CHECK(material.metallic == (material.name == "tin" ? 1.0 : 0.0));
            if (material.name != "coat") continue;
            const json coat = json::parse(material.extensions)["KHR_materials_clearcoat"]["clearcoatTexture"];
            CHECK(image_named(read->looks, TextureUse{.texture = coat["index"]}) == "oak");
        }
        CHECK(shown == expected.at(node.name.substr(0, 1)));
    }
    // The first object is as in a file of its own.
    REQUIRE(export_pieces(folder.path / "alone.glb", *fracture(first.mesh, sites), {},
                          {.name = "a", .source = &first, .uv_by_plane = true}));
    const Glb alone = read_glb(folder.path / "alone.glb");
    for (size_t k = 0; k < alone.document["materials"].size(); ++k)
        CHECK(glb.document["materials"][k] == alone.document["materials"][k]);
    CHECK(glb.document["textures"] == alone.document["textures"]);
    for (size_t k = 0; k < alone.document["meshes"].size(); ++k)
        CHECK(glb.document["meshes"][k]["primitives"].size() == alone.document["meshes"][k]["primitives"].size());
}
