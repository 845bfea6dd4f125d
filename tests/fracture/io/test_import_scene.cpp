// import_scene(): the nodes of a glTF file.
#include <string>

#include <doctest/doctest.h>
#include <glm/gtc/matrix_transform.hpp>

#include "fracture/io/export.h"
#include "fracture/io/import.h"
#include "fracture/shapes/shapes.h"
#include "tests/folder.h"
#include "tests/fracture/mesh_checks.h"
#include "tests/glb_file.h"

using namespace brittle::fracture;
using brittle::test_files::Folder;
using brittle::test_files::GlbFile;

namespace {

MeshScene scene_of(const GlbFile& glb, const std::string& members) {
    const Folder folder;
    Result<MeshScene> scene = import_scene(folder.write("scene.glb", glb.bytes(members)));
    if (!scene) FAIL(scene.error().message);
    return std::move(*scene);
}

void check_refused(const std::string& bytes, Status status, const std::string& words) {
    const Folder folder;
    const Result<MeshScene> scene = import_scene(folder.write("scene.glb", bytes));
    REQUIRE(!scene);
    CAPTURE(scene.error().message);
    CHECK(std::string(to_string(scene.error().status)) == to_string(status));
    CHECK(scene.error().message.find("scene.glb: ") != std::string::npos);
    CHECK(scene.error().message.find(words) != std::string::npos);
}

TriangleMesh single_triangle() {
    return {{{0.0, 0.0, 0.0}, {1.0, 0.0, 0.0}, {0.0, 1.0, 0.0}}, {{0, 1, 2}}};
}

double difference(const glm::dmat4& a, const glm::dmat4& b) {
    double most = 0.0;
    for (int k = 0; k < 16; ++k) most = std::max(most, std::abs(a[k / 4][k % 4] - b[k / 4][k % 4]));
    return most;
}

} // namespace

TEST_CASE("import scene: files without nodes that show triangles are refused") {
    GlbFile glb;
    glb.add_mesh(single_triangle());
    const Folder folder;
    CHECK(import_scene(folder / "none.glb").error().status == Status::file_not_found);
    const auto other = import_scene(folder.write("cube.obj", "v 0 0 0\n"));
    CHECK(other.error().status == Status::unsupported_format);
    CHECK(other.error().message.find("only .glb and .gltf files have nodes") != std::string::npos);
    check_refused("", Status::malformed_file, "empty");
    check_refused(glb.bytes(R"("nodes": [])"), Status::empty_mesh, "no triangles");
    check_refused(glb.bytes(R"("nodes": [{"camera": 0}, {"name": "empty"}])"), Status::empty_mesh, "no triangles");
    check_refused(glb.bytes(R"("nodes": [{"mesh": 7}])"), Status::malformed_file, "meshes[7]");
    check_refused(glb.bytes(R"("nodes": [{"mesh": "a"}])"), Status::malformed_file, "meshes");
    check_refused(glb.bytes(R"("nodes": [{"mesh": 0, "scale": [1e308, 1, 1], "children": [1]},
                                         {"mesh": 0, "scale": [1e308, 1, 1]}])"),
                  Status::malformed_file, "nodes[1] has a transform that is not finite");
    check_refused(
        glb.bytes(R"("nodes": [{"mesh": 0, "children": [1]}, {"children": [0]}], "scenes": [{"nodes": [0]}])"),
        Status::malformed_file, "nodes[0] is reached twice");
}

TEST_CASE("import scene: a mesh counts once however many nodes show it, and meshes reach the limit together") {
    GlbFile glb;
    glb.add_mesh(icosphere(4, 1.0)); // 5,120 triangles
    std::string nodes;
    for (int k = 0; k < 3000; ++k) nodes += std::string(k > 0 ? ", " : "") + R"({"mesh": 0})";
    CHECK(scene_of(glb, R"("nodes": [)" + nodes + "]").nodes.size() == 3000); // 15 million triangles, if joined
    const std::string mesh = R"({"primitives": [{"attributes": {"POSITION": 0}}]})";
    check_refused(GlbFile().bytes(R"("accessors": [{"componentType": 5126, "type": "VEC3", "count": 600000}],
                                     "meshes": [)"
                                  + mesh + ", " + mesh + R"(], "nodes": [{"mesh": 0}, {"mesh": 1}])"),
                  Status::malformed_file, "meshes[1].primitives[0]: with it the nodes of the file show over 10");
}

