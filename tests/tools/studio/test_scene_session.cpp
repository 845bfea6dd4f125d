// The studio's session with a scene of several objects, on a real renderer without a window.
#include <cmath>
#include <filesystem>
#include <string>

#include <doctest/doctest.h>
#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <glm/trigonometric.hpp>

#include "fracture/io/import.h"
#include "tests/tools/studio/room.h"
#include "tests/tools/support.h"
#include "tools/brittle/studio/tools.h"
#include "tools/scenario/recipe/recipe.h"
#include "tools/scenario/replay/log.h"

using namespace brittle;
using namespace brittle::tools;
using test::Folder, test::frame, test::Outcome, test::Room, test::run_brittle;

namespace {

// A floor, a vase in the air above it and a ball that comes after a tenth of a second.
FractureOptions table_top(const Folder& folder) {
    FractureOptions options;
    read_recipe(folder.write("scene.json", R"({"brittle": 2, "objects": [
        {"name": "floor", "mesh": "shape:cube", "scale": [3, 0.1, 3], "translation": [0, -0.1, 0], "fixed": true},
        {"name": "vase", "mesh": "shape:cube", "material": "ceramic", "scale": 0.2, "translation": [0.5, 1, 0]}],
        "world": {"shots": [{"time": 0.1, "from": [0, 1, 2], "velocity": [0, 0, -1], "radius": 0.05}]}})"),
                options);
    return options;
}

constexpr glm::dvec3 down(0.0, -1.0, 0.0);

// Looks from the front, slightly from above, at the middle of the table top.
Viewport from_front() {
    engine::Camera camera;
    camera.eye = {0.0f, 1.5f, 5.0f};
    camera.target = {0.0f, 1.0f, 0.0f};
    return {camera, {800.0f, 600.0f}, {}, {800.0f, 600.0f}};
}

std::optional<PieceHit> below(const Session& session, double x) {
    return session.pieces().first(glm::dvec3(x, 5.0, 0.0), down);
}

} // namespace

TEST_CASE("studio scene: objects stand at their places until time begins, and reset puts them back") {
    const Folder folder;
    Room room(table_top(folder));
    if (!room.device) return;
    Session& session = *room.session;
    CHECK_FALSE(session.playing());
    CHECK(session.quiet());
    for (int k = 0; k < 30; ++k) session.update(frame);
    CHECK(session.steps() == 0);
    const auto vase = below(session, 0.5), floor = below(session, -0.5);
    REQUIRE(vase);
    REQUIRE(floor);
    CHECK(vase->point.y == doctest::Approx(1.2));
    CHECK(floor->point.y == doctest::Approx(0.0));
    CHECK(session.stage().simulation().member_of(vase->piece) == 1);
    CHECK(session.stage().simulation().member_of(floor->piece) == 0);
    const auto start = session.stage().simulation().state_hash();

    session.break_all();
    CHECK(session.playing());
    for (int k = 0; k < 30; ++k) session.update(frame);
    CHECK(session.steps() > 40);
    CHECK(session.stage().simulation().balls().size() == 1); // the recipe's shot
    (void)room.picture();
    REQUIRE(below(session, 0.5));
    CHECK(below(session, 0.5)->point.y < 1.0f); // it falls
    session.reset();
    CHECK_FALSE(session.playing());
    CHECK(session.stage().simulation().state_hash() == start);
    CHECK(session.stage().simulation().balls().empty());
}

TEST_CASE("studio scene: a blow begins the run, cuts what it hits, and leaves a fixed object") {
    const Folder folder;
    Room room(table_top(folder));
    if (!room.device) return;
    Session& session = *room.session;
    session.strike(*below(session, -0.5), down);
    CHECK_FALSE(session.playing());
    CHECK(session.activity().message().text.find("floor is fixed") == 0);
    session.strike(*below(session, 0.5), down);
    CHECK(session.playing());
    REQUIRE(room.soon([&] { return session.counts()->pieces > 3; }));
    session.files().save_replay(folder.path / "run.log");
    const Outcome again = run_brittle(folder, "replay " + folder / "run.log");
    CAPTURE(again.output);
    CHECK(again.exit_code == exit_success);
}

