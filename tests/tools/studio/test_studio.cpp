// The studio without its window: files, keys, pixels, workers. test_document.cpp tests edits.
#include <atomic>
#include <chrono>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <set>
#include <string>
#include <thread>

#include <doctest/doctest.h>
#include <glm/geometric.hpp>

#include "engine/camera/view_volume.h"
#include "fracture/pieces/certificate.h"
#include "tests/engine/support.h"
#include "tests/tools/support.h"
#include "tools/brittle/base/device_failure.h"
#include "tools/brittle/stage/stage.h"
#include "tools/brittle/studio/frame_times.h"
#include "tools/brittle/studio/idleness.h"
#include "tools/brittle/studio/keys.h"
#include "tools/brittle/studio/material_menu.h"
#include "tools/brittle/studio/navigation.h"
#include "tools/brittle/studio/object.h"
#include "tools/brittle/studio/preview.h"
#include "tools/brittle/studio/recent.h"
#include "tools/brittle/studio/viewport.h"
#include "tools/brittle/studio/worker.h"
#include "tools/scenario/base/failure.h"

using namespace brittle;
using namespace brittle::tools;
using namespace brittle::tools::test;
namespace fs = std::filesystem;

namespace {

FractureOptions options_of(const std::string& mesh) {
    FractureOptions options;
    options.mesh = mesh;
    return options;
}

engine::Camera camera() {
    return {.eye = {1.0f, 2.0f, 5.0f}, .target = {0.2f, 0.7f, -0.3f}, .vertical_fov = 0.7f};
}

template<class Condition>
bool soon(const Condition& condition) {
    for (int k = 0; k < 3000 && !condition(); ++k) std::this_thread::sleep_for(std::chrono::milliseconds(10));
    return condition();
}

} // namespace

TEST_CASE("studio: each key has one meaning and a line in the help") {
    std::set<std::pair<int, int>> seen;
    for (const KeyBinding& binding : key_bindings()) {
        const int modifiers = binding.modifiers.shift + 2 * binding.modifiers.control + 4 * binding.modifiers.alt;
        CHECK(seen.insert({static_cast<int>(binding.key), modifiers}).second);
        CHECK(command_for(binding.key, binding.modifiers) == binding.action);
        const bool named = *binding.shown != '\0';
        CHECK(named == (*binding.what != '\0'));
    }
    CHECK_FALSE(command_for(static_cast<engine::Key>('S'), {.alt = true}));
    CHECK(command_for(static_cast<engine::Key>('S'), {})
          != command_for(static_cast<engine::Key>('S'), {.control = true}));
}

TEST_CASE("studio: the ray through the pixel of a point passes through the point, with and without a shift") {
    for (const glm::vec2 shift : {glm::vec2(0.0f), glm::vec2(0.2f, -0.1f)}) {
        engine::Camera eye = camera();
        eye.shift = shift;
        const Viewport view(eye, {1280.0f, 720.0f}, {}, {1280.0f, 720.0f});
        for (const glm::vec3& p : {glm::vec3(0.0f), glm::vec3(0.5f, 0.2f, 1.0f), glm::vec3(-1.0f, 1.5f, -2.0f)}) {
            const auto pixel = view.pixel(p);
            REQUIRE(pixel);
            const Ray ray = view.ray(*pixel);
            CHECK(glm::length(ray.direction) == doctest::Approx(1.0));
            CHECK(glm::length(glm::cross(glm::dvec3(p) - ray.from, ray.direction)) < 1e-3);
        }
        CHECK_FALSE(view.pixel(eye.eye + (eye.eye - eye.target))); // behind the eye
    }
}

TEST_CASE("studio: the target is in the middle of the part without panels") {
    const glm::vec2 window(1280.0f, 720.0f), low(276.0f, 42.0f), high(1100.0f, 694.0f);
    engine::Camera eye = camera();
    eye.shift = Viewport::shift(window, low, high);
    const Viewport view(eye, window, low, high);
    const auto pixel = view.pixel(eye.target);
    REQUIRE(pixel);
    CHECK(glm::distance(*pixel, 0.5f * (low + high)) < 0.01f);
    CHECK(view.is_free(*pixel));
    CHECK_FALSE(view.is_free({1101.0f, 300.0f}));
    CHECK_FALSE(view.is_free({300.0f, 41.0f}));
}

