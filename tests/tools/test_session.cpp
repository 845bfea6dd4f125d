// The studio's session on a real renderer without a window: files, work that is cancelled, time, previews; and the mouse
// as the tools see it.
#include <chrono>
#include <filesystem>
#include <fstream>
#include <memory>
#include <string>
#include <thread>

#include <doctest/doctest.h>
#include <glm/geometric.hpp>
#include <unistd.h>

#include "tests/engine/support.h"
#include "tools/brittle/failure.h"
#include "tools/brittle/studio/tools.h"

using namespace brittle;
using namespace brittle::tools;
namespace fs = std::filesystem;

namespace {

constexpr double frame = 1.0 / 60.0; // s
constexpr glm::uvec2 small{160, 120};

class Room {
  public:
    explicit Room(const std::string& mesh, uint32_t sites = 8) {
        device = engine::test::make_device();
        if (!device) return;
        renderer = must(engine::Renderer::create(*device));
        FractureOptions options;
        options.mesh = mesh;
        options.pattern.count = sites;
        session = std::make_unique<Session>(options, Object::load(options), *renderer, nullptr);
    }
    // Frames until the condition holds, for half a minute at most.
    template<class Condition> bool soon(const Condition& condition) {
        for (int k = 0; k < 3000 && !condition(); ++k) {
            session->update(frame);
            std::this_thread::sleep_for(std::chrono::milliseconds(10));
        }
        return condition();
    }
    void break_it() {
        session->break_all();
        REQUIRE(soon([&] { return session->broken(); }));
    }
    engine::Bitmap picture() {
        const engine::Camera camera = engine::look_at_bounds(session->stage().home_bounds(), 0.5f, 0.3f, 4.0f / 3.0f);
        return must(renderer->render(session->scene(camera), small));
    }

    std::unique_ptr<engine::Device> device;
    std::unique_ptr<engine::Renderer> renderer;
    std::unique_ptr<Session> session;
};

class Folder {
  public:
    Folder() {
        std::string pattern = (fs::temp_directory_path() / "brittle-session-XXXXXX").string();
        REQUIRE(mkdtemp(pattern.data()) != nullptr);
        path = pattern;
    }
    ~Folder() { fs::remove_all(path); }
    fs::path path;
};

Viewport view_of(const Navigation& navigation) {
    return {navigation.camera({}), {800.0f, 600.0f}, {}, {800.0f, 600.0f}};
}

} // namespace

TEST_CASE("session: a dropped file takes the scene's place, a bad one leaves it and says why") {
    const Folder folder;
    const std::string open = (folder.path / "open.off").string(), noise = (folder.path / "noise.stl").string(),
                      good = (folder.path / "good.off").string();
    std::ofstream(open) << "OFF\n4 2 0\n0 0 0\n1 0 0\n0 1 0\n0 0 1\n3 0 1 2\n3 0 2 3\n";
    std::ofstream(noise) << "this is no mesh";
    std::ofstream(good) << "OFF\n4 4 0\n0 0 0\n1 0 0\n0 1 0\n0 0 1\n3 0 2 1\n3 0 1 3\n3 1 2 3\n3 2 0 3\n";
    Room room("shape:cube");
    if (!room.device) return;
    Session& session = *room.session;
    const Object* before = &session.object();
    for (const std::string& file : {open, noise, (folder.path / "missing.obj").string()}) {
        CAPTURE(file);
        session.say({});
        engine::Input input;
        input.dropped = {file};
        open_dropped(input, session);
        REQUIRE(room.soon([&] { return session.message().fault; }));
        CHECK(session.message().text.find(fs::path(file).stem().string()) != std::string::npos);
        CHECK(&session.object() == before);
        CHECK(session.recipe().mesh == "shape:cube");
        CHECK_FALSE(session.document().can_undo());
    }
    engine::Input input;
    input.dropped = {open, good}; // the last one counts
    open_dropped(input, session);
    REQUIRE(room.soon([&] { return session.object().name() == "good"; }));
    CHECK(session.recipe().mesh == good);
    CHECK_FALSE(session.message().fault);
    room.break_it();
    session.undo(); // the mesh before
    REQUIRE(room.soon([&] { return session.object().name() == "cube"; }));
    CHECK_FALSE(session.broken());
}