TEST_CASE("studio scene: selected objects are changed, copied and removed, with undo, and saved as they are") {
    const Folder folder;
    Room room(table_top(folder));
    if (!room.device) return;
    Session& session = *room.session;
    const auto settled = [&] { return !session.activity().busy(); };
    const std::string before = recipe_json(session.recipe());
    session.select(1, false);
    session.change_selected([](SceneObject& object) { object.placement.translation.x = -1.5; });
    session.duplicate_selected();
    REQUIRE(session.recipe().objects.size() == 3);
    CHECK(session.recipe().objects[2].name == "vase 2");
    CHECK(session.selected == std::vector<uint32_t>{2});
    REQUIRE(room.soon([&] { return settled() && session.stage().simulation().members().size() == 3; }));
    CHECK(below(session, -1.5)->point.y == doctest::Approx(1.2));
    CHECK(below(session, 0.5)->point.y == doctest::Approx(0.0));

    session.files().save_recipe(folder.path / "saved.json");
    FractureOptions saved;
    read_recipe(folder.path / "saved.json", saved);
    CHECK(recipe_json(saved) == recipe_json(session.recipe()));

    session.remove_selected();
    CHECK(session.recipe().objects.size() == 2);
    CHECK(session.selected.empty());
    for (int k = 0; k < 3; ++k) session.undo();
    CHECK(recipe_json(session.recipe()) == before);
    REQUIRE(room.soon([&] { return settled() && session.stage().simulation().members().size() == 2; }));
    CHECK(below(session, 0.5)->point.y == doctest::Approx(1.2));
    session.selected = {0, 1};
    session.remove_selected(); // a scene needs an object
    CHECK(session.recipe().objects.size() == 2);
}

TEST_CASE("studio scene: a dropped mesh is added, and one that cannot be read leaves the stage and is named") {
    const Folder folder;
    folder.write("wedge.off", "OFF\n4 4 0\n0 0 0\n1 0 0\n0 1 0\n0 0 1\n3 0 2 1\n3 0 1 3\n3 1 2 3\n3 2 0 3\n");
    Room room(table_top(folder));
    if (!room.device) return;
    Session& session = *room.session;
    engine::Input input;
    input.dropped = {folder / "wedge.off"};
    open_dropped(input, from_front(), session);
    REQUIRE(room.soon([&] { return session.stage().simulation().members().size() == 3; }));
    CHECK(session.stage().simulation().members()[2].name == "wedge");
    CHECK(session.selected == std::vector<uint32_t>{2});
    input.dropped = {folder / "missing.obj"};
    open_dropped(input, from_front(), session);
    REQUIRE(room.soon([&] { return session.activity().message().fault; }));
    CHECK(session.activity().message().text.find("missing") != std::string::npos);
    CHECK(session.stage().simulation().members().size() == 3);
    session.undo();
    CHECK(session.recipe().objects.size() == 3);
}

TEST_CASE("studio scene: the middle of what is selected is there until time begins") {
    const Folder folder;
    Room room(table_top(folder));
    if (!room.device) return;
    Session& session = *room.session;
    CHECK_FALSE(session.middle_of_selected());
    session.select(1, false);
    REQUIRE(session.middle_of_selected());
    CHECK(glm::distance(*session.middle_of_selected(), glm::vec3(0.5f, 1.0f, 0.0f)) < 1e-5f);
    session.break_all();
    CHECK_FALSE(session.middle_of_selected());
}

