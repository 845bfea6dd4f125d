// The view of materials: textures, cut-outs, normal maps and the grain of fracture surfaces. The oracle is the view of
// pieces, in which the colour of a surface is the caller's.
#include <cmath>
#include <cstdlib>
#include <memory>
#include <vector>

#include <doctest/doctest.h>
#include <glm/geometric.hpp>

#include "renderer_fixture.h"

using namespace brittle::engine;
using namespace brittle::engine::test;

namespace {

constexpr glm::uvec2 size{96, 96};

float linear_of(uint32_t srgb) {
    const double c = srgb / 255.0;
    return static_cast<float>(c <= 0.04045 ? c / 12.92 : std::pow((c + 0.055) / 1.055, 2.4));
}

// A square of two units a side in the x-y plane that faces the camera, with (0, 0) of the texture in its upper left
// corner.
struct Square {
    std::vector<glm::vec3> positions{{-1, 1, 0}, {-1, -1, 0}, {1, -1, 0}, {1, 1, 0}};
    std::vector<glm::uvec3> triangles{{0, 1, 2}, {0, 2, 3}};
    std::vector<CornerLook> corners;

    explicit Square(uint32_t material, float repeats = 1.0f, uint32_t colour = srgb8(255, 255, 255)) {
        const glm::vec2 uv[] = {{0, 0}, {0, repeats}, {repeats, repeats}, {repeats, 0}};
        for (const glm::uvec3& t : triangles)
            for (int k = 0; k < 3; ++k) corners.push_back({uv[t[k]], colour, material});
    }
    [[nodiscard]] PieceMesh piece(uint32_t body = 0) const {
        return {
            .positions = positions, .triangles = triangles, .exterior_triangles = 2, .body = body, .corners = corners};
    }
};

Bitmap texture(uint32_t width, uint32_t height, std::initializer_list<uint32_t> texels) {
    Bitmap made{width, height, {}};
    for (const uint32_t texel : texels)
        for (int k = 0; k < 4; ++k) made.pixels.push_back(static_cast<uint8_t>(texel >> 8 * k));
    return made;
}

// A texture whose texels are squares of many texels, so that filters do not blur them where tests look.
Bitmap enlarged(const Bitmap& image, uint32_t factor) {
    Bitmap made{image.width * factor, image.height * factor, {}};
    for (uint32_t y = 0; y < made.height; ++y)
        for (uint32_t x = 0; x < made.width; ++x) {
            const uint8_t* from = image.at(x / factor, y / factor);
            made.pixels.insert(made.pixels.end(), from, from + 4);
        }
    return made;
}

std::shared_ptr<MaterialSet> set_of(const MeshMaterial& material, const std::vector<Bitmap>& images = {}) {
    auto set = std::make_shared<MaterialSet>();
    set->materials.push_back(material);
    set->base_colours = TextureStack::of(images);
    return set;
}

Scene scene_of(bool materials) {
    Scene scene = empty_stage();
    scene.materials = materials;
    scene.look.tint = 0.0f;
    return scene;
}

// The picture of the square in one colour, in the view of pieces.
Bitmap plain_picture(const Fixture& f, const Square& square, const glm::vec3& colour) {
    REQUIRE(f.renderer->set_pieces({{square.piece()}}));
    Scene scene = scene_of(false);
    scene.look.exterior = colour;
    return f.draw(scene, size);
}

Bitmap material_picture(const Fixture& f, const Square& square, std::shared_ptr<const MaterialSet> set,
                        const Scene& scene = scene_of(true)) {
    REQUIRE(f.renderer->set_materials({std::move(set)}));
    REQUIRE(f.renderer->set_pieces({{square.piece()}}));
    return f.draw(scene, size);
}

int largest_difference(const Bitmap& a, const Bitmap& b) {
    return compare_bitmaps(a, b, {.ignore = 0, .channel = 255, .fraction = 1.0}).largest;
}

int difference_at(const Bitmap& a, const Bitmap& b, uint32_t x, uint32_t y) {
    int largest = 0;
    for (int k = 0; k < 3; ++k) largest = std::max(largest, std::abs(a.at(x, y)[k] - b.at(x, y)[k]));
    return largest;
}

} // namespace

