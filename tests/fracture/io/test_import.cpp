#include "fracture/io/import.h"

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <cstring>
#include <ctime>
#include <fstream>
#include <iterator>
#include <span>
#include <string>

#include <doctest/doctest.h>
#include <sys/stat.h>
#include <unistd.h>

#include "fracture/base/random.h"
#include "fracture/doctor/repair.h"
#include "fracture/io/readers.h"
#include "tests/fracture/mesh_checks.h"

using namespace brittle::fracture;
using test::is_closed;
using test::signed_volume;
namespace fs = std::filesystem;

namespace {

const fs::path meshes = fs::path(BRITTLE_CORPUS) / "meshes";
const fs::path glmark2 = "/usr/share/glmark2/models";

void write(const fs::path& file, const std::string& text) {
    std::ofstream(file, std::ios::binary) << text;
}

// Imports a file that must fail. Checks the status, and that the message contains the name of the file and the words.
void check_refused(const fs::path& file, Status status, const std::string& words) {
    CAPTURE(file.string());
    const Result<TriangleMesh> result = import_mesh(file);
    REQUIRE(!result);
    CAPTURE(result.error().message);
    CHECK(std::string(to_string(result.error().status)) == to_string(status));
    CHECK(result.error().message.find(file.filename().string()) != std::string::npos);
    CHECK(result.error().message.find(words) != std::string::npos);
}

void check_malformed(const char* name, const std::string& words) {
    check_refused(meshes / name, Status::malformed_file, words);
}

TriangleMesh import_valid(const fs::path& file) {
    CAPTURE(file.string());
    Result<TriangleMesh> result = import_mesh(file);
    if (!result) FAIL(result.error().message);
    return std::move(*result);
}

// The peak memory of this process since the last reset, in bytes; 0 where /proc does not give it.
uint64_t peak_memory() {
    std::ifstream status("/proc/self/status");
    for (std::string line; std::getline(status, line);)
        if (line.starts_with("VmHWM:")) return std::strtoull(line.c_str() + 6, nullptr, 10) * 1024;
    return 0;
}

void forget_peak_memory() {
    std::ofstream("/proc/self/clear_refs") << 5;
}

// Sanitizers keep freed memory for a while.
#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
constexpr uint64_t max_memory_growth = UINT64_MAX;
#else
constexpr uint64_t max_memory_growth = uint64_t{16} << 20; // bytes, over all damaged files of a format
#endif
constexpr double max_seconds = 2.0; // seconds of processor time, independent of other tests

} // namespace

TEST_CASE("import: missing files, folders, pipes and unreadable files are refused with the reason") {
    const test::Folder folder;
    check_refused(folder.path / "none.obj", Status::file_not_found, "No such file or directory");
    fs::create_directory(folder.path / "folder.obj");
    check_refused(folder.path / "folder.obj", Status::file_not_found, "is a folder");
    REQUIRE(::mkfifo((folder.path / "pipe.stl").c_str(), 0600) == 0);
    check_refused(folder.path / "pipe.stl", Status::file_not_found, "not a regular file");

    const fs::path secret = folder.path / "secret.obj";
    write(secret, "v 0 0 0\n");
    REQUIRE(::chmod(folder.path.c_str(), 0755) == 0);
    REQUIRE(::chmod(secret.c_str(), 0) == 0);
    const bool root = ::geteuid() == 0; // permissions do not apply to root
    if (root) REQUIRE(::seteuid(65534) == 0);
    const Result<TriangleMesh> result = import_mesh(secret);
    if (root) REQUIRE(::seteuid(0) == 0);
    REQUIRE(!result);
    CHECK(result.error().message.find("Permission denied") != std::string::npos);
}

TEST_CASE("import: empty and oversized files are refused without reading them") {
    check_malformed("empty.obj", "empty (0 bytes)");
    const test::Folder folder;
    const fs::path huge = folder.path / "huge.stl";
    write(huge, "x");
    std::error_code no_sparse_files;
    fs::resize_file(huge, uint64_t{5} << 30, no_sparse_files);
    if (!no_sparse_files) check_refused(huge, Status::malformed_file, "4 GiB");
}

TEST_CASE("import: unknown extensions are refused with a list of readable ones, in any letter case") {
    check_refused("mesh.fbx", Status::unsupported_format,
                  ".fbx files are not read; convert the mesh to one of .obj, .stl");
    check_refused("mesh.x3d", Status::unsupported_format, ".glb");
    check_refused("mesh", Status::unsupported_format, "no extension");
    const test::Folder folder;
    fs::copy_file(meshes / "cube.obj", folder.path / "CUBE.OBJ");
    CHECK(import_valid(folder.path / "CUBE.OBJ").triangles.size() == 12);
}

