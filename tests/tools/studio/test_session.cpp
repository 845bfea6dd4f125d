// The studio's session on a real renderer without a window: files, cancelled work, time, previews, the hammer and balls.
#include <algorithm>
#include <chrono>
#include <filesystem>
#include <fstream>
#include <set>
#include <string>
#include <thread>

#include <doctest/doctest.h>
#include <glm/geometric.hpp>

#include "fracture/io/export.h"
#include "fracture/mesh/mass_properties.h"
#include "fracture/pieces/certificate.h"
#include "fracture/shapes/shapes.h"
#include "tests/tools/studio/room.h"
#include "tests/tools/support.h"
#include "tools/brittle/studio/tools.h"
#include "tools/scenario/base/failure.h"
#include "tools/scenario/replay/player.h"

using namespace brittle;
using namespace brittle::tools;
using test::Folder, test::frame, test::read_text, test::Room;
namespace fs = std::filesystem;

namespace {

// Maximum number of steps, of a millisecond or more each, to wait for a worker's cut. On a busy machine hundreds of
// steps pass before it begins.
constexpr uint64_t patience = 20'000;

std::multiset<double> volumes_of(const fracture::Fragments& fragments) {
    std::multiset<double> volumes;
    for (const fracture::Piece& piece : fragments.pieces) volumes.insert(piece.mass.volume);
    return volumes;
}

std::multiset<double> volumes_of(const Session& session) {
    const physics::Destruction& destruction = *session.stage().simulation().destruction();
    std::multiset<double> volumes;
    for (const physics::PieceId id : destruction.pieces()) volumes.insert(destruction.solid(id)->mass.volume);
    return volumes;
}

uint32_t largest_of(const Session& session) {
    const physics::Destruction& destruction = *session.stage().simulation().destruction();
    const auto all = destruction.pieces();
    return std::max_element(all.begin(), all.end(),
                            [&](physics::PieceId a, physics::PieceId b) {
                                return destruction.solid(a)->mass.volume < destruction.solid(b)->mass.volume;
                            })
        ->value;
}

} // namespace

TEST_CASE("session: a dropped file replaces the object, and a bad one leaves it and gives the reason") {
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
        session.activity().say({});
        engine::Input input;
        input.dropped = {file};
        open_dropped(input, Viewport({}, {800.0f, 600.0f}, {}, {800.0f, 600.0f}), session);
        CHECK_FALSE(session.activity().message().fault); // read on a worker; the result arrives with an update
        REQUIRE(room.soon([&] { return session.activity().message().fault; }));
        CHECK(session.activity().message().text.find(fs::path(file).stem().string()) != std::string::npos);
        CHECK(&session.object() == before);
        CHECK(session.recipe().mesh == "shape:cube");
        CHECK_FALSE(session.document().can_undo());
    }
    engine::Input input;
    input.dropped = {open, good}; // the last one is opened
    open_dropped(input, Viewport({}, {800.0f, 600.0f}, {}, {800.0f, 600.0f}), session);
    REQUIRE(room.soon([&] { return session.object().name() == "good"; }));
    CHECK(session.recipe().mesh == good);
    CHECK_FALSE(session.activity().message().fault);
    room.break_it();
    session.undo(); // back to the mesh before
    REQUIRE(room.soon([&] { return session.object().name() == "cube"; }));
    CHECK_FALSE(session.broken());
}

TEST_CASE("session: parts that pass through each other are told of and united, and undo parts them again") {
    const Folder folder;
    fracture::TriangleMesh mesh = fracture::cube(1.0);
    fracture::TriangleMesh other = fracture::cube(1.0);
    for (const glm::dvec3& p : other.positions) mesh.positions.push_back(p + 0.5);
    for (const fracture::Triangle& t : other.triangles) mesh.triangles.push_back(t + 8u);
    fracture::Model model;
    model.mesh = mesh;
    REQUIRE(fracture::export_model(folder / "boxes.ply", model, "boxes"));
    Room room(folder / "boxes.ply");
    if (!room.device) return;
    Session& session = *room.session;
    session.edit(AddSite{{0.1, 0.1, 0.1}});
    CHECK(session.object().overlap().find("counts twice") != std::string::npos);
    session.edit(SetUnite{true});
    REQUIRE(room.soon([&] { return session.object().overlap().empty(); }));
    CHECK(fracture::signed_volume(session.object().file().model.mesh.positions,
                                  session.object().file().model.mesh.triangles)
          == doctest::Approx(1.875));
    CHECK(session.recipe().points.size() == 1); // sites stay
    session.undo();
    REQUIRE(room.soon([&] { return !session.object().overlap().empty(); }));
    CHECK(session.object().file().model.mesh.triangles.size() == mesh.triangles.size());
}