TEST_CASE("studio: the camera of the free part shows exactly that part") {
    const engine::Camera camera{{1.0f, 2.0f, 5.0f}, {0.2f, 0.1f, 0.0f}};
    const glm::vec2 window(900.0f, 500.0f), low(200.0f, 30.0f), high(650.0f, 460.0f);
    engine::Camera shifted = camera;
    shifted.shift = Viewport::shift(window, low, high);
    const Viewport view(shifted, window, low, high);
    const engine::ViewVolume volume(view.free_camera(), view.free_aspect());
    for (const float depth : {0.5f, 4.0f, 60.0f})
        for (const float x : {-3.0f, 3.0f, 222.0f, 447.0f, 453.0f})
            for (const float y : {-3.0f, 3.0f, 215.0f, 427.0f, 433.0f}) {
                const glm::vec2 pixel = low + glm::vec2(x, y);
                const Ray ray = view.ray(pixel);
                CAPTURE(x);
                CAPTURE(y);
                CHECK(volume.sees(glm::vec3(ray.from) + depth * glm::vec3(ray.direction), 0.0f) == view.is_free(pixel));
            }
}

TEST_CASE("studio: a window of size zero gives rays, too") {
    const Viewport view(camera(), {0.0f, 0.0f}, {}, {});
    CHECK(std::isfinite(view.ray({5.0f, 5.0f}).direction.x));
}

TEST_CASE("studio: zooming keeps the point under the cursor in place") {
    Navigation navigation;
    navigation.frame({}, 1.5f);
    const auto view_of = [&] {
        return Viewport(navigation.camera({0.1f, 0.0f}), {900.0f, 600.0f}, {}, {900.0f, 600.0f});
    };
    const Viewport before = view_of();
    const glm::vec2 cursor(620.0f, 180.0f);
    const Ray ray = before.ray(cursor);
    const glm::dvec3 forward(before.forward());
    const double depth = glm::dot(glm::dvec3(before.camera().target) - ray.from, forward);
    const glm::dvec3 under = ray.from + depth / glm::dot(ray.direction, forward) * ray.direction;
    navigation.zoom(5.0f, before, cursor);
    const auto after = view_of().pixel(glm::vec3(under));
    REQUIRE(after);
    CHECK(glm::distance(*after, cursor) < 0.5f);
    CHECK(glm::distance(view_of().camera().eye, glm::vec3(under))
          < glm::distance(before.camera().eye, glm::vec3(under)));
}

TEST_CASE("studio: the recipe's picture restores the camera") {
    Navigation navigation;
    const engine::Bounds home{{-1.0f, 0.5f, -1.0f}, {1.0f, 2.5f, 1.0f}};
    PictureOptions picture;
    picture.azimuth = -120.0f;
    picture.elevation = 40.0f;
    picture.distance = 1.7f;
    navigation.look_as(picture, home, 1.3f);
    PictureOptions told;
    navigation.tell(told, home, 1.3f);
    CHECK(told.azimuth == doctest::Approx(-120.0f));
    CHECK(told.elevation == doctest::Approx(40.0f));
    CHECK(told.distance == doctest::Approx(1.7f));
    const engine::Camera expected = picture_camera(picture, home, 1.3f);
    CHECK(glm::distance(navigation.camera({}).eye, expected.eye)
          < 0.01f * glm::distance(expected.eye, expected.target));
}

TEST_CASE("studio: opening refuses a mesh that does not bound a solid and a file that is not a mesh") {
    const Folder folder;
    std::ofstream(folder.path / "open.off") << "OFF\n4 2 0\n0 0 0\n1 0 0\n0 1 0\n0 0 1\n3 0 1 2\n3 0 2 3\n";
    std::ofstream(folder.path / "noise.stl") << "this is no mesh";
    for (const char* name : {"open.off", "noise.stl", "missing.obj"}) {
        CAPTURE(name);
        CHECK_THROWS_AS((void)Object::load(options_of((folder.path / name).string())), Failure);
    }
    CHECK_THROWS_AS((void)Object::load(options_of("shape:cheese")), Failure);
}

TEST_CASE("studio: an object's sites equal the command line's, and points convert to the stage and back") {
    FractureOptions options = options_of("shape:torus");
    options.pattern.count = 50;
    options.world.height = 0.75;
    const auto object = Object::load(options);
    const Input placed = placed_on_stage(load_input(options), options.world);
    CHECK(object->mesh().positions == placed.model.mesh.positions);
    CHECK(object->sites(options).sites == placed.sites);
    for (size_t k = 0; k < 10; ++k) {
        const glm::dvec3 in_file = object->file().model.mesh.positions[k * 37];
        CHECK(glm::distance(object->to_stage(in_file), placed.model.mesh.positions[k * 37]) < 1e-12);
        CHECK(glm::distance(object->to_file(object->to_stage(in_file)), in_file) < 1e-12);
    }
    WorldOptions standing;
    standing.anchored = true;
    CHECK(fracture::bounds(object->placed_for(standing)->mesh()).min.y == doctest::Approx(0.0));
}