TEST_CASE("import: files without usable triangles are named as such") {
    for (const char* name : {"points_and_lines.obj", "garbage.obj", "no_triangles.stl", "points.gltf"}) {
        check_refused(meshes / name, Status::empty_mesh, "no triangles in the file");
    }
    check_refused(meshes / "all_degenerate.obj", Status::empty_mesh, "two corners at the same place");
}

TEST_CASE("import: damaged OBJ files are refused with line and value") {
    check_malformed("nan.obj", "line 3: vertex 3 needs three finite coordinates, but number 2 of them is 'nan'");
    check_malformed("out_of_range.obj", "line 15: a face names vertex 9, but the file has only 8 vertices");
    check_malformed("zero_index.obj", "line 15: a face names vertex '0'");
    check_malformed("too_negative.obj", "line 4: a face names vertex '-4'");
    check_malformed("two_corners.obj", "line 15: a face has 2 corners");
    const test::Folder folder;
    fs::copy_file(meshes / "cube_binary.stl", folder.path / "renamed.obj");
    check_refused(folder.path / "renamed.obj", Status::malformed_file, "not OBJ text");
    std::string wide = "v 0 0 0\nv 1 0 0\nv 0 1 0\nf";
    for (int k = 0; k < 5000; ++k) (wide += ' ') += std::to_string(k % 3 + 1);
    write(folder.path / "wide.obj", wide);
    check_refused(folder.path / "wide.obj", Status::malformed_file, "line 4: a face has 5000 corners");
}

TEST_CASE("import: damaged STL files are refused with promised and actual size") {
    check_malformed("cut_short_binary.stl", "promises 12 triangles, which take 684 bytes, but it has 614");
    check_malformed("cut_short_text.stl", "the file ends; it was cut short");
    check_malformed("wrong_word.stl", "line 7: 'endloop' expected, but found 'endlop'");
    check_malformed("short_header.stl", "this file has 3");
    check_malformed("nan_binary.stl", "vertex 9 lies at (nan, ");
    check_malformed("infinite_text.stl", "a finite coordinate of triangle");
}

TEST_CASE("import: damaged glTF files are refused with the element") {
    check_malformed("cut_short.glb", "it was cut short");
    check_malformed("cut_short_head.glb", "9 bytes");
    check_malformed("cut_short_inside.glb", "longer than the file");
    check_malformed("version_1.glb", "version 1");
    check_malformed("version_1.gltf", "glTF version 1.0; only 2 is read");
    check_malformed("garbage.gltf", "the JSON cannot be read");
    check_malformed("wrong_types.gltf", "scenes[0]");
    check_malformed("out_of_range.gltf", "meshes[0].primitives[0]: index 38 names vertex 8 of 8");
    check_malformed("node_cycle.gltf", "nodes[0] is reached twice");
    check_malformed("endless_accessor.gltf", "accessors[0] has 4000000000 elements");
    check_malformed("accessor_too_long.gltf", "accessors[0] has 9 elements");
    check_malformed("offset_overflows.gltf", "too short");
    check_malformed("view_too_long.gltf", "its buffer view ends at byte 96 + 100 of a buffer of 168");
    check_malformed("compressed.gltf", "KHR_draco_mesh_compression");
    check_malformed("missing_buffer.gltf", "nowhere.bin");
    check_malformed("buffer_elsewhere.gltf", "not a file below its own folder");
}

