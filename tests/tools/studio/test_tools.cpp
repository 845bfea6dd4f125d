// The studio's tools and its camera: mouse gestures on a session, and flight.
#include <algorithm>
#include <cmath>

#include <doctest/doctest.h>
#include <glm/geometric.hpp>

#include "tests/tools/studio/room.h"
#include "tools/brittle/studio/tools.h"

using namespace brittle;
using namespace brittle::tools;
using test::frame, test::Room;

namespace {

Viewport view_of(const Navigation& navigation) {
    return {navigation.camera({}), {800.0f, 600.0f}, {}, {800.0f, 600.0f}};
}

} // namespace

TEST_CASE("tools: wheel and buttons move the camera as the help describes, and only over the scene") {
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
    // Shift + wheel belongs to the tool.
    tools.choose(Tool::hammer, *room.session);
    const float radius = room.session->tools.hammer_radius;
    const engine::Camera same = handle({.modifiers = {.shift = true}, .scroll = 2.0f});
    CHECK(distance(same) == doctest::Approx(distance(start)));
    CHECK(room.session->tools.hammer_radius > radius);
    // Middle drag: target and eye move across the view.
    (void)handle({.buttons = {press(engine::Button::middle, true)}});
    const engine::Camera panned = handle({.drag_middle = {50.0f, 0.0f}});
    (void)handle({.buttons = {press(engine::Button::middle, false)}});
    const glm::vec3 way = panned.target - start.target;
    CHECK(glm::length(way) > 0.05f);
    CHECK(std::abs(glm::dot(glm::normalize(way), glm::normalize(start.target - start.eye))) < 1e-3f);
    CHECK(glm::distance(panned.eye - start.eye, way) < 1e-4f);
    CHECK(handle({.drag_middle = {50.0f, 0.0f}}).target == panned.target); // released
    // Right drag: the eye moves around the target.
    (void)handle({.buttons = {press(engine::Button::right, true)}});
    CHECK(tools.right_held());
    const engine::Camera turned = handle({.drag_right = {80.0f, 0.0f}});
    (void)handle({.buttons = {press(engine::Button::right, false)}});
    CHECK_FALSE(tools.right_held());
    CHECK(turned.target == panned.target);
    CHECK(distance(turned) == doctest::Approx(distance(panned)));
    CHECK(glm::distance(turned.eye, panned.eye) > 0.3f);
}

TEST_CASE("tools: anchors are painted along the mouse's path, removed with Ctrl, and hold the pieces") {
    Room room("shape:cube");
    if (!room.device) return;
    Session& session = *room.session;
    Tools tools;
    Navigation navigation;
    navigation.frame(session.stage().home_bounds(), 4.0f / 3.0f);
    tools.choose(Tool::anchors, session);
    const auto stroke = [&](glm::vec2 from, glm::vec2 to, bool rub_out) {
        const engine::Modifiers modifiers{.control = rub_out};
        tools.handle(
            {.buttons = {{.button = engine::Button::left, .down = true, .cursor = from, .modifiers = modifiers}},
             .modifiers = modifiers,
             .cursor = from},
            view_of(navigation), true, session, navigation);
        tools.handle(
            {.buttons = {{.button = engine::Button::left, .down = false, .cursor = to, .modifiers = modifiers}},
             .modifiers = modifiers,
             .cursor = to},
            view_of(navigation), true, session, navigation);
    };
    const auto& anchors = session.recipe().world.anchors;
    stroke({20.0f, 20.0f}, {30.0f, 20.0f}, false); // beside the cube
    CHECK(anchors.empty());
    stroke({340.0f, 300.0f}, {460.0f, 300.0f}, false);
    const size_t painted = anchors.size();
    CHECK(painted >= 3);
    for (size_t k = 0; k + 1 < painted; ++k) { // on the surface, and their balls overlap
        CHECK(glm::distance(anchors[k].at, anchors[k + 1].at) < 2.0 * anchors[k].radius);
        const glm::dvec3 p = session.on_stage(anchors[k]);
        const fracture::Box box = fracture::bounds(session.object().mesh());
        const glm::dvec3 inside = glm::min(p - box.min, box.max - p);
        CHECK(std::abs(std::min({inside.x, inside.y, inside.z})) < 1e-9);
    }
    stroke({340.0f, 300.0f}, {460.0f, 300.0f}, false); // over painted anchors
    CHECK(anchors.size() == painted);
    session.undo();
    CHECK(anchors.empty());
    session.redo();
    CHECK(anchors.size() == painted);
    stroke({450.0f, 300.0f}, {460.0f, 300.0f}, true);
    CHECK(anchors.size() < painted);
    CHECK(!anchors.empty());
    // Space: breaks into bonded pieces that hang on the painted anchors.
    room.break_it();
    for (int k = 0; k < 30; ++k) session.update(frame);
    bool held = false;
    for (const physics::BodyId body : session.stage().world().bodies())
        held = held || session.stage().world().fixed(body);
    CHECK(held);
    const size_t before = anchors.size();
    stroke({400.0f, 250.0f}, {400.0f, 350.0f}, false); // broken: no anchor, but a message
    CHECK(anchors.size() == before);
    CHECK_FALSE(session.activity().message().text.empty());
    session.undo(); // makes it whole again
    CHECK_FALSE(session.broken());
}

TEST_CASE("studio: flying moves along the view, to the side and up, at a speed proportional to the distance") {
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
