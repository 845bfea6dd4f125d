// Every scene under assets/scenes against its golden in tests/images/scenes: the last picture that `brittle render` makes of
// it. tools/update-goldens rewrites them; look at them then. Of a scene that fails and moves, the replay log is left beside
// the pictures.
#include <algorithm>
#include <cstdlib>
#include <filesystem>
#include <string>
#include <vector>

#include <doctest/doctest.h>
#include <unistd.h>

#include "engine/core/bitmap.h"
#include "tests/engine/support.h"
#include "tools/brittle/recipe.h"

namespace fs = std::filesystem;
using namespace brittle::engine;
using namespace brittle::engine::test;

TEST_CASE("every scene looks as it did") {
    std::string folder = (fs::temp_directory_path() / "brittle-scenes-XXXXXX").string();
    REQUIRE(mkdtemp(folder.data()) != nullptr);
    std::vector<fs::path> scenes;
    for (const auto& entry : fs::directory_iterator(BRITTLE_ASSETS "/scenes"))
        if (entry.path().extension() == ".json") scenes.push_back(entry.path());
    std::sort(scenes.begin(), scenes.end());
    REQUIRE(scenes.size() >= 9);
    for (const fs::path& scene : scenes) {
        const std::string name = scene.stem().string();
        CAPTURE(name);
        const std::string file = folder + "/" + name + ".png";
        const std::string log = folder + "/" + name + ".log";
        brittle::tools::FractureOptions options;
        brittle::tools::read_recipe(scene, options);
        const bool whole = options.picture.whole || options.picture.planes > 0; // nothing moves
        const std::string command = std::string("timeout 120 " BRITTLE_PROGRAM " render ") + scene.string()
                                    + " --size 480x300 --device cpu --validation -o " + file
                                    + (whole ? "" : " --record " + log) + " > " + folder + "/log 2>&1";
        REQUIRE(std::system(command.c_str()) == 0);
#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
        continue; // other code, other roundings: what falls lies elsewhere
#endif
        const auto image = read_png(file);
        REQUIRE(image);
        const GoldenCheck check = check_golden(*image, name, {}, golden_folder() + "/scenes");
        CHECK_MESSAGE(check.passed, check.message);
        if (check.passed || whole) continue;
        const std::string kept = BRITTLE_FAILURE_FOLDER "/" + name + ".log";
        fs::create_directories(BRITTLE_FAILURE_FOLDER);
        fs::copy_file(log, kept, fs::copy_options::overwrite_existing);
        FAIL_CHECK("brittle replay ", kept, " --render repeats it");
    }
    fs::remove_all(folder);
}