TEST_CASE("session: long work can be cancelled, and later work succeeds") {
    Room room("shape:animal", 3000);
    if (!room.device) return;
    Session& session = *room.session;
    FractureOptions recipe = session.recipe();
    recipe.algorithm = fracture::Algorithm::sequential;
    session.edit(SetRecipe{recipe});
    session.break_all();
    REQUIRE(
        // The work has begun.
        room.soon([&] { return session.activity().work() && session.activity().work()->share > 0.0; }));
    session.activity().cancel();
    REQUIRE(room.soon([&] { return !session.activity().work() && !session.activity().message().text.empty(); }));
    CHECK_FALSE(session.broken());
    CHECK_FALSE(session.activity().message().fault);
    CHECK(session.activity().message().text == "cancelled");
    fracture::Pattern few = session.recipe().pattern;
    few.count = 4;
    session.edit(SetPattern{few});
    room.break_it();
    CHECK(session.counts()->pieces >= 4);
}

TEST_CASE("session: pause, single step and slow motion control the time of the simulation") {
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
    session.step_once(); // a step requested while time passes pauses it
    session.update(frame);
    CHECK(session.playback.paused);
}

TEST_CASE("session: it is quiet when the next frame would equal the last") {
    Room room("shape:cube");
    if (!room.device) return;
    Session& session = *room.session;
    REQUIRE(room.soon([&] { return session.quiet(); })); // whole
    session.break_all();
    CHECK_FALSE(session.quiet()); // work, then new pieces, then falling ones
    int frames = 0;
    while (!session.broken()) {
        CHECK_FALSE(session.quiet());
        session.update(frame);
        std::this_thread::sleep_for(std::chrono::milliseconds(1));
        REQUIRE(++frames < 30000);
    }
    while (!session.quiet() && session.steps() < 3600) {
        const auto before = session.stage().world().state_hash();
        const bool moved = session.stage().world().awake_count() > 0;
        session.update(frame);
        if (moved) CHECK(session.stage().world().state_hash() != before);
    }
    CHECK(session.quiet());
    CHECK(session.stage().world().awake_count() == 0);
    const auto rest = session.stage().world().state_hash();
    for (int k = 0; k < 60; ++k) session.update(frame);
    CHECK(session.stage().world().state_hash() == rest);
    session.reset();
    session.picture().cells = true;
    session.update(frame);
    CHECK((!session.quiet() || session.preview().pieces() > 0)); // a preview is on its way
    REQUIRE(room.soon([&] { return session.quiet(); }));
    CHECK(session.preview().pieces() > 0);
}

TEST_CASE("session: idle sites are the sites without effect, to which no part of the mesh is nearest") {
    Room room("shape:cube");
    if (!room.device) return;
    Session& session = *room.session;
    const fracture::Box box = fracture::bounds(session.object().file().model.mesh);
    const glm::dvec3 middle = box.centre();
    const double side = box.size().x;
    // One site inside, one outside but nearest to a part of the surface, one far away beyond the second one's cell.
    const std::vector<glm::dvec3> sites{middle, middle + glm::dvec3(0.7 * side, 0.0, 0.0),
                                        middle + glm::dvec3(0.0, 9.0 * side, 0.0),
                                        middle + glm::dvec3(-0.2 * side, 0.1 * side, 0.0)};
    session.edit(SetSites{placed_sites({sites, {}, {}})});
    CHECK(session.preview().idle_sites().empty()); // not known yet
    session.preview().wanted = true;
    REQUIRE(room.soon([&] { return session.preview().pieces() > 0; }));
    CHECK(std::vector<uint32_t>(session.preview().idle_sites().begin(), session.preview().idle_sites().end())
          == std::vector<uint32_t>{2});
    const auto with = volumes_of(session.preview().current()->fragments);
    CHECK(with.size() == 3);
    const auto key = session.preview().current()->key;
    session.edit(RemoveSites{{2}});
    REQUIRE(room.soon([&] { return session.preview().current() && session.preview().current()->key != key; }));
    CHECK(session.preview().idle_sites().empty());
    CHECK(volumes_of(session.preview().current()->fragments) == with);
}

