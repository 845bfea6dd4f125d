// Materials and attributes of meshes through import, fracture and export.
#include <algorithm>
#include <cmath>
#include <cstring>
#include <filesystem>
#include <fstream>

#include <doctest/doctest.h>
#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <glm/gtc/quaternion.hpp>
#include <nlohmann/json.hpp>

#include "fracture/fracture.h"
#include "fracture/io/export.h"
#include "fracture/io/import.h"
#include "fracture/mesh/topology.h"
#include "fracture/pieces/certificate.h"
#include "fracture/shapes/shapes.h"
#include "fracture/sites/sites.h"
#include "tests/fracture/mesh_checks.h"

using namespace brittle::fracture;
namespace fs = std::filesystem;
using nlohmann::json;

namespace {

const fs::path meshes = fs::path(BRITTLE_CORPUS) / "meshes";

Model imported(const fs::path& file) {
    Result<Model> model = import_model(file);
    REQUIRE_MESSAGE(model, (model ? std::string() : model.error().message));
    return std::move(*model);
}

struct Cut {
    std::vector<glm::dvec3> sites;
    Fragments fragments;
    Certificate certificate;
};

Cut cut(const Model& model, uint32_t count) {
    Cut result{uniform_sites(bounds(model.mesh), count, 3), {}, {}};
    Result<Fragments> fragments = fracture(model.mesh, result.sites);
    REQUIRE(fragments);
    result.fragments = std::move(*fragments);
    result.certificate = certify(model.mesh, result.fragments);
    return result;
}

fs::path written(const fs::path& file, const Cut& cut, ExportOptions options) {
    options.sites = cut.sites;
    const auto files = export_pieces(file, cut.fragments, cut.certificate, options);
    REQUIRE_MESSAGE(files, (files ? std::string() : files.error().message));
    REQUIRE(!files->empty());
    return files->front();
}

json document_of(const fs::path& glb) {
    const std::string bytes = test::read_text(glb);
    uint32_t size = 0;
    std::memcpy(&size, bytes.data() + 12, 4);
    return json::parse(bytes.substr(20, size));
}

uint32_t material_named(const Model& model, const std::string& name) {
    for (uint32_t m = 0; m < model.materials.size(); ++m)
        if (model.materials[m].name == name) return m;
    FAIL("no material " << name);
    return 0;
}

// The attributes of the crate as functions of the position, all linear.
struct Paint {
    glm::dvec2 uv;
    glm::dvec4 colour{1.0};
};
Paint planks(const glm::dvec3& p) {
    return {{p.x + p.z, 0.5 - p.y}};
}
Paint lid(const glm::dvec3& p) {
    return {{p.x * 0.5 + 0.5, p.z / 1.5 + 0.5}, {p.x * 0.25 + 0.5, p.z * 0.25 + 0.5, 0.5, 1.0}};
}

// Checks all corners of a material and returns their number.
uint32_t check_paint(const Model& model, uint32_t material, Paint (*paint)(const glm::dvec3&),
                     double tolerance = 2e-6) {
    uint32_t corners = 0;
    double worst = 0.0;
    for (size_t t = 0; t < model.mesh.triangles.size(); ++t) {
        if (model.material_of[t] != material) continue;
        for (size_t k = 0; k < 3; ++k) {
            const Paint expected = paint(model.mesh.positions[model.mesh.triangles[t][static_cast<int>(k)]]);
            worst = std::max(worst, glm::distance(glm::dvec2(model.uv[0][3 * t + k]), expected.uv));
            if (!model.colours.empty())
                worst = std::max(worst, glm::distance(glm::dvec4(model.colours[3 * t + k]), expected.colour));
            ++corners;
        }
    }
    CHECK(worst < tolerance);
    return corners;
}

} // namespace

