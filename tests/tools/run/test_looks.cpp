// The looks of meshes: from files with materials and textures to the corners of pieces and to pictures.
#include "tools/brittle/base/device_failure.h"
#include "tools/brittle/stage/mesh_looks.h"

#include <cmath>
#include <functional>
#include <random>

#include <doctest/doctest.h>
#include <glm/geometric.hpp>
#include <nlohmann/json.hpp>

#include "fracture/io/export.h"
#include "fracture/io/import.h"
#include "fracture/shapes/shapes.h"
#include "physics/cutting/destruction.h"
#include "tests/engine/support.h"
#include "tests/tools/studio/room.h"
#include "tests/tools/support.h"
#include "tools/brittle/stage/loading.h"
#include "tools/brittle/stage/stage.h"
#include "tools/scenario/recipe/recipe.h"
#include "tools/scenario/run/scene.h"

using namespace brittle;
using namespace brittle::tools;
using namespace brittle::tools::test;
using engine::test::check_golden;
using engine::test::GoldenCheck;

namespace {

fracture::Image png_of(const engine::Bitmap& bitmap, const std::string& name = "checker") {
    const Folder folder;
    const std::string file = folder / "image.png";
    must(engine::write_png(bitmap, file));
    const std::string bytes = read_text(file);
    const auto* begin = reinterpret_cast<const std::byte*>(bytes.data());
    return {.name = name, .mime_type = "image/png", .bytes = {begin, begin + bytes.size()}};
}

// Squares of 16 texels in two colours; the lighter ones have the opacity `light_alpha`.
engine::Bitmap checker(uint32_t squares, uint8_t light_alpha) {
    engine::Bitmap made{16 * squares, 16 * squares, {}};
    for (uint32_t y = 0; y < made.height; ++y)
        for (uint32_t x = 0; x < made.width; ++x) {
            const bool light = (x / 16 + y / 16) % 2 == 0;
            const uint8_t texel[4] = {uint8_t(light ? 230 : 150), uint8_t(light ? 210 : 40), uint8_t(light ? 160 : 50),
                                      light ? light_alpha : uint8_t(255)};
            made.pixels.insert(made.pixels.end(), texel, texel + 4);
        }
    return made;
}

// The texture coordinates of a point of the crate: an affine map on each side, so that those of any part of a side are
// known. v points down, as the texture's rows.
glm::dvec2 uv_of(const glm::dvec3& p, const glm::dvec3& normal) {
    if (std::abs(normal.x) > 0.5) return {p.z + 0.5, 0.5 - p.y};
    if (std::abs(normal.y) > 0.5) return {p.x + 0.5, p.z + 0.5};
    return {p.x + 0.5, 0.5 - p.y};
}

// A cube of one metre: a checker on its sides, a cut-out checker at the front, a plain colour on top, and a bottom
// without material.
fracture::Model crate() {
    fracture::Model model;
    model.mesh = fracture::cube(1.0);
    for (const fracture::Triangle& t : model.mesh.triangles) {
        const auto& at = model.mesh.positions;
        const glm::dvec3 normal = glm::normalize(glm::cross(at[t.y] - at[t.x], at[t.z] - at[t.x]));
        for (int k = 0; k < 3; ++k) model.uv[0].emplace_back(uv_of(at[t[k]], normal));
        model.material_of.push_back(normal.z > 0.5 ? 1 : (normal.y > 0.5 ? 2 : (normal.y < -0.5 ? ~0u : 0)));
    }
    model.images = {png_of(checker(4, 255)), png_of(checker(6, 0), "lattice")};
    model.textures = {{.image = 0}, {.image = 1}};
    model.materials.resize(3);
    model.materials[0] = {.name = "board", .base_colour_texture = fracture::TextureUse{.texture = 0}};
    model.materials[1] = {.name = "lattice",
                          .base_colour_texture = fracture::TextureUse{.texture = 1},
                          .alpha_mode = fracture::AlphaMode::mask};
    model.materials[2] = {.name = "lid", .base_colour = {0.10, 0.25, 0.45, 1.0}};
    return model;
}

void write_crate(const std::string& file, const std::function<void(fracture::Model&)>& change = {}) {
    fracture::Model model = crate();
    if (change) change(model);
    must(fracture::export_model(file, model));
}

// Writes a GLB file with the meshes of a crate and nodes of its own: mesh 0 is the crate, mesh 1 has one colour, mesh 2
// has planks and another lid, mesh 3 no material.
void write_crates(const std::string& file, const std::string& nodes) {
    write_crate(file);
    const std::string bytes = read_text(file);
    const auto number = [&](size_t at) {
        uint32_t value = 0;
        for (size_t k = 0; k < 4; ++k) value |= uint32_t(uint8_t(bytes[at + k])) << (8 * k);
        return value;
    };
    auto json = nlohmann::ordered_json::parse(bytes.substr(20, number(12)));
    const std::string rest = bytes.substr(20 + number(12)); // the binary chunk
    const auto painted = json["materials"].size();
    json["materials"].push_back(
        {{"name", "red"}, {"pbrMetallicRoughness", {{"baseColorFactor", {0.45, 0.03, 0.02, 1.0}}}}});
    json["materials"].push_back(
        {{"name", "yellow"}, {"pbrMetallicRoughness", {{"baseColorFactor", {0.7, 0.45, 0.03, 1.0}}}}});
    const auto crate = json["meshes"][0];
    json["meshes"] = {crate, crate, crate, crate};
    for (auto& primitive : json["meshes"][1]["primitives"]) primitive["material"] = painted;
    for (auto& primitive : json["meshes"][2]["primitives"])
        primitive["material"] = primitive.value("material", -1) == 2 ? painted + 1 : size_t{0};
    for (auto& primitive : json["meshes"][3]["primitives"]) primitive.erase("material");
    json["nodes"] = nlohmann::ordered_json::parse(nodes);
    json["scenes"] = {{{"nodes", nlohmann::ordered_json::array()}}};
    for (size_t k = 0; k < json["nodes"].size(); ++k) json["scenes"][0]["nodes"].push_back(k);
    std::string text = json.dump();
    text.resize((text.size() + 3) / 4 * 4, ' ');
    const auto word = [](size_t value) {
        std::string four;
        for (int k = 0; k < 4; ++k) four += static_cast<char>(value >> (8 * k) & 255);
        return four;
    };
    write_text(file, bytes.substr(0, 8) + word(20 + text.size() + rest.size()) + word(text.size()) + bytes.substr(16, 4)
                         + text + rest);
}

engine::Bitmap render(const Folder& folder, const std::string& arguments) {
    const std::string file = folder / "picture.png";
    const Outcome outcome =
        run_brittle(folder, "render " + arguments + " --size 480x300 --device cpu --validation -o " + file);
    REQUIRE_MESSAGE(outcome.exit_code == exit_success, outcome.output);
    return must(engine::read_png(file));
}

bool is_skipped() {
    return engine::test::make_device() == nullptr;
}

// The corners of a batch against the affine maps of the crate's sides. Positions plus `origin` are in the crate's
// coordinates once divided by `scale` and moved by `centre`.
void check_corners(const engine::PieceBatch& batch,
                   const std::function<glm::dvec3(uint32_t, const glm::vec3&)>& in_crate) {
    REQUIRE(batch.corners().size() == batch.positions().size());
    uint32_t number = 0;
    size_t checked = 0;
    for (const engine::PieceBatch::Piece& piece : batch.pieces()) {
        for (uint32_t i = 0; i < piece.exterior_indices + piece.interior_indices; i += 3) {
            std::array<engine::CornerLook, 3> looks;
            std::array<glm::dvec3, 3> at;
            for (uint32_t k = 0; k < 3; ++k) {
                const uint32_t v = piece.first_vertex + batch.indices()[piece.first_index + i + k];
                looks[k] = batch.corners()[v];
                at[k] = in_crate(number, batch.positions()[v]);
            }
            CHECK(looks[0].material == looks[1].material);
            CHECK(looks[0].material == looks[2].material);
            if (i >= piece.exterior_indices) {
                CHECK(looks[0].material == 0);
                continue;
            }
            const glm::dvec3 across = glm::cross(at[1] - at[0], at[2] - at[0]);
            if (!(glm::length(across) > 1e-4)) continue; // a sliver: its plane is not known to single precision
            const glm::dvec3 normal = glm::normalize(across);
            CHECK(looks[0].material == (normal.z > 0.5 ? 2 : (normal.y > 0.5 ? 3 : (normal.y < -0.5 ? 0 : 1))));
            if (looks[0].material == 0) continue;
            for (uint32_t k = 0; k < 3; ++k) CHECK(glm::distance(glm::dvec2(looks[k].uv), uv_of(at[k], normal)) < 1e-5);
            ++checked;
        }
        ++number;
    }
    CHECK(checked > 0);
}

} // namespace

