#include "tools/scenario/replay/body_checks.h"

#include <bit>
#include <cstdio>
#include <initializer_list>

namespace brittle::tools {

namespace {

uint16_t check_of(const physics::World& world, physics::BodyId body) {
    const physics::Pose pose = world.pose(body);
    const glm::vec3 linear = world.linear_velocity(body), angular = world.angular_velocity(body);
    const glm::quat& q = pose.orientation;
    uint64_t hash = 0xcbf29ce484222325; // FNV-1a on words
    for (const float value : {pose.position.x, pose.position.y, pose.position.z, q.w, q.x, q.y, q.z, linear.x, linear.y,
                              linear.z, angular.x, angular.y, angular.z}) {
        hash ^= std::bit_cast<uint32_t>(value);
        hash *= 0x100000001b3;
    }
    return static_cast<uint16_t>(hash ^ (hash >> 16) ^ (hash >> 32) ^ (hash >> 48));
}

void append_run(std::string& text, uint64_t& run) {
    if (run > 0) text += "(" + std::to_string(run) + ")";
    run = 0;
}

} // namespace

std::string BodyChecks::next(const physics::World& world) {
    std::string text;
    uint64_t run = 0;
    for (const physics::BodyId body : world.bodies()) {
        if (body.value >= last_.size()) last_.resize(size_t{body.value} + 1);
        const uint16_t check = check_of(world, body);
        if (last_[body.value] == check) {
            ++run;
            continue;
        }
        last_[body.value] = check;
        append_run(text, run);
        char digits[5];
        std::snprintf(digits, sizeof digits, "%04x", static_cast<unsigned>(check));
        text += digits;
    }
    append_run(text, run);
    return text;
}

} // namespace brittle::tools
