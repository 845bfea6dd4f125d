// Scene::write_poses and Scene::moment: a caller writes only the poses that changed since a frame slot was last
// written.
#include <algorithm>
#include <random>
#include <stdexcept>

#include "renderer_fixture.h"

using namespace brittle::engine;
using namespace brittle::engine::test;

namespace {

// Bodies in a row, and the moment at which each last moved.
struct Row {
    Shape cube = box(glm::vec3(0.12f));
    std::vector<BodyPose> poses;
    std::vector<uint64_t> changed;
    uint64_t moment = 0;
    uint64_t since = 0; // argument of the newest call
    size_t written = 0;

    explicit Row(size_t count) : poses(count), changed(count) {
        ++moment;
        for (size_t i = 0; i < count; ++i) {
            poses[i].position.x = 0.3f * static_cast<float>(i) - 1.0f;
            changed[i] = moment;
        }
    }
    void move(size_t body, float y) {
        poses[body].position.y = y;
        changed[body] = ++moment;
    }
    std::vector<PieceMesh> pieces() const {
        std::vector<PieceMesh> all;
        for (uint32_t i = 0; i < poses.size(); ++i) all.push_back(cube.piece(i, piece_tint(i)));
        return all;
    }
    Scene scene() {
        Scene made = empty_stage();
        made.moment = moment;
        made.write_poses = [this](std::span<BodyPose> out, uint64_t from) {
            since = from;
            written = 0;
            for (size_t i = 0; i < std::min(out.size(), poses.size()); ++i) {
                if (from != 0 && changed[i] <= from) continue;
                out[i] = poses[i];
                ++written;
            }
        };
        return made;
    }
};

} // namespace

TEST_CASE("poses: without a moment, all are written in each frame") {
    const Fixture f;
    if (!f) return;
    Row row(3);
    REQUIRE(f.renderer->set_pieces(row.pieces()));
    for (int frame = 0; frame < 5; ++frame) {
        Scene scene = row.scene();
        scene.moment = 0;
        (void)f.draw(scene);
        CHECK(row.since == 0);
        CHECK(row.written == 3);
    }
}

TEST_CASE("poses: a resting body is written once for each frame in flight, a moving one in each frame") {
    const Fixture f;
    if (!f) return;
    Row row(6);
    REQUIRE(f.renderer->set_pieces(row.pieces()));
    for (const size_t written : {6, 6, 0, 0, 0}) { // two frames are in flight
        (void)f.draw(row.scene());
        CHECK(row.written == written);
    }
    row.move(2, 0.5f);
    const uint64_t first = row.moment;
    for (const size_t written : {1, 1, 0, 0}) {
        (void)f.draw(row.scene());
        CHECK(row.written == written);
        CHECK(row.since <= first);
    }
}

TEST_CASE("poses: partial writes give the pictures of complete writes") {
    const Fixture parts, whole;
    if (!parts) return;
    std::mt19937 random(5);
    Row row(7);
    std::vector<PieceMesh> pieces = row.pieces();
    REQUIRE(parts.renderer->set_pieces(pieces));
    REQUIRE(whole.renderer->set_pieces(pieces));
    size_t spared = 0;
    for (int frame = 0; frame < 80; ++frame) {
        for (uint32_t n = random() % 3; n > 0; --n)
            row.move(random() % row.poses.size(), static_cast<float>(random() % 100) * 0.01f - 0.5f);
        // Sometimes an event that invalidates the poses: another caller, other pieces, an earlier moment.
        const uint32_t event = random() % 12;
        if (event == 0) (void)parts.draw(empty_stage());
        if (event == 1) REQUIRE(parts.renderer->warm_up());
        if (event == 2) (void)parts.renderer->render_ids(row.scene(), small);
        if (event == 3) REQUIRE(parts.renderer->set_pieces(pieces));
        CAPTURE(frame);
        Scene scene = row.scene();
        const Bitmap is = parts.draw(scene);
        spared += row.poses.size() - row.written;
        scene.moment = 0;
        REQUIRE(is.pixels == whole.draw(scene).pixels);
    }
    CHECK(spared > 100);
}

TEST_CASE("poses: a new body or an earlier moment makes the renderer request all poses") {
    const Fixture f;
    if (!f) return;
    Row row(4);
    const std::vector<PieceMesh> pieces = row.pieces();
    const auto set = f.renderer->set_pieces(std::span(pieces).first(2));
    REQUIRE(set);
    for (int frame = 0; frame < 3; ++frame) (void)f.draw(row.scene());
    CHECK(row.since == row.moment);
    REQUIRE(f.renderer->add_pieces(std::span(pieces).last(2)));
    for (int frame = 0; frame < 2; ++frame) {
        (void)f.draw(row.scene());
        CHECK(row.since == 0);
        CHECK(row.written == 4);
    }
    (void)f.draw(row.scene());
    CHECK(row.since == row.moment);
    REQUIRE(f.renderer->remove_pieces(*set));
    (void)f.draw(row.scene());
    CHECK(row.since == row.moment);
    Scene earlier = row.scene();
    --earlier.moment;
    (void)f.draw(earlier);
    CHECK(row.since == 0);
}

TEST_CASE("poses: after an exception in the callback, all are requested again") {
    const Fixture f;
    if (!f) return;
    Row row(3);
    REQUIRE(f.renderer->set_pieces(row.pieces()));
    const Bitmap expected = f.draw(row.scene());
    (void)f.draw(row.scene());
    for (int frame = 0; frame < 2; ++frame) {
        Scene scene = row.scene();
        scene.write_poses = [](std::span<BodyPose> poses, uint64_t) {
            poses[1].position.y = 5.0f;
            throw std::bad_alloc();
        };
        CHECK_FALSE(f.renderer->render(scene, small));
    }
    for (int frame = 0; frame < 2; ++frame) {
        CHECK(f.draw(row.scene()).pixels == expected.pixels);
        CHECK(row.since == 0);
    }
}
