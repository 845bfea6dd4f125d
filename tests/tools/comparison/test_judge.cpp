// The judge of tools/compare --physics: closed forms pass, and what misses its bound does not.
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <functional>
#include <numbers>

#include <doctest/doctest.h>

#include "tools/bench/bounds.h"
#include "tools/bench/scenes.h"
#include "tools/bench/theory.h"
#include "tools/comparison/physics/judge.h"
#include "tools/comparison/physics/scenes.h"

using namespace brittle::comparison;
namespace tools = brittle::tools;

namespace {

// Moves a body from its start, `seconds` later.
using Motion = std::function<void(size_t body, double seconds, BodyPose& pose)>;

Trajectory trajectory_of(const RigidScene& scene, const Motion& move) {
    Trajectory made{.bodies = static_cast<uint32_t>(scene.bodies.size())};
    for (uint32_t step = 0; step <= scene.steps; step += scene.steps_a_record) {
        for (size_t body = 0; body < scene.bodies.size(); ++body) {
            made.poses.push_back(scene.bodies[body].numbers.pose);
            move(body, step * scene.numbers.step, made.poses.back());
        }
        ++made.records;
    }
    return made;
}
std::string reason(const char* name, const Motion& move) {
    const SceneInfo& info = scene_info(name);
    const RigidScene scene = make_scene(info);
    return judge(info, scene, trajectory_of(scene, move)).reason();
}
bool says(const std::string& reason, const std::string& part) {
    return reason.find(part) != std::string::npos;
}
void nothing(size_t, double, BodyPose&) {}

} // namespace

TEST_CASE("judge: files that are missing, of another kind, too short or too long are refused by name") {
    const std::filesystem::path folder = std::filesystem::temp_directory_path() / "brittle_test_judge";
    std::filesystem::create_directories(folder);
    const std::string file = folder / "file";
    const auto message = [&](const auto& read) {
        try {
            (void)read(file);
        } catch (const std::runtime_error& error) {
            return std::string(error.what());
        }
        return std::string();
    };
    const auto is_refused = [&](const auto& read) { return says(message(read), file); };
    std::filesystem::remove(file);
    CHECK(is_refused(read_scene));
    CHECK(is_refused(read_poses));
    std::ofstream(file) << "";
    CHECK(is_refused(read_scene));
    CHECK(is_refused(read_poses));

    const RigidScene scene = make_scene(scene_info("slope_below"));
    write_scene(file, scene);
    CHECK(is_refused(read_poses));
    const RigidScene again = read_scene(file);
    REQUIRE(again.bodies.size() == scene.bodies.size());
    CHECK(again.steps == scene.steps);
    CHECK(again.bodies[1].fixed);
    CHECK(again.bodies[1].corners == scene.bodies[1].corners);
    CHECK(again.bodies[0].numbers.pose.orientation == scene.bodies[0].numbers.pose.orientation);
    const auto size = std::filesystem::file_size(file);
    for (uintmax_t length = 0; length < size; length += 7) {
        std::filesystem::resize_file(file, length);
        CHECK(is_refused(read_scene));
        write_scene(file, scene);
    }

    const Trajectory trajectory = trajectory_of(scene, nothing);
    write_poses(file, trajectory);
    CHECK(is_refused(read_scene));
    CHECK(read_poses(file).poses.size() == trajectory.poses.size());
    std::filesystem::resize_file(file, std::filesystem::file_size(file) + 8);
    CHECK(is_refused(read_poses));
    std::filesystem::resize_file(file, 100);
    CHECK(is_refused(read_poses));
    std::filesystem::remove_all(folder);
}

TEST_CASE("judge: scenes are finite, with unit orientations and solids around their centres of mass") {
    for (const SceneInfo& info : scene_infos()) {
        CAPTURE(info.name);
        const RigidScene scene = make_scene(info);
        CHECK(scene.steps % scene.steps_a_record == 0);
        CHECK(!scene.bodies.empty());
        for (const RigidBody& body : scene.bodies) {
            const Numbers4& q = body.numbers.pose.orientation;
            CHECK(std::hypot(std::hypot(q[0], q[1]), std::hypot(q[2], q[3])) == doctest::Approx(1.0).epsilon(1e-6));
            CHECK(body.numbers.mass > 0.0);
            for (size_t axis = 0; axis < 3; ++axis) {
                CHECK(body.numbers.moments[axis] > 0.0);
                double low = 0.0, high = 0.0;
                for (const Numbers3& corner : body.corners) {
                    low = std::min(low, corner[axis]);
                    high = std::max(high, corner[axis]);
                }
                CHECK(low < 0.0);
                CHECK(high > 0.0);
            }
        }
    }
    CHECK(make_scene(scene_info("stack_20")).bodies.size() == 20);
    CHECK_THROWS_WITH((void)scene_info("nothing"), doctest::Contains("there is no scene 'nothing', only stack_20"));
}

TEST_CASE("judge: the axes of a body are its principal axes") {
    // The keystone of an arch is upright; its neighbours are turned.
    const RigidScene scene = make_scene(scene_info("arch_13"));
    for (const RigidBody& body : scene.bodies) {
        // Products of inertia of the corners vanish where those of the prism do.
        double xy = 0.0, xz = 0.0, yz = 0.0, sum = 0.0;
        for (const Numbers3& p : body.corners) {
            xy += p[0] * p[1];
            xz += p[0] * p[2];
            yz += p[1] * p[2];
            sum += p[0] * p[0] + p[1] * p[1] + p[2] * p[2];
        }
        CHECK(std::abs(xz) < 1e-5 * sum);
        CHECK(std::abs(yz) < 1e-5 * sum);
        CHECK(std::abs(xy) < 1e-3 * sum);
    }
}

