// Pieces that are added, faded and removed between frames. The oracle is a call of set_pieces() with the remaining
// pieces.
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <map>
#include <random>
#include <string>
#include <thread>
#include <tuple>

#include <glm/geometric.hpp>
#include <glm/gtc/quaternion.hpp>

#include "engine/render/piece_arena.h"
#include "renderer_fixture.h"

using namespace brittle::engine;
using namespace brittle::engine::test;

namespace {

// Piece `number`, with its own shape and its own place on a grid in the x-y plane. Its body index is its number.
struct Made {
    Shape shape;
    uint32_t body;

    explicit Made(uint32_t number) : body(number) {
        const float size = 0.04f + 0.01f * static_cast<float>(number % 7);
        // Every twelfth piece is large enough to be staged.
        shape = number % 3 == 0 ? icosphere(size, number % 12 == 0 ? 4 : static_cast<int>(number % 2))
                                : box({size, size * 0.7f, size * 0.5f}, number % 5);
        for (glm::vec3& p : shape.positions)
            p += glm::vec3(static_cast<float>(number % 12) * 0.17f - 0.9f,
                           static_cast<float>(number / 12 % 8) * 0.17f - 0.6f, 0.0f);
    }
    [[nodiscard]] PieceMesh mesh() const { return shape.piece(body, piece_tint(body)); }
};

std::vector<PieceHandle> add(const Fixture& f, std::span<const PieceMesh> meshes) {
    Result<std::vector<PieceHandle>> handles = f.renderer->add_pieces(meshes);
    REQUIRE(handles);
    REQUIRE(handles->size() == meshes.size());
    return *std::move(handles);
}

// Adds each piece as a batch of its own.
std::vector<PieceHandle> add_staged(const Fixture& f, std::span<const PieceMesh> meshes) {
    std::vector<PieceBatch> batches;
    for (const PieceMesh& mesh : meshes) {
        batches.push_back(*PieceBatch::create({&mesh, 1}));
        f.renderer->stage(batches.back());
    }
    Result<std::vector<PieceHandle>> handles = f.renderer->add_pieces(std::move(batches));
    REQUIRE(handles);
    REQUIRE(handles->size() == meshes.size());
    return *std::move(handles);
}

IdImage ids_of(const Fixture& f, const Scene& scene) {
    Result<IdImage> image = f.renderer->render_ids(scene, small);
    REQUIRE(image);
    return *std::move(image);
}

// Draws the meshes with set_pieces(), for comparison, and removes them again.
Bitmap drawn_at_once(const Fixture& f, const KnownScene& known) {
    REQUIRE(f.renderer->set_pieces(known.pieces()));
    Bitmap picture = f.draw(known.scene);
    REQUIRE(f.renderer->set_pieces({}));
    return picture;
}

} // namespace

TEST_CASE("adding or removing no pieces succeeds, and unknown handles are refused") {
    const Fixture f;
    if (!f) return;
    CHECK(add(f, {}).empty());
    CHECK(f.renderer->add_pieces(PieceBatch{}));
    CHECK(f.renderer->remove_pieces({}));
    CHECK(f.renderer->fade_pieces({}, 0.5f));
    const Made made(4);
    const PieceMesh mesh = made.mesh();
    const std::vector<PieceHandle> handles = add(f, {&mesh, 1});
    CHECK(handles[0].number != 0);
    const PieceHandle strangers[] = {handles[0], {}, {handles[0].number + 1}};
    for (const size_t last : {1, 2}) {
        const PieceHandle two[] = {strangers[0], strangers[last]};
        for (const Result<void>& result : {f.renderer->remove_pieces(two), f.renderer->fade_pieces(two, 0.5f)}) {
            REQUIRE_FALSE(result);
            CHECK(result.error().status == Status::invalid_argument);
            CHECK(result.error().message.find("handle " + std::to_string(two[1].number)) != std::string::npos);
        }
    }
    for (const float fade : {-0.1f, 1.1f, std::numeric_limits<float>::quiet_NaN()})
        CHECK_FALSE(f.renderer->fade_pieces(handles, fade));
    CHECK(f.renderer->body_count() == 5);
    const PieceHandle twice[] = {handles[0], handles[0]};
    CHECK(f.renderer->remove_pieces(twice));
    CHECK(f.renderer->body_count() == 0);
    CHECK_FALSE(f.renderer->remove_pieces(handles));
    (void)f.draw(empty_stage());
    CHECK(f.renderer->stats().pieces == 0);
}

