// What a test case that fails prints, and that it repeats the run.
#include "tests/physics/run_log.h"

#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <string>

#include <doctest/doctest.h>

#include "tests/physics/bodies.h"
#include "tests/physics/convex_pieces.h"

using namespace brittle;
using namespace brittle::physics;
using namespace brittle::physics::test_bodies;

namespace {

// Both streams.
std::string output_of(const std::string& command) {
    std::string output;
    FILE* const pipe = popen((command + " 2>&1").c_str(), "r");
    REQUIRE(pipe);
    for (int c; (c = std::fgetc(pipe)) != EOF;) output += static_cast<char>(c);
    CHECK(pclose(pipe) != 0);
    return output;
}

// From the first of it on, to the end of the line.
std::string line_from(const std::string& text, const std::string& start) {
    const size_t begin = text.find(start);
    REQUIRE_MESSAGE(begin != std::string::npos, text);
    return text.substr(begin, text.find('\n', begin) - begin);
}

} // namespace

TEST_CASE("run log: on demand, a box isn't where it should be") {
    const char* const wanted = std::getenv("BRITTLE_FAILED_RUN");
    if (!wanted) return;
    test::Random random(std::strtoull(wanted, nullptr, 10));
    World world;
    RunLog log(std::string("a box falls, seed ") + wanted);
    INFO(log);
    const BodyId id = must_add(world, box(glm::vec3(0.1f), 2.0f, glm::vec3(0.0f, 1.0f, 0.0f)));
    for (int step = 0; step < 20; ++step) {
        world.step();
        log.look(world);
        if (step != 4) continue;
        const glm::vec3 impulse(random.direction());
        log.did("an impulse of ", impulse, " N s");
        world.apply_impulse(id, impulse, world.pose(id).position);
    }
    CHECK(world.pose(id).position.y > 2.0f);
}

TEST_CASE("run log: what a failed test prints repeats it alone, and prints it again") {
    const std::string program = std::filesystem::read_symlink("/proc/self/exe");
    const std::string first = output_of("BRITTLE_FAILED_RUN=7 '" + program + "' -tc='run log: on demand*'");
    const std::string command = line_from(first, "to run it alone: ").substr(17);
    const std::string again = output_of(command);
    for (const char* line : {"the run: a box falls, seed 7", "after step 5: an impulse of (", "state after step 16: ",
                             "state after step 20: ", "test cases: 1 | 0 passed | 1 failed", "to run it alone: "})
        CHECK(line_from(again, line) == line_from(first, line));
    const std::string other = output_of("BRITTLE_FAILED_RUN=8 '" + program + "' -tc='run log: on demand*'");
    CHECK(line_from(other, "state after step 4: ") == line_from(first, "state after step 4: "));
    CHECK(line_from(other, "state after step 8: ") != line_from(first, "state after step 8: "));
}