TEST_CASE("model: a glTF file's materials, textures, images, coordinates, colours and normals are read") {
    const Model crate = imported(meshes / "crate.glb");
    CHECK(crate.notes.empty());
    REQUIRE(crate.materials.size() == 3);
    CHECK(crate.materials[1].name == "painted lid");
    CHECK(crate.materials[1].base_colour == glm::dvec4(1.0, 0.9, 0.8, 1.0));
    CHECK(crate.materials[1].extensions.find("KHR_materials_clearcoat") != std::string::npos);
    REQUIRE(crate.materials[1].base_colour_texture);
    CHECK(crate.materials[1].base_colour_texture->texture == 1);
    CHECK(crate.materials[1].base_colour_texture->extensions.find("KHR_texture_transform") != std::string::npos);
    CHECK(crate.materials[2].metallic == 1.0);
    CHECK(crate.materials[2].emissive == glm::dvec3(0.01, 0.0, 0.0));
    REQUIRE(crate.textures.size() == 2);
    CHECK(crate.textures[0].wrap_s == 33648);
    REQUIRE(crate.images.size() == 2);
    CHECK(crate.images[0].mime_type == "image/png");
    CHECK(crate.images[0].bytes.size() == fs::file_size(meshes / "crate planks.png"));
    CHECK(check_paint(crate, 0, planks) == 4 * 2 * 3);
    CHECK(check_paint(crate, 1, lid) == 2 * 3);

    // The knob: a sphere, rotated by 45 degrees and stretched. The normal is the gradient of its quadric.
    const glm::dquat turn(0.92387953, 0.0, 0.0, 0.38268343);
    const glm::dvec3 scale(0.3, 0.15, 0.2);
    uint32_t corners = 0;
    for (size_t t = 0; t < crate.mesh.triangles.size(); ++t) {
        if (crate.material_of[t] != no_material) continue;
        for (size_t k = 0; k < 3; ++k) {
            const glm::dvec3 p = crate.mesh.positions[crate.mesh.triangles[t][static_cast<int>(k)]];
            const glm::dvec3 local = glm::conjugate(turn) * (p - glm::dvec3(0.0, 0.8, 0.0));
            const glm::dvec3 expected = glm::normalize(turn * (local / (scale * scale)));
            CHECK(glm::distance(expected, glm::dvec3(crate.normals[3 * t + k])) < 1e-5);
            ++corners;
        }
    }
    CHECK(corners == 120 * 3);
}

TEST_CASE("model: pieces in a GLB file keep the materials and attributes of the source") {
    const test::Folder folder;
    const Model crate = imported(meshes / "crate.glb");
    const Cut pieces = cut(crate, 25);
    const fs::path file = written(folder.path / "crate.glb", pieces, {.source = &crate});
    const Model back = imported(file);
    CHECK(back.notes.empty());
    REQUIRE(back.materials.size() == 5); // with the default of the knob, which has none, and that of the cuts
    for (size_t m = 0; m < 3; ++m) {
        CAPTURE(m);
        CHECK(back.materials[m].name == crate.materials[m].name);
        CHECK(back.materials[m].base_colour == crate.materials[m].base_colour);
        CHECK(back.materials[m].metallic == crate.materials[m].metallic);
        CHECK(back.materials[m].roughness == crate.materials[m].roughness);
        CHECK(back.materials[m].emissive == crate.materials[m].emissive);
        CHECK(back.materials[m].extensions == crate.materials[m].extensions);
        CHECK(back.materials[m].base_colour_texture.has_value() == crate.materials[m].base_colour_texture.has_value());
    }
    CHECK(back.materials[4].name == "interior");
    REQUIRE(back.images.size() == 2);
    for (size_t i = 0; i < 2; ++i) CHECK(back.images[i].bytes == crate.images[i].bytes);
    CHECK(back.textures[0].wrap_s == 33648);
    CHECK(check_paint(back, 0, planks) > 100);
    CHECK(check_paint(back, 1, lid) > 30);
    for (const glm::vec4& colour : back.colours)
        for (int k = 0; k < 4; ++k) CHECK((colour[k] >= 0.0f && colour[k] <= 1.0f)); // not rounded out of range
    // Smooth normals stay: those of the parts of the knob differ within triangles, those of the crate do not.
    bool smooth_knob = false, flat_crate = true;
    for (size_t t = 0; t < back.mesh.triangles.size(); ++t) {
        const bool varies = glm::distance(back.normals[3 * t], back.normals[3 * t + 1]) > 1e-3f;
        if (back.material_of[t] == 3) smooth_knob = smooth_knob || varies;
        if (back.material_of[t] < 3) flat_crate = flat_crate && !varies;
    }
    CHECK(smooth_knob);
    CHECK(flat_crate);
    const json document = document_of(file);
    CHECK(document["extensionsUsed"] == json{"KHR_materials_clearcoat", "KHR_texture_transform"});
}