TEST_CASE("looks: a mesh without materials has none, and an image for the cuts alone leaves the outside as it is") {
    fracture::Model model;
    model.mesh = fracture::cube();
    std::vector<std::string> notes;
    CHECK(materials_of(model, notes) == nullptr);
    CHECK(looks_of(model, model.mesh, nullptr) == nullptr);
    model.materials.emplace_back(); // that no triangle uses
    CHECK(materials_of(model, notes) == nullptr);
    const fracture::Image image = png_of(checker(2, 255));
    const auto set = materials_of(model, notes, &image);
    REQUIRE(set);
    CHECK(set->materials.empty());
    CHECK(set->cuts == 0u);
    const auto looks = looks_of(model, model.mesh, set);
    REQUIRE(looks);
    CHECK_FALSE(looks->of_mesh);
    CHECK(batch_of(model.mesh, looks.get()).corners().empty());
    CHECK(notes.empty());
    CHECK(shows_materials(PieceColours::automatic, true));
    CHECK_FALSE(shows_materials(PieceColours::automatic, false));
    CHECK_FALSE(shows_materials(PieceColours::pieces, true));
    CHECK(shows_materials(PieceColours::materials, false));
}

TEST_CASE("looks: an image that cannot be shown gives a note, and its material the plain colour") {
    const auto note_for = [](const std::function<void(fracture::Image&)>& change) {
        fracture::Model model = crate();
        change(model.images[0]);
        std::vector<std::string> notes;
        const auto set = materials_of(model, notes);
        REQUIRE(set);
        CHECK_FALSE(set->materials[0].base_colour);
        CHECK(set->materials[1].base_colour);
        CHECK(set->base_colours.layers() == 1);
        return notes.empty() ? std::string() : notes.front();
    };
    const std::string shown = "image 0 'checker' is drawn as a plain colour: ";
    CHECK(note_for([](auto& image) { image.bytes.clear(); }).starts_with(shown));
    CHECK(note_for([](auto& image) { image.bytes.resize(image.bytes.size() / 2); }).starts_with(shown));
    CHECK(note_for([](auto& image) { image.bytes[24] = std::byte{0xff}; }).starts_with(shown));
    const std::string huge = note_for([](auto& image) {
        image.bytes[18] = std::byte{0x2f}; // 12,000 pixels a side
        image.bytes[22] = std::byte{0x2f};
    });
    CHECK(huge.starts_with(shown));
    CHECK(huge.find("pixels") != std::string::npos);
    CHECK(note_for([](auto& image) { image.mime_type = "image/webp"; }).find("image/webp") != std::string::npos);
    // The reader has a note about an image that it left out.
    CHECK(note_for([](auto& image) { image = {}; }).empty());
}