TEST_CASE("materials: pieces without any, no sets and empty sets") {
    const Fixture f;
    if (!f) return;
    const Shape shape = box(glm::vec3(0.7f), 2);
    REQUIRE(f.renderer->set_pieces({{shape.piece(0)}}));
    Scene scene = scene_of(true);
    scene.look.grain = Grain::glass;
    const Bitmap first = f.draw(scene, size);
    REQUIRE(f.renderer->set_materials({std::make_shared<MaterialSet>()}));
    CHECK(largest_difference(f.draw(scene, size), first) == 0);
    scene.smooth = true;
    (void)f.draw(scene, size);
    REQUIRE(f.renderer->set_pieces({}));
    (void)f.draw(scene, size);
    REQUIRE(f.renderer->render_ids(scene, size));
}

TEST_CASE("materials: a wrong number of corners is refused") {
    const Fixture f;
    if (!f) return;
    Square square(1);
    square.corners.pop_back();
    const auto refused = f.renderer->set_pieces({{square.piece()}});
    REQUIRE_FALSE(refused);
    CHECK(refused.error().status == Status::invalid_argument);
    CHECK(refused.error().message.find("5 corners") != std::string::npos);
}

TEST_CASE("materials: colour, vertex colour and texture multiply, in linear light") {
    const Fixture f;
    if (!f) return;
    const uint32_t grey = srgb8(150, 150, 150), orange = srgb8(200, 120, 40);
    const Square square(1), coloured(1, 1.0f, orange);
    const glm::vec3 factor(0.8f, 0.5f, 0.9f), of_grey(linear_of(150)),
        of_orange(linear_of(200), linear_of(120), linear_of(40));
    const MeshMaterial plain{.colour = {factor, 1.0f}};
    MeshMaterial textured = plain;
    textured.base_colour = MaterialTexture{};
    CHECK(largest_difference(material_picture(f, square, set_of(plain)), plain_picture(f, square, factor)) <= 1);
    CHECK(largest_difference(material_picture(f, coloured, set_of(plain)), plain_picture(f, square, factor * of_orange))
          <= 2);
    CHECK(largest_difference(material_picture(f, coloured, set_of(textured, {texture(1, 1, {grey})})),
                             plain_picture(f, square, factor * of_orange * of_grey))
          <= 2);
}

TEST_CASE("materials: a triangle without one has the look of the scene") {
    const Fixture f;
    if (!f) return;
    Square square(0);
    Scene scene = scene_of(true);
    scene.look.exterior = {0.3f, 0.4f, 0.1f};
    CHECK(largest_difference(material_picture(f, square, set_of({}), scene),
                             plain_picture(f, square, scene.look.exterior))
          <= 1);
}

TEST_CASE("materials: the texture lies as its coordinates say, and repeats, ends or is mirrored beyond 1") {
    const Fixture f;
    if (!f) return;
    const uint32_t red = srgb8(200, 30, 30), green = srgb8(30, 160, 40), blue = srgb8(40, 50, 190),
                   yellow = srgb8(190, 180, 40);
    const uint32_t colours[2][2] = {{red, green}, {blue, yellow}};
    const std::vector<Bitmap> images{enlarged(texture(2, 2, {red, green, blue, yellow}), 16)};
    const auto colour_of = [](uint32_t c) {
        return glm::vec3(linear_of(c & 0xff), linear_of(c >> 8 & 0xff), linear_of(c >> 16 & 0xff));
    };
    for (const Wrap wrap : {Wrap::repeat, Wrap::clamp, Wrap::mirror}) {
        CAPTURE(static_cast<int>(wrap));
        MeshMaterial material;
        material.base_colour = MaterialTexture{.wrap_u = wrap, .wrap_v = wrap};
        const Square square(1, 2.0f);
        const Bitmap picture = material_picture(f, square, set_of(material, images));
        // The square reaches over the middle 65 % of the picture, with four quarters of the texture a side.
        for (uint32_t row = 0; row < 4; ++row)
            for (uint32_t column = 0; column < 4; ++column) {
                const auto quarter = [&](uint32_t k) {
                    if (wrap == Wrap::repeat) return k % 2;
                    if (wrap == Wrap::clamp) return std::min(k, 1u);
                    return k == 0 || k == 3 ? 0u : 1u;
                };
                const auto middle = [](uint32_t k) {
                    return 48 + static_cast<uint32_t>(15.5f * (static_cast<float>(k) - 1.5f));
                };
                const Bitmap expected = plain_picture(f, square, colour_of(colours[quarter(row)][quarter(column)]));
                CAPTURE(row);
                CAPTURE(column);
                CHECK(difference_at(picture, expected, middle(column), middle(row)) <= 2);
            }
    }
    // A transform of the coordinates turns and moves the texture: the left half of the square shows the right one.
    MeshMaterial moved;
    moved.base_colour = MaterialTexture{.turn = glm::mat2(0.5f), .offset = {0.5f, 0.0f}};
    const Square square(1);
    const Bitmap picture = material_picture(f, square, set_of(moved, images));
    const Bitmap expected = plain_picture(f, square, colour_of(green));
    CHECK(difference_at(picture, expected, 30, 30) <= 2);
    CHECK(difference_at(picture, expected, 66, 66) <= 2);
}