TEST_CASE("session: bricks and graded cells break as before after their sites become sites placed by hand") {
    Room room("shape:wall");
    if (!room.device) return;
    Session& session = *room.session;
    const auto hash_of = [](const FractureOptions& recipe) {
        return fracture::hash(break_input(Object::load(recipe)->with_sites(recipe), recipe).fragments);
    };
    fracture::Pattern bricks, graded;
    bricks.kind = fracture::PatternKind::bricks;
    bricks.count = 12;
    graded.count = 12;
    graded.grading = 0.8;
    for (const fracture::Pattern& pattern : {bricks, graded}) {
        session.edit(SetPattern{pattern});
        const FractureOptions before = session.recipe();
        session.take_sites(session.begin_gesture());
        REQUIRE(session.recipe().points.size() == session.sites().on_stage().size());
        CHECK(hash_of(session.recipe()) == hash_of(before));
    }
    // A brick is two cells of one group.
    session.edit(SetPattern{bricks});
    session.sites().selection = {0};
    const std::vector<uint32_t> pair = session.sites().fellows_of_selected();
    REQUIRE(pair.size() == 2);
    CHECK(pair[0] == 0);
    CHECK(session.sites().selected()[0].group > 0);
    session.sites().selection.clear();
    CHECK(session.sites().fellows_of_selected().empty());
}

TEST_CASE("session: the preview is drawn in place of the mesh, and the mesh again after it") {
    Room room("shape:icosphere", 20);
    if (!room.device) return;
    Session& session = *room.session;
    const engine::Bitmap before = room.picture();
    CHECK(room.renderer->stats().pieces == 1);
    session.picture().cells = true;
    REQUIRE(room.soon([&] { return session.preview().pieces() > 0; }));
    const engine::Bitmap cells = room.picture();
    CHECK(room.renderer->stats().pieces == session.preview().pieces());
    CHECK(cells.pixels != before.pixels);
    fracture::Pattern more = session.recipe().pattern;
    more.count = 40;
    session.edit(SetPattern{more});
    const uint32_t few = session.preview().pieces();
    REQUIRE(room.soon([&] { return session.preview().pieces() > few; }));
    (void)room.picture();
    CHECK(room.renderer->stats().pieces == session.preview().pieces()); // the older preview is removed
    session.picture().cells = false;
    session.update(frame);
    CHECK(session.preview().pieces() == 0);
    CHECK(room.picture().pixels == before.pixels);
    CHECK(room.renderer->stats().pieces == 1);
}

TEST_CASE("session: a replay log can be saved once the mesh is broken, and not before") {
    const Folder folder;
    Room room("shape:cube");
    if (!room.device) return;
    Session& session = *room.session;
    const fs::path file = folder.path / "run.log";
    session.files().save_replay(file);
    CHECK(session.activity().message().fault);
    CHECK_FALSE(fs::exists(file));
    room.break_it();
    for (int k = 0; k < 5; ++k) session.update(frame);
    session.files().save_replay(file);
    CHECK_FALSE(session.activity().message().fault);
    const auto size = fs::file_size(file);
    CHECK(size > 500);
    for (int k = 0; k < 5; ++k) session.update(frame);
    session.files().save_replay(file); // recording went on
    CHECK(fs::file_size(file) > size);
    session.files().save_replay(folder.path / "none" / "run.log");
    CHECK(session.activity().message().fault);
}