TEST_CASE("looks: materials of a file keep colour, opacity, wrapping and the transform of coordinates") {
    fracture::Model model = crate();
    model.textures[0].wrap_s = 33071;
    model.textures[0].wrap_t = 33648;
    model.materials[0].base_colour_texture->extensions =
        R"({"KHR_texture_transform": {"offset": [0.25, -1], "scale": [2, 3], "rotation": 1.5707963267948966}})";
    model.materials[1].base_colour_texture->extensions =
        R"({"KHR_texture_transform": {"scale": [1e99, "x"], "offset": 3}})";
    model.materials[2].alpha_mode = fracture::AlphaMode::blend;
    model.materials[2].base_colour.w = 0.5;
    std::vector<std::string> notes;
    const auto set = materials_of(model, notes);
    REQUIRE(set);
    REQUIRE(set->materials.size() == 4); // one more for vertex colours without a material
    const auto& board = *set->materials[0].base_colour;
    CHECK(board.wrap_u == engine::Wrap::clamp);
    CHECK(board.wrap_v == engine::Wrap::mirror);
    CHECK(board.offset == glm::vec2(0.25f, -1.0f));
    // By glTF: offset * rotation * scale, with the rotation counter-clockwise in an image whose v points down.
    const glm::vec2 turned = board.turn * glm::vec2(1.0f, 1.0f);
    CHECK(turned.x == doctest::Approx(3.0));
    CHECK(turned.y == doctest::Approx(-2.0));
    const auto& lattice = *set->materials[1].base_colour;
    CHECK(lattice.turn == glm::mat2(1.0f));
    CHECK(lattice.offset == glm::vec2(0.0f));
    CHECK(set->materials[1].opacity == engine::Opacity::mask);
    CHECK(set->materials[1].cutoff == 0.5f);
    CHECK(set->materials[2].opacity == engine::Opacity::blend);
    CHECK(set->materials[2].colour.w == 0.5f);
    CHECK(notes.empty());
}