TEST_CASE("invalid pieces are refused, and none is added") {
    const Fixture f;
    if (!f) return;
    const Made made(1);
    const PieceMesh good = made.mesh();
    (void)add(f, {&good, 1});
    const Bitmap before = f.draw(empty_stage());
    PieceMesh bad_exterior = good, bad_body = good;
    bad_exterior.exterior_triangles = 13;
    bad_body.body = std::numeric_limits<uint32_t>::max();
    for (const PieceMesh& bad : {bad_exterior, bad_body}) {
        const PieceMesh two[] = {good, bad};
        const auto added = f.renderer->add_pieces(two);
        REQUIRE_FALSE(added);
        CHECK(added.error().message.find("piece 1") != std::string::npos);
    }
    CHECK(f.draw(empty_stage()).pixels == before.pixels);
    CHECK(f.renderer->stats().pieces == 1);
}

TEST_CASE("pieces without triangles or vertices have a handle and a body, and nothing to draw") {
    const Fixture f;
    if (!f) return;
    const std::vector<glm::vec3> lonely(3);
    const Made made(2);
    const PieceMesh meshes[] = {{}, {.positions = lonely, .body = 3}, made.mesh()};
    const std::vector<PieceHandle> handles = add(f, meshes);
    CHECK(f.renderer->body_count() == 4);
    (void)f.draw(empty_stage());
    CHECK(f.renderer->stats().pieces == 3);
    CHECK(f.renderer->stats().draws == 2);
    REQUIRE(f.renderer->remove_pieces(std::span(handles).last(2)));
    CHECK(f.renderer->body_count() == 1);
    (void)f.draw(empty_stage());
    CHECK(f.renderer->stats().draws == 0);
}

TEST_CASE("a batch created on another thread is drawn like its meshes") {
    const Fixture f;
    if (!f) return;
    const KnownScene known;
    const Bitmap expected = drawn_at_once(f, known);
    PieceBatch batch;
    std::thread([&] { batch = *PieceBatch::create(known.pieces()); }).join();
    CHECK(batch.pieces().size() == 4);
    REQUIRE(f.renderer->add_pieces(std::move(batch)));
    CHECK(f.draw(known.scene).pixels == expected.pixels);
}

TEST_CASE("batches added together, with bodies and tints assigned later, are drawn like their meshes") {
    const Fixture f;
    if (!f) return;
    const KnownScene known;
    const Bitmap expected = drawn_at_once(f, known);
    std::vector<PieceBatch> batches(1); // an empty batch
    for (const PieceMesh& piece : known.pieces()) {
        PieceMesh plain = piece;
        plain.body = 99;
        plain.tint = glm::vec3(0.1f);
        batches.push_back(*PieceBatch::create({&plain, 1}));
        batches.back().attach({.body = piece.body, .tint = piece.tint});
    }
    const auto handles = f.renderer->add_pieces(std::move(batches));
    REQUIRE(handles);
    CHECK(handles->size() == 4);
    CHECK(f.draw(known.scene).pixels == expected.pixels);
}