TEST_CASE("materials: far textures show their mean light, without flicker") {
    const Fixture f;
    if (!f) return;
    Bitmap checker{256, 256, {}};
    for (uint32_t i = 0; i < 256 * 256; ++i)
        checker.pixels.insert(checker.pixels.end(),
                              {uint8_t((i % 256 + i / 256) % 2 * 255), uint8_t((i % 256 + i / 256) % 2 * 255),
                               uint8_t((i % 256 + i / 256) % 2 * 255), 255});
    MeshMaterial material;
    material.base_colour = MaterialTexture{};
    const Square square(1, 8.0f);
    CHECK(largest_difference(material_picture(f, square, set_of(material, {checker})),
                             plain_picture(f, square, glm::vec3(linear_of(188))))
          <= 2);
}

TEST_CASE("materials: masks cut holes into the picture, the ids and the shadow") {
    const Fixture f;
    if (!f) return;
    const uint32_t hole = 0x00ffffffu, full = 0xffffffffu;
    MeshMaterial material{.colour = glm::vec4(0.1f, 0.1f, 0.1f, 1.0f), .opacity = Opacity::mask};
    material.base_colour = MaterialTexture{};
    const std::vector<Bitmap> images{enlarged(texture(2, 1, {hole, full}), 16)};
    const Square square(1);
    // The same as a rectangle: the right half of the square.
    Square half(0);
    for (glm::vec3& p : half.positions) p.x = std::max(p.x, 0.0f);
    Scene scene = scene_of(true);
    scene.ground = true;
    scene.ground_height = -1.2f;
    scene.camera.eye = {0.0f, 0.8f, 5.0f};
    scene.look.exterior = glm::vec3(0.1f);
    const Bitmap cut = material_picture(f, square, set_of(material, images), scene);
    const IdImage cut_ids = *f.renderer->render_ids(scene, size);
    REQUIRE(f.renderer->set_pieces({{half.piece()}}));
    Scene plain = scene;
    plain.materials = false;
    const Bitmap expected = f.draw(plain, size);
    const IdImage ids = *f.renderer->render_ids(plain, size);
    const BitmapDifference difference = compare_bitmaps(cut, expected, {.ignore = 2});
    CHECK(difference.unequal_pixels <= 150); // along the edge of the hole and of its shadow, by a pixel
    size_t shown = 0, unequal = 0;
    for (size_t i = 0; i < ids.ids.size(); ++i) {
        shown += ids.ids[i] != 0;
        unequal += (ids.ids[i] != 0) != (cut_ids.ids[i] != 0);
    }
    CHECK(shown > 900);
    CHECK(unequal <= 70);

    // Without the view of materials nothing is cut out.
    REQUIRE(f.renderer->set_pieces({{square.piece()}}));
    CHECK(largest_difference(f.draw(plain, size), expected) > 50);
    // A cutoff below the opacity of the hole leaves no hole.
    material.cutoff = 0.0f;
    const Bitmap whole = material_picture(f, square, set_of(material, images), scene);
    CHECK(largest_difference(whole, f.draw(plain, size)) <= 1);
}

TEST_CASE("materials: a blended material covers a share of the pixels") {
    const Fixture f;
    if (!f) return;
    const Square square(1);
    const auto covered = [&](float opacity) {
        (void)material_picture(f, square, set_of({.colour = {1.0f, 1.0f, 1.0f, opacity}, .opacity = Opacity::blend}));
        size_t count = 0;
        const Result<IdImage> ids = f.renderer->render_ids(scene_of(true), size);
        REQUIRE(ids);
        for (const uint32_t id : ids->ids) count += id != 0;
        return static_cast<double>(count);
    };
    const double all = covered(1.0f);
    CHECK(all > 3000);
    CHECK(covered(0.0f) == 0.0);
    CHECK(covered(0.25f) / all == doctest::Approx(0.25).epsilon(0.05));
    CHECK(covered(0.75f) / all == doctest::Approx(0.75).epsilon(0.05));
}