TEST_CASE("session: work that takes long can be cancelled, and what comes after it works") {
    Room room("shape:animal", 3000);
    if (!room.device) return;
    Session& session = *room.session;
    FractureOptions recipe = session.recipe();
    recipe.algorithm = fracture::Algorithm::sequential;
    session.edit(SetRecipe{recipe});
    session.break_all();
    REQUIRE(room.soon([&] { return session.work() && session.work()->share > 0.0; })); // it has begun
    session.cancel();
    REQUIRE(room.soon([&] { return !session.work() && !session.message().text.empty(); }));
    CHECK_FALSE(session.broken());
    CHECK_FALSE(session.message().fault);
    CHECK(session.message().text == "cancelled");
    fracture::Pattern few = session.recipe().pattern;
    few.count = 4;
    session.edit(SetPattern{few});
    room.break_it();
    CHECK(session.counts()->pieces >= 4);
}

TEST_CASE("session: nothing moves while it is paused, a single step is one, slow motion is slow") {
    Room room("shape:cube");
    if (!room.device) return;
    Session& session = *room.session;
    room.break_it();
    const auto steps = [&] { return session.steps(); };
    session.playback.paused = true;
    const uint64_t still = steps();
    const auto hash = session.stage().world().state_hash();
    for (int k = 0; k < 30; ++k) session.update(frame);
    CHECK(steps() == still);
    CHECK(session.stage().world().state_hash() == hash);
    session.step_once();
    for (int k = 0; k < 30; ++k) session.update(frame);
    CHECK(steps() == still + 1);
    CHECK(session.stage().world().state_hash() != hash); // it falls
    session.playback.paused = false;
    for (int k = 0; k < 60; ++k) session.update(frame);
    const uint64_t after_a_second = steps() - still - 1;
    CHECK(after_a_second >= 118); // of 120 a second
    CHECK(after_a_second <= 122);
    session.playback.speed = 0.1f;
    const uint64_t slow = steps();
    for (int k = 0; k < 60; ++k) session.update(frame);
    CHECK(steps() - slow >= 10);
    CHECK(steps() - slow <= 14);
    session.playback = {.paused = true, .speed = 1.0f};
    session.step_once(); // a step that was asked for while time went by stops it
    session.update(frame);
    CHECK(session.playback.paused);
}

TEST_CASE("session: the preview is drawn in place of the mesh, and the mesh after it as before") {
    Room room("shape:icosphere", 20);
    if (!room.device) return;
    Session& session = *room.session;
    const engine::Bitmap before = room.picture();
    CHECK(room.renderer->stats().pieces == 1);
    session.picture().cells = true;
    REQUIRE(room.soon([&] { return session.preview_pieces() > 0; }));
    const engine::Bitmap cells = room.picture();
    CHECK(room.renderer->stats().pieces == session.preview_pieces());
    CHECK(cells.pixels != before.pixels);
    fracture::Pattern more = session.recipe().pattern;
    more.count = 40;
    session.edit(SetPattern{more});
    const uint32_t few = session.preview_pieces();
    REQUIRE(room.soon([&] { return session.preview_pieces() > few; }));
    (void)room.picture();
    CHECK(room.renderer->stats().pieces == session.preview_pieces()); // the older ones are gone
    session.picture().cells = false;
    session.update(frame);
    CHECK(session.preview_pieces() == 0);
    CHECK(room.picture().pixels == before.pixels);
    CHECK(room.renderer->stats().pieces == 1);
}

TEST_CASE("session: a replay log is there once something broke, and not before") {
    const Folder folder;
    Room room("shape:cube");
    if (!room.device) return;
    Session& session = *room.session;
    const fs::path file = folder.path / "run.log";
    session.save_replay(file);
    CHECK(session.message().fault);
    CHECK_FALSE(fs::exists(file));
    room.break_it();
    for (int k = 0; k < 5; ++k) session.update(frame);
    session.save_replay(file);
    CHECK_FALSE(session.message().fault);
    const auto size = fs::file_size(file);
    CHECK(size > 500);
    for (int k = 0; k < 5; ++k) session.update(frame);
    session.save_replay(file); // it went on
    CHECK(fs::file_size(file) > size);
    session.save_replay(folder.path / "none" / "run.log");
    CHECK(session.message().fault);
}