TEST_CASE("studio scene: the pieces of all objects are exported as one file, and another format is refused") {
    const Folder folder;
    Room room(table_top(folder));
    if (!room.device) return;
    Session& session = *room.session;
    session.strike(*below(session, 0.5), down);
    REQUIRE(room.soon([&] { return session.counts()->pieces > 3; }));
    session.files().export_pieces(folder.path / "rubble.glb", PiecesAs::they_lie);
    CHECK(session.activity().message().text.find("pieces in ") != std::string::npos);
    const auto written = fracture::import_scene(folder.path / "rubble.glb");
    REQUIRE(written);
    CHECK(written->nodes.size() == session.counts()->pieces);
    session.files().export_pieces(folder.path / "rubble.obj", PiecesAs::they_lie);
    CHECK(session.activity().message().text.find(".glb file") != std::string::npos);
    CHECK_FALSE(std::filesystem::exists(folder.path / "rubble.obj"));
}

TEST_CASE("studio scene: it has the name of its file, and reset ends the exploded view") {
    const Folder folder;
    Room room(table_top(folder));
    if (!room.device) return;
    Session& session = *room.session;
    CHECK(session.name() == "scene"); // no file is known
    session.files().save_recipe(folder.path / "table top.json");
    CHECK(session.name() == "table top");
    session.picture().explode = 0.5f;
    session.reset();
    CHECK(session.picture().explode == 0.0f);
    session.files().open("shape:cube");
    REQUIRE(room.soon([&] { return !session.object().is_scene(); }));
    CHECK(session.name() == "cube");
    CHECK(session.recipe_file.empty()); // saving must not replace the scene
    session.files().open((folder.path / "scene.json").string());
    REQUIRE(room.soon([&] { return session.object().is_scene(); }));
    CHECK(session.name() == "scene");
    CHECK(session.recipe_file == folder / "scene.json");
}

TEST_CASE("studio scene: a message says that a ball broke nothing, and with what energy it would") {
    const Folder folder;
    FractureOptions options;
    read_recipe(folder.write("scene.json", R"({"brittle": 2, "objects": [
        {"name": "block", "mesh": "shape:cube", "material": "stone", "scale": 0.5, "translation": [0, 0.5, 0]}]})"),
                options);
    Room room(options);
    if (!room.device) return;
    Session& session = *room.session;
    const auto told = [&] { return session.activity().message().text; };
    session.tools.ball_radius = 0.02f;
    session.tools.ball_speed = 1.5f;
    session.shoot({0.0f, 0.5f, 0.7f}, {0.0f, 0.0f, -1.0f});
    REQUIRE(room.soon([&] { return !told().empty(); }));
    CAPTURE(told());
    REQUIRE(told().find("Nothing broke: block was hit with") == 0);
    const std::string text = told();
    const double energy = std::stod(text.substr(text.find("with") + 5));
    const double ball = 0.5 * 7800.0 * 4.0 / 3.0 * 3.14159 * std::pow(0.02, 3.0) * 1.5 * 1.5;
    CHECK(energy > 0.3 * ball);
    CHECK(energy < 1.1 * ball);
    const size_t from = text.find("about");
    REQUIRE(from != std::string::npos);
    const double needed = std::stod(text.substr(from + 6));
    CHECK(needed > energy);
    session.reset(); // a ball with twice that energy breaks it, without a message
    session.tools.ball_speed = 1.5f * static_cast<float>(std::sqrt(2.0 * needed / energy));
    session.shoot({0.0f, 0.5f, 0.7f}, {0.0f, 0.0f, -1.0f});
    REQUIRE(room.soon([&] { return session.counts()->pieces > 1; }));
    CHECK(told().empty());
}

TEST_CASE("studio scene: a mesh replaces a scene, and undo brings the scene back") {
    const Folder folder;
    Room room(table_top(folder));
    if (!room.device) return;
    Session& session = *room.session;
    session.files().open("shape:cube");
    REQUIRE(room.soon([&] { return !session.object().is_scene(); }));
    CHECK_FALSE(session.broken());
    CHECK(session.recipe().world.shots.empty());
    CHECK_FALSE(session.sites().on_stage().empty());
    room.break_it();
    session.undo();
    REQUIRE(room.soon([&] { return session.object().is_scene(); }));
    CHECK(session.stage().simulation().members().size() == 2);
    CHECK_FALSE(session.playing());
    session.files().open(folder / "scene.json");
    CHECK_FALSE(session.document().saved());
    CHECK(room.soon([&] { return session.document().saved(); }));
}

