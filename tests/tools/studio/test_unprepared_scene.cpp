// A scene that is shown while its objects are being prepared. Results of the worker arrive in Session::update() alone, so
// a session that was not updated is certain to be unprepared.
#include <algorithm>
#include <atomic>
#include <chrono>
#include <cstdlib>
#include <filesystem>
#include <optional>
#include <string>
#include <thread>
#include <vector>

#include <doctest/doctest.h>

#include "tests/tools/studio/room.h"
#include "tests/tools/support.h"
#include "tools/scenario/recipe/recipe.h"

using namespace brittle;
using namespace brittle::tools;
using test::Folder, test::frame, test::Room;

namespace {

constexpr glm::dvec3 down(0.0, -1.0, 0.0);

// A fixed floor, two equal vases of which one is turned, and a large ball of clusters.
FractureOptions shelf(const Folder& folder, const std::string& vase = "shape:cube") {
    FractureOptions options;
    read_recipe(folder.write("scene.json", R"({"brittle": 2, "objects": [
        {"name": "floor", "mesh": "shape:cube", "scale": [3, 0.1, 3], "translation": [0, -0.1, 0], "fixed": true},
        {"name": "vase", "mesh": ")" + vase + R"(", "material": "ceramic", "scale": 0.2, "translation": [0.5, 1, 0]},
        {"name": "jar", "mesh": ")" + vase + R"(", "material": "ceramic", "scale": 0.2, "translation": [-0.5, 1, 0],
         "rotation": [0, 30, 0]},
        {"name": "ball", "mesh": "shape:icosphere:5", "material": "stone", "scale": 0.3, "translation": [0, 1, -1]}]})"),
                options);
    return options;
}

size_t pixels_that_differ(const engine::Bitmap& a, const engine::Bitmap& b) {
    REQUIRE(a.pixels.size() == b.pixels.size());
    size_t count = 0;
    for (size_t k = 0; k < a.pixels.size(); k += 4) {
        int most = 0;
        for (size_t c = 0; c < 3; ++c) most = std::max(most, std::abs(int{a.pixels[k + c]} - int{b.pixels[k + c]}));
        count += most > 8;
    }
    return count;
}

bool stands(Room& room) {
    return room.soon([&] { return room.session->object().is_prepared() && room.session->quiet(); });
}

// The height of what is below a point.
double height(const Session& session, double x, double z) {
    const auto hit = session.first_piece(glm::dvec3(x, 5.0, z), down);
    REQUIRE(hit);
    return hit->point.y;
}

} // namespace

TEST_CASE("unprepared scene: it looks as it will stand, and stands once it is prepared") {
    const Folder folder;
    const FractureOptions options = shelf(folder);
    Room room(options, Object::open(options));
    if (!room.device) return;
    Session& session = *room.session;
    CHECK_FALSE(session.object().is_prepared());
    CHECK_FALSE(session.broken());
    CHECK_FALSE(session.quiet());
    CHECK_FALSE(session.pieces().contains(0));
    CHECK(session.object().meshes().batches.size() == 3); // one for both vases
    const engine::Bitmap shown = room.picture();
    session.hide(1, true);
    const engine::Bitmap without = room.picture();
    CHECK(pixels_that_differ(shown, without) > 20);
    session.hide(1, false);
    CHECK(room.picture().pixels == shown.pixels);

    REQUIRE(stands(room));
    CHECK(session.broken());
    CHECK_FALSE(session.playing());
    CHECK(session.counts()->pieces == 4);
    const engine::Bitmap standing = room.picture();
    CHECK(pixels_that_differ(shown, standing) * 200 < shown.pixels.size() / 4);
    session.hide(1, true);
    CHECK(pixels_that_differ(without, room.picture()) * 200 < shown.pixels.size() / 4);
    CHECK(session.activity().message().text.empty());
}

TEST_CASE("unprepared scene: play, a blow and a ball wait until it stands, and a reset forgets them") {
    const Folder folder;
    const FractureOptions options = shelf(folder);
    const auto open = [&] { return Room(options, Object::open(options)); };
    Room played = open();
    if (!played.device) return;
    played.session->break_all();
    CHECK_FALSE(played.session->playing());
    CHECK(played.session->activity().message().text.find("as soon as") != std::string::npos);
    CHECK(played.soon([&] { return played.session->playing(); }));
    CHECK(played.session->activity().message().text.empty());

    Room struck = open();
    struck.session->strike_along({0.5, 5.0, 0.0}, down);
    CHECK(struck.soon([&] { return struck.session->counts() && struck.session->counts()->pieces > 5; }));

    Room shot = open();
    shot.session->shoot({0.5f, 1.0f, 3.0f}, {0.0f, 0.0f, -1.0f});
    CHECK(shot.soon([&] { return shot.session->stage().simulation().balls().size() == 1; }));

    Room stepped = open();
    stepped.session->step_once();
    CHECK(stepped.soon([&] { return stepped.session->steps() == 1; }));

    Room forgetful = open();
    forgetful.session->break_all();
    forgetful.session->reset();
    REQUIRE(stands(forgetful));
    for (int k = 0; k < 10; ++k) forgetful.session->update(frame);
    CHECK_FALSE(forgetful.session->playing());
    CHECK(forgetful.session->steps() == 0);
}