TEST_CASE("session: the log of a breakable world holds each change of the view, and replays") {
    const Folder folder;
    Room room("shape:icosphere");
    if (!room.device) return;
    Session& session = *room.session;
    session.edit(SetMaterial{"stone"});
    WorldOptions world;
    world.breakable = true;
    world.piece_limit = 5;
    session.edit(SetWorld{world});
    const engine::Bounds home = session.stage().home_bounds();
    const glm::vec3 middle = home.centre();
    engine::Camera camera = engine::look_at_bounds(home, 0.5f, 0.3f, 1.5f);
    const auto frames = [&](int count) {
        for (int k = 0; k < count; ++k) {
            session.watch(camera, 1.5f);
            session.update(frame);
            (void)session.scene(camera);
        }
    };
    session.watch(camera, 1.5f);
    session.strike(glm::dvec3(middle) + glm::dvec3(0.0, 0.0, 1.0), {0.0, 0.0, -1.0});
    REQUIRE(room.soon([&] { return session.counts() && session.counts()->pieces > 5; }));
    frames(10);
    std::swap(camera.eye, camera.target);
    frames(10);
    session.picture().explode = 1.0f;
    frames(10);
    session.files().save_replay(folder.path / "run.log");
    const ReplayLog log = read_replay_log(folder.path / "run.log");
    std::vector<Watch> told;
    for (const auto& [step, action] : log.actions)
        if (const Watch* watch = std::get_if<Watch>(&action)) told.push_back(*watch);
    REQUIRE(told.size() == 3);
    CHECK(told[0].eye == glm::dvec3(camera.target));
    CHECK(told[1].eye == glm::dvec3(camera.eye));
    CHECK(told[1].aspect == 1.5);
    // A piece at twice its distance from the middle is seen as from half the distance.
    CHECK(glm::distance(told[2].eye, 0.5 * (glm::dvec3(camera.eye) + glm::dvec3(middle))) < 1e-6);

    FractureOptions recipe = log.recipe;
    Simulation again(recipe.material);
    Player player(log);
    again.observe(&player);
    follow(log, again);
    const Broken broken = break_input(Object::load(recipe)->with_sites(recipe), recipe);
    again.start(broken.fragments, world_of(recipe));
    schedule(log, again);
    while (!player.done() && !player.difference()) again.step();
    CHECK_FALSE(player.difference());
}

TEST_CASE("session: the hammer cuts a breakable mesh as its preview showed, and undo and reset make it whole") {
    Room room("shape:animal");
    if (!room.device) return;
    Session& session = *room.session;
    session.edit(SetMaterial{"stone"});
    fracture::Pattern pattern = session.recipe().pattern;
    pattern.seed = 7; // also the seed of blows
    session.edit(SetPattern{pattern});
    WorldOptions world;
    world.breakable = world.anchored = true;
    session.edit(SetWorld{world});
    session.tools.hammer_radius = 0.3f;
    REQUIRE(room.soon([&] { return !session.activity().work(); }));
    const auto undo_name = std::string(session.document().undo_name());
    const glm::dvec3 middle(session.stage().home_bounds().centre());
    const std::vector<std::pair<glm::dvec3, glm::dvec3>> rays{{middle + glm::dvec3(0.0, 0.0, 3.0), {0.0, 0.0, -1.0}},
                                                              {middle + glm::dvec3(0.1, 3.0, 0.0), {0.0, -1.0, 0.0}}};
    int blows = 0;
    for (const auto& [from, direction] : rays) {
        const auto hit = session.object().first_hit(from, direction);
        REQUIRE(hit);
        session.preview().aim(hit->point, direction);
        REQUIRE(room.soon([&] { return session.preview().current() && session.preview().current()->ghost; }));
        const auto volumes_ahead = volumes_of(session.preview().current()->fragments);
        const auto falls =
            std::count(session.preview().current()->stays.begin(), session.preview().current()->stays.end(), 0);
        REQUIRE(volumes_ahead.size() > 4);
        CHECK(falls == static_cast<std::ptrdiff_t>(volumes_ahead.size()) - 1);
        for (const engine::LineVertex& v : session.preview().current()->cracks)
            CHECK(glm::distance(glm::dvec3(v.position), hit->point) < 1.2); // radii: 4
        (void)room.picture();
        CHECK(room.renderer->stats().pieces == volumes_ahead.size());

        session.strike(hit->point, direction);
        session.playback.paused = true; // after the cut no piece may break by its fall
        REQUIRE(room.soon([&] { return session.broken(); }));
        while (session.counts()->pieces == 1 && session.steps() < patience) {
            session.step_once();
            session.update(frame);
            std::this_thread::sleep_for(std::chrono::milliseconds(1));
        }
        CAPTURE(session.counts()->pieces);
        CAPTURE(session.steps());
        CHECK(volumes_of(session) == volumes_ahead);
        CHECK(session.recipe().strikes.empty()); // an action of the log, not an edit
        CHECK(session.document().undo_name() == undo_name);

        // A second blow, at a piece at its current place.
        (void)room.picture(); // updates the drawn poses
        const glm::dvec3 largest(session.pieces().bounds(largest_of(session))->centre());
        const auto piece = session.pieces().first(largest + glm::dvec3(0.0, 0.0, 3.0), {0.0, 0.0, -1.0});
        REQUIRE(piece);
        session.preview().aim(*piece, direction);
        const bool foreseen = room.soon(
            [&] { return session.preview().current() && session.preview().current()->piece == piece->piece; }, 300);
        if (foreseen) {
            const auto part = volumes_of(session.preview().current()->fragments);
            std::multiset<double> expected = volumes_of(session);
            expected.erase(expected.find(session.pieces().volume(piece->piece)));
            expected.insert(part.begin(), part.end());
            const size_t before = session.counts()->pieces;
            session.strike(*piece, direction);
            const uint64_t until = session.steps() + patience;
            while (session.counts()->pieces == before && session.steps() < until) {
                session.step_once();
                session.update(frame);
                std::this_thread::sleep_for(std::chrono::milliseconds(1));
            }
            CHECK(volumes_of(session) == expected);
            ++blows;
        }
        session.playback.paused = false;
        session.preview().aim_nowhere();
        session.reset();
        CHECK_FALSE(session.broken());
        session.update(frame);
        CHECK(session.all_bounds().min == session.stage().home_bounds().min);
    }
    CHECK(blows >= 1);
    session.undo(); // undoes the edit of the world; the mesh is whole and not breakable
    CHECK_FALSE(session.recipe().world.breakable);
    CHECK_FALSE(session.broken());
}