TEST_CASE("model: OBJ files with their materials, from import to export and back") {
    const test::Folder folder;
    const Model crate = imported(meshes / "crate.obj");
    CHECK(crate.notes.empty());
    REQUIRE(crate.materials.size() == 3);
    CHECK(crate.materials[1].alpha_mode == AlphaMode::blend);
    CHECK(crate.materials[1].base_colour.w == 0.5);
    REQUIRE(crate.images.size() == 1); // both materials share it
    CHECK(crate.images[0].bytes.size() == fs::file_size(meshes / "crate planks.png"));
    CHECK(check_paint(crate, material_named(crate, "planks"), planks) == 24);

    const Cut pieces = cut(crate, 20);
    const Model back = imported(written(folder.path / "pieces.obj", pieces, {.source = &crate}));
    CHECK(back.notes.empty());
    CHECK(test::read_text(folder.path / "pieces_image0.png") == test::read_text(meshes / "crate planks.png"));
    CHECK(check_paint(back, material_named(back, "planks"), planks) > 60);
    const Material& painted = back.materials[material_named(back, "painted_lid")];
    CHECK(painted.base_colour == glm::dvec4(1.0, 0.9, 0.8, 0.5));
    CHECK(painted.roughness == 0.3);
    CHECK(back.materials[material_named(back, "iron")].metallic == 1.0);
    CHECK(std::count(back.material_of.begin(), back.material_of.end(), material_named(back, "interior"))
          == static_cast<std::ptrdiff_t>(pieces.certificate.cap_triangles));
}

TEST_CASE("model: faults of a material library give notes, and no file outside the folder is read") {
    const test::Folder folder;
    const fs::path inner = folder.path / "inner";
    fs::create_directory(inner);
    std::ofstream(folder.path / "secret.png") << "\x89PNG\r\n\x1a\n";
    std::ofstream(inner / "t.mtl") << "newmtl a\nmap_Kd ../secret.png\nKd 2 nan x\nnewmtl b\nmap_Kd missing.png\nPr\n";
    std::ofstream(inner / "t.obj") << "mtllib t.mtl\nmtllib gone.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nusemtl a\n"
                                      "f 1 3 2\nf 1 2 4\nusemtl c\nf 1 4 3\nf 2//7 3/9 4\n";
    const Model model = imported(inner / "t.obj");
    CHECK(model.images.empty());
    CHECK(model.notes.size() == 4); // ../secret.png, missing.png, gone.mtl, c
    CHECK(model.notes[0].find("secret") != std::string::npos);
    CHECK(model.materials.size() == 3);
    CHECK(model.material_of == std::vector<uint32_t>{0, 0, 2, 2});
}

TEST_CASE("model: a material that nobody could see is opaque, with a note") {
    const test::Folder folder;
    std::ofstream(folder.path / "t.mtl") << "newmtl mesh lab\nTr 1.0\nKd 1 0 0\nnewmtl hidden\nd 0\n"
                                            "newmtl pane\nd 0.25\nnewmtl first clear\nTr 0.5\nd 1\n";
    std::ofstream(folder.path / "t.obj")
        << "mtllib t.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nusemtl mesh lab\nf 1 3 2\n"
           "usemtl hidden\nf 1 2 4\nusemtl pane\nf 1 4 3\nusemtl first clear\nf 2 3 4\n";
    const Model model = imported(folder.path / "t.obj");
    const auto opacity = [&](const char* name) {
        const Material& material = model.materials[material_named(model, name)];
        return std::pair(material.base_colour.w, material.alpha_mode);
    };
    CHECK(opacity("mesh lab") == std::pair(1.0, AlphaMode::opaque));
    CHECK(opacity("hidden") == std::pair(1.0, AlphaMode::opaque));
    CHECK(opacity("pane") == std::pair(0.25, AlphaMode::blend));
    CHECK(opacity("first clear") == std::pair(1.0, AlphaMode::opaque));
    REQUIRE(model.notes.size() == 2);
    CHECK(model.notes[0].find("mesh lab") != std::string::npos);
    CHECK(model.notes[1].find("hidden") != std::string::npos);
}

TEST_CASE("model: PLY keeps colours, STL the triangles, both are closed and have the volume") {
    const test::Folder folder;
    const Model crate = imported(meshes / "crate.glb");
    const Cut pieces = cut(crate, 15);
    for (const char* name : {"crate.ply", "crate.stl"}) {
        CAPTURE(name);
        const Model back = imported(written(folder.path / name, pieces, {.source = &crate, .per_piece = true}));
        const Piece& first = pieces.fragments.pieces[0];
        CHECK(back.mesh.triangles.size() == first.triangles.size());
        CHECK(check_topology(back.mesh.positions.size(), back.mesh.triangles).closed());
        CHECK(signed_volume(back.mesh.positions, back.mesh.triangles)
              == doctest::Approx(first.mass.volume).epsilon(1e-5));
    }
    Model plain;
    plain.mesh = icosphere(2);
    for (const Triangle& t : plain.mesh.triangles)
        for (int k = 0; k < 3; ++k) {
            const glm::dvec3 p = plain.mesh.positions[t[k]] * 0.5 + 0.5;
            plain.colours.emplace_back(p, 0.5);
        }
    const auto files = export_model(folder.path / "ball.ply", plain);
    REQUIRE(files);
    const Model back = imported(folder.path / "ball.ply");
    REQUIRE(back.colours.size() == plain.colours.size());
    for (size_t t = 0; t < back.mesh.triangles.size(); ++t)
        for (int k = 0; k < 3; ++k) // doubles, bit for bit
            CHECK(back.mesh.positions[back.mesh.triangles[t][k]] == plain.mesh.positions[plain.mesh.triangles[t][k]]);
    CHECK(back.mesh.positions.size() == plain.mesh.positions.size());
    double worst = 0.0;
    for (size_t c = 0; c < back.colours.size(); ++c)
        worst = std::max(worst, double(glm::distance(back.colours[c], plain.colours[c])));
    CHECK(worst < 0.012); // eight bits of sRGB are coarsest near white
}