TEST_CASE("after any additions, copies and removals, pictures, ids and counts are those of the remaining pieces") {
    const Fixture changed, fresh;
    if (!changed) return;
    std::mt19937 random(11);
    constexpr uint32_t shapes = 96, bodies = 3 * shapes; // copies have bodies of their own
    std::vector<Made> all;
    for (uint32_t i = 0; i < bodies; ++i) {
        all.emplace_back(i % shapes);
        all.back().body = i;
    }
    std::map<PieceHandle, uint32_t> live; // piece number by handle, hence in the order of adding
    const auto is_live = [&](uint32_t number) {
        return std::ranges::any_of(live, [&](const auto& entry) { return entry.second == number; });
    };
    const auto copy = [&] {
        if (live.empty()) return;
        const auto [handle, number] = *std::next(live.begin(), random() % live.size());
        const uint32_t other = number % shapes + (1 + random() % 2) * shapes;
        if (is_live(other)) return;
        const auto copies = changed.renderer->copy_pieces({&handle, 1}, {.body = other, .tint = piece_tint(other)});
        REQUIRE(copies);
        REQUIRE(copies->size() == 1);
        live[copies->front()] = other;
    };
    const auto remove = [&](uint32_t count) {
        std::vector<PieceHandle> gone;
        while (gone.size() < std::min<size_t>(count, live.size())) {
            const PieceHandle handle = std::next(live.begin(), random() % live.size())->first;
            if (std::ranges::find(gone, handle) == gone.end()) gone.push_back(handle);
        }
        REQUIRE(changed.renderer->remove_pieces(gone));
        for (const PieceHandle handle : gone) live.erase(handle);
    };
    Scene scene = empty_stage();
    scene.ground = true;
    scene.ground_height = -0.8f;
    scene.write_poses = [](std::span<BodyPose> poses, uint64_t) {
        for (size_t body = 0; body < poses.size(); ++body)
            poses[body] = {.position = glm::vec3(0.05f, 0.04f, 0.1f) * static_cast<float>(body / shapes)};
    };
    for (int round = 0; round < 120; ++round) {
        // Several changes between two frames; some remove pieces that no frame has drawn yet.
        for (uint32_t change = random() % 4; change > 0; --change) {
            if (random() % 12 == 0) {
                REQUIRE(changed.renderer->set_pieces({}));
                live.clear();
            } else if (random() % 2 == 0) {
                remove(random() % 20);
            } else if (random() % 3 == 0) {
                for (uint32_t n = random() % 20; n > 0; --n) copy();
            } else {
                std::vector<uint32_t> numbers;
                std::vector<PieceMesh> meshes;
                for (uint32_t n = random() % 30; n > 0; --n) {
                    const uint32_t number = random() % shapes;
                    if (is_live(number) || std::ranges::count(numbers, number)) continue;
                    numbers.push_back(number);
                    meshes.push_back(all[number].mesh());
                }
                const std::vector<PieceHandle> handles =
                    random() % 2 == 0 ? add(changed, meshes) : add_staged(changed, meshes);
                for (size_t i = 0; i < handles.size(); ++i) live[handles[i]] = numbers[i];
            }
        }
        scene.moved = round % 3 == 0; // changes of pieces invalidate the shadow map by themselves
        std::vector<PieceMesh> meshes;
        std::vector<PieceHandle> expected_handles;
        for (const auto& [handle, number] : live) {
            meshes.push_back(all[number].mesh());
            expected_handles.push_back(handle);
        }
        const auto set = fresh.renderer->set_pieces(meshes);
        REQUIRE(set);
        CAPTURE(round);
        REQUIRE(changed.renderer->body_count() == fresh.renderer->body_count());
        REQUIRE(changed.draw(scene).pixels == fresh.draw(scene).pixels);
        const FrameStats &is = changed.renderer->stats(), &should = fresh.renderer->stats();
        REQUIRE(is.pieces == should.pieces);
        REQUIRE(is.pieces_in_view == should.pieces_in_view);
        REQUIRE(is.draws == should.draws);
        REQUIRE(is.triangles == should.triangles);
        // One of the renderers may have reused its shadow map if nothing changed.
        REQUIRE(is.indirect_calls == (is.draws == 0 ? 0u : is.shadow_drawn ? 2u : 1u));
        if (round % 4 != 0) continue;
        const IdImage ids = ids_of(changed, scene), should_ids = ids_of(fresh, scene);
        for (size_t i = 0; i < ids.ids.size(); ++i) {
            REQUIRE((ids.ids[i] == 0) == (should_ids.ids[i] == 0));
            if (ids.ids[i] == 0) continue;
            const auto place = std::ranges::find(*set, PieceHandle{should_ids.ids[i]}) - set->begin();
            REQUIRE(ids.ids[i] == expected_handles[static_cast<size_t>(place)].number);
        }
    }
}

TEST_CASE("ten thousand pieces added and removed in turn need no more memory than the first few") {
    Fixture f;
    if (!f) return;
    std::mt19937 random(3);
    std::vector<Shape> shapes;
    for (uint32_t i = 0; i < 8; ++i) shapes.push_back(i % 2 == 0 ? box(glm::vec3(0.02f), i % 6) : icosphere(0.02f, 0));
    const Shape large = icosphere(0.02f, 1);
    std::vector<PieceHandle> live;
    uint32_t allocations = 0;
    for (int cycle = 0; cycle < 10000; ++cycle) {
        // The first pieces are the largest, so that no later frame needs more memory.
        const Shape& shape = cycle < 200 ? large : shapes[random() % shapes.size()];
        const PieceMesh mesh = shape.piece(static_cast<uint32_t>(cycle % 32));
        live.push_back(add(f, {&mesh, 1})[0]);
        if (live.size() > 32) {
            std::swap(live[random() % live.size()], live.back());
            REQUIRE(f.renderer->remove_pieces({&live.back(), 1}));
            live.pop_back();
        }
        if (cycle % 20 == 0) (void)f.draw(empty_stage(), {8, 8});
        if (cycle == 200) allocations = f.faults.count(Call::allocate);
    }
    CHECK(f.faults.count(Call::allocate) == allocations);
    CHECK(f.renderer->stats().pieces <= 32);
}