TEST_CASE("import: JSON of a million brackets and a chain of 100,000 nodes do not overflow the stack"
          * doctest::test_suite("long")) {
    const test::Folder folder;
    write(folder.path / "brackets.gltf", std::string(1'000'000, '['));
    check_refused(folder.path / "brackets.gltf", Status::malformed_file, "nested over 64 levels");
    std::string chain = R"({"asset":{"version":"2.0"},"nodes":[)";
    for (int k = 1; k < 100'000; ++k) chain += R"({"children":[)" + std::to_string(k) + "]},";
    write(folder.path / "chain.gltf", chain + "{}]}");
    check_refused(folder.path / "chain.gltf", Status::empty_mesh, "no triangles");
}

TEST_CASE("import: glTF accessors without data, which stand for zeros, are refused before they fill the memory") {
    check_malformed("accessor_of_zeros.gltf", "accessors[0] has 99999999 elements but no data");
    check_malformed("indices_of_zeros.gltf", "accessors[1] has 99999999 elements but no data");
}

TEST_CASE("import: one small mesh used by very many nodes is refused before it fills the memory") {
    // 4000 vertices of three bytes, and a triangle: 16 kB.
    const std::string zeros(size_t{4} * 4000, 'A');
    std::string bomb = R"({"asset":{"version":"2.0"},"buffers":[{"uri":"data:;base64,)" + zeros + R"("}],
        "bufferViews":[{"buffer":0,"byteLength":12000}],
        "accessors":[{"bufferView":0,"componentType":5120,"count":4000,"type":"VEC3"},
                     {"bufferView":0,"componentType":5125,"count":3,"type":"SCALAR"}],
        "meshes":[{"primitives":[{"attributes":{"POSITION":0},"indices":1}]}],"nodes":[{"mesh":0})";
    for (int k = 0; k < 1000; ++k) bomb += R"(,{"mesh":0})";
    const test::Folder folder;
    write(folder.path / "bomb.gltf", bomb + "]}");
    check_refused(folder.path / "bomb.gltf", Status::malformed_file,
                  "meshes[0].primitives[0]: with it the nodes of the file");
}

TEST_CASE("import: glTF indices are unsigned integers") {
    check_malformed("indices_of_floats.gltf", "meshes[0].primitives[0]: its indices are not unsigned integers");
}

TEST_CASE("import: a PLY face of many lists has no more corners than any other") {
    const test::Folder folder;
    std::string lists = "ply\nformat ascii 1.0\nelement vertex 3\nproperty int x\nproperty int y\nproperty int z\n"
                        "element face 1\n";
    for (int k = 0; k < 2; ++k) lists += "property list int int vertex_indices\n";
    lists += "end_header\n0 0 0\n1 0 0\n0 1 0\n";
    for (int k = 0; k < 2; ++k) {
        lists += "4000";
        for (int corner = 0; corner < 4000; ++corner) (lists += ' ') += std::to_string(corner % 3);
        lists += '\n';
    }
    write(folder.path / "lists.ply", lists);
    check_refused(folder.path / "lists.ply", Status::malformed_file, "face 0: a list of 4000");
}

TEST_CASE("import: messages contain no terminal control characters") {
    for (const char* name : {"escape_in_element.ply", "escape_in_extension.gltf", "escape_in_buffer_name.gltf"}) {
        CAPTURE(name);
        const Result<TriangleMesh> result = import_mesh(meshes / name);
        REQUIRE(!result);
        CHECK(result.error().message.find("[31m") != std::string::npos);
        CHECK(result.error().message.find('\x1b') == std::string::npos);
    }
}

TEST_CASE("import: damaged PLY files are refused with line or byte, and element") {
    check_malformed("cut_short.ply", "byte 428, face 4: the file ends before the content that its header promises");
    check_malformed("huge_count.ply", "vertex 1: the file ends before the content that its header promises");
    check_malformed("no_end.ply", "line 4: the header has no 'end_header'");
    check_malformed("bad_type.ply", "line 4: an unknown type in 'property quad x'");
    check_malformed("not_a_number.ply", "line 11, vertex 1: a number is expected, but found 'x'");
    check_malformed("out_of_range.ply", "face 0: it names vertex 7");
    const test::Folder folder;
    fs::copy_file(meshes / "cube.obj", folder.path / "renamed.ply");
    check_refused(folder.path / "renamed.ply", Status::malformed_file, "begins with a line 'ply'");
}

TEST_CASE("import: damaged OFF files are refused with line and index") {
    check_malformed("out_of_range.off", "line 6: face 0 names vertex '3'; there are 3, counted from 0");
    check_malformed("huge_count.off", "line 2: three counts are expected");
    const test::Folder folder;
    fs::copy_file(meshes / "cube_binary.stl", folder.path / "renamed.off");
    check_refused(folder.path / "renamed.off", Status::malformed_file, "binary OFF is not read");
    write(folder.path / "other.off", "4OFF\n0 0 0\n");
    check_refused(folder.path / "other.off", Status::malformed_file, "begins with '4OFF'");
    write(folder.path / "ends.off", "OFF 3 1 0\n0 0 0\n1 0 0\n");
    check_refused(folder.path / "ends.off", Status::malformed_file, "vertex 2 needs three finite coordinates");
}

TEST_CASE("import: damaged 3DS files are refused with chunk and byte") {
    check_malformed("cut_short.3ds", "chunk 3D3D at byte 16 claims 237 bytes where 207");
    check_malformed("out_of_range.3ds", "has a face 12 that names vertex 8 of 8");
    check_malformed("too_many_vertices.3ds", "chunk 4110 at byte 149 lists 900 elements");
    check_malformed("not_3ds.3ds", "does not start with the bytes 4D 4D");
    check_malformed("endless_name.3ds", "a name without a terminating zero");
}

TEST_CASE("import: the same cube comes out of every format, closed and right side out") {
    for (const char* name :
         {"cube.obj", "spelled_oddly.obj", "cube_binary.stl", "cube_named_solid.stl", "cube_text.stl",
          "cube_text_shouting.stl", "cube.glb", "cube_bytes.gltf", "cube_outside_buffer.gltf", "cube.3ds",
          "cube_text.ply", "cube_little.ply", "cube_big.ply", "cube.off"}) {
        CAPTURE(name);
        const TriangleMesh cube = import_valid(meshes / name);
        CHECK(cube.positions.size() == 8);
        CHECK(cube.triangles.size() == 12);
        CHECK(is_closed(cube.triangles));
        CHECK(signed_volume(cube) == doctest::Approx(8.0).epsilon(1e-15));
    }
}

TEST_CASE("import: concave polygons are split inside themselves") {
    for (const auto& [case_name, volume, triangles] :
         {std::tuple{"concave_prism.obj", 5.0, 28u}, std::tuple{"concave_quads.obj", 6.0, 12u}}) {
        const auto name = case_name; // clang 14 captures no structured binding
        CAPTURE(name);
        const TriangleMesh mesh = import_valid(meshes / name);
        CHECK(mesh.triangles.size() == triangles);
        CHECK(is_closed(mesh.triangles));
        CHECK(signed_volume(mesh) == doctest::Approx(volume));
        // A triangle outside the polygon would need another one that is upside down.
        for (const Triangle& t : mesh.triangles) {
            const glm::dvec3& a = mesh.positions[t.x];
            const glm::dvec3 n = glm::cross(mesh.positions[t.y] - a, mesh.positions[t.z] - a);
            if (a.z == 1.0 && mesh.positions[t.y].z == 1.0 && mesh.positions[t.z].z == 1.0) CHECK(n.z > 0.0);
        }
    }
}

TEST_CASE("import: OBJ coordinates keep double precision") {
    const test::Folder folder;
    write(folder.path / "fine.obj", "v 0.1 0 0\nv 1 0.123456789012345678 0\nv 0 1e-300 1\nf 1 2 3\n");
    const TriangleMesh mesh = import_valid(folder.path / "fine.obj");
    CHECK(mesh.positions == std::vector<glm::dvec3>{{0.1, 0, 0}, {1, 0.123456789012345678, 0}, {0, 1e-300, 1}});
}

TEST_CASE("import: node transforms apply, and a mirroring one does not turn the mesh inside out") {
    const TriangleMesh mirrored = import_valid(meshes / "mirrored.gltf");
    CHECK(is_closed(mirrored.triangles));
    CHECK(signed_volume(mirrored) == doctest::Approx(48.0));
    CHECK(bounds(mirrored).min == glm::dvec3(9, -2, -3));
    CHECK(bounds(mirrored).max == glm::dvec3(11, 2, 3));

    const TriangleMesh two = import_valid(meshes / "matrix_and_rotation.gltf");
    CHECK(two.triangles.size() == 24);
    CHECK(is_closed(two.triangles));
    CHECK(signed_volume(two) == doctest::Approx(64.0 + 8.0));
    CHECK(bounds(two).min.x == doctest::Approx(-6.0));
    CHECK(bounds(two).max.x == doctest::Approx(7.0));
}

TEST_CASE("import: strips and fans face the same way as the quad they cover") {
    for (const char* name : {"strip.gltf", "fan.gltf"}) {
        CAPTURE(name);
        const TriangleMesh mesh = import_valid(meshes / name);
        REQUIRE(mesh.triangles.size() == 2);
        glm::dvec3 area{0.0};
        for (const Triangle& t : mesh.triangles) {
            const glm::dvec3& a = mesh.positions[t.x];
            area += 0.5 * glm::cross(mesh.positions[t.y] - a, mesh.positions[t.z] - a);
        }
        CHECK(area == glm::dvec3(0, 0, 4));
    }
}

TEST_CASE("import: the models of glmark2") {
    if (!fs::exists(glmark2 / "bunny.obj")) {
        MESSAGE("skipped: the Debian package glmark2-data is not installed");
        return;
    }
    const TriangleMesh bunny = import_valid(glmark2 / "bunny.obj");
    CHECK(bunny.positions.size() == 34835);
    CHECK(bunny.triangles.size() == 69666);
    CHECK(is_closed(bunny.triangles));

    const TriangleMesh horse = import_valid(glmark2 / "horse.3ds");
    CHECK(horse.positions.size() == 3582);
    CHECK(horse.triangles.size() == 7172);
    CHECK(!is_closed(horse.triangles)); // six quads are split along both diagonals
    const Repair repair = remove_spare_patches(horse);
    CHECK(repair.removed_patches == 6);
    CHECK(repair.removed_triangles == 12);
    CHECK(is_closed(repair.mesh.triangles));

    const TriangleMesh cat = import_valid(glmark2 / "cat.3ds");
    CHECK(cat.positions.size() == 7340);
    CHECK(cat.triangles.size() == 14348);
}

TEST_CASE("import: readers given files with random bytes changed, cut or repeated never crash, hang, "
          "fill the memory or name missing vertices") {
    Random random(1);
    const char* const wanted = std::getenv("BRITTLE_DAMAGED_FILES"); // per format; HACKING.md
    const int rounds = wanted ? std::atoi(wanted) : 2000;
    for (const std::string name :
         {"spelled_oddly.obj", "cube_binary.stl", "cube_text.stl", "cube.glb", "mirrored.gltf", "cube.3ds",
          "cube_text.ply", "cube_little.ply", "cube_big.ply", "cube.off", "crate.glb", "crate.obj", "crate.mtl"}) {
        CAPTURE(name);
        const std::string original = test::read_text(meshes / name);
        REQUIRE(!original.empty());
        uint32_t read_well = 0;
        double slowest = 0.0; // seconds
        forget_peak_memory();
        const uint64_t memory_before = peak_memory();
        for (int round = 0; round < rounds; ++round) {
            CAPTURE(round);
            std::string damaged = original;
            for (uint64_t k = 1 + random.next() % 4; k > 0; --k) {
                const size_t at = random.next() % damaged.size();
                switch (random.next() % 8) {
                case 0:
                    damaged.resize(at + 1);
                    break;
                case 1:
                    damaged.insert(at, damaged.substr(random.next() % damaged.size(), 16));
                    break;
                case 2:
                    damaged.replace(at, 4, 4, '\xff');
                    break;
                case 3:
                    damaged[at] = '-';
                    break;
                case 4:
                    damaged[at] = static_cast<char>(damaged[at] ^ (1 << random.next() % 8));
                    break;
                default:
                    damaged[at] = static_cast<char>(random.next());
                    break;
                }
            }
            const std::span<const std::byte> bytes = std::as_bytes(std::span(damaged));
            Companions companions(meshes);
            const std::string extension = fs::path(name).extension().string();
            if (extension == ".mtl") { // never an error, and all indices are valid
                Model model;
                read_mtl(damaged, companions, model);
                for (const Material& m : model.materials)
                    for (const auto& use : {m.base_colour_texture, m.emissive_texture, m.normal_texture})
                        if (use) REQUIRE(model.textures.at(use->texture).image.value() < model.images.size());
                read_well += !model.materials.empty();
                continue;
            }
            const std::clock_t begin = std::clock();
            const Result<Model> result = read_model(extension, bytes, companions);
            slowest = std::max(slowest, static_cast<double>(std::clock() - begin) / CLOCKS_PER_SEC);
            if (!result) {
                CHECK(!result.error().message.empty());
                continue;
            }
            ++read_well;
            const TriangleMesh& mesh = result->mesh;
            for (const Triangle& t : mesh.triangles) {
                for (int k = 0; k < 3; ++k) REQUIRE(t[k] < mesh.positions.size());
            }
            const auto fits = [](size_t size, size_t whole) { return size == 0 || size == whole; };
            for (const auto& set : result->uv) REQUIRE(fits(set.size(), 3 * mesh.triangles.size()));
            REQUIRE(fits(result->normals.size(), 3 * mesh.triangles.size()));
            REQUIRE(fits(result->colours.size(), 3 * mesh.triangles.size()));
            REQUIRE(fits(result->material_of.size(), mesh.triangles.size()));
            for (const uint32_t m : result->material_of) REQUIRE((m == no_material || m < result->materials.size()));
        }
        CHECK(read_well > 0); // otherwise the damage is too coarse to get past the headers
        CHECK(slowest < max_seconds);
        const uint64_t growth = peak_memory() - memory_before;
        CHECK(growth < max_memory_growth);
        if (wanted)
            MESSAGE(name, ": ", rounds, " files, ", read_well, " read, slowest ", slowest * 1e3, " ms, memory grew by ",
                    growth / 1024, " KiB");
    }
}

TEST_CASE("import: OBJ and OFF in UTF-16 of both byte orders are read as in UTF-8") {
    const test::Folder folder;
    for (const char* name : {"cube.obj", "cube.off"}) {
        const std::string text = "# \u00e9\u20ac\n" + test::read_text(meshes / name);
        const Result<TriangleMesh> expected = import_mesh(meshes / name);
        REQUIRE(expected);
        for (const bool big : {false, true}) {
            std::string wide = big ? "\xfe\xff" : "\xff\xfe";
            for (const char c : name == std::string("cube.obj") ? text : test::read_text(meshes / name)) {
                const char zero = '\0';
                wide += big ? zero : c;
                wide += big ? c : zero;
            }
            std::ofstream(folder.path / name, std::ios::binary) << wide;
            const Result<TriangleMesh> read = import_mesh(folder.path / name);
            REQUIRE_MESSAGE(read, read.error().message);
            CHECK(read->positions == expected->positions);
            CHECK(read->triangles == expected->triangles);
        }
    }
    // An odd byte at the end, a half of a pair alone: no crash.
    for (const std::string& end : {std::string("\x00\xd8", 2), std::string("\x00\xdc\x41", 3), std::string("v")}) {
        std::ofstream(folder.path / "odd.obj", std::ios::binary) << "\xff\xfe" << end;
        CHECK_FALSE(import_mesh(folder.path / "odd.obj"));
    }
}

TEST_CASE("import: messages about PLY files write counts and indices as whole numbers") {
    const test::Folder folder;
    const std::string head = "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\nproperty "
                             "float z\nelement face 1\nproperty list uchar int vertex_indices\nend_header\n0 0 0\n1 0 "
                             "0\n0 1 0\n";
    const auto message = [&](const std::string& face) {
        std::ofstream(folder.path / "a.ply") << head << face << "\n";
        const Result<TriangleMesh> read = import_mesh(folder.path / "a.ply");
        REQUIRE_FALSE(read);
        return read.error().message;
    };
    CHECK(message("2 0 1").find("a list of 2 numbers;") != std::string::npos);
    CHECK(message("3 0 1 7").find("it names vertex 7;") != std::string::npos);
    CHECK(message("3 0 1 -1").find("it names vertex -1;") != std::string::npos);
}

TEST_CASE("import: the first bytes tell the format, and noise tells none") {
    const auto told = [](const std::string& text) { return std::string(extension_of(std::as_bytes(std::span(text)))); };
    CHECK(told("").empty());
    CHECK(told("#\n# nothing but comments").empty());
    CHECK(told("plywood").empty());
    CHECK(told("vx 1 2 3").empty());
    CHECK(told("glT").empty());
    CHECK(told(std::string(84, '\0')).empty()); // an STL file without triangles
    CHECK(told("MM\xff\xff\xff\xff"
               "12")
              .empty());
    CHECK(told("# from a scanner\r\n\r\nv 1 2 3\n") == ".obj");
    CHECK(told("  mtllib a.mtl") == ".obj");
    CHECK(told("# off\nCNOFF 1 1 1") == ".off");
    CHECK(told("Solid of mine\nfacet") == ".stl");
    CHECK(told("ply\r\nformat ascii 1.0") == ".ply");
    CHECK(told("\n {\"asset\": {}}") == ".gltf");
    std::string binary = "solid, says a binary file" + std::string(59, ' ') + std::string(50, '\0');
    binary[80] = 1;
    binary[81] = binary[82] = binary[83] = 0;
    CHECK(told(binary) == ".stl");
    CHECK(told(std::string("\xff\xfe"
                           "v\0 \0"
                           "1\0",
                           8))
          == ".obj"); // UTF-16
    // The corpus: the bytes of each readable file give its ending.
    size_t files = 0;
    for (const auto& entry : fs::directory_iterator(meshes)) {
        if (!entry.is_regular_file() || !import_mesh(entry.path())) continue;
        CAPTURE(entry.path().string());
        std::ifstream stream(entry.path(), std::ios::binary);
        CHECK(told({std::istreambuf_iterator<char>(stream), {}}) == entry.path().extension().string());
        ++files;
    }
    CHECK(files > 5);
}