TEST_CASE("model: PLY keeps texture coordinates at the corners of faces, and images beside the file") {
    const test::Folder folder;
    const Model crate = imported(meshes / "crate.obj");
    const Cut pieces = cut(crate, 20);
    const fs::path file = written(folder.path / "pieces.ply", pieces, {.source = &crate});
    const std::string text = test::read_text(file);
    CHECK(text.find("\ncomment TextureFile pieces_image0.png\n") != std::string::npos);
    CHECK(test::read_text(folder.path / "pieces_image0.png") == test::read_text(meshes / "crate planks.png"));
    size_t vertices = 0, textured = 0;
    for (const Piece& piece : pieces.fragments.pieces) {
        vertices += piece.vertices.size();
        for (uint32_t t = 0; t < piece.exterior_triangles; ++t) {
            const uint32_t source = pieces.fragments.triangle_source[piece.triangles.begin + t];
            textured += crate.materials[crate.material_of[source]].base_colour_texture ? 1 : 0;
        }
    }
    // Seams of the texture do not divide vertices.
    CHECK(text.find("\nelement vertex " + std::to_string(vertices) + "\n") != std::string::npos);
    const Model back = imported(file);
    CHECK(back.notes.empty());
    REQUIRE(back.materials.size() == 1); // both textured materials share an image
    REQUIRE(back.images.size() == 1);
    CHECK(back.images[0].bytes == crate.images[0].bytes);
    CHECK(textured > 0);
    CHECK(std::count(back.material_of.begin(), back.material_of.end(), 0u) == static_cast<std::ptrdiff_t>(textured));
    CHECK(check_topology(back.mesh.positions.size(), back.mesh.triangles).components == pieces.fragments.pieces.size());

    const Model coloured = imported(meshes / "crate.glb"); // an image for each material, and colours
    const Cut others = cut(coloured, 20);
    const Model both = imported(written(folder.path / "both.ply", others, {.source = &coloured}));
    REQUIRE(both.materials.size() == 2);
    CHECK(both.materials[1].name == "both_image1.png");
    constexpr double eight_bits = 0.012; // of sRGB are coarsest near white
    CHECK(check_paint(both, 0, planks, eight_bits) > 100);
    CHECK(check_paint(both, 1, lid, eight_bits) > 30);
    Model uncoloured = coloured;
    uncoloured.colours.clear();
    Paint (*const lid_uv)(const glm::dvec3&) = [](const glm::dvec3& p) { return Paint{lid(p).uv}; };
    const Model plain = imported(written(folder.path / "plain.ply", others, {.source = &uncoloured}));
    CHECK(check_paint(plain, 0, planks) > 100);
    CHECK(check_paint(plain, 1, lid_uv) > 30);

    Model broken = crate; // an image that could not be read leaves the coordinates alone
    broken.images[0].mime_type.clear();
    broken.images[0].bytes.clear();
    const std::string without = test::read_text(written(folder.path / "without.ply", pieces, {.source = &broken}));
    CHECK(without.find("property list uchar float texcoord\n") != std::string::npos);
    CHECK(without.find("TextureFile") == std::string::npos);
    CHECK(without.find("texnumber") == std::string::npos);
}

TEST_CASE("model: one file per piece") {
    const test::Folder folder;
    const Model crate = imported(meshes / "crate.obj");
    const Cut pieces = cut(crate, 7);
    for (const std::string ending : {".glb", ".obj", ".ply", ".stl"}) {
        const auto files = export_pieces(folder.path / ("c" + ending), pieces.fragments, pieces.certificate,
                                         {.source = &crate, .per_piece = true});
        REQUIRE(files);
        REQUIRE(files->size() == pieces.fragments.pieces.size());
        double sum = 0.0;
        for (const fs::path& file : *files) {
            const Model piece = imported(file);
            CHECK(check_topology(piece.mesh.positions.size(), piece.mesh.triangles).closed());
            sum += signed_volume(piece.mesh.positions, piece.mesh.triangles);
        }
        CHECK(sum == doctest::Approx(pieces.certificate.volume_input).epsilon(1e-6));
        CHECK(files->back().filename() == "c_006" + ending);
    }
}

