// Content of glTF files that is left out with a note, and compressed files, which are refused.
#include <string>

#include <doctest/doctest.h>

#include "fracture/io/import.h"
#include "tests/folder.h"

using namespace brittle::fracture;
using brittle::test_files::Folder;

namespace {

// A tetrahedron in a .gltf file and its buffer: accessor 0 has the positions, 1 the indices, 2 red as VEC3, 3 and 4 four
// vectors of three and of four components.
struct Tetrahedron {
    std::string attributes{};                      // members besides POSITION
    std::string primitive = R"("indices": 1)";     // members besides the attributes
    std::string members{};                         // at the top, each after a comma
    std::string nodes = R"([{"mesh": 0}])";        // of the file
    std::string position = R"("bufferView": 0, )"; // of the accessor of positions
    std::string further_meshes{};                  // each after a comma

    [[nodiscard]] std::string text() const {
        return R"({"asset": {"version": "2.0"}, "scene": 0, "scenes": [{"nodes": [0]}], "nodes": )" + nodes
               + R"(, "meshes": [{"primitives": [{"attributes": {"POSITION": 0)" + attributes + "}, " + primitive
               + "}]}" + further_meshes + R"(], "accessors": [{)" + position
               + R"("componentType": 5126, "count": 4, "type": "VEC3"},
                   {"bufferView": 1, "componentType": 5121, "count": 12, "type": "SCALAR"},
                   {"bufferView": 2, "componentType": 5126, "count": 4, "type": "VEC3"},
                   {"bufferView": 2, "componentType": 5126, "count": 4, "type": "VEC3"},
                   {"bufferView": 2, "componentType": 5126, "count": 3, "type": "VEC4"}],
                  "bufferViews": [{"buffer": 0, "byteLength": 48}, {"buffer": 0, "byteOffset": 48, "byteLength": 12},
                                  {"buffer": 0, "byteOffset": 60, "byteLength": 48}],
                  "buffers": [{"byteLength": 108, "uri": "b.bin"}])"
               + members + "}";
    }

    [[nodiscard]] Result<Model> import() const {
        const Folder folder;
        const float corners[] = {0, 0, 0, 2, 0, 0, 0, 3, 0, 0, 0, 4}, red[] = {1, 0, 0, 1, 0, 0, 1, 0, 0, 1, 0, 0};
        std::string bytes(reinterpret_cast<const char*>(corners), sizeof corners);
        bytes += std::string("\0\2\1\0\1\3\0\3\2\1\2\3", 12);
        bytes.append(reinterpret_cast<const char*>(red), sizeof red);
        (void)folder.write("b.bin", bytes);
        return import_model(folder.write("a.gltf", text()));
    }
};

Model imported(const Tetrahedron& file) {
    Result<Model> model = file.import();
    if (!model) FAIL(model.error().message);
    return std::move(*model);
}

void check_refused(const Tetrahedron& file, const std::string& words) {
    const Result<Model> model = file.import();
    REQUIRE(!model);
    CAPTURE(model.error().message);
    CHECK(model.error().status == Status::malformed_file);
    CHECK(model.error().message.find("a.gltf: ") != std::string::npos);
    CHECK(model.error().message.find(words) != std::string::npos);
}

} // namespace

TEST_CASE("glTF left out: a file with nothing to leave out has no note") {
    CHECK(imported({}).notes.empty());
    CHECK(imported({.members = R"(, "skins": [], "animations": [], "cameras": [], "extensions": {})"}).notes.empty());
}

TEST_CASE("glTF left out: everything that pieces do not keep is in one note") {
    Tetrahedron file;
    file.attributes = R"(, "TANGENT": 3, "TEXCOORD_2": 3, "JOINTS_0": 3, "WEIGHTS_0": 3)";
    file.primitive = R"("indices": 1, "targets": [{"POSITION": 3}, {"POSITION": 3}])";
    file.further_meshes =
        R"(, {"primitives": [{"attributes": {"POSITION": 0, "TANGENT": 3}, "mode": 1}, {"attributes": {"TANGENT": 3}}]})";
    file.nodes =
        R"([{"mesh": 0, "skin": 0, "extensions": {"EXT_mesh_gpu_instancing": {"attributes": {"TRANSLATION": 3}}}}])";
    file.members = R"(, "skins": [{"joints": [0]}], "animations": [{}, {}], "cameras": [{"type": "perspective"}],
                      "extensions": {"KHR_lights_punctual": {"lights": [{}, {}, {}]}})";
    const Model model = imported(file);
    CHECK(model.mesh.triangles.size() == 4);
    REQUIRE(model.notes.size() == 1);
    CHECK(model.notes[0]
          == "left out, because pieces do not keep it: 1 skin (meshes keep the shape without it), 2 animations, morph "
             "targets of 1 mesh, tangents of 2 meshes (new ones are made for normal maps), further texture coordinates "
             "or colours of 1 mesh, points or "
             "lines of 1 mesh, instances of 1 node, 1 camera, 3 lights");
}

TEST_CASE("glTF left out: damaged lists give no note and no crash") {
    Tetrahedron file;
    file.members = R"(, "skins": 7, "animations": {}, "cameras": "a", "extensions": {"KHR_lights_punctual": [1]})";
    file.further_meshes =
        R"(, 3, {"primitives": 4}, {"primitives": [5, {"attributes": 6, "targets": 7, "mode": "a"}]})";
    file.nodes = R"([{"mesh": 0, "extensions": {"EXT_mesh_gpu_instancing": 8}}, 9, {"extensions": []}])";
    CHECK(imported(file).notes.empty());
}

TEST_CASE("glTF left out: colours of three components are read without a note, others are left out with one") {
    const Model three = imported({.attributes = R"(, "COLOR_0": 2)"});
    CHECK(three.notes.empty());
    REQUIRE(three.colours.size() == 12);
    for (const glm::vec4& colour : three.colours) CHECK(colour == glm::vec4(1.0f, 0.0f, 0.0f, 1.0f));
    const Model short_of_one = imported({.attributes = R"(, "COLOR_0": 4)"});
    CHECK(short_of_one.colours.empty());
    REQUIRE(short_of_one.notes.size() == 1);
    CHECK(short_of_one.notes[0].find("COLOR_0") == 0);
}

TEST_CASE("glTF left out: compressed files are refused by name, with the command that decompresses them") {
    const std::string command = "npx @gltf-transform/cli copy IN.glb OUT.glb";
    for (const std::string extension : {"KHR_draco_mesh_compression", "EXT_meshopt_compression"}) {
        CAPTURE(extension);
        const std::string lists =
            R"(, "extensionsUsed": [")" + extension + R"("], "extensionsRequired": [")" + extension + R"("])";
        check_refused({.members = lists}, extension);
        check_refused({.members = lists}, command);
    }
    // Draco geometry that the file calls optional, without the vertices for other readers.
    Tetrahedron only_draco;
    only_draco.primitive =
        R"("indices": 1, "extensions": {"KHR_draco_mesh_compression": {"bufferView": 2, "attributes": {"POSITION": 0}}})";
    only_draco.members = R"(, "extensionsUsed": ["KHR_draco_mesh_compression"])";
    CHECK(imported(only_draco).mesh.triangles.size() == 4); // the vertices are there
    only_draco.position.clear();
    check_refused(only_draco, "KHR_draco_mesh_compression");
    check_refused(only_draco, command);
    check_refused({.members = R"(, "extensionsRequired": ["ACME_cloth"])"}, "needs the glTF extension");
}