TEST_CASE("looks: vertex colours are looks of their own, and damaged ones do no harm") {
    fracture::Model model;
    model.mesh = fracture::cube();
    model.colours.assign(3 * model.mesh.triangles.size(), glm::vec4(0.2158605f, 1.0f, 0.0f, 1.0f)); // sRGB 128, 255, 0
    model.colours[3] = glm::vec4(std::nanf(""), -1.0f, 7.0f, 1.0f);
    std::vector<std::string> notes;
    const auto looks = looks_of(model, model.mesh, materials_of(model, notes));
    REQUIRE(looks);
    const auto corners_of = [&](uint32_t t) {
        const fracture::Triangle& c = model.mesh.triangles[t];
        const auto& at = model.mesh.positions;
        return looks->corners(t, {at[c.x], at[c.y], at[c.z]});
    };
    CHECK(corners_of(0)[0].material == 1);
    CHECK(corners_of(0)[0].colour == engine::srgb8(128, 255, 0));
    CHECK(corners_of(1)[1].colour == engine::srgb8(128, 255, 0));
    CHECK((corners_of(1)[0].colour >> 8 & 0xffff) == 0xff00); // green 0, blue 255
}

TEST_CASE("looks: the corners of pieces, however they are cut, lie in the texture where they lay before") {
    const auto device = engine::test::make_device();
    if (!device) return;
    const auto renderer = must(engine::Renderer::create(*device));
    Input input;
    input.model = crate();
    input = placed_on_stage(std::move(input));
    std::vector<std::string> notes;
    const auto looks = looks_of(input.model, input.model.mesh, materials_of(input.model, notes));
    REQUIRE(looks);
    const fracture::Box box = fracture::bounds(input.model.mesh);
    const auto in_crate = [&](const glm::dvec3& on_stage) { return (on_stage - box.centre()) / (box.max - box.min); };
    check_corners(batch_of(input.model.mesh, looks.get()),
                  [&](uint32_t, const glm::vec3& p) { return in_crate(glm::dvec3(p)); });
    for (int k = 0; k < 6; ++k)
        input.sites.push_back(in_crate(glm::dvec3(0.0)) + box.centre()
                              + glm::dvec3(0.3 * k - 0.7, 0.21 * (k % 3) - 0.2, 0.1 * (k % 2)));
    FractureOptions options;
    const Broken broken = break_input(input, options);
    REQUIRE(broken.fragments.pieces.size() > 2);
    const auto centre_of = [&](uint32_t piece) { return broken.fragments.pieces[piece].mass.centre_of_mass; };
    const PreparedPieces loose = prepare_pieces(*renderer, broken.fragments, {}, {}, 0, looks);
    check_corners(loose.batch,
                  [&](uint32_t piece, const glm::vec3& p) { return in_crate(glm::dvec3(p) + centre_of(piece)); });
    for (size_t k = 0; k < loose.batch.pieces().size(); ++k)
        CHECK(glm::distance(glm::dvec3(loose.batch.pieces()[k].attachment.centre), centre_of(static_cast<uint32_t>(k)))
              < 1e-6);

    // Cut again by a blow.
    WorldOptions world;
    world.breakable = true;
    const physics::SolidPtr whole = must(physics::make_solid(input.model.mesh, {.min_size = 0.01}));
    const auto pieces = must(physics::break_solid(*whole, input.sites, {}, {.min_size = 0.01}));
    REQUIRE(pieces.size() > 2);
    for (const physics::SolidPtr& piece : pieces) {
        const auto again = must(physics::break_solid(*piece, input.sites, {}, {.min_size = 0.001}));
        for (const physics::SolidPtr& solid : again)
            check_corners(draw_piece(*solid, piece.get(), looks.get())->batch, [&](uint32_t, const glm::vec3& p) {
                return in_crate(glm::dvec3(p) + solid->mass.centre_of_mass);
            });
    }
}