TEST_CASE("copies of a piece share its geometry, whichever is removed first, and are refused like pieces") {
    Fixture f;
    if (!f) return;
    const Shape ball = icosphere(0.3f, 4);
    const PieceMesh mesh = ball.piece(0);
    std::vector<PieceHandle> handles = add(f, {&mesh, 1});
    (void)f.draw(empty_stage());
    const uint32_t before = f.faults.count(Call::allocate);
    for (uint32_t body = 1; body < 100; ++body) { // far more geometry than the arenas hold
        const auto copies = f.renderer->copy_pieces({&handles.back(), 1}, {.body = body});
        REQUIRE(copies);
        handles.push_back(copies->front());
    }
    const Bitmap picture = f.draw(empty_stage());
    CHECK(f.renderer->stats().pieces == 100);
    CHECK(f.renderer->stats().triangles == 100 * ball.triangles.size());
    REQUIRE(f.renderer->remove_pieces(std::span(handles).first(99))); // the one that was added among them
    CHECK(f.draw(empty_stage()).pixels == picture.pixels);
    REQUIRE(f.renderer->copy_pieces(std::span(handles).last(1), {}));
    CHECK(f.renderer->stats().pieces == 1); // of the last frame
    (void)f.draw(empty_stage());
    CHECK(f.renderer->stats().pieces == 2);
    // The draw lists of a hundred pieces and their poses are all that needed memory.
    CHECK(f.faults.count(Call::allocate) <= before + 8);

    CHECK_FALSE(f.renderer->copy_pieces(std::span(handles).first(1), {})); // it is gone
    const PieceHandle two[] = {handles.back(), {}};
    CHECK_FALSE(f.renderer->copy_pieces(two, {}));
    CHECK_FALSE(f.renderer->copy_pieces({two, 1}, {.body = std::numeric_limits<uint32_t>::max()}));
    CHECK(f.renderer->copy_pieces({}, {})->empty());
    (void)f.draw(empty_stage());
    CHECK(f.renderer->stats().pieces == 2);
}

TEST_CASE("a row of copies, and its shadow, look like a row of pieces with geometry of their own") {
    const Fixture copied, added;
    if (!copied) return;
    Scene scene = empty_stage();
    scene.ground = true;
    scene.ground_height = -0.5f;
    scene.write_poses = [](std::span<BodyPose> poses, uint64_t) {
        for (size_t body = 0; body < poses.size(); ++body)
            poses[body] = {
                .position = {0.3f * static_cast<float>(body) - 1.0f, 0.0f, -0.2f * static_cast<float>(body)}};
    };
    for (const uint32_t interior : {0u, 3u, 6u}) { // one range a piece, or two
        CAPTURE(interior);
        const Shape block = box(glm::vec3(0.1f), interior);
        std::vector<PieceMesh> meshes;
        for (uint32_t body = 0; body < 8; ++body) meshes.push_back(block.piece(body, piece_tint(body)));
        REQUIRE(added.renderer->set_pieces(meshes));
        const auto first = copied.renderer->set_pieces({meshes.data(), 1});
        REQUIRE(first);
        for (uint32_t body = 1; body < 8; ++body)
            REQUIRE(copied.renderer->copy_pieces(*first, {.body = body, .tint = piece_tint(body)}));
        CHECK(copied.draw(scene).pixels == added.draw(scene).pixels);
        CHECK(copied.renderer->stats().draws == added.renderer->stats().draws);
        (void)copied.draw(scene); // pieces in view are those of an earlier frame
        (void)added.draw(scene);
        CHECK(copied.renderer->stats().pieces_in_view == added.renderer->stats().pieces_in_view);
    }
}

TEST_CASE("a frame that uploads pieces needs no memory beyond that of the frames around it") {
    Fixture f;
    if (!f) return;
    const Shape cube = box(glm::vec3(0.5f));
    const PieceMesh mesh = cube.piece(0);
    uint32_t allocations = 0;
    for (int cycle = 0; cycle < 12; ++cycle) {
        const std::vector<PieceHandle> handles = add(f, {&mesh, 1});
        for (int frame = 0; frame < 3; ++frame) (void)f.draw(empty_stage(), {64, 64}); // the first one uploads
        REQUIRE(f.renderer->remove_pieces(handles));
        if (cycle == 3) allocations = f.faults.count(Call::allocate); // each frame in flight has its buffers by now
    }
    CHECK(f.faults.count(Call::allocate) == allocations);
    CHECK(f.device->validation_messages().empty());
}