TEST_CASE("materials: a flat normal map changes nothing, and a bent one turns the surface towards its side") {
    const Fixture f;
    if (!f) return;
    const Square square(1);
    MeshMaterial material{.colour = {0.2f, 0.2f, 0.2f, 1.0f}};
    material.normal_map = MaterialTexture{};
    const auto picture = [&](uint32_t r, uint32_t g, uint32_t b, const glm::vec3& to_light) {
        auto set = std::make_shared<MaterialSet>(*set_of(material));
        const Bitmap map = texture(1, 1, {srgb8(r, g, b)});
        set->normal_maps = TextureStack::of({&map, 1}, {.srgb = false});
        Scene scene = scene_of(true);
        scene.look.to_light = to_light;
        return static_cast<int>(material_picture(f, square, set, scene).at(48, 48)[0]);
    };
    const glm::vec3 right(1.0f, 0.0f, 1.0f), up(0.0f, 1.0f, 1.0f);
    const int flat = picture(128, 128, 255, right);
    const MeshMaterial none{.colour = material.colour};
    Scene scene = scene_of(true);
    scene.look.to_light = right;
    CHECK(std::abs(flat - material_picture(f, square, set_of(none), scene).at(48, 48)[0]) <= 1);
    // Red is the direction of u, to the right; green is up, against v.
    CHECK(picture(218, 128, 218, right) > flat + 10);
    CHECK(picture(38, 128, 218, right) < flat - 20);
    CHECK(picture(128, 218, 218, up) > flat + 10);
    CHECK(picture(128, 38, 218, up) < flat - 20);
}

TEST_CASE("materials: the view of pieces is that of pieces without any, bit for bit") {
    const Fixture f;
    if (!f) return;
    Shape shape = box({0.6f, 0.5f, 0.4f}, 2);
    PieceMesh plain = shape.piece(0, piece_tint(3));
    std::vector<CornerLook> corners;
    for (uint32_t t = 0; t < shape.exterior_triangles; ++t)
        for (int k = 0; k < 3; ++k)
            corners.push_back({.uv = {0.1f * static_cast<float>(t), 0.0f}, .material = 1 + t % 3});
    for (const bool smooth : {false, true}) {
        Scene scene = scene_of(false);
        scene.look.tint = 0.9f;
        scene.smooth = smooth;
        REQUIRE(f.renderer->set_pieces({{plain}}));
        const Bitmap expected = f.draw(scene, size);
        PieceMesh dressed = plain;
        dressed.corners = corners;
        REQUIRE(f.renderer->set_pieces({{dressed}}));
        CHECK(largest_difference(f.draw(scene, size), expected) == 0);
    }
}

TEST_CASE("materials: pieces with and without come and go while the views change") {
    const Fixture f, fresh;
    if (!f) return;
    MeshMaterial red{.colour = {0.7f, 0.1f, 0.1f, 1.0f}}, blue{.colour = {0.1f, 0.1f, 0.7f, 1.0f}};
    const std::vector<std::shared_ptr<const MaterialSet>> sets{set_of(red), set_of(blue)};
    const Square square(1);
    const Shape ball = icosphere(0.5f, 4);
    const auto add = [&](const Renderer& renderer, uint32_t first_material, uint32_t body) {
        const PieceMesh mesh = square.piece(body);
        PieceBatch batch = *PieceBatch::create({&mesh, 1});
        batch.attach({.body = body, .first_material = first_material});
        renderer.stage(batch);
        return batch;
    };
    Scene scene = scene_of(true);
    scene.write_poses = [](std::span<BodyPose> poses, uint64_t) {
        for (size_t i = 0; i < poses.size(); ++i) {
            poses[i].position = {0.7f * static_cast<float>(i) - 1.0f, 0.0f, 0.1f * static_cast<float>(i)};
            poses[i].scale = 0.4f;
        }
    };
    REQUIRE(f.renderer->set_materials(sets));
    const auto balls = f.renderer->add_pieces({{ball.piece(0)}});
    REQUIRE(balls);
    scene.materials = false;
    (void)f.draw(scene, size);
    scene.materials = true; // an arena of corners is made for a piece without any
    (void)f.draw(scene, size);
    REQUIRE(f.renderer->add_pieces(add(*f.renderer, 0, 1)));
    (void)f.draw(scene, size);
    REQUIRE(f.renderer->add_pieces({{icosphere(0.3f, 5).piece(3)}})); // arenas grow
    REQUIRE(f.renderer->add_pieces(add(*f.renderer, 1, 2)));
    REQUIRE(f.renderer->remove_pieces(*balls));
    const Bitmap picture = f.draw(scene, size);

    REQUIRE(fresh.renderer->set_materials(sets));
    REQUIRE(fresh.renderer->add_pieces(add(*fresh.renderer, 0, 1)));
    REQUIRE(fresh.renderer->add_pieces({{icosphere(0.3f, 5).piece(3)}}));
    REQUIRE(fresh.renderer->add_pieces(add(*fresh.renderer, 1, 2)));
    CHECK(largest_difference(picture, fresh.draw(scene, size)) == 0);
    // The first square is red, the second one blue.
    const uint8_t* const first = picture.at(40, 48);
    const uint8_t* const second = picture.at(57, 48);
    CHECK(first[0] > first[2] + 50);
    CHECK(second[2] > second[0] + 50);
}