TEST_CASE("session: a ball cuts a breakable mesh where it hits, and undo makes it whole") {
    Room room("shape:pane");
    if (!room.device) return;
    Session& session = *room.session;
    session.edit(SetMaterial{"glass"});
    WorldOptions world;
    world.breakable = world.anchored = true;
    session.edit(SetWorld{world});
    const engine::Bounds home = session.stage().home_bounds();
    const glm::vec3 middle = home.centre();
    session.shoot(middle + glm::vec3(0.0f, 0.0f, 3.0f), {0.0f, 0.0f, -1.0f});
    REQUIRE(room.soon([&] { return session.counts() && session.counts()->pieces > 8; }));
    CHECK(session.recipe().strikes.empty());
    const physics::Destruction& destruction = *session.stage().simulation().destruction();
    double sum = 0.0;
    size_t near = 0;
    for (const physics::PieceId id : destruction.pieces()) {
        const physics::SolidPiece& solid = *destruction.solid(id);
        sum += solid.mass.volume;
        if (glm::distance(solid.mass.centre_of_mass, glm::dvec3(middle)) < 0.6) ++near; // by its place in the pane
    }
    CHECK(near > destruction.pieces().size() / 2);
    CHECK(sum
          == doctest::Approx(
                 fracture::signed_volume(session.object().mesh().positions, session.object().mesh().triangles))
                 .epsilon(1e-6));
    session.undo();
    CHECK_FALSE(session.broken());
    session.redo();
    CHECK_FALSE(session.broken());
    CHECK(session.recipe().world.breakable);
    CHECK(session.pieces().first(glm::dvec3(middle) + glm::dvec3(0.0, 0.0, 3.0), {0.0, 0.0, -1.0})
          == std::nullopt); // there are no pieces
}