TEST_CASE("unprepared scene: a ray finds the object that it finds once it stands") {
    const Folder folder;
    const FractureOptions options = shelf(folder);
    Room room(options, Object::open(options));
    if (!room.device) return;
    Session& session = *room.session;
    const auto found = [&] {
        std::vector<std::optional<uint32_t>> objects;
        for (int x = -8; x <= 8; ++x)
            for (int z = -8; z <= 2; ++z)
                objects.push_back(session.first_object(glm::dvec3(0.11 * x, 5.0, 0.17 * z), down, true));
        return objects;
    };
    const auto all = found();
    for (const uint32_t object : {0u, 1u, 2u, 3u}) CHECK(std::ranges::count(all, object) > 3);
    session.hide(3, true);
    session.lock(1, true);
    const auto fewer = found();
    CHECK(std::ranges::count(fewer, 3u) + std::ranges::count(fewer, 1u) == 0);
    CHECK(session.first_object({0.5, 5.0, 0.0}, down) == 1u); // locked against selection alone
    CHECK_FALSE(session.first_object({9.0, 5.0, 0.0}, down));
    REQUIRE(stands(room));
    CHECK(found() == fewer);
    session.hide(3, false);
    session.lock(1, false);
    CHECK(found() == all);
}

TEST_CASE("unprepared scene: objects move and change before they are prepared") {
    const Folder folder;
    const FractureOptions options = shelf(folder);
    Room room(options, Object::open(options));
    if (!room.device) return;
    Session& session = *room.session;
    const engine::Bitmap before = room.picture();
    std::vector<ObjectPlacement> places{session.recipe().objects[1].placement};
    places[0].translation.z = -0.6; // within the bounds that the camera looks at
    const std::vector<uint32_t> vase{1};
    session.set_places(vase, places, session.begin_gesture());
    CHECK_FALSE(session.object().is_prepared());
    const engine::Bitmap moved = room.picture();
    CHECK(pixels_that_differ(before, moved) > 20);
    REQUIRE(stands(room));
    CHECK(pixels_that_differ(moved, room.picture()) * 200 < moved.pixels.size() / 4);
    CHECK(height(session, 0.5, -0.6) == doctest::Approx(1.2));
    CHECK(height(session, 0.5, 0.0) == doctest::Approx(0.0)); // the floor
    session.undo();
    REQUIRE(stands(room));
    CHECK(height(session, 0.5, 0.0) == doctest::Approx(1.2));
}

TEST_CASE("unprepared scene: it is not exported, and a failure leaves it shown until the next attempt") {
    const Folder folder;
    const std::string wedge = "OFF\n4 4 0\n0 0 0\n1 0 0\n0 1 0\n0 0 1\n3 0 2 1\n3 0 1 3\n3 1 2 3\n3 2 0 3\n";
    folder.write("wedge.off", wedge);
    const FractureOptions options = shelf(folder, "wedge.off");
    const auto object = Object::open(options);
    std::filesystem::remove(folder.path / "wedge.off");
    Room room(options, object);
    if (!room.device) return;
    Session& session = *room.session;
    session.files().export_pieces(folder.path / "pieces.glb");
    CHECK(session.activity().message().text.find("being prepared") != std::string::npos);
    CHECK_FALSE(std::filesystem::exists(folder.path / "pieces.glb"));
    const engine::Bitmap shown = room.picture();
    session.break_all();
    REQUIRE(room.soon([&] { return session.quiet(); }));
    CHECK(session.activity().message().fault);
    CHECK(session.activity().message().text.find("wedge.off") != std::string::npos);
    CHECK_FALSE(session.object().is_prepared());
    CHECK_FALSE(session.playing());
    CHECK(room.picture().pixels == shown.pixels);
    folder.write("wedge.off", wedge);
    session.break_all();
    CHECK(room.soon([&] { return session.playing(); }));
}

TEST_CASE("unprepared scene: preparation that is cancelled ends, and begins again when it is needed") {
    const Folder folder;
    FractureOptions options = shelf(folder);
    options.threads = 1;
    CHECK_THROWS_AS((void)Object::open(options, [] { return true; }), Failure);
    for (int last = 0; last < 10; ++last) { // 4 objects are read, 3 meshes made and 3 prepared
        int asked = 0;
        CHECK_THROWS_AS((void)Object::load(options, {}, nullptr, [&] { return asked++ == last; }), Failure);
        CHECK(asked == last + 1);
    }
    Room room(options, Object::open(options));
    if (!room.device) return;
    Session& session = *room.session;
    session.activity().cancel();
    REQUIRE(room.soon([&] { return session.quiet(); }));
    if (session.object().is_prepared()) return; // it was faster
    CHECK_FALSE(session.broken());
    session.break_all();
    CHECK(room.soon([&] { return session.playing(); }));
}

TEST_CASE("unprepared scene: only the progress of its preparation changes the picture") {
    const Folder folder;
    const FractureOptions options = shelf(folder);
    Room room(options, Object::open(options));
    if (!room.device) return;
    Session& session = *room.session;
    std::atomic<int> results = 0;
    session.activity().wake_by([&] { ++results; });
    CHECK((session.only_works() || session.activity().has_results()));
    for (int k = 0; k < 3000 && !session.activity().has_results(); ++k)
        std::this_thread::sleep_for(std::chrono::milliseconds(10));
    CHECK(session.activity().has_results());
    CHECK_FALSE(session.only_works());
    REQUIRE(stands(room));
    CHECK_FALSE(session.only_works());
    const int before = results;
    session.files().open((folder.path / "scene.json").string());
    CHECK_FALSE(session.quiet());
    REQUIRE(stands(room));
    CHECK(results == before + 2); // the scene, and the scene prepared
}