TEST_CASE("looks: a large piece, drawn in parts, has corners, too") {
    if (is_skipped()) return;
    fracture::Model model;
    model.mesh = fracture::icosphere(5); // in clusters
    for (const fracture::Triangle& t : model.mesh.triangles)
        for (int k = 0; k < 3; ++k) {
            const glm::dvec3& p = model.mesh.positions[t[k]];
            model.uv[0].emplace_back(p.x, p.y);
        }
    model.material_of.assign(model.mesh.triangles.size(), 0);
    model.materials.emplace_back();
    model.materials[0].base_colour_texture = fracture::TextureUse{};
    model.textures = {{.image = 0}};
    model.images = {png_of(checker(2, 255))};
    std::vector<std::string> notes;
    const auto looks = looks_of(model, model.mesh, materials_of(model, notes));
    REQUIRE(looks);
    const physics::SolidPtr whole = must(physics::make_solid(model.mesh));
    REQUIRE(whole->is_clustered());
    const auto drawing = draw_piece(*whole, nullptr, looks.get());
    REQUIRE(drawing->batch.pieces().size() > 1);
    REQUIRE(drawing->batch.corners().size() == drawing->batch.positions().size());
    for (size_t v = 0; v < drawing->batch.positions().size(); ++v) {
        const glm::vec3& p = drawing->batch.positions()[v]; // of a clustered piece: in the object
        CHECK(drawing->batch.corners()[v].material == 1);
        CHECK(glm::distance(drawing->batch.corners()[v].uv, glm::vec2(p)) < 1e-5f);
    }
}

TEST_CASE("looks: a crate with textures and a cut-out, whole and broken, in both views") {
    if (is_skipped()) return;
    const Folder folder;
    const std::string file = folder / "crate.glb", plain = folder / "plain.stl"; // which keeps no materials
    write_crate(file);
    write_crate(plain);
    const std::string broken = " -n 14 --frames 0 --explode 0.35 --distance 0.8 --elevation 25";
    const auto check = [&](const std::string& arguments, const std::string& name) {
        const engine::Bitmap picture = render(folder, file + arguments);
        const GoldenCheck golden = check_golden(picture, name, {}, engine::test::golden_folder() + "/looks");
        CHECK_MESSAGE(golden.passed, golden.message);
        return picture;
    };
    const engine::Bitmap whole = check(" --whole", "crate");
    const engine::Bitmap pieces = check(broken + " --material wood", "crate_in_pieces");
    (void)check(" -n 14 --breakable --shot 0.4,1.2,4,0,0,-30,0.25 --frames 30", "crate_is_shot");
    // By default as by --colors materials; the other view is that of a mesh without looks.
    CHECK(render(folder, file + broken + " --material wood --colors materials").pixels == pieces.pixels);
    for (const std::string& arguments : {broken, std::string(" --whole")}) {
        const engine::Bitmap without = render(folder, plain + arguments);
        CHECK(render(folder, file + arguments + " --colors pieces").pixels == without.pixels);
        CHECK(render(folder, file + arguments).pixels != without.pixels);
    }
    CHECK(render(folder, plain + " --whole --colors materials").pixels != whole.pixels);
    // A recipe keeps the view.
    const std::string recipe = folder / "recipe.json";
    (void)render(folder, file + broken + " --colors pieces --save-recipe " + recipe);
    CHECK(render(folder, "--recipe " + recipe).pixels == render(folder, plain + broken).pixels);
}

TEST_CASE("looks: a broken vase of glass is clear, and the other view is as before") {
    if (is_skipped()) return;
    const Folder folder;
    const std::string vase = "shape:vase --material glass -n 20 --frames 0 --explode 0.1 --smooth";
    const engine::Bitmap picture = render(folder, vase + " --colors materials");
    const GoldenCheck golden = check_golden(picture, "glass_vase", {}, engine::test::golden_folder() + "/looks");
    CHECK_MESSAGE(golden.passed, golden.message);
    CHECK(render(folder, vase).pixels == render(folder, vase + " --colors pieces").pixels);
}