TEST_CASE("session: it exports the recipe's pieces before the break and the pieces on the stage after it") {
    const Folder folder;
    Room room("shape:animal", 20);
    if (!room.device) return;
    Session& session = *room.session;
    const auto exported = [&](const fs::path& name, PiecesAs as) {
        session.activity().say({});
        session.files().export_pieces(folder.path / name, as);
        REQUIRE(room.soon([&] { return !session.activity().work() && !session.activity().message().text.empty(); }));
        CHECK_MESSAGE(!session.activity().message().fault, session.activity().message().text);
        return read_text(folder.path / name);
    };
    const auto recipe_pieces = [&] {
        const FractureOptions options = session.recipe();
        const Input input = load_input(options, true);
        (void)write_pieces({.output = (folder.path / "line.glb").string()}, options, input,
                           break_input(input, options));
        return read_text(folder.path / "line.glb");
    };
    // Returns the export of a replay of the current log, without a window.
    const auto replayed = [&](PiecesAs as, const std::string& ending) {
        session.files().save_replay(folder.path / "run.log");
        const ReplayLog log = read_replay_log(folder.path / "run.log");
        const Input source = load_input(log.recipe, true);
        const auto fragments = std::make_shared<const fracture::Fragments>(
            break_input(placed_on_stage(source, log.recipe.world), log.recipe).fragments);
        Simulation simulation(log.recipe.material);
        Player player(log);
        simulation.observe(&player);
        follow(log, simulation);
        simulation.start(*fragments, log.recipe.world);
        schedule(log, simulation);
        while (!player.done()) simulation.step();
        CHECK_MESSAGE(!player.difference(), (player.difference() ? player.difference()->what : ""));
        const std::string file = (folder.path / ("line" + ending)).string();
        (void)write_state({.output = file}, as, log.recipe, source, snapshot(simulation, fragments));
        return read_text(file);
    };
    CHECK(exported("whole.glb", PiecesAs::made) == recipe_pieces());
    room.break_it();
    for (int k = 0; k < 40; ++k) session.update(frame);
    session.playback.paused = true; // frames go on during the export
    CHECK(exported("made.glb", PiecesAs::made) == recipe_pieces());
    CHECK(exported("lie.ply", PiecesAs::they_lie) == replayed(PiecesAs::they_lie, ".ply"));

    // A mesh cut by blows, and then a mesh on the ground broken as a whole.
    session.playback.paused = false;
    session.reset();
    WorldOptions world;
    world.breakable = world.anchored = true;
    session.edit(SetWorld{world});
    REQUIRE(room.soon([&] { return !session.activity().work(); }));
    const glm::dvec3 middle = 0.5 * glm::dvec3(session.stage().home_bounds().min + session.stage().home_bounds().max);
    const auto hit = session.object().first_hit(middle + glm::dvec3(0.0, 0.0, 3.0), {0.0, 0.0, -1.0});
    REQUIRE(hit);
    session.strike(hit->point, {0.0, 0.0, -1.0});
    REQUIRE(room.soon([&] { return session.counts() && session.counts()->pieces > 3; }));
    session.playback.paused = true;
    for (const PiecesAs as : {PiecesAs::they_lie, PiecesAs::made})
        CHECK(exported("cut.ply", as) == replayed(as, ".ply"));
    session.playback.paused = false;
    session.reset();
    room.break_it();
    for (int k = 0; k < 20; ++k) session.update(frame);
    session.playback.paused = true;
    CHECK(session.counts()->pieces >= 15);
    CHECK(exported("fallen.ply", PiecesAs::they_lie) == replayed(PiecesAs::they_lie, ".ply"));
    FractureOptions cut = session.recipe();
    cut.world.breakable = false;
    const Input input = load_input(cut, true);
    (void)write_pieces({.output = (folder.path / "line.ply").string()}, cut, input, break_input(input, cut));
    CHECK(exported("fallen_made.ply", PiecesAs::made) == read_text(folder.path / "line.ply"));

    // A cancelled export, and one to a missing folder: no file, and a message.
    session.activity().say({});
    session.files().export_pieces(folder.path / "none" / "a.glb", PiecesAs::they_lie);
    REQUIRE(room.soon([&] { return session.activity().message().fault; }));
    session.activity().say({});
    session.files().export_pieces(folder.path / "called_off.glb", PiecesAs::they_lie);
    session.activity().cancel();
    REQUIRE(room.soon([&] { return !session.activity().work(); }));
    session.update(frame); // delivers the message
    CHECK_FALSE(session.activity().message().fault);
    // The export was faster than the cancellation.
    const bool done = session.activity().message().text.find("called_off") != std::string::npos;
    CHECK(fs::exists(folder.path / "called_off.glb") == done);
    for (const auto& entry : fs::directory_iterator(folder.path)) CHECK(entry.path().extension() != ".tmp");
}