TEST_CASE("model: bonds, hulls and rigid bodies in a GLB file") {
    const test::Folder folder;
    const Model crate = imported(meshes / "crate.obj");
    const Cut pieces = cut(crate, 9);
    // Any closed mesh can serve as a hull here.
    std::vector<std::vector<TriangleMesh>> hulls;
    for (const Piece& piece : pieces.fragments.pieces) {
        hulls.push_back({cube(0.1)});
        for (glm::dvec3& p : hulls.back()[0].positions) p += piece.mass.centre_of_mass;
    }
    ExportOptions options{.name = "crate", .source = &crate};
    options.hulls = hulls;
    options.rigid_bodies = true;
    options.density = 500.0;
    const json document = document_of(written(folder.path / "a.glb", pieces, options));
    size_t bonds = 0, bodies = 0;
    for (const json& node : document["nodes"]) {
        if (!node.contains("extensions")) continue;
        ++bodies;
        const json &body = node["extensions"]["KHR_physics_rigid_bodies"], &extras = node["extras"]["brittle"];
        CHECK(body["motion"]["mass"].get<double>() == doctest::Approx(500.0 * extras["volume"].get<double>()));
        CHECK_FALSE(node.contains("children")); // the hulls are not drawn
        const json& geometry = body["collider"]["geometry"];
        CHECK(geometry["convexHull"] == true);
        const json& hull = document["meshes"][geometry["mesh"].get<size_t>()];
        CHECK(hull["name"] == node["name"].get<std::string>() + "_hull_00");
        const json& position = document["accessors"][hull["primitives"][0]["attributes"]["POSITION"].get<size_t>()];
        for (size_t k = 0; k < 3; ++k) {
            CHECK(position["min"][k].get<double>() == doctest::Approx(-0.05).epsilon(1e-5));
            CHECK(position["max"][k].get<double>() == doctest::Approx(0.05).epsilon(1e-5));
        }
        // Recomputes the tensor from its principal axes.
        const json &d = body["motion"]["inertiaDiagonal"], &q = body["motion"]["inertiaOrientation"];
        const glm::dmat3 axes = glm::mat3_cast(glm::dquat(q[3], q[0], q[1], q[2]));
        const glm::dmat3 tensor = axes * glm::dmat3(d[0], 0, 0, 0, d[1], 0, 0, 0, d[2]) * glm::transpose(axes);
        for (int row = 0; row < 3; ++row)
            for (int column = 0; column < 3; ++column)
                CHECK(tensor[column][row]
                      == doctest::Approx(500.0 * extras["inertia"][static_cast<size_t>(3 * row + column)].get<double>())
                             .epsilon(1e-9)
                             .scale(0.1));
        bonds += extras.contains("bonds") ? extras["bonds"].size() : 0;
    }
    CHECK(bodies == pieces.fragments.pieces.size());
    CHECK(bonds == pieces.fragments.bonds.size());
    options.body_names = BodyNames::unreal;
    const json unreal = document_of(written(folder.path / "b.glb", pieces, options));
    CHECK(unreal["nodes"][2]["name"] == "UCX_crate_000_00");
    CHECK(unreal["nodes"][2]["mesh"]
          == unreal["nodes"][1]["extensions"]["KHR_physics_rigid_bodies"]["collider"]["geometry"]["mesh"]);
    hulls[0].push_back(hulls[0][0]);
    options.hulls = hulls;
    const json several = document_of(written(folder.path / "d.glb", pieces, options));
    const json &first = several["nodes"][1], &second_hull = several["nodes"][3];
    CHECK(first["children"] == json{2, 3});
    CHECK_FALSE(first["extensions"]["KHR_physics_rigid_bodies"].contains("collider")); // its hulls are the colliders
    CHECK(second_hull["name"] == "UCX_crate_000_01");
    CHECK(second_hull["extensions"]["KHR_physics_rigid_bodies"]["collider"]["geometry"]["mesh"] == second_hull["mesh"]);
    options.body_names = BodyNames::none;
    const json undrawn = document_of(written(folder.path / "e.glb", pieces, options));
    CHECK(undrawn["nodes"][1]["children"] == json{2, 3});
    CHECK_FALSE(undrawn["nodes"][3].contains("mesh"));
    CHECK(undrawn["nodes"][3]["extensions"]["KHR_physics_rigid_bodies"]["collider"]["geometry"].contains("mesh"));
    options.rigid_bodies = false;
    options.body_names = BodyNames::godot;
    const json godot = document_of(written(folder.path / "f.glb", pieces, options));
    CHECK(godot["nodes"].size() == 1 + pieces.fragments.pieces.size());
    CHECK(godot["nodes"][1]["name"] == "crate_000-rigid");
    options.rigid_bodies = options.fixed = true;
    const json fixed = document_of(written(folder.path / "g.glb", pieces, options));
    CHECK(fixed["nodes"].size() == 1 + pieces.fragments.pieces.size());
    CHECK(fixed["nodes"][1]["name"] == "crate_000-col");
    const json& surface = fixed["nodes"][1]["extensions"]["KHR_physics_rigid_bodies"];
    CHECK_FALSE(surface.contains("motion"));
    CHECK(surface["collider"]["geometry"] == json{{"mesh", fixed["nodes"][1]["mesh"]}});
    hulls.pop_back();
    options.hulls = hulls;
    const auto refused = export_pieces(folder.path / "c.glb", pieces.fragments, pieces.certificate, options);
    REQUIRE(!refused);
    CHECK(refused.error().status == Status::invalid_setting);
}