TEST_CASE("looks: an image for fracture surfaces") {
    if (is_skipped()) return;
    const Folder folder;
    const std::string file = folder / "crate.glb", image = folder / "tiles.png", recipe = folder / "recipe.json";
    write_crate(file);
    must(engine::write_png(checker(8, 255), image));
    const std::string broken = " -n 14 --frames 0 --explode 0.35 --distance 0.8 --elevation 25";
    const engine::Bitmap picture =
        render(folder, file + broken + " --interior-texture " + image + " --save-recipe " + recipe);
    const GoldenCheck golden =
        check_golden(picture, "crate_with_tiles_inside", {}, engine::test::golden_folder() + "/looks");
    CHECK_MESSAGE(golden.passed, golden.message);
    CHECK(read_text(recipe).find("\"interior_texture\": \"" + image + "\"") != std::string::npos);
    CHECK(render(folder, "--recipe " + recipe).pixels == picture.pixels);

    const Outcome missing =
        run_brittle(folder, "render " + file + broken + " --interior-texture " + folder / "none.png -o x.png");
    CHECK(missing.exit_code == exit_input);
    CHECK(missing.has("none.png"));
    write_text(image, read_text(image).substr(0, 200));
    const Outcome damaged =
        run_brittle(folder, "render " + file + broken + " --interior-texture " + image + " -o " + folder / "y.png");
    CHECK(damaged.exit_code == exit_success);
    CHECK(damaged.has("the texture of fracture surfaces"));
    CHECK(damaged.has("is drawn as a plain colour"));
}

TEST_CASE("looks: a missing, a damaged and a huge texture leave the mesh in its plain colours, with a message") {
    if (is_skipped()) return;
    const Folder folder;
    const std::string good = folder / "good.glb", bad = folder / "bad.glb", obj = folder / "crate.obj";
    const auto untextured = [](fracture::Model& model) {
        for (fracture::Material& material : model.materials) material.base_colour_texture.reset();
    };
    write_crate(good, untextured);
    const engine::Bitmap plain = render(folder, good + " --whole");
    for (const size_t kept : {size_t{40}, size_t{200}}) {
        write_crate(bad, [&](fracture::Model& model) {
            for (fracture::Image& image : model.images) image.bytes.resize(kept);
        });
        const std::string picture = folder / "bad.png";
        const Outcome outcome =
            run_brittle(folder, "render " + bad + " --whole --size 480x300 --validation -o " + picture);
        CHECK(outcome.exit_code == exit_success);
        CHECK(outcome.has("bad: image 0"));
        CHECK(outcome.has("image 1"));
        CHECK(must(engine::read_png(picture)).pixels == plain.pixels);
    }
    // An OBJ file with the textures beside it, which are then gone.
    write_crate(obj);
    const engine::Bitmap beside = render(folder, obj + " --whole");
    CHECK(beside.pixels != plain.pixels);
    for (const auto& entry : std::filesystem::directory_iterator(std::filesystem::path(obj).parent_path()))
        if (entry.path().extension() == ".png" && entry.path().stem().string().find("picture") == std::string::npos
            && entry.path().stem() != "bad")
            std::filesystem::remove(entry.path());
    const Outcome gone = run_brittle(folder, "render " + obj + " --whole --size 480x300 -o " + folder / "gone.png");
    CHECK(gone.exit_code == exit_success);
    CHECK(gone.has("crate: "));
}

TEST_CASE("looks: objects of a scene have those of their files, mirrored and scaled, each texture once") {
    if (is_skipped()) return;
    const Folder folder;
    const std::string damaged = folder / "damaged.glb";
    write_crate(folder / "crate.glb");
    write_crate(damaged, [](fracture::Model& model) { model.images[0].bytes.resize(50); });
    const std::string scene = folder.write("scene.json", R"({"brittle": 2, "objects": [
        {"mesh": "crate.glb", "translation": [-1.3, 0.5, 0], "material": "wood"},
        {"mesh": "crate.glb", "scale": [-1.2, 1.2, 1.2], "translation": [0, 0.6, 0.2], "shattered": true,
         "material": "concrete", "pattern": {"type": "uniform", "count": 9}},
        {"mesh": "shape:cube", "scale": [0.5, 0.5, 0.5], "translation": [0, 1.8, 0.2], "material": "glass"},
        {"mesh": "damaged.glb", "fixed": true, "translation": [1.5, 0.5, 0]},
        {"mesh": "damaged.glb", "scale": [0.5, 0.5, 0.5], "translation": [1.5, 1.3, 0]}]})");
    const std::string file = folder / "picture.png";
    const Outcome outcome = run_brittle(
        folder, "render --recipe " + scene + " --frames 20 --size 480x300 --device cpu --validation -o " + file);
    REQUIRE_MESSAGE(outcome.exit_code == exit_success, outcome.output);
    const size_t first = outcome.output.find("image 0");
    CHECK(first != std::string::npos);
    CHECK(outcome.output.find("image 0", first + 1) == std::string::npos);
    const GoldenCheck golden =
        check_golden(must(engine::read_png(file)), "scene_of_crates", {}, engine::test::golden_folder() + "/looks");
    CHECK_MESSAGE(golden.passed, golden.message);
}