TEST_CASE("fading discards a growing, reproducible set of pixels") {
    for (const uint32_t samples : {1u, 4u}) {
        Quality quality = plain_quality;
        quality.samples = samples;
        quality.ambient_occlusion = samples == 4;
        const Fixture f(quality);
        if (!f) return;
        const Shape cube = box(glm::vec3(0.8f), 1), other = box(glm::vec3(0.2f));
        const PieceMesh meshes[] = {cube.piece(0), other.piece(1)};
        const std::vector<PieceHandle> handles = add(f, meshes);
        const std::span faded(handles.data(), 1);
        Scene scene = empty_stage();
        scene.write_poses = [](std::span<BodyPose> poses, uint64_t) { poses[1].position.x = 1.2f; };
        const IdImage whole = ids_of(f, scene);
        const Bitmap solid = f.draw(scene);
        const auto count = [&](PieceHandle handle) {
            const IdImage ids = ids_of(f, scene);
            for (size_t i = 0; i < ids.ids.size(); ++i) REQUIRE((ids.ids[i] == 0 || ids.ids[i] == whole.ids[i]));
            return static_cast<int>(std::ranges::count(ids.ids, handle.number));
        };
        const int all = count(handles[0]), others = count(handles[1]);
        int before = all;
        for (const float fade : {0.25f, 0.5f, 0.75f, 1.0f}) {
            REQUIRE(f.renderer->fade_pieces(faded, fade));
            const int left = count(handles[0]);
            CHECK(left < before);
            CHECK(static_cast<float>(left) == doctest::Approx((1.0f - fade) * static_cast<float>(all)).epsilon(0.05));
            CHECK(count(handles[1]) == others);
            const Bitmap picture = f.draw(scene);
            CHECK(picture.pixels != solid.pixels);
            CHECK(f.draw(scene).pixels == picture.pixels);
            CHECK(f.renderer->stats().pieces == 2);
            CHECK(f.renderer->stats().draws == (fade < 1.0f ? 3u : 1u));
            before = left;
        }
        const Bitmap gone = f.draw(scene);
        REQUIRE(f.renderer->fade_pieces(faded, 0.0f));
        CHECK(f.draw(scene).pixels == solid.pixels);
        REQUIRE(f.renderer->remove_pieces(faded));
        CHECK(f.draw(scene).pixels == gone.pixels);
    }
}

TEST_CASE("each pixel of a fading piece shows either the piece or the background behind it") {
    const Fixture f;
    if (!f) return;
    const Shape cube = box(glm::vec3(0.5f));
    const PieceMesh meshes[] = {cube.piece(0), cube.piece(1, {0.2f, 0.4f, 1.0f})};
    const std::vector<PieceHandle> handles = add(f, meshes);
    Scene scene = empty_stage();
    scene.look.sun = glm::vec3(0.0f); // without shadows, pixels are independent of each other
    scene.write_poses = [](std::span<BodyPose> poses, uint64_t) { poses[1].position = {0.3f, 0.1f, -1.2f}; };
    for (const bool smooth : {false, true}) {
        scene.smooth = smooth;
        REQUIRE(f.renderer->fade_pieces(handles, 0.0f));
        const Bitmap with = f.draw(scene);
        REQUIRE(f.renderer->fade_pieces(std::span(handles).first(1), 1.0f));
        const Bitmap without = f.draw(scene);
        REQUIRE(f.renderer->fade_pieces(std::span(handles).first(1), 0.4f));
        const Bitmap faded = f.draw(scene);
        const IdImage ids = ids_of(f, scene);
        for (uint32_t y = 0; y < small.y; ++y)
            for (uint32_t x = 0; x < small.x; ++x) {
                const bool left = ids.at(x, y) == handles[0].number;
                REQUIRE(pixel(faded, x, y) == pixel(left ? with : without, x, y));
            }
    }
}