TEST_CASE("model: poses are node transforms in GLB and transformed coordinates elsewhere") {
    const test::Folder folder;
    const Model crate = imported(meshes / "crate.obj");
    const Cut pieces = cut(crate, 9);
    std::vector<PiecePose> poses;
    std::vector<glm::dmat3> turns; // by Rodrigues' formula, independent of quaternions
    for (size_t p = 0; p < pieces.fragments.pieces.size(); ++p) {
        const double angle = 0.4 + static_cast<double>(p), c = std::cos(angle), s = std::sin(angle);
        const glm::dvec3 a = glm::normalize(glm::dvec3(1.0, 0.5 * static_cast<double>(p) - 1.0, 0.3));
        const glm::dmat3 cross(0.0, a.z, -a.y, -a.z, 0.0, a.x, a.y, -a.x, 0.0);
        turns.push_back(c * glm::dmat3(1.0) + s * cross + (1.0 - c) * glm::outerProduct(a, a));
        poses.push_back({glm::dvec3(static_cast<double>(p), 2.0, -1.0), glm::angleAxis(angle, a)});
    }
    ExportOptions options{.source = &crate, .uv_by_plane = true, .poses = poses, .per_piece = true};
    for (const std::string ending : {".glb", ".obj", ".ply", ".stl"}) {
        CAPTURE(ending);
        const auto files = export_pieces(folder.path / ("c" + ending), pieces.fragments, pieces.certificate, options);
        REQUIRE(files);
        for (size_t p = 0; p < poses.size(); ++p) {
            const Piece& piece = pieces.fragments.pieces[p];
            const Model back = imported((*files)[p]);
            CHECK(check_topology(back.mesh.positions.size(), back.mesh.triangles).closed());
            std::vector<glm::dvec3> expected;
            for (const glm::dvec3& v : pieces.fragments.positions_of(piece))
                expected.push_back(poses[p].position + turns[p] * (v - piece.mass.centre_of_mass));
            for (const glm::dvec3& v : back.mesh.positions) {
                double nearest = 1.0;
                for (const glm::dvec3& e : expected) nearest = std::min(nearest, glm::distance(v, e));
                CHECK(nearest < 2e-6); // single precision, metres
            }
            CHECK(signed_volume(back.mesh.positions, back.mesh.triangles)
                  == doctest::Approx(piece.mass.volume).epsilon(1e-5));
            double worst = 1.0; // normals agree with the orientation of their triangles
            for (size_t t = 0; t < back.mesh.triangles.size() && !back.normals.empty(); ++t) {
                const Triangle& at = back.mesh.triangles[t];
                const glm::dvec3 across = glm::cross(back.mesh.positions[at.y] - back.mesh.positions[at.x],
                                                     back.mesh.positions[at.z] - back.mesh.positions[at.x]);
                if (glm::length(across) < 1e-4) continue; // a sliver has no plane in single precision
                worst = std::min(worst, glm::dot(glm::normalize(across), glm::dvec3(back.normals[3 * t])));
            }
            CHECK(worst > 0.99);
        }
    }
    poses[2].orientation *= 1.1;
    CHECK(export_pieces(folder.path / "d.glb", pieces.fragments, pieces.certificate, options).error().status
          == Status::invalid_setting);
    options.poses = std::span(poses).first(2);
    CHECK(export_pieces(folder.path / "d.glb", pieces.fragments, pieces.certificate, options).error().status
          == Status::invalid_setting);
    CHECK_FALSE(fs::exists(folder.path / "d_000.glb"));
}