TEST_CASE("import scene: nodes have names, meshes, materials and custom properties, and instances share a mesh") {
    GlbFile glb;
    glb.add_mesh(single_triangle(), R"("name": "Blade", "extras": {"wear": 0.5})", 1);
    glb.add_mesh(cuboid({1.0, 2.0, 3.0}));
    glb.add_mesh(single_triangle()); // of no node
    const MeshScene scene = scene_of(glb, R"("materials": [{"name": "Oak"}, {"name": "Steel"}], "cameras": [{}],
        "nodes": [{"name": "Knife", "mesh": 0, "extras": {"kind": "tool", "n": [1, 2]}}, {"mesh": 0}, {"mesh": 1},
                  {"name": "Knife", "mesh": 0}, {"name": "Knife 2", "mesh": 1}, {"name": "Sun", "extensions": {}},
                  {"name": "Eye", "camera": 0}, {"name": "Unused", "mesh": 1}],
        "scenes": [{"nodes": [0]}, {"nodes": [2, 0, 1, 3, 4, 5, 6]}], "scene": 1)");
    REQUIRE(scene.nodes.size() == 5);
    const char* const names[] = {"node 2", "Knife", "Blade", "Knife 2", "Knife 2 2"}; // in the order of the scene
    const uint32_t mesh_of[] = {0, 1, 1, 1, 0};
    for (size_t k = 0; k < 5; ++k) {
        CHECK(scene.nodes[k].name == names[k]);
        CHECK(scene.nodes[k].mesh == mesh_of[k]);
        CHECK(scene.nodes[k].world == glm::dmat4(1.0));
    }
    CHECK(scene.nodes[1].extras == R"({"kind":"tool","n":[1,2]})");
    CHECK(scene.nodes[2].extras.empty());
    REQUIRE(scene.meshes.size() == 2);
    CHECK(scene.meshes[0].mesh.triangles.size() == 12);
    CHECK(scene.meshes[0].mesh.positions.size() == 8);
    CHECK(scene.meshes[0].materials.empty());
    CHECK(scene.meshes[1].name == "Blade");
    CHECK(scene.meshes[1].extras == R"({"wear":0.5})");
    CHECK(scene.meshes[1].materials == std::vector<std::string>{"Steel"});
    CHECK(scene.notes.empty());
}

TEST_CASE("import scene: a mesh without triangles leaves its nodes out, with notes") {
    GlbFile glb;
    glb.add_mesh(single_triangle());
    TriangleMesh needle = single_triangle();
    needle.positions[2] = needle.positions[1];
    glb.add_mesh(needle);
    const MeshScene scene = scene_of(glb, R"("nodes": [{"name": "needle", "mesh": 1}, {"name": "leaf", "mesh": 0}])");
    REQUIRE(scene.nodes.size() == 1);
    CHECK(scene.nodes[0].name == "leaf");
    CHECK(scene.nodes[0].mesh == 0);
    REQUIRE(scene.meshes.size() == 1);
    CHECK(scene.meshes[0].mesh.triangles.size() == 1);
    REQUIRE(scene.notes.size() == 1);
    CHECK(scene.notes[0].find("node 'needle' is left out") == 0);
}

