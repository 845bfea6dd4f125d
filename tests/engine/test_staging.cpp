// Batches that a worker copies to mapped memory. The oracle is an equal batch that the frame copies.
#include <algorithm>
#include <thread>

#include "engine/render/piece_arena.h"
#include "engine/render/staging_pool.h"
#include "renderer_fixture.h"

using namespace brittle::engine;
using namespace brittle::engine::test;

namespace {

constexpr uint64_t large = 64 << 10; // minimum size of a batch that stage() moves, bytes

// Balls in a row, each large enough to be staged.
struct Row {
    Shape ball = icosphere(0.3f, 4);
    std::vector<CornerLook> corners = corners_of(ball); // so that every arena holds something

    [[nodiscard]] PieceMesh mesh(uint32_t body) const {
        PieceMesh mesh = ball.piece(body, piece_tint(body));
        mesh.corners = corners;
        return mesh;
    }
    [[nodiscard]] static std::vector<CornerLook> corners_of(const Shape& shape) {
        std::vector<CornerLook> made;
        for (uint32_t t = 0; t < shape.exterior_triangles; ++t)
            for (int k = 0; k < 3; ++k) made.push_back({.uv = glm::vec2(shape.positions[shape.triangles[t][k]])});
        return made;
    }
    [[nodiscard]] PieceBatch batch(uint32_t body) const {
        const PieceMesh one = mesh(body);
        return *PieceBatch::create({&one, 1});
    }
    [[nodiscard]] static Scene scene() {
        Scene scene = empty_stage();
        scene.write_poses = [](std::span<BodyPose> poses, uint64_t) {
            for (size_t i = 0; i < poses.size(); ++i) poses[i].position.x = 0.45f * static_cast<float>(i) - 0.9f;
        };
        return scene;
    }
};

Bitmap picture_of(const Fixture& f, std::span<const PieceMesh> meshes) {
    REQUIRE(f.renderer->set_pieces(meshes));
    Bitmap picture = f.draw(Row::scene());
    REQUIRE(f.renderer->set_pieces({}));
    return picture;
}

std::vector<uint8_t> bytes_of(const PieceBatch& batch) {
    std::vector<uint8_t> all;
    const auto append = [&](std::span<const std::byte> bytes) {
        for (const std::byte byte : bytes) all.push_back(static_cast<uint8_t>(byte));
    };
    append(std::as_bytes(batch.positions()));
    append(std::as_bytes(batch.normals()));
    append(std::as_bytes(batch.indices()));
    append(std::as_bytes(batch.corners()));
    return all;
}

} // namespace

TEST_CASE("stage() moves a large batch to mapped memory and leaves a small one unchanged") {
    const Fixture f;
    if (!f) return;
    const Row row;
    PieceBatch batch = row.batch(0);
    REQUIRE(batch.bytes() > large);
    const std::vector<uint8_t> before = bytes_of(batch);
    CHECK(before.size() == batch.bytes());
    f.renderer->stage(batch);
    REQUIRE(batch.staged());
    CHECK(bytes_of(batch) == before);
    const std::span<const uint8_t> staged = batch.staged()->mapped_as<uint8_t>(0, before.size());
    CHECK(std::ranges::equal(staged, before));
    const DeviceBuffer* buffer = batch.staged().get();
    f.renderer->stage(batch);
    CHECK(batch.staged().get() == buffer);

    const Shape cube = box(glm::vec3(0.2f));
    const PieceMesh few = cube.piece(0);
    PieceBatch small_one = *PieceBatch::create({&few, 1}), none;
    f.renderer->stage(small_one);
    f.renderer->stage(none);
    CHECK_FALSE(small_one.staged());
    CHECK_FALSE(none.staged());
}