TEST_CASE("model: without sites, cuts have texture coordinates by their planes") {
    const test::Folder folder;
    Model plain;
    plain.mesh = cube(1.0);
    const Cut pieces = cut(plain, 9);
    REQUIRE(export_pieces(folder.path / "a.glb", pieces.fragments, pieces.certificate, {.uv_by_plane = true}));
    const Model back = imported(folder.path / "a.glb");
    REQUIRE(!back.uv[0].empty());
    size_t cuts = 0;
    for (size_t t = 0; t < back.mesh.triangles.size(); ++t) {
        if (back.materials[back.material_of[t]].name != "interior") continue;
        const Triangle& at = back.mesh.triangles[t];
        for (int k = 0; k < 3; ++k) { // metres: equal lengths in texture and space
            const auto a = 3 * t + static_cast<size_t>(k), b = 3 * t + static_cast<size_t>((k + 1) % 3);
            CHECK(double(glm::distance(back.uv[0][a], back.uv[0][b]))
                  == doctest::Approx(glm::distance(back.mesh.positions[at[k]], back.mesh.positions[at[(k + 1) % 3]]))
                         .epsilon(1e-4)
                         .scale(1.0));
        }
        ++cuts;
    }
    CHECK(cuts == pieces.certificate.cap_triangles);
}

TEST_CASE("model: an image for the cuts, and one that could not be read") {
    const test::Folder folder;
    Model crate = imported(meshes / "crate.glb");
    crate.images[1].mime_type.clear();
    crate.images[1].bytes.clear();
    const Cut pieces = cut(crate, 5);
    const Result<Image> stone = read_image(meshes / "crate planks.png");
    REQUIRE(stone);
    const Model back = imported(written(folder.path / "a.glb", pieces, {.source = &crate, .interior_image = *stone}));
    CHECK(back.notes.empty());
    REQUIRE(back.images.size() == 3);
    CHECK(back.images[1].mime_type == "image/png"); // one white pixel
    CHECK(back.images[2].bytes == stone->bytes);
    const Material& interior = back.materials.back();
    REQUIRE(interior.base_colour_texture);
    CHECK(back.textures[interior.base_colour_texture->texture].image == 2u);
    CHECK(!read_image(meshes / "cube.obj"));
}

TEST_CASE("model: unknown extensions are refused with a list of writable ones") {
    const Cut pieces = cut(imported(meshes / "crate.obj"), 2);
    for (const char* name : {"a.fbx", "a", "a.gltf"}) {
        const auto refused = export_pieces(name, pieces.fragments, pieces.certificate);
        REQUIRE(!refused);
        CHECK(refused.error().status == Status::unsupported_format);
        CHECK(refused.error().message.find(".glb, .obj, .ply, .stl") != std::string::npos);
    }
}

TEST_CASE("model: a sparse accessor moves the vertices that it names") {
    // A tetrahedron of zeros with three sparse corners.
    const test::Folder folder;
    const std::string text = R"({"asset":{"version":"2.0"},"scene":0,"scenes":[{"nodes":[0]}],"nodes":[{"mesh":0}],
"meshes":[{"primitives":[{"attributes":{"POSITION":0},"indices":1}]}],
"accessors":[{"componentType":5126,"count":4,"type":"VEC3","sparse":{"count":3,"indices":{"bufferView":0,"componentType":5121},
"values":{"bufferView":1}}},{"bufferView":2,"componentType":5121,"count":12,"type":"SCALAR"}],
"bufferViews":[{"buffer":0,"byteLength":3},{"buffer":0,"byteOffset":4,"byteLength":36},{"buffer":0,"byteOffset":40,"byteLength":12}],
"buffers":[{"byteLength":52,"uri":"b.bin"}]})";
    std::string data = std::string("\1\2\3\0", 4);
    const float corners[] = {2, 0, 0, 0, 3, 0, 0, 0, 4};
    data.append(reinterpret_cast<const char*>(corners), sizeof corners);
    data += std::string("\0\2\1\0\1\3\0\3\2\1\2\3", 12);
    std::ofstream(folder.path / "b.bin", std::ios::binary) << data;
    std::ofstream(folder.path / "a.gltf") << text;
    const Model model = imported(folder.path / "a.gltf");
    CHECK(signed_volume(model.mesh.positions, model.mesh.triangles) == doctest::Approx(4.0));
    std::string beyond = text;
    data[2] = 4;
    std::ofstream(folder.path / "b.bin", std::ios::binary) << data;
    const auto refused = import_model(folder.path / "a.gltf");
    REQUIRE(!refused);
    CHECK(refused.error().message.find("sparse index") != std::string::npos);
}