TEST_CASE("studio scene: an object that cannot be broken is named") {
    const Folder folder;
    folder.write("open.off", "OFF\n4 2 0\n0 0 0\n1 0 0\n0 1 0\n0 0 1\n3 0 1 2\n3 0 2 3\n");
    FractureOptions options;
    read_recipe(folder.write("faulty.json",
                             R"({"brittle": 2, "objects": [{"name": "sheet", "mesh": "open.off"},
                                                            {"mesh": "shape:cube"}]})"),
                options);
    Room room(options);
    if (!room.device) return;
    CHECK(room.session->activity().message().text.find("sheet stays whole and fixed") == 0);
}

TEST_CASE("studio scene: what is moved is drawn there at once, and stands there once the mouse is released") {
    const Folder folder;
    Room room(table_top(folder));
    if (!room.device) return;
    Session& session = *room.session;
    session.select(1, false);
    (void)room.picture();
    const auto start = session.stage().simulation().state_hash();
    session.preview().held = true;
    const uint64_t gesture = session.begin_gesture();
    for (int k = 1; k <= 5; ++k) {
        session.change_selected(
            [k](SceneObject& object) {
                object.placement.translation.x = 0.5 - 0.4 * k;
                object.placement.rotation.z = 9.0 * k; // 45 degrees at the end
            },
            gesture);
        session.update(frame);
        CHECK_FALSE(session.activity().busy()); // nothing is read
    }
    CHECK(session.stage().simulation().state_hash() == start);
    CHECK(session.middle_of_selected()->x == doctest::Approx(-1.5));
    (void)room.picture(); // poses are those that are drawn
    REQUIRE(below(session, -1.5));
    CHECK(below(session, -1.5)->point.y == doctest::Approx(1.0 + 0.2 * std::sqrt(2.0)));
    CHECK(below(session, 0.5)->point.y == doctest::Approx(0.0)); // the floor
    CHECK_FALSE(session.quiet());
    session.preview().held = false;
    REQUIRE(room.soon([&] { return session.quiet(); }));
    CHECK(session.stage().simulation().state_hash() != start);
    CHECK(below(session, -1.5)->point.y == doctest::Approx(1.0 + 0.2 * std::sqrt(2.0)));

    session.undo(); // the whole gesture; a blow does not wait for the stage
    (void)room.picture();
    session.strike(*below(session, 0.5), down);
    CHECK(session.playing());
    REQUIRE(room.soon([&] { return session.counts()->pieces > 3; }));
    session.files().save_replay(folder.path / "run.log");
    CHECK(run_brittle(folder, "replay " + folder / "run.log").exit_code == exit_success);
    session.change_selected([](SceneObject& object) { object.placement.translation.y = 2.0; }); // while it is played
    CHECK_FALSE(session.playing());
    CHECK(below(session, 0.5)->point.y == doctest::Approx(2.2));
}

TEST_CASE("studio scene: time begins once the edits before it are on the stage") {
    const Folder folder;
    Room room(table_top(folder));
    if (!room.device) return;
    Session& session = *room.session;
    session.select(1, false);
    session.change_selected([](SceneObject& object) { object.placement.scale *= 2.0; });
    session.break_all();
    CHECK_FALSE(session.playing());
    REQUIRE(room.soon([&] { return session.playing(); }));
    CHECK(session.object().scene().objects[1].box.max.y == doctest::Approx(1.4));
    session.reset();
    CHECK_FALSE(session.playing());
    session.change_selected([](SceneObject& object) { object.placement.translation.y = 3.0; });
    session.break_all(); // a change of place is there at once
    CHECK(session.playing());
}