TEST_CASE("staged batches are drawn like their meshes, alone and among others") {
    const Fixture f;
    if (!f) return;
    const Row row;
    const Shape cube = box({0.2f, 0.3f, 0.25f}, 2);
    const std::vector<PieceMesh> meshes{row.mesh(0), cube.piece(1, piece_tint(7)), row.mesh(2), row.mesh(3),
                                        cube.piece(4)};
    const Bitmap expected = picture_of(f, meshes);
    for (const uint32_t stage : {0b11111u, 0b00100u, 0b01001u, 0b00000u}) { // one bit for each batch
        std::vector<PieceBatch> batches;
        for (size_t i = 0; i < 2; ++i) batches.push_back(*PieceBatch::create({&meshes[i], 1}));
        batches.push_back(*PieceBatch::create(std::span(meshes).subspan(2, 2))); // two pieces in one buffer
        batches.push_back(*PieceBatch::create({&meshes[4], 1}));
        for (size_t i = 0; i < batches.size(); ++i)
            if (stage >> i & 1) f.renderer->stage(batches[i]);
        CHECK(static_cast<bool>(batches[2].staged()) == (stage >> 2 & 1));
        const auto handles = f.renderer->add_pieces(std::move(batches));
        REQUIRE(handles);
        CHECK(handles->size() == 5);
        CHECK(std::ranges::is_sorted(*handles));
        CAPTURE(stage);
        CHECK(f.draw(Row::scene()).pixels == expected.pixels);
        // The pieces are moved into larger arenas and drawn in another order.
        REQUIRE(f.renderer->remove_pieces({&handles->front(), 1}));
        PieceBatch again = row.batch(0);
        f.renderer->stage(again);
        REQUIRE(f.renderer->add_pieces(std::move(again)));
        CHECK(f.draw(Row::scene()).pixels == expected.pixels);
        REQUIRE(f.renderer->set_pieces({}));
    }
}

TEST_CASE("copies of a staged batch share its buffer, with bodies and tints of their own") {
    const Fixture f;
    if (!f) return;
    const Row row;
    const std::vector<PieceMesh> meshes{row.mesh(0), row.mesh(1), row.mesh(2)};
    const Bitmap expected = picture_of(f, meshes);
    PieceBatch other = row.batch(9);
    f.renderer->stage(other);
    std::vector<PieceBatch> batches{other, row.batch(8), other};
    for (uint32_t i = 0; i < 3; ++i) batches[i].attach({.body = i, .tint = piece_tint(i)});
    CHECK(batches[0].staged() == batches[2].staged());
    REQUIRE(f.renderer->add_pieces(std::move(batches)));
    CHECK(f.draw(Row::scene()).pixels == expected.pixels);
    other.attach({.body = 3, .tint = piece_tint(3)}); // its buffer was read by a frame, and may be read again
    REQUIRE(f.renderer->add_pieces(std::move(other)));
    const PieceMesh four[] = {meshes[0], meshes[1], meshes[2], row.mesh(3)};
    const Bitmap all = f.draw(Row::scene());
    CHECK(all.pixels == picture_of(f, four).pixels);
}

TEST_CASE("batches are added all or none, and the error counts pieces over all batches") {
    const Fixture f;
    if (!f) return;
    const Row row;
    std::vector<PieceBatch> batches{row.batch(0), PieceBatch{}, row.batch(1), row.batch(UINT32_MAX)};
    const auto added = f.renderer->add_pieces(std::move(batches));
    REQUIRE_FALSE(added);
    CHECK(added.error().message.find("piece 2: ") != std::string::npos);
    CHECK(f.renderer->body_count() == 0);
    CHECK(f.renderer->add_pieces(std::vector<PieceBatch>{}));
}

TEST_CASE("the frame that uploads staged pieces allocates no memory for them") {
    const Fixture f, fresh;
    if (!f) return;
    const Row row;
    const Shape other = icosphere(0.2f, 4);
    const std::vector<CornerLook> corners = Row::corners_of(other);
    PieceMesh before = other.piece(0);
    before.corners = corners;
    const PieceMesh after = row.mesh(0);
    for (int frame = 0; frame < 3; ++frame) { // allocates the arenas and the buffers of the frame slots
        REQUIRE(f.renderer->set_pieces({&before, 1}));
        (void)f.draw(Row::scene());
    }
    PieceBatch batch = row.batch(0);
    f.renderer->stage(batch);
    REQUIRE(f.renderer->set_pieces({}));
    const uint32_t allocations = f.faults.count(Call::allocate), maps = f.faults.count(Call::map);
    REQUIRE(f.renderer->add_pieces(std::move(batch)));
    CHECK(f.draw(Row::scene()).pixels == picture_of(fresh, {&after, 1}).pixels);
    CHECK(f.faults.count(Call::allocate) == allocations);
    CHECK(f.faults.count(Call::map) == maps);
}