TEST_CASE("the shadow of a piece fades with it") {
    const Fixture f;
    if (!f) return;
    const Shape cube = box(glm::vec3(0.5f));
    const PieceMesh piece = cube.piece(0);
    const std::vector<PieceHandle> handles = add(f, {&piece, 1});
    // The camera looks down on the ground where the shadow falls; the piece is outside the picture.
    Scene scene{.camera = {{3.0f, 3.0f, 0.001f}, {3.0f, 0.0f, 0.0f}, 0.3f},
                .bounds = {{-0.5f, 2.5f, -0.5f}, {0.5f, 3.5f, 0.5f}}};
    scene.write_poses = [](std::span<BodyPose> poses, uint64_t) { poses[0].position = {0.0f, 3.0f, 0.0f}; };
    scene.look.to_light = {-1.0f, 1.0f, 0.0f};
    const auto brightness = [&](float fade) {
        REQUIRE(f.renderer->fade_pieces(handles, fade));
        scene.moved = false; // a change of fade invalidates the shadow map by itself
        const Bitmap image = f.draw(scene);
        CHECK(f.renderer->stats().shadow_drawn);
        double sum = 0.0;
        for (const uint8_t byte : image.pixels) sum += byte;
        return sum;
    };
    const double dark = brightness(0.0f), light = brightness(1.0f);
    CHECK(dark < 0.9 * light);
    CHECK(brightness(0.5f) == doctest::Approx(0.5 * (dark + light)).epsilon(0.02));
    (void)f.draw(scene);
    CHECK_FALSE(f.renderer->stats().shadow_drawn);
}

TEST_CASE("front-to-back order keeps the draws and sorts them by distance, fading pieces last") {
    const std::unique_ptr<Device> device = make_device();
    if (!device) return;
    PieceArena arena(*device);
    std::mt19937 random(2);
    std::vector<PieceMesh> meshes;
    std::vector<Made> made;
    for (uint32_t i = 0; i < 60; ++i) made.emplace_back(i);
    for (const Made& one : made) meshes.push_back(one.mesh());
    const auto handles = arena.add({*PieceBatch::create(meshes)});
    REQUIRE(handles);
    REQUIRE(arena.fade(std::span(*handles).subspan(20, 10), 0.5f));
    REQUIRE(arena.fade(std::span(*handles).subspan(40, 5), 1.0f));
    std::vector<BodyPose> poses(60);
    for (BodyPose& pose : poses) {
        pose.position = {static_cast<float>(random() % 64) / 8.0f, static_cast<float>(random() % 64) / 8.0f, 0.5f};
        pose.rotation = glm::angleAxis(static_cast<float>(random() % 6), glm::vec3(0.0f, 0.6f, 0.8f));
        pose.scale = static_cast<float>(random() % 3);
    }
    poses[3].position.x = poses[23].position.y = std::numeric_limits<float>::quiet_NaN();
    poses[5] = poses[6]; // their distances still differ, because each piece is offset in its body
    const glm::vec3 eye(1.0f, 2.0f, -3.0f);

    struct Lists {
        std::vector<brittle::engine::shared::DrawData> data;
        std::vector<VkDrawIndexedIndirectCommand> commands;
        explicit Lists(size_t size) : data(size), commands(size) {}
        operator PieceArena::DrawLists() { return {data, commands}; }
    };
    Lists plain(arena.draws()), sorted(arena.draws());
    arena.write_draws(plain);
    arena.write_draws(sorted, poses, eye);

    const auto distance = [&](const brittle::engine::shared::DrawData& draw) {
        const BodyPose& pose = poses[draw.body];
        const float d =
            glm::length(pose.position + glm::mat3_cast(pose.rotation) * glm::vec3(draw.sphere) * pose.scale - eye);
        return std::isnan(d) ? std::numeric_limits<float>::infinity() : d;
    };
    const auto contents = [](const Lists& lists, size_t i) {
        const auto& command = lists.commands[i];
        return std::tuple(lists.data[i].id, lists.data[i].material, lists.data[i].tint, lists.data[i].body,
                          command.indexCount, command.firstIndex, command.vertexOffset, command.instanceCount);
    };
    std::vector<decltype(contents(plain, 0))> is, should;
    for (size_t i = 0; i < arena.draws(); ++i) {
        is.push_back(contents(sorted, i));
        should.push_back(contents(plain, i));
        CHECK(sorted.commands[i].firstInstance == i);
        CHECK((sorted.data[i].tint >> 24 == 255) == (i < arena.solid_draws()));
        if (i == 0 || i == arena.solid_draws()) continue;
        CHECK(distance(sorted.data[i - 1]) <= distance(sorted.data[i]) + 1e-5f);
        const bool same = sorted.data[i - 1].id == sorted.data[i].id;
        if (same) CHECK(sorted.data[i - 1].material < sorted.data[i].material); // consecutive ranges of one piece
    }
    CHECK(is != should);
    std::ranges::sort(is);
    std::ranges::sort(should);
    CHECK(is == should);
}