TEST_CASE("studio: rays find the entry and exit points of the surface") {
    const auto object = Object::load(options_of("shape:cube")); // 2 m, from y = 0.5 to 2.5
    const auto hit = object->first_hit({0.1, 1.0, 9.0}, {0.0, 0.0, -1.0});
    REQUIRE(hit);
    CHECK(hit->distance == doctest::Approx(8.0));
    CHECK(object->exit_after(*hit, {0.0, 0.0, -1.0}).point.z == doctest::Approx(-1.0));
    CHECK_FALSE(object->first_hit({0.1, 1.0, 9.0}, {0.0, 0.0, 1.0}));
    CHECK_FALSE(object->first_hit({0.1, 9.0, 9.0}, {0.0, 0.0, -1.0}));
}

TEST_CASE(
    "studio: a preview shows the pieces of the fracture, cracks on the surface, and the crumbs of an aimed blow") {
    const auto device = engine::test::make_device();
    if (!device) return;
    const auto renderer = must(engine::Renderer::create(*device));
    FractureOptions options = options_of("shape:icosphere");
    options.pattern.count = 30;
    const auto object = Object::load(options);
    const Broken broken = break_input(object->with_sites(options), options);
    Preview preview(*renderer);
    preview.request({.object = object, .recipe = options, .key = 7});
    std::shared_ptr<Cracked> made;
    REQUIRE(soon([&] { return made || (made = preview.take()); }));
    CHECK(made->key == 7);
    CHECK(fracture::hash(made->fragments) == fracture::hash(broken.fragments));
    CHECK(made->batch.pieces().size() == broken.fragments.pieces.size());
    REQUIRE(made->cracks.size() > 100);
    for (const engine::LineVertex& v : made->cracks)
        CHECK(glm::distance(v.position, glm::vec3(0.0f, 1.5f, 0.0f)) == doctest::Approx(1.0).epsilon(0.02));

    Strike ghost{.at = object->to_file({0.0, 2.5, 0.0}), .radius = 0.4};
    preview.request({.object = object, .recipe = options, .ghost = ghost, .key = 8});
    made.reset();
    REQUIRE(soon([&] { return made || (made = preview.take()); }));
    CHECK(made->ghost);
    REQUIRE(made->cracks.size() > 10);
    for (const engine::LineVertex& v : made->cracks)
        CHECK(glm::distance(v.position, glm::vec3(0.0f, 2.5f, 0.0f)) < 0.7f);

    options.pattern.jitter = 7.0;
    preview.request({.object = object, .recipe = options, .key = 9});
    made.reset();
    REQUIRE(soon([&] { return made || (made = preview.take()); }));
    CHECK(made->fault.find("jitter") != std::string::npos);
    CHECK(made->batch.pieces().empty());
}

TEST_CASE("studio: a worker runs the newest task, can be cancelled, and ends with its owner") {
    std::atomic<int> ran = 0;
    std::atomic<bool> started = false, saw_cancel = false;
    {
        Worker worker;
        CHECK_FALSE(worker.busy());
        worker.cancel(); // nothing to do
        worker.run([&](const Worker::Cancelled& cancelled) {
            started = true;
            while (!cancelled()) std::this_thread::yield();
            saw_cancel = true;
        });
        REQUIRE(soon([&] { return started.load(); }));
        worker.run([&](const Worker::Cancelled&) { ran += 1; });
        worker.run([&](const Worker::Cancelled&) { ran += 10; }); // replaces the waiting task
        CHECK(worker.busy());
        worker.cancel(); // drops it too
        REQUIRE(soon([&] { return !worker.busy(); }));
        CHECK(saw_cancel);
        CHECK(ran == 0);
        worker.run([&](const Worker::Cancelled& cancelled) { ran += cancelled() ? 100 : 1; });
        REQUIRE(soon([&] { return !worker.busy(); }));
        CHECK(ran == 1);
        worker.run([&](const Worker::Cancelled& cancelled) {
            while (!cancelled()) std::this_thread::yield();
            ran += 1000;
        });
        std::this_thread::sleep_for(std::chrono::milliseconds(20));
    }
    CHECK((ran == 1001 || ran == 1)); // it ran to its end or never began
}