TEST_CASE("without memory for staging, the frame copies the batch") {
    Fixture f;
    if (!f) return;
    const Row row;
    const PieceMesh mesh = row.mesh(1);
    const Bitmap expected = picture_of(f, {&mesh, 1});
    for (const Call kind : {Call::allocate, Call::map}) {
        PieceBatch batch = row.batch(1);
        f.faults.fail(kind, VK_ERROR_OUT_OF_DEVICE_MEMORY);
        f.renderer->stage(batch);
        f.faults.fail(kind, VK_SUCCESS);
        CHECK_FALSE(batch.staged());
        const auto handles = f.renderer->add_pieces(batch);
        REQUIRE(handles);
        CHECK(f.draw(Row::scene()).pixels == expected.pixels);
        REQUIRE(f.renderer->remove_pieces(*handles));
        f.renderer->stage(batch); // memory is available again
        CHECK(batch.staged());
        const auto staged = f.renderer->add_pieces(std::move(batch));
        REQUIRE(staged);
        CHECK(f.draw(Row::scene()).pixels == expected.pixels);
        REQUIRE(f.renderer->remove_pieces(*staged));
    }
}

TEST_CASE("staged pieces whose frame fails are uploaded by the next one") {
    Fixture f;
    if (!f) return;
    const Row row;
    const PieceMesh meshes[] = {row.mesh(0), row.mesh(1)};
    const Bitmap expected = picture_of(f, meshes);
    for (uint32_t body = 0; body < 2; ++body) {
        PieceBatch batch = row.batch(body);
        f.renderer->stage(batch);
        REQUIRE(f.renderer->add_pieces(std::move(batch)));
        f.faults.fail(Call::submit, VK_ERROR_OUT_OF_DEVICE_MEMORY);
        CHECK_FALSE(f.renderer->render(Row::scene(), small));
    }
    CHECK(f.draw(Row::scene()).pixels == expected.pixels);
}

TEST_CASE("a staged batch that was never drawn may be destroyed at any time before the device") {
    Fixture f;
    if (!f) return;
    const Row row;
    PieceBatch kept = row.batch(0), gone = row.batch(1);
    f.renderer->stage(kept);
    f.renderer->stage(gone);
    const auto handles = f.renderer->add_pieces(std::move(gone));
    REQUIRE(handles);
    REQUIRE(f.renderer->remove_pieces(*handles)); // before any frame
    (void)f.draw(Row::scene());
    f.renderer.reset();
    CHECK(kept.staged()); // destroyed before the fixture's device
}

TEST_CASE("threads stage pieces while the renderer draws") {
    const Fixture f;
    if (!f) return;
    const Row row;
    std::vector<Bitmap> expected;
    for (uint32_t body = 0; body < 4; ++body) {
        const PieceMesh mesh = row.mesh(body);
        expected.push_back(picture_of(f, {&mesh, 1}));
    }
    std::vector<PieceBatch> ready(4);
    for (uint32_t round = 0; round < 12; ++round) {
        std::vector<PieceBatch> next(4);
        std::vector<std::thread> workers;
        for (uint32_t body = 0; body < 4; ++body)
            workers.emplace_back([&, body] {
                next[body] = row.batch(body);
                f.renderer->stage(next[body]);
            });
        for (uint32_t body = 0; body < 4 && round > 0; ++body) {
            const auto handles = f.renderer->add_pieces(std::move(ready[body]));
            REQUIRE(handles);
            REQUIRE(handles->size() == 1);
            CHECK(f.draw(Row::scene()).pixels == expected[body].pixels);
            REQUIRE(f.renderer->remove_pieces(*handles));
        }
        for (std::thread& worker : workers) worker.join();
        for (const PieceBatch& batch : next) CHECK(batch.staged());
        ready = std::move(next);
    }
}