TEST_CASE("looks: nodes and pieces of a file have its textures where they lie, mirrored nodes, too") {
    const Folder folder;
    write_crates(folder / "crates.glb", R"([{"name": "a", "mesh": 0}, {"name": "b", "mesh": 0, "scale": [-1, 1, 1],
        "translation": [3, 0, 0]}, {"name": "c", "mesh": 3, "translation": [0, 3, 0]}])");
    // The place of a point of the file, in the crate that it belongs to.
    const auto in_crate = [](const glm::dvec3& p) {
        return p.y > 1.5 ? p - glm::dvec3(0.0, 3.0, 0.0) : (p.x > 1.5 ? glm::dvec3(3.0 - p.x, p.y, p.z) : p);
    };
    const auto check = [&](const LoadedObject& object, const std::function<glm::dvec3(const glm::dvec3&)>& local) {
        CAPTURE(object.object.name);
        const MeshLooks* const looks = object.input->looks.get();
        REQUIRE(looks);
        const fracture::TriangleMesh& mesh = object.input->model.mesh;
        size_t checked = 0;
        for (uint32_t t = 0; t < mesh.triangles.size(); ++t) {
            const fracture::Triangle& c = mesh.triangles[t];
            const std::array<glm::dvec3, 3> at{mesh.positions[c.x], mesh.positions[c.y], mesh.positions[c.z]};
            const std::array<glm::dvec3, 3> own{local(at[0]), local(at[1]), local(at[2])};
            const glm::dvec3 normal = glm::normalize(glm::cross(own[1] - own[0], own[2] - own[0]));
            const auto corners = looks->corners(t, at);
            if (corners[0].material == 0) continue;
            for (size_t k = 0; k < 3; ++k)
                CHECK(glm::distance(glm::dvec2(corners[k].uv), uv_of(own[k], normal)) < 1e-6);
            ++checked;
        }
        CHECK(checked == (object.object.in_pieces ? 24u : 12u)); // all but those of c, which has no material
    };
    FractureOptions nodes, pieces;
    read_recipe(folder.write("nodes.json", R"({"brittle": 2, "level": {"mesh": "crates.glb"}})"), nodes);
    read_recipe(
        folder.write("pieces.json", R"({"brittle": 2, "objects": [{"mesh": "crates.glb", "in_pieces": true}]})"),
        pieces);
    const LoadedScene level = load_scene(nodes, drawing_host());
    REQUIRE(level.objects.size() == 3);
    for (const size_t k : {0u, 1u}) { // the scale of an object is part of its mesh
        const glm::dvec3 scale = level.objects[k].object.placement.scale;
        CHECK(scale.x * scale.y * scale.z == doctest::Approx(k == 0 ? 1.0 : -1.0));
        check(level.objects[k], [&](const glm::dvec3& p) { return p / scale; });
    }
    CHECK(level.objects[2].input->looks == nullptr);
    CHECK(level.objects[0].input->looks->materials == level.objects[1].input->looks->materials); // decoded once
    const LoadedScene set = load_scene(pieces, drawing_host());
    REQUIRE(set.objects.size() == 1);
    CHECK_FALSE(set.objects[0].refused);
    check(set.objects[0], in_crate);
    CHECK(load_scene(nodes).objects[0].input->looks == nullptr); // nobody draws
}