TEST_CASE("studio: recent files are kept, newest first, without shapes and duplicates") {
    const Folder folder;
    const fs::path place = folder.path / "state" / "recent";
    {
        Recent recent(place, max_recent_files);
        CHECK(recent.entries().empty());
        for (const char* file : {"/a.obj", "/b.obj", "shape:cube", "/x/../a.obj", "/line\nbreak"})
            add_file(recent, file);
        CHECK(recent.entries() == std::vector<std::string>{"/a.obj", "/b.obj"});
    }
    Recent again(place, max_recent_files);
    CHECK(again.entries() == std::vector<std::string>{"/a.obj", "/b.obj"});
    for (int k = 0; k < 40; ++k) add_file(again, "/" + std::to_string(k));
    CHECK(again.entries().size() == max_recent_files);
    CHECK(again.entries().front() == "/39");
    CHECK(Recent(place, max_recent_files).entries() == again.entries());
    Recent nowhere(fs::path(), max_recent_files);
    add_file(nowhere, "/a.obj");
    CHECK(nowhere.entries().size() == 1);
}

TEST_CASE("studio: recent materials are kept, newest first, without plain and unknown ones") {
    const Folder folder;
    const fs::path place = folder.path / "state" / "recent_materials";
    {
        Recent recent(place, max_recent_materials);
        for (const char* material : {"wood", "glass", "", "stone", "glass", "brick"}) recent.add(material);
        CHECK(recent_materials(recent) == std::vector<std::string>{"brick", "glass", "stone"});
        recent.add(recent.entries().back()); // an entry of the list itself
        CHECK(recent_materials(recent) == std::vector<std::string>{"stone", "brick", "glass"});
    }
    CHECK(recent_materials(Recent(place, max_recent_materials)) == std::vector<std::string>{"stone", "brick", "glass"});
    std::ofstream(place) << "cheese\n\nwood\nplain\nglass\n";
    CHECK(recent_materials(Recent(place, max_recent_materials)) == std::vector<std::string>{"wood"});
    std::ofstream(place) << "";
    CHECK(recent_materials(Recent(place, max_recent_materials)).empty());
    CHECK(recent_materials(Recent(folder.path, max_recent_materials)).empty()); // a folder
}

TEST_CASE("studio: an idle window is drawn for some frames after input, and slowly while a cursor blinks") {
    Idleness idleness;
    int drawn = 0;
    while (idleness.draws(false, false)) REQUIRE(++drawn < 100); // frames at the start
    CHECK(drawn > 2);
    CHECK(idleness.wait() == Idleness::pause);
    for (int k = 0; k < 10; ++k) CHECK_FALSE(idleness.draws(false, false));
    CHECK(idleness.draws(false, true)); // one frame per pause
    CHECK(idleness.wait() == Idleness::pause);
    CHECK(idleness.draws(true, false)); // at once
    CHECK(idleness.wait() == 0.0);
    for (int k = 1; k < Idleness::settling; ++k) CHECK(idleness.draws(false, false));
    CHECK_FALSE(idleness.draws(false, false));
    for (int k = 0; k < 100; ++k) CHECK(idleness.draws(true, false));
}

TEST_CASE(
    "studio: a window whose frames take long settles after few of them, and shows progress in a fifth of the time") {
    Idleness idleness;
    idleness.took(5.0); // s
    CHECK(idleness.wait() == 0.0);
    CHECK(idleness.draws(true, false));
    int drawn = 1;
    while (idleness.draws(false, false)) REQUIRE(++drawn < 100);
    CHECK(drawn == Idleness::min_settling);
    CHECK(idleness.wait() == doctest::Approx(20.0));
    CHECK(idleness.draws(false, true));
    CHECK(idleness.wait() == doctest::Approx(20.0));
    idleness.took(0.01);
    CHECK(idleness.wait() == Idleness::pause);
}

TEST_CASE("studio: the newest frame times are kept, and marks move with them") {
    FrameTimes times;
    CHECK(times.median() == 0.0);
    times.mark();
    for (size_t k = 0; k < FrameTimes::capacity; ++k) times.add(0.001 * static_cast<double>(k));
    REQUIRE(times.marks() == std::vector<size_t>{0});
    times.mark();
    times.add(1.0);
    CHECK(times.milliseconds().size() == FrameTimes::capacity);
    CHECK(times.marks() == std::vector<size_t>{FrameTimes::capacity - 1});
    times.add(1.0);
    CHECK(times.marks() == std::vector<size_t>{FrameTimes::capacity - 2});
    CHECK(times.milliseconds().front() == doctest::Approx(2.0));
}