TEST_CASE("a staging buffer is reused only after the copies from it have finished") {
    const std::unique_ptr<Device> device = make_device();
    if (!device) return;
    const Row row;
    StagingPool pool(*device);
    PieceArena arena(*device);
    std::vector<PieceBatch> batches;
    for (uint32_t body = 0; body < 2; ++body) {
        batches.push_back(row.batch(body));
        batches.back().move_to(pool.take(batches.back().bytes()));
    }
    const std::vector<PieceBatch> oracle = batches;
    REQUIRE(arena.add(batches));
    batches.clear();
    const PieceUpload upload = arena.next_upload();
    CHECK(upload.staging_size == 0);
    REQUIRE(upload.staged.size() == 2);
    for (size_t k = 0; k < 2; ++k) {
        CHECK(upload.staged[k].buffer == oracle[k].staged());
        const uint64_t sizes[] = {oracle[k].positions().size_bytes(), oracle[k].normals().size_bytes(),
                                  oracle[k].indices().size_bytes(), oracle[k].corners().size_bytes()};
        uint64_t from = 0;
        for (size_t i = 0; i < piece_arenas; ++i) {
            REQUIRE(upload.staged[k].copies[i].size() == 1);
            const VkBufferCopy& copy = upload.staged[k].copies[i][0];
            CHECK(copy.srcOffset == from);
            CHECK(copy.dstOffset == k * sizes[i]);
            CHECK(copy.size == sizes[i]);
            from += sizes[i];
        }
    }
    std::vector<std::shared_ptr<const DeviceBuffer>> retired;
    arena.uploaded(retired);
    CHECK(arena.next_upload().empty());
    CHECK(retired.size() == 2);
    for (size_t k = 0; k < retired.size(); ++k) CHECK(retired[k] == oracle[k].staged());
}

TEST_CASE("staging pool: idle buffers are reused where they fit, and their total is limited") {
    FaultInjector faults;
    const std::unique_ptr<Device> device = make_device(&faults);
    if (!device) return;
    StagingPool pool(*device);
    std::shared_ptr<DeviceBuffer> first = pool.take(1 << 20), second = pool.take(1 << 20);
    CHECK(first->size() >= 1 << 20);
    CHECK(first->mapped() != nullptr);
    CHECK(first->handle() != second->handle());
    const VkBuffer handle = first->handle();
    CHECK(pool.idle_bytes() == 0);
    first.reset();
    CHECK(pool.idle_bytes() >= 1 << 20);
    const std::shared_ptr<DeviceBuffer> small_one = pool.take(1 << 16); // must not get the large buffer
    CHECK(small_one->handle() != handle);
    const std::shared_ptr<DeviceBuffer> larger = pool.take(3 << 20);
    CHECK(larger->size() >= 3 << 20);
    first = pool.take(1000 << 10); // a little less than before
    CHECK(first->handle() == handle);
    CHECK(pool.idle_bytes() == 0);

    faults.fail(Call::allocate, VK_ERROR_OUT_OF_DEVICE_MEMORY);
    CHECK_THROWS((void)pool.take(5 << 20));
    CHECK(pool.idle_bytes() == 0);
    CHECK(pool.take(5 << 20)->size() >= 5 << 20);
    CHECK(pool.idle_bytes() >= 5 << 20);

    std::vector<std::shared_ptr<DeviceBuffer>> many;
    for (int i = 0; i < 12; ++i) many.push_back(pool.take(8 << 20));
    many.clear();
    CHECK(pool.idle_bytes() > StagingPool::max_idle);
    second = pool.take(1 << 10); // take() frees the surplus
    CHECK(pool.idle_bytes() <= StagingPool::max_idle);
    CHECK(pool.idle_bytes() > StagingPool::max_idle / 2);
    CHECK(device->validation_messages().empty());
}