// A surface in two parts. Each has vertices of its own, and the triangles of the other around it.
struct Halves {
    struct Half {
        std::vector<glm::vec3> positions;
        std::vector<glm::uvec3> triangles, neighbours;
    };
    std::array<Half, 2> halves;

    Halves(const Shape& shape, const glm::vec3& origin) {
        for (size_t k = 0; k < 2; ++k) {
            Half& half = halves[k];
            std::map<uint32_t, uint32_t> index;
            const auto add = [&](const glm::uvec3& t, std::vector<glm::uvec3>& to) {
                glm::uvec3 corners;
                for (int c = 0; c < 3; ++c) {
                    const auto [at, is_new] = index.emplace(t[c], static_cast<uint32_t>(half.positions.size()));
                    if (is_new) half.positions.push_back(shape.positions[t[c]] - origin);
                    corners[c] = at->second;
                }
                to.push_back(corners);
            };
            const size_t middle = shape.triangles.size() / 2;
            for (size_t t = 0; t < shape.triangles.size(); ++t)
                if ((t < middle) == (k == 0)) add(shape.triangles[t], half.triangles);
            for (size_t t = 0; t < shape.triangles.size(); ++t)
                if ((t < middle) != (k == 0)) add(shape.triangles[t], half.neighbours);
        }
    }
    [[nodiscard]] PieceBatch batch(const PieceAttachment& attachment) const {
        std::vector<PieceMesh> meshes;
        for (const Half& half : halves)
            meshes.push_back({.positions = half.positions,
                              .triangles = half.triangles,
                              .exterior_triangles = static_cast<uint32_t>(half.triangles.size()),
                              .neighbours = half.neighbours});
        Result<PieceBatch> batch = PieceBatch::create(meshes);
        REQUIRE(batch);
        batch->attach(attachment);
        return *std::move(batch);
    }
};

int largest_difference(const Bitmap& a, const Bitmap& b) {
    REQUIRE(a.pixels.size() == b.pixels.size());
    int largest = 0;
    for (size_t i = 0; i < a.pixels.size(); ++i) largest = std::max(largest, std::abs(a.pixels[i] - b.pixels[i]));
    return largest;
}

TEST_CASE("a piece in parts, whose positions have another origin, is drawn like the whole, with one id") {
    const Fixture f;
    if (!f) return;
    const glm::vec3 origin(0.5f, -0.25f, 0.125f);
    for (const Shape& shape : {icosphere(0.5f, 2), box({0.5f, 0.25f, 0.375f}, 3)}) {
        Shape exact = shape; // sums with the origin are exact
        for (glm::vec3& p : exact.positions) p = glm::round(p * 1024.0f) / 1024.0f;
        const Halves halves(exact, origin);
        PieceMesh whole = exact.piece(1, piece_tint(3));
        whole.exterior_triangles = static_cast<uint32_t>(exact.triangles.size());
        const PieceAttachment attachment{.body = 1, .tint = piece_tint(3), .offset = origin, .id = 7};
        Scene scene = empty_stage();
        const std::array poses{
            BodyPose{},
            BodyPose{glm::angleAxis(0.7f, glm::normalize(glm::vec3(1.0f, 2.0f, 0.5f))), {0.2f, -0.1f, 0.3f}},
            BodyPose{glm::angleAxis(-0.4f, glm::vec3(0.0f, 1.0f, 0.0f)), {-0.3f, 0.2f, 0.0f}, 0.5f}};
        scene.write_poses = [&](std::span<BodyPose> out, uint64_t) {
            std::copy_n(poses.begin(), out.size(), out.begin());
        };
        for (const bool smooth : {false, true}) {
            scene.smooth = smooth;
            const int tolerance = smooth ? 1 : 0; // normals are sums in another order
            REQUIRE(f.renderer->set_pieces({&whole, 1}));
            const Bitmap expected = f.draw(scene);
            const IdImage shape_ids = ids_of(f, scene);
            REQUIRE(f.renderer->set_pieces({}));
            const auto handles = f.renderer->add_pieces(halves.batch(attachment));
            REQUIRE(handles);
            REQUIRE(handles->size() == 2);
            CHECK(largest_difference(f.draw(scene), expected) <= tolerance);
            CHECK(f.renderer->stats().pieces_in_view == 2);
            const IdImage ids = ids_of(f, scene);
            for (size_t i = 0; i < ids.ids.size(); ++i) REQUIRE(ids.ids[i] == (shape_ids.ids[i] != 0 ? 7 : 0));

            // Attached to another body, they are drawn as if they had been added there.
            PieceMesh other = whole;
            other.body = 2;
            other.tint = piece_tint(5);
            REQUIRE(f.renderer->attach_pieces(*handles, {.body = 2, .tint = piece_tint(5), .offset = origin}));
            const Bitmap moved = f.draw(scene);
            REQUIRE(f.renderer->set_pieces({&other, 1}));
            CHECK(largest_difference(f.draw(scene), moved) <= tolerance);
            CHECK_FALSE(f.renderer->attach_pieces(*handles, attachment)); // they are gone
        }
    }
}