TEST_CASE("studio scene: an anchored object that is turned is held by its new foot") {
    const Folder folder;
    FractureOptions options;
    read_recipe(folder.write("scene.json", R"({"brittle": 2, "objects": [
        {"name": "post", "mesh": "shape:cube", "material": "stone", "scale": [0.1, 1, 0.1], "translation": [0, 2, 0],
         "anchored": true}]})"),
                options);
    Room room(options);
    if (!room.device) return;
    Session& session = *room.session;
    session.select(0, false);
    session.change_selected([](SceneObject& object) { object.placement.rotation.z = 90.0; });
    REQUIRE(room.soon([&] { return session.quiet(); }));
    session.files().save_recipe(folder.path / "turned.json");
    FractureOptions turned;
    read_recipe(folder.path / "turned.json", turned);
    LoadedScene loaded = load_scene(turned);
    Simulation fresh;
    fresh.start(prepare_scene(loaded), loaded.world);
    CHECK(session.stage().simulation().state_hash() == fresh.state_hash());
}

TEST_CASE("studio scene: undo of an edit that could not be read keeps the stage, and takes the message back") {
    const Folder folder;
    Room room(table_top(folder));
    if (!room.device) return;
    Session& session = *room.session;
    const Stage* stage = &session.stage();
    session.select(1, false);
    session.change_selected([](SceneObject& object) { object.recipe.mesh = "missing.obj"; });
    REQUIRE(room.soon([&] { return session.activity().message().fault; }));
    session.undo();
    CHECK_FALSE(session.activity().busy());
    CHECK_FALSE(session.activity().message().fault);
    CHECK(&session.stage() == stage);
    CHECK(session.quiet());
}

namespace {

// Drives the tools with the mouse.
struct Hand {
    Session& session;
    Tools tools{};
    Navigation navigation{};
    Viewport view = from_front();

    void send(engine::Input input, glm::vec2 at) {
        input.cursor = at;
        tools.handle(input, view, true, session, navigation);
    }
    void button(bool goes_down, glm::vec2 at, engine::Modifiers modifiers = {}) {
        engine::Input input{.modifiers = modifiers};
        input.buttons.push_back({engine::Button::left, goes_down, at, modifiers});
        send(input, at);
    }
    void drag(glm::vec2 from, glm::vec2 to, engine::Modifiers modifiers = {}) {
        button(true, from, modifiers);
        for (int k = 1; k <= 4; ++k) send({.modifiers = modifiers}, glm::mix(from, to, 0.25f * static_cast<float>(k)));
        button(false, to, modifiers);
    }
    [[nodiscard]] glm::vec2 pixel(const glm::vec3& at) const { return *view.pixel(at); }
};

} // namespace