TEST_CASE("tools: wheel and buttons move the camera as the help says, and only over the scene") {
    Room room("shape:cube");
    if (!room.device) return;
    Tools tools;
    Navigation navigation;
    navigation.frame({}, 4.0f / 3.0f);
    const auto handle = [&](engine::Input input, bool free = true) {
        input.cursor = {400.0f, 300.0f}; // on the target
        tools.handle(input, view_of(navigation), free, *room.session, navigation);
        return navigation.camera({});
    };
    const auto distance = [](const engine::Camera& c) { return glm::distance(c.eye, c.target); };
    const auto press = [](engine::Button button, bool down) {
        return engine::ButtonEvent{.button = button, .down = down, .cursor = {400.0f, 300.0f}};
    };
    const engine::Camera start = navigation.camera({});
    CHECK(distance(handle({.scroll = 3.0f}, false)) == distance(start)); // over a panel
    const engine::Camera near = handle({.scroll = 3.0f});
    CHECK(distance(near) < 0.8f * distance(start));
    CHECK(glm::distance(near.target, start.target) < 1e-3f);
    CHECK(distance(handle({.scroll = -3.0f})) == doctest::Approx(distance(start)));
    // Shift and the wheel are the tool's.
    tools.choose(Tool::hammer, *room.session);
    const float radius = room.session->tools.hammer_radius;
    const engine::Camera same = handle({.modifiers = {.shift = true}, .scroll = 2.0f});
    CHECK(distance(same) == doctest::Approx(distance(start)));
    CHECK(room.session->tools.hammer_radius > radius);
    // Middle drag: the target goes across the view, as far as the eye.
    (void)handle({.buttons = {press(engine::Button::middle, true)}});
    const engine::Camera panned = handle({.drag_middle = {50.0f, 0.0f}});
    (void)handle({.buttons = {press(engine::Button::middle, false)}});
    const glm::vec3 way = panned.target - start.target;
    CHECK(glm::length(way) > 0.05f);
    CHECK(std::abs(glm::dot(glm::normalize(way), glm::normalize(start.target - start.eye))) < 1e-3f);
    CHECK(glm::distance(panned.eye - start.eye, way) < 1e-4f);
    CHECK(handle({.drag_middle = {50.0f, 0.0f}}).target == panned.target); // released
    // Right drag: round the target.
    (void)handle({.buttons = {press(engine::Button::right, true)}});
    CHECK(tools.right_held());
    const engine::Camera turned = handle({.drag_right = {80.0f, 0.0f}});
    (void)handle({.buttons = {press(engine::Button::right, false)}});
    CHECK_FALSE(tools.right_held());
    CHECK(turned.target == panned.target);
    CHECK(distance(turned) == doctest::Approx(distance(panned)));
    CHECK(glm::distance(turned.eye, panned.eye) > 0.3f);
}

TEST_CASE("studio: flying goes where one looks, aside and up, at a speed that suits the distance") {
    Navigation navigation;
    navigation.frame({}, 1.5f);
    const engine::Camera start = navigation.camera({});
    const glm::vec3 forward = glm::normalize(start.target - start.eye);
    const float distance = glm::distance(start.eye, start.target);
    navigation.fly({1.0f, 0.0f, 0.0f}, 0.1);
    glm::vec3 way = navigation.camera({}).eye - start.eye;
    CHECK(glm::dot(way, forward) == doctest::Approx(glm::length(way)));
    CHECK(glm::length(way) > 0.02f * distance);
    CHECK(glm::length(way) < distance);
    navigation.fly({-1.0f, 0.0f, 0.0f}, 0.1);
    CHECK(glm::distance(navigation.camera({}).eye, start.eye) < 1e-4f);
    navigation.fly({0.0f, 1.0f, 0.0f}, 0.1);
    way = navigation.camera({}).eye - start.eye;
    CHECK(std::abs(way.y) < 1e-5f);
    CHECK(std::abs(glm::dot(way, forward)) < 1e-4f);
    CHECK(glm::dot(glm::cross(forward, way), glm::vec3(0.0f, 1.0f, 0.0f)) < 0.0f); // to the right
    navigation.fly({0.0f, 0.0f, 1.0f}, 0.1);
    CHECK(navigation.camera({}).eye.y > start.eye.y);
}