TEST_CASE("looks: a level of crates with materials of their own, and a crate in pieces of a file") {
    if (is_skipped()) return;
    const Folder folder;
    write_crates(folder / "level.glb", R"([{"name": "Crate", "mesh": 0, "translation": [-1.4, 0.5, 0.1]},
        {"name": "Broken crate", "mesh": 0, "scale": [-1.2, 1.2, 1.2], "rotation": [0, 0.2588, 0, 0.9659],
         "translation": [0.1, 0.6, 0]},
        {"name": "Red crate", "mesh": 1, "scale": [0.8, 0.8, 0.8], "translation": [1.5, 0.4, 0.3]},
        {"name": "Planks", "mesh": 2, "scale": [0.5, 0.5, 0.5], "translation": [-1.3, 1.25, 0.1]},
        {"name": "Plain crate", "mesh": 3, "scale": [0.5, 0.5, 0.5], "translation": [1.5, 1.05, 0.3]}])");
    const std::string scene = folder.write("scene.json", R"({"brittle": 2, "level": {"mesh": "level.glb", "rules": [
        {"node": "Broken*", "then": {"shattered": true, "material": "concrete",
                                     "pattern": {"type": "uniform", "count": 9}}},
        {"node": "Plain*", "then": {"material": "stone"}}, {"then": {"material": "wood"}}]},
        "objects": [{"name": "one more", "mesh": "level.glb", "node": "Red crate", "scale": [0.4, 0.4, 0.4],
                     "translation": [0.1, 1.5, 0], "material": "glass"}]})");
    const auto check = [](const engine::Bitmap& picture, const std::string& name) {
        const GoldenCheck golden = check_golden(picture, name, {}, engine::test::golden_folder() + "/looks");
        CHECK_MESSAGE(golden.passed, golden.message);
    };
    check(render(folder,
                 "--recipe " + scene + " --frames 24 --elevation 20 --distance 0.9 --shot 0.1,0.9,2.5,0,0,-14,0.15"),
          "level_of_crates");

    // A crate is drawn alike as a node and as a whole file.
    write_crate(folder / "crate.glb");
    const auto one = [&](const std::string& members) {
        return render(folder, "--recipe "
                                  + folder
                                        .write("one.json", R"({"brittle": 2, "objects": [{"name": "a", )" + members
                                                               + R"(, "translation": [0, 0.5, 0]}]})")
                                        .string()
                                  + " --frames 0");
    };
    CHECK(one(R"("mesh": "level.glb", "node": "Crate")").pixels == one(R"("mesh": "crate.glb")").pixels);

    const std::string pieces = folder / "pieces.glb";
    REQUIRE(run_brittle(folder, "fracture " + (folder / "crate.glb") + " -n 14 --material wood -o " + pieces).exit_code
            == 0);
    const std::string set = folder.write("set.json", R"({"brittle": 2, "objects": [{"mesh": "pieces.glb",
        "in_pieces": true, "bonded": true, "material": "wood", "translation": [0, 0.5, 0]}]})");
    check(render(folder, "--recipe " + set
                             + " --shot 0.2,0.6,3,0,0,-16,0.2 --frames 40 --azimuth 30 --elevation 20 --distance 1.2"),
          "crates_from_pieces");
}

TEST_CASE("looks: the studio shows materials where the mesh has some, and a view of pieces") {
    const Folder folder;
    const std::string file = folder / "crate.glb";
    write_crate(file);
    Room room(file), plain("shape:cube");
    if (!room.device) return;
    CHECK(room.session->stage().shows_materials());
    CHECK_FALSE(plain.session->stage().shows_materials());
    const engine::Bitmap whole = room.picture();
    room.session->picture().colours = PieceColours::pieces;
    CHECK(room.picture().pixels != whole.pixels);
    CHECK_FALSE(room.session->stage().shows_materials());
    room.session->picture().colours = PieceColours::materials;
    CHECK(room.picture().pixels == whole.pixels);
    CHECK(room.session->recipe().picture.colours == PieceColours::materials);
    room.break_it();
    const engine::Bitmap broken = room.picture();
    CHECK(room.session->stage().shows_materials());
    room.session->picture().colours = PieceColours::automatic;
    CHECK(room.picture().pixels == broken.pixels);
    // Another material and another place make new stages with the same textures.
    room.session->edit(SetMaterial{"brick"});
    CHECK(room.session->stage().shows_materials());
    WorldOptions world = room.session->recipe().world;
    world.anchored = true;
    room.session->edit(SetWorld{world});
    CHECK(room.session->stage().shows_materials());
    CHECK(room.session->object().looks() != nullptr);
}