TEST_CASE("goldens: the grain of fracture surfaces, and their texture") {
    const Fixture f(Quality{.shadow_size = 1024, .soft_shadows = false, .samples = 1, .ambient_occlusion = false});
    if (!f) return;
    std::vector<Shape> shapes;
    std::vector<PieceMesh> meshes;
    for (uint32_t k = 0; k < 7; ++k) shapes.push_back(box(glm::vec3(0.28f), 6));
    for (uint32_t k = 0; k < 7; ++k) meshes.push_back(shapes[k].piece(k));
    const SurfaceLook looks[] = {{.interior = {0.45f, 0.60f, 0.55f}, .grain = Grain::glass},
                                 {.interior = {0.42f, 0.36f, 0.30f}, .grain = Grain::stone},
                                 {.interior = {0.34f, 0.33f, 0.31f}, .grain = Grain::concrete},
                                 {.interior = {0.50f, 0.33f, 0.16f}, .grain = Grain::wood},
                                 {.interior = {0.55f, 0.25f, 0.10f}, .grain = Grain::ceramic},
                                 {.interior = {0.40f, 0.14f, 0.08f}, .grain = Grain::brick}};
    const auto handles = f.renderer->set_pieces(meshes);
    REQUIRE(handles);
    for (uint32_t k = 0; k < 7; ++k)
        REQUIRE(f.renderer->attach_pieces({{(*handles)[k]}}, {.body = k, .surface = k, .centre = {0.3f, 0.2f, 0.1f}}));
    Scene scene = scene_of(true);
    scene.surfaces = looks;
    scene.ground = true;
    scene.ground_height = -1.0f;
    scene.write_poses = [](std::span<BodyPose> poses, uint64_t) {
        for (size_t k = 0; k < poses.size(); ++k)
            poses[k] = {
                .rotation = glm::normalize(glm::quat(1.0f, 0.25f, 0.4f, 0.0f)),
                .position = {0.95f * (static_cast<float>(k % 4) - (k < 4 ? 1.5f : 1.0f)), k < 4 ? 0.5f : -0.5f, 0.0f}};
    };
    scene.camera.eye = {0.0f, 0.0f, 4.3f};
    const auto check = [&](const char* name) {
        const GoldenCheck golden = check_golden(
            f.draw(scene, {480, 300}), name,
            f.device->is_cpu() ? BitmapTolerance{} : BitmapTolerance{.ignore = 3, .channel = 255, .fraction = 0.02},
            golden_folder());
        CHECK_MESSAGE(golden.passed, golden.message);
    };
    check("grain");
    MaterialSet set;
    const Bitmap tiles = enlarged(
        texture(2, 2, {srgb8(210, 200, 180), srgb8(120, 90, 60), srgb8(60, 90, 120), srgb8(210, 200, 180)}), 32);
    set.base_colours = TextureStack::of({&tiles, 1});
    set.cuts = 0;
    REQUIRE(f.renderer->set_materials({std::make_shared<MaterialSet>(set)}));
    check("cut_texture");
}