TEST_CASE("import scene: transforms multiply down the tree, and the nodes together are what import_mesh() joins") {
    GlbFile glb;
    glb.add_mesh(cuboid({1.0, 2.0, 3.0}));
    glb.add_mesh(icosphere(1, 0.5));
    const std::string members = R"("nodes": [
        {"translation": [1, 2, 3], "rotation": [0, 0, 0.7071067811865476, 0.7071067811865476], "children": [1, 2]},
        {"name": "stretched", "mesh": 0, "scale": [2, 1, 1], "children": [3]},
        {"name": "mirrored", "mesh": 1, "scale": [1, -1, 1], "translation": [0, 5, 0]},
        {"name": "skewed", "mesh": 1, "rotation": [0, 0, 0.3826834323650898, 0.9238795325112867], "translation": [4, 0, 0]}],
        "scenes": [{"nodes": [0]}])";
    const MeshScene scene = scene_of(glb, members);
    REQUIRE(scene.nodes.size() == 3);
    const glm::dvec3 z(0.0, 0.0, 1.0);
    const glm::dmat4 root = glm::rotate(glm::translate(glm::dmat4(1.0), {1.0, 2.0, 3.0}), glm::radians(90.0), z);
    const glm::dmat4 stretched = glm::scale(root, {2.0, 1.0, 1.0});
    const glm::dmat4 skewed = glm::rotate(glm::translate(stretched, {4.0, 0.0, 0.0}), glm::radians(45.0), z);
    const glm::dmat4 mirrored = glm::scale(glm::translate(root, {0.0, 5.0, 0.0}), {1.0, -1.0, 1.0});
    CHECK(scene.nodes[0].name == "stretched"); // depth first
    CHECK(scene.nodes[1].name == "skewed");
    CHECK(scene.nodes[2].name == "mirrored");
    CHECK(difference(scene.nodes[0].world, stretched) < 1e-14);
    CHECK(difference(scene.nodes[1].world, skewed) < 1e-14);
    CHECK(difference(scene.nodes[2].world, mirrored) < 1e-14);

    const Folder folder;
    const auto joined = import_mesh(folder.write("scene.glb", glb.bytes(members)));
    REQUIRE(joined);
    double volume = 0.0;
    size_t triangles = 0;
    for (const SceneNode& node : scene.nodes) {
        const TriangleMesh& mesh = scene.meshes[node.mesh].mesh;
        CHECK(test::signed_volume(mesh) > 0.0); // the mirroring is the transform's alone
        volume += test::signed_volume(mesh) * std::abs(glm::determinant(glm::dmat3(node.world)));
        triangles += mesh.triangles.size();
    }
    CHECK(triangles == joined->triangles.size());
    CHECK(test::signed_volume(*joined) == doctest::Approx(volume).epsilon(1e-12));
}

TEST_CASE("import scene: nodes that are collision shapes by their names are left out, with one note") {
    GlbFile glb;
    for (int k = 0; k < 3; ++k) glb.add_mesh(cube(1.0 + k));
    const MeshScene scene = scene_of(glb, R"("nodes": [{"name": "crate", "mesh": 1, "children": [1, 2]},
        {"name": "UCX_crate_00", "mesh": 0}, {"name": "lid", "mesh": 2}, {"name": "crate-convcolonly", "mesh": 0},
        {"name": "UCXbox", "mesh": 1}], "scenes": [{"nodes": [0, 3, 4]}], "scene": 0)");
    REQUIRE(scene.nodes.size() == 3);
    CHECK(scene.nodes[0].name == "crate");
    CHECK(scene.nodes[1].name == "lid");
    CHECK(scene.nodes[2].name == "UCXbox");
    CHECK(scene.meshes.size() == 2);
    CHECK(bounds(scene.meshes[scene.nodes[1].mesh].mesh).size().x == doctest::Approx(3.0));
    REQUIRE(scene.notes.size() == 1);
    CHECK(scene.notes[0].find("2 nodes that are collision shapes") == 0);
    check_refused(glb.bytes(R"("nodes": [{"name": "a-colonly", "mesh": 0}])"), Status::empty_mesh, "no triangles");
}

TEST_CASE("import scene: with looks each mesh has the attributes of its corners, and the scene the materials") {
    GlbFile glb;
    glb.add_mesh(cube(), "", 1);
    glb.add_mesh(cuboid({1.0, 2.0, 3.0}));
    glb.add_mesh(icosphere(1), "", 7); // there is no such material
    const Folder folder;
    const auto file = folder.write("scene.glb", glb.bytes(R"("nodes": [{"mesh": 0}, {"mesh": 1}, {"mesh": 2},
        {"mesh": 0, "translation": [5, 0, 0]}], "materials": [{"name": "Oak"}, {"name": "Steel", "pbrMetallicRoughness":
        {"baseColorFactor": [0.5, 0.25, 0.125, 1], "baseColorTexture": {"index": 0}}}],
        "textures": [{"source": 0}], "images": [{"uri": "none.png"}])"));
    const Result<MeshScene> scene = import_scene(file, true);
    REQUIRE(scene);
    REQUIRE(scene->meshes.size() == 3);
    REQUIRE(scene->looks.materials.size() == 2);
    CHECK(scene->looks.materials[1].base_colour == glm::dvec4(0.5, 0.25, 0.125, 1.0));
    CHECK(scene->looks.textures.size() == 1);
    CHECK(scene->looks.images.size() == 1);
    REQUIRE(scene->looks.notes.size() == 1);
    CHECK(scene->looks.notes[0].find("image 0") == 0);
    CHECK(scene->notes.empty());
    const Model steel = model_of(*scene, 0);
    CHECK(steel.material_of == std::vector<uint32_t>(12, 1));
    CHECK(steel.materials.size() == 2);
    CHECK(steel.textures.size() == 1);
    CHECK(steel.images.empty());
    CHECK(steel.mesh.triangles.size() == 12);
    CHECK(has_looks(steel));
    for (const uint32_t mesh : {1u, 2u}) CHECK_FALSE(has_looks(model_of(*scene, mesh)));

    const Result<MeshScene> plain = import_scene(file);
    REQUIRE(plain);
    CHECK(plain->looks.materials.empty());
    CHECK(plain->looks.notes.empty());
    for (uint32_t mesh = 0; mesh < 3; ++mesh) {
        CHECK_FALSE(has_looks(model_of(*plain, mesh)));
        CHECK(plain->meshes[mesh].mesh.triangles == scene->meshes[mesh].mesh.triangles);
        CHECK(plain->meshes[mesh].mesh.positions == scene->meshes[mesh].mesh.positions);
    }
}