TEST_CASE("pieces are attached to bodies that exist, and neighbours name vertices that exist") {
    const Fixture f;
    if (!f) return;
    const Shape cube = box(glm::vec3(0.5f));
    const PieceMesh piece = cube.piece(0);
    const auto handles = f.renderer->set_pieces({&piece, 1});
    REQUIRE(handles);
    CHECK_FALSE(f.renderer->attach_pieces(*handles, {.body = std::numeric_limits<uint32_t>::max()}));
    CHECK(f.renderer->body_count() == 1);
    REQUIRE(f.renderer->attach_pieces(*handles, {.body = 4}));
    CHECK(f.renderer->body_count() == 5);
    const glm::uvec3 wrong(0, 1, static_cast<uint32_t>(cube.positions.size()));
    PieceMesh bad = piece;
    bad.neighbours = {&wrong, 1};
    const Result<PieceBatch> batch = PieceBatch::create({&bad, 1});
    REQUIRE_FALSE(batch);
    CHECK(batch.error().message.find("neighbour 0") != std::string::npos);
}

TEST_CASE("a piece with a surface of its own looks as if the scene had that look, and others stay as they are") {
    const Fixture f;
    if (!f) return;
    const Shape ball = icosphere(0.8f, 2);
    const PieceMesh left{.positions = ball.positions,
                         .triangles = ball.triangles,
                         .exterior_triangles = static_cast<uint32_t>(ball.triangles.size() / 2)};
    const auto handles = f.renderer->set_pieces({&left, 1});
    REQUIRE(handles);
    Scene scene = empty_stage();
    const Bitmap plain = f.draw(scene);
    const SurfaceLook glass{.exterior = {0.1f, 0.5f, 0.4f}, .interior = {0.0f, 0.2f, 0.9f}, .tint = 0.25f};
    Scene of_glass = scene;
    of_glass.look.exterior = glass.exterior;
    of_glass.look.interior = glass.interior;
    of_glass.look.tint = glass.tint;
    const Bitmap expected = f.draw(of_glass);
    REQUIRE(expected.pixels != plain.pixels);
    const SurfaceLook surfaces[] = {{}, glass};
    scene.surfaces = surfaces;
    CHECK(f.draw(scene).pixels == plain.pixels);
    for (const bool smooth : {false, true}) {
        scene.smooth = of_glass.smooth = smooth;
        REQUIRE(f.renderer->attach_pieces(*handles, {.surface = 2}));
        CHECK(f.draw(scene).pixels == f.draw(of_glass).pixels);
        REQUIRE(f.renderer->attach_pieces(*handles, {.surface = 3})); // beyond the last: the look of the scene
        const Bitmap beyond = f.draw(scene);
        REQUIRE(f.renderer->attach_pieces(*handles, {}));
        CHECK(f.draw(scene).pixels == beyond.pixels);
    }
}

TEST_CASE("the draw order changes no picture") {
    Quality quality = plain_quality;
    quality.front_to_back = false;
    const Fixture as_added(quality);
    quality.front_to_back = true;
    const Fixture sorted(quality);
    if (!sorted) return;
    KnownScene known;
    REQUIRE(as_added.renderer->set_pieces(known.pieces()));
    REQUIRE(sorted.renderer->set_pieces(known.pieces()));
    for (int step = 0; step < 12; ++step) {
        known.scene.camera = look_at_bounds(known.scene.bounds, 0.55f * static_cast<float>(step), 0.3f, 1.5f);
        known.poses[0].position.y += 0.03f;
        CHECK(sorted.draw(known.scene).pixels == as_added.draw(known.scene).pixels);
    }
}