TEST_CASE("studio scene: the gizmo moves, turns and scales what is selected, each drag one step of the history") {
    const Folder folder;
    Room room(table_top(folder));
    if (!room.device) return;
    Session& session = *room.session;
    Hand hand{session};
    hand.button(true, hand.pixel({0.5f, 1.1f, 0.0f}));
    hand.button(false, hand.pixel({0.5f, 1.1f, 0.0f}));
    REQUIRE(session.selected == std::vector<uint32_t>{1});
    const auto place = [&]() -> const ObjectPlacement& { return session.recipe().objects[1].placement; };
    const glm::dvec3 start = place().translation;
    const float metres = 1.0f / hand.view.pixels_a_metre({0.5f, 1.0f, 0.0f});
    const glm::vec2 arrow = hand.pixel(glm::vec3(0.5f + 50.0f * metres, 1.0f, 0.0f));
    hand.drag(arrow, arrow + glm::vec2(0.3f / metres, 0.0f));
    CHECK(place().translation.x == doctest::Approx(0.8).epsilon(0.05));
    CHECK(glm::distance(place().translation * glm::dvec3(0, 1, 1), start * glm::dvec3(0, 1, 1)) < 1e-9);
    session.undo();
    CHECK(place().translation == start);
    hand.drag(arrow, arrow + glm::vec2(0.33f / metres, 0.0f), {.control = true});
    CHECK(place().translation.x == doctest::Approx(0.8).epsilon(1e-9));
    session.undo();

    hand.tools.choose(GizmoMode::turn);
    const auto rings = gizmo_shape(GizmoMode::turn, {glm::dvec3(*session.middle_of_selected())}, hand.view);
    const auto& ring = rings[1].points;
    hand.drag(ring[ring.size() / 2], ring[ring.size() / 2 + 5], {.control = true});
    CHECK(place().rotation == glm::dvec3(0.0, 30.0, 0.0)); // 28 degrees, and the nearest step
    CHECK(glm::distance(place().translation, start) < 1e-6);
    session.undo();
    CHECK(place().rotation == glm::dvec3(0.0));

    hand.tools.choose(GizmoMode::scale);
    const glm::vec2 middle = hand.pixel({0.5f, 1.0f, 0.0f});
    hand.drag(middle, middle + glm::vec2(32.0f, -32.0f));
    CHECK(place().scale.x == doctest::Approx(0.2 * (1.0 + std::sqrt(0.5))).epsilon(0.01));
    CHECK(place().scale.x == place().scale.y);
    REQUIRE(room.soon([&] { return session.quiet(); }));
    CHECK(session.object().scene().objects[1].box.size().x == doctest::Approx(2.0 * place().scale.x));
    session.undo();
    CHECK(place().scale == glm::dvec3(0.2));
    CHECK_FALSE(session.document().can_undo());
}

TEST_CASE("studio scene: several objects turn about their common middle") {
    const Folder folder;
    Room room(table_top(folder));
    if (!room.device) return;
    Session& session = *room.session;
    session.select(1, false);
    session.duplicate_selected(); // at 0.6
    session.selected = {2};
    session.change_selected([](SceneObject& object) { object.placement.translation.x = -0.5; });
    REQUIRE(room.soon([&] { return session.quiet(); }));
    session.selected = {1, 2};
    Hand hand{session};
    hand.tools.choose(GizmoMode::turn);
    const auto rings = gizmo_shape(GizmoMode::turn, {glm::dvec3(*session.middle_of_selected())}, hand.view);
    const auto& ring = rings[1].points;
    hand.drag(ring[ring.size() / 2], ring[ring.size() / 2 + 5], {.control = true});
    const double angle = session.recipe().objects[1].placement.rotation.y;
    CHECK(angle == 30.0);
    for (const uint32_t k : {1u, 2u}) {
        const double side = k == 1 ? 0.5 : -0.5;
        const ObjectPlacement& place = session.recipe().objects[k].placement;
        CHECK(place.rotation.y == angle);
        CHECK(place.translation.x == doctest::Approx(side * std::cos(glm::radians(angle))).epsilon(1e-5));
        CHECK(place.translation.z == doctest::Approx(-side * std::sin(glm::radians(angle))).epsilon(1e-5));
    }
}

TEST_CASE("studio scene: a box selects what is wholly within it, but nothing that is hidden or locked") {
    const Folder folder;
    Room room(table_top(folder));
    if (!room.device) return;
    Session& session = *room.session;
    Hand hand{session};
    const glm::vec2 low = hand.pixel({0.5f, 1.0f, 0.0f}) - 80.0f, high = low + 160.0f;
    hand.drag(low, high); // turns the view
    CHECK(session.selected.empty());
    hand.drag(high, low, {.shift = true}); // from any corner; the floor reaches beyond the box
    CHECK(session.selected == std::vector<uint32_t>{1});
    hand.drag(low, high, {.shift = true}); // adds
    CHECK(session.selected == std::vector<uint32_t>{1});
    session.selected.clear();
    session.lock(1, true);
    hand.drag(low, high, {.shift = true});
    CHECK(session.selected.empty());
    const glm::vec2 vase = hand.pixel({0.5f, 1.1f, 0.0f});
    hand.button(true, vase);
    hand.button(false, vase);
    CHECK(session.selected.empty()); // what is behind it: nothing
    session.lock(1, false);
    hand.drag(low, low + 20.0f, {.shift = true}); // too small
    CHECK(session.selected.empty());
}