TEST_CASE("model: an image that a file names often is not copied each time") {
    const test::Folder folder;
    const std::string png = "\x89PNG\r\n\x1a\n" + std::string(100'000, '.');
    std::ofstream(folder.path / "a.png", std::ios::binary) << png;
    const auto content = [](const char* name) { return test::read_text(meshes / name); };
    std::string materials, comments, images, path;
    for (int k = 0; k < 50; ++k) {
        materials += "newmtl m" + std::to_string(k) + "\nmap_Kd " + path + "a.png\n";
        comments += "comment TextureFile " + path + "a.png\n";
        images += (k > 0 ? "," : "") + (R"({"uri":")" + path + R"(a.png"})");
        path += "./";
    }
    std::string ply = content("cube_text.ply"), gltf = content("cube_bytes.gltf");
    ply.insert(ply.find("element vertex"), comments);
    gltf.insert(1, R"("images":[)" + images + "],");
    std::ofstream(folder.path / "m.mtl") << materials;
    std::ofstream(folder.path / "a.obj") << "mtllib m.mtl\nmtllib ./m.mtl\n" << content("cube.obj");
    std::ofstream(folder.path / "a.ply") << ply;
    std::ofstream(folder.path / "a.gltf") << gltf;
    for (const char* name : {"a.obj", "a.ply", "a.gltf"}) {
        CAPTURE(std::string(name));
        const Model model = imported(folder.path / name);
        size_t sum = 0;
        for (const Image& image : model.images) sum += image.bytes.size();
        CHECK(sum >= png.size());
        CHECK(sum <= 4 * (png.size() + 10'000));
        if (std::string_view(name) != "a.gltf") CHECK(model.materials.size() <= 51); // plus the one of the cube
    }
}

TEST_CASE("model: replace_mesh keeps the attributes of the source triangles") {
    Model model = imported(meshes / "crate.glb");
    const Model before = model;
    TriangleMesh mesh = model.mesh;
    std::vector<uint32_t> source;
    for (uint32_t t = 0; t < mesh.triangles.size(); ++t) {
        Triangle& c = mesh.triangles[t];
        source.push_back(t % 5 == 4 ? no_source : t);
        if (t % 3 == 1) c = {c.y, c.z, c.x};
        if (t % 3 == 2) std::swap(c.x, c.y);
    }
    replace_mesh(model, mesh, source);
    for (uint32_t t = 0; t < mesh.triangles.size(); ++t) {
        CAPTURE(t);
        CHECK(model.material_of[t] == (t % 5 == 4 ? no_material : before.material_of[t]));
        const uint32_t order[3][3] = {{0, 1, 2}, {1, 2, 0}, {1, 0, 2}};
        for (uint32_t k = 0; k < 3; ++k) {
            const uint32_t from = 3 * t + order[t % 3][k];
            CHECK(model.uv[0][3 * t + k] == (t % 5 == 4 ? glm::vec2(0.0f) : before.uv[0][from]));
            CHECK(model.normals[3 * t + k]
                  == (t % 5 == 4 ? glm::vec3(0.0f) : (t % 3 == 2 ? -before.normals[from] : before.normals[from])));
        }
    }
}

TEST_CASE("model: divide_mesh interpolates the attributes of the source triangles") {
    // One triangle, cut from its corner to the middle of the opposite side; the second part looks the other way.
    Model model;
    model.mesh = {{{0, 0, 0}, {4, 0, 0}, {0, 4, 0}}, {{0, 1, 2}}};
    model.uv[0] = {{0, 0}, {1, 0}, {0, 1}};
    model.normals = {{0, 0, 1}, {1, 0, 0}, {0, 1, 0}};
    model.colours = {{1, 0, 0, 1}, {0, 1, 0, 1}, {0, 0, 1, 0}};
    model.material_of = {3};
    TriangleMesh parts{{{0, 0, 0}, {4, 0, 0}, {0, 4, 0}, {2, 2, 0}}, {{0, 1, 3}, {0, 2, 3}}};
    const std::vector<uint32_t> source{0, 0};
    const Model before = model;
    divide_mesh(model, parts, source);
    CHECK(model.mesh.triangles == parts.triangles);
    CHECK(model.material_of == std::vector<uint32_t>{3, 3});
    CHECK(model.uv[0] == std::vector<glm::vec2>{{0, 0}, {1, 0}, {0.5, 0.5}, {0, 0}, {0, 1}, {0.5, 0.5}});
    CHECK(model.uv[1].empty());
    CHECK(model.colours[2] == glm::vec4(0, 0.5, 0.5, 0.5));
    const float diagonal = std::sqrt(0.5f);
    for (size_t k = 0; k < 2; ++k) CHECK(model.normals[k] == before.normals[k]);
    CHECK(glm::distance(model.normals[2], {diagonal, diagonal, 0}) < 1e-6f);
    CHECK(model.normals[3] == -before.normals[0]);
    CHECK(glm::distance(model.normals[5], {-diagonal, -diagonal, 0}) < 1e-6f);
}