TEST_CASE("judge: what stands passes, and what moves by more than 5 mm does not") {
    CHECK(reason("stack_20", nothing) == "");
    CHECK(reason("mass_ratio_10", nothing) == "");
    CHECK(reason("card_house_4", nothing) == "");
    const auto shift = [](double most) {
        return [most](size_t body, double seconds, BodyPose& pose) {
            if (body == 19) pose.position[2] += most * seconds / 30.0;
        };
    };
    CHECK(reason("stack_20", shift(0.0049)) == "");
    CHECK(reason("stack_20", shift(0.0051)) == "moves by 5.1 mm");
    CHECK(says(reason("stack_20", shift(0.6)), "falls within 25"));
}

TEST_CASE("judge: an arch falls or stands by its thickness") {
    const auto fall = [](size_t body, double seconds, BodyPose& pose) {
        if (body < 15) pose.position[1] -= 0.5 * tools::earth_gravity * seconds * seconds;
    };
    CHECK(reason("arch_09", nothing) == "stands");
    CHECK(reason("arch_09", fall) == "");
    CHECK(reason("arch_13", nothing) == "");
    CHECK(says(reason("arch_13", fall), "falls within 0.2 s"));
}

TEST_CASE("judge: a box slides as far as Coulomb's law says") {
    const auto slide = [](double share) {
        return [share](size_t body, double seconds, BodyPose& pose) {
            const double angle = std::atan(slope_friction) + 0.5 * std::numbers::pi / 180.0;
            const double way = share * 0.5 * tools::earth_gravity * (std::sin(angle) - slope_friction * std::cos(angle))
                               * seconds * seconds;
            if (body != 0) return;
            pose.position[0] -= way * std::cos(angle);
            pose.position[1] -= way * std::sin(angle);
        };
    };
    CHECK(reason("slope_above", slide(1.0)) == "");
    CHECK(reason("slope_above", slide(0.91)) == "");
    CHECK(says(reason("slope_above", slide(0.89)), "slides 1.5"));
    CHECK(says(reason("slope_above", nothing), "slides 0.000 m"));
    CHECK(reason("slope_below", nothing) == "");
    CHECK(says(reason("slope_below", slide(0.01)), "slides by"));
}

TEST_CASE("judge: dominoes fall at the speed of the theory") {
    const double speed = tools::domino_wave_speed({});
    const auto wave = [&](double share) {
        return [share, speed](size_t body, double seconds, BodyPose& pose) {
            const tools::Dominoes row;
            if (seconds > static_cast<double>(body) * (row.gap + row.thickness) / (share * speed))
                pose.orientation = {0.0, 0.0, -std::sin(0.1), std::cos(0.1)};
        };
    };
    CHECK(!says(reason("dominoes", wave(1.0)), "speed"));
    CHECK(!says(reason("dominoes", wave(0.93)), "speed"));
    CHECK(says(reason("dominoes", wave(0.87)), "speed / sqrt(g h)"));
    CHECK(says(reason("dominoes", wave(1.15)), "speed / sqrt(g h)"));
    CHECK(says(reason("dominoes", nothing), "the wave dies"));
}

TEST_CASE("judge: pieces that hang in the air, fall too slowly, or sink into the ground or each other are found") {
    CHECK(says(reason("pile_300", nothing), "falls 0.000 m in the first 0.2 s"));
    CHECK(says(reason("pile_300", nothing), "its centre of mass sinks 0.000 m"));
    const auto fall = [](double gravity, double ground) {
        return [gravity, ground](size_t, double seconds, BodyPose& pose) {
            pose.position[1] -= std::min(0.3 + ground, 0.5 * gravity * seconds * seconds);
        };
    };
    // The whole bunny lands on its feet: a pile of its own kind.
    CHECK(reason("pile_300", fall(tools::earth_gravity, 0.0)) == "");
    CHECK(says(reason("pile_300", fall(0.5 * tools::earth_gravity, 0.0)), "falls 0.098 m in the first 0.2 s"));
    CHECK(says(reason("pile_300", fall(tools::earth_gravity, 0.01)), "through the ground"));
    const auto flat = [](size_t, double seconds, BodyPose& pose) {
        pose.position[1] -= std::min(0.3, 0.5 * tools::earth_gravity * seconds * seconds);
        if (seconds > 1.0) pose.position[0] *= 0.5;
    };
    CHECK(says(reason("pile_300", flat), "bodies more than a fifth inside another"));
    const auto pressed = [](size_t body, double seconds, BodyPose& pose) {
        pose.position[1] -= std::min(0.3, 0.5 * tools::earth_gravity * seconds * seconds);
        if (seconds > 1.0 && body % 8 == 0) pose.position[0] += 0.02;
    };
    CHECK(says(reason("pile_300", pressed), "bodies overlap by up to 1"));
    const auto burst = [](size_t, double seconds, BodyPose& pose) {
        pose.position[1] -= std::min(0.3, 0.5 * tools::earth_gravity * seconds * seconds);
        if (seconds > 1.0)
            for (double& x : pose.position) x *= 1.0 + 10.0 * (seconds - 1.0);
    };
    CHECK(says(reason("pile_300", burst), "gains energy"));
}
