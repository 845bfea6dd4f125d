// Every scene under assets/scenes against its goldens: the last picture by `brittle render` (tests/images/scenes), and
// the piece of each pixel before anything moves (NAME.ids.png), which is exact. tools/update-goldens rewrites them;
// look at the result. The runs of those that move repeat to the bit. A failing scene that moves leaves its replay log
// beside the pictures.
#include <cstdlib>
#include <filesystem>
#include <string>

#include <doctest/doctest.h>

#include "engine/core/bitmap.h"
#include "tests/engine/support.h"
#include "tests/tools/replays.h"
#include "tests/tools/scenes.h"
#include "tests/tools/support.h"

namespace fs = std::filesystem;
using namespace brittle::engine;
using namespace brittle::engine::test;
using namespace brittle::tools;
using namespace brittle::tools::test;

namespace {

void render_file(const fs::path& file, const std::string& options, const Folder& folder) {
    const std::string command = std::string("timeout 120 " BRITTLE_PROGRAM " render ") + file.string()
                                + " --size 480x300 --device cpu --validation " + options + " > " + folder / "log"
                                + " 2>&1";
    REQUIRE(std::system(command.c_str()) == 0);
}

void render(const std::string& scene, const std::string& options, const Folder& folder) {
    render_file(scene_file(scene), options, folder);
}

constexpr BitmapTolerance exact{.ignore = 0, .channel = 0, .fraction = 0.0};

} // namespace

TEST_CASE("scenes: every file has a test here") {
    CHECK(names_of<scene::All>() == scenes_where([](const FractureOptions&) { return true; }));
}

TEST_CASE_TEMPLATE_DEFINE("every scene looks as it did, and its run repeats to the bit", Scene, looks) {
    const Folder folder;
    const std::string name = name_of<Scene>();
    const std::string file = folder / (name + ".png");
    const std::string log = folder / (name + ".log");
    const FractureOptions options = recipe_of(name);
    const bool moves = !options.picture.whole && options.picture.planes == 0 && options.picture.frames > 0;
    render(name, "-o " + file + (moves ? " --record " + log : ""), folder);
    const auto keep_log = [&] {
        const std::string kept = BRITTLE_FAILURE_FOLDER "/" + name + ".log";
        fs::create_directories(BRITTLE_FAILURE_FOLDER);
        fs::copy_file(log, kept, fs::copy_options::overwrite_existing);
        return kept;
    };
    if (moves) {
        const ReplayLog run = read_replay_log(log);
        CHECK(run.states.size() > options.picture.frames); // a step a frame at least
        if (const std::optional<Difference> difference = replayed(run, started(run.recipe)))
            FAIL_CHECK("step ", difference->step, ": ", difference->what, "; brittle replay ", keep_log());
    }
#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
    return; // other code rounds differently, so fallen pieces lie elsewhere
#endif
    const auto image = read_png(file);
    REQUIRE(image);
    const GoldenCheck check = check_golden(*image, name, {}, golden_folder() + "/scenes");
    CHECK_MESSAGE(check.passed, check.message);
    if (!check.passed && moves) FAIL_CHECK("brittle replay ", keep_log(), " --render repeats it");
}
TEST_CASE_TEMPLATE_APPLY(looks, scene::All);

TEST_CASE_TEMPLATE_DEFINE("every pixel of every scene shows the piece that it did, until something moves", Scene, ids) {
    const Folder folder;
    const std::string name = name_of<Scene>();
    const std::string file = folder / (name + "_ids.png");
    render(name, "--frames 0 -o " + folder / "picture.png" + " --ids " + file, folder);
    const auto ids = read_png(file);
    REQUIRE(ids);
    const GoldenCheck check = check_golden(*ids, name + ".ids", exact, golden_folder() + "/scenes");
    CHECK_MESSAGE(check.passed, check.message);
}
TEST_CASE_TEMPLATE_APPLY(ids, scene::All);

TEST_CASE("every world of several objects looks as it did before anything moves, and at its end") {
    for (const auto& entry : fs::directory_iterator(BRITTLE_ASSETS "/worlds")) {
        const Folder folder;
        const std::string name = entry.path().stem().string();
        CAPTURE(name);
        for (const bool end : {false, true}) {
            const std::string file = folder / (name + ".png");
            render_file(entry.path(), (end ? "-o " : "--frames 0 -o ") + file, folder);
#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
            continue;
#endif
            const auto image = read_png(file);
            REQUIRE(image);
            const GoldenCheck check =
                check_golden(*image, name + (end ? "" : ".start"), {}, golden_folder() + "/worlds");
            CHECK_MESSAGE(check.passed, check.message);
        }
    }
}

TEST_CASE("a single pixel with another piece is found") {
    if (is_updating_goldens()) return;
    auto ids = read_png(golden_folder() + "/scenes/figure_11_icosphere_falls_apart.ids.png");
    REQUIRE(ids);
    const auto check = [&] {
        return check_golden(*ids, "figure_11_icosphere_falls_apart.ids", exact, golden_folder() + "/scenes").passed;
    };
    CHECK(check());
    uint8_t* const middle = ids->at(ids->width / 2, ids->height / 2);
    REQUIRE(middle[3] == 255); // a piece
    middle[2] ^= 1;
    CHECK_FALSE(check());
    middle[2] ^= 1;
    uint8_t* const corner = ids->at(0, 0);
    REQUIRE(corner[3] == 0); // none
    corner[3] = 255;
    CHECK_FALSE(check());
}