TEST_CASE("studio scene: a hidden object is neither drawn nor hit until it is shown, and marks follow a new name") {
    const Folder folder;
    Room room(table_top(folder));
    if (!room.device) return;
    Session& session = *room.session;
    const auto all = room.picture().pixels;
    const auto under = [&] { return session.first_piece(glm::dvec3(0.5, 5.0, 0.0), down)->point.y; };
    CHECK(under() == doctest::Approx(1.2));
    session.hide(1, true);
    CHECK(session.is_hidden(1));
    CHECK(room.picture().pixels != all);
    CHECK(under() == doctest::Approx(0.0)); // the floor
    CHECK(session.document().saved());      // no edit of the recipe
    session.rename(1, "jar");
    REQUIRE(room.soon([&] { return session.quiet(); }));
    CHECK(session.is_hidden(1));
    CHECK(under() == doctest::Approx(0.0));
    session.undo();
    REQUIRE(room.soon([&] { return session.quiet(); }));
    CHECK(session.is_hidden(1));
    session.hide(1, false);
    CHECK(under() == doctest::Approx(1.2));
    CHECK(room.picture().pixels == all);
    session.hide(1, true); // its pieces are hidden, too
    session.strike(*below(session, 0.5), down);
    REQUIRE(room.soon([&] { return session.counts()->pieces > 3; }));
    const auto hit = session.first_piece(glm::dvec3(0.5, 5.0, 0.0), down);
    CHECK(session.stage().simulation().member_of(hit->piece) == 0);
}

TEST_CASE("studio scene: objects lie on what is under the cursor, their lowest point on the surface") {
    const Folder folder;
    Room room(table_top(folder));
    if (!room.device) return;
    Session& session = *room.session;
    const glm::dvec3 eye(0.0, 1.5, 5.0);
    CHECK(session.surface_at(eye, down, {})->y == doctest::Approx(0.0)); // the ground beside the floor
    CHECK_FALSE(session.surface_at(eye, -down, {}));
    CHECK(session.surface_at({0.5, 5.0, 0.0}, down, {})->y == doctest::Approx(1.2));
    const std::vector<uint32_t> vase{1};
    CHECK(session.surface_at({0.5, 5.0, 0.0}, down, vase)->y == doctest::Approx(0.0));

    session.select(1, false);
    Hand hand{session};
    hand.drag(hand.pixel({0.5f, 1.0f, 0.0f}), hand.pixel({-1.0f, 0.0f, 1.0f}), {.shift = true});
    const fracture::Box& box = session.object().scene().objects[1].box;
    CHECK(box.min.y == doctest::Approx(0.0));
    CHECK(glm::distance(box.centre() * glm::dvec3(1, 0, 1), glm::dvec3(-1, 0, 1)) < 0.01);
    session.undo();
    REQUIRE(room.soon([&] { return session.quiet(); }));

    folder.write("wedge.off", "OFF\n4 4 0\n0 -1 0\n1 -1 0\n0 0 0\n0 -1 1\n3 0 2 1\n3 0 1 3\n3 1 2 3\n3 2 0 3\n");
    engine::Input input;
    input.dropped = {folder / "wedge.off"};
    input.cursor = hand.pixel({-0.5f, 0.0f, 0.5f});
    open_dropped(input, hand.view, session);
    REQUIRE(room.soon([&] { return session.quiet() && session.object().scene().objects.size() == 3; }));
    const fracture::Box& wedge = session.object().scene().objects[2].box;
    CHECK(wedge.min.y == doctest::Approx(0.0).epsilon(1e-5));
    CHECK(glm::distance(wedge.centre() * glm::dvec3(1, 0, 1), glm::dvec3(-0.5, 0, 0.5)) < 0.01);
    session.undo(); // one step
    CHECK(session.recipe().objects.size() == 2);
}