TEST_CASE("import scene: the looks of a node are those of the whole file") {
    const Folder folder;
    Model crate; // texture coordinates, normals, colours, two materials and none
    crate.mesh = cube(1.0);
    for (uint32_t t = 0; t < crate.mesh.triangles.size(); ++t) {
        crate.material_of.push_back(t % 3 == 2 ? no_material : t % 3);
        for (int k = 0; k < 3; ++k) {
            const glm::dvec3& p = crate.mesh.positions[crate.mesh.triangles[t][k]];
            crate.uv[0].emplace_back(p.x, p.y);
            crate.uv[1].emplace_back(p.z, p.x);
            crate.normals.emplace_back(t % 2 == 0 ? glm::vec3(0.0f, 1.0f, 0.0f) : glm::vec3(0.6f, 0.0f, 0.8f));
            crate.colours.emplace_back(p.x + 0.5, p.y + 0.5, p.z + 0.5, 1.0);
        }
    }
    crate.materials.resize(2);
    crate.materials[0].name = "a";
    crate.materials[1].name = "b";
    const std::string file = folder / "crate.glb";
    REQUIRE(export_model(file, crate));
    const Result<Model> whole = import_model(file);
    const Result<MeshScene> scene = import_scene(file, true);
    REQUIRE(whole);
    REQUIRE(scene);
    REQUIRE(scene->meshes.size() == 1);
    const Model node = model_of(*scene, 0);
    REQUIRE(whole->normals.size() == 36);
    REQUIRE(whole->colours.size() == 36);
    CHECK(node.mesh.triangles == whole->mesh.triangles);
    CHECK(node.uv == whole->uv);
    CHECK(node.normals == whole->normals);
    CHECK(node.colours == whole->colours);
    CHECK(node.material_of == whole->material_of);
    CHECK(node.materials.size() == whole->materials.size());
}

TEST_CASE("import scene: meshes with and without attributes are appended to each other") {
    Model plain, rich;
    plain.mesh = rich.mesh = single_triangle();
    rich.uv[1] = {{0.1f, 0.2f}, {0.3f, 0.4f}, {0.5f, 0.6f}};
    rich.colours.assign(3, glm::vec4(0.5f));
    rich.material_of = {3};
    Model joined;
    for (const Model* one : {&plain, &rich, &plain}) append_mesh(joined, *one);
    CHECK(joined.mesh.positions.size() == 9);
    CHECK(joined.mesh.triangles == std::vector<Triangle>{{0, 1, 2}, {3, 4, 5}, {6, 7, 8}});
    CHECK(joined.uv[0].empty());
    CHECK(joined.normals.empty());
    REQUIRE(joined.uv[1].size() == 9);
    CHECK(joined.uv[1][0] == glm::vec2(0.0f));
    CHECK(joined.uv[1][4] == glm::vec2(0.3f, 0.4f));
    CHECK(joined.uv[1][8] == glm::vec2(0.0f));
    CHECK(joined.colours[2] == glm::vec4(1.0f));
    CHECK(joined.colours[3] == glm::vec4(0.5f));
    CHECK(joined.colours.size() == 9);
    CHECK(joined.material_of == std::vector<uint32_t>{no_material, 3, no_material});
}
