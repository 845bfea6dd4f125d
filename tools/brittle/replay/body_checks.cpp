#include "tools/brittle/replay/body_checks.h"

#include <algorithm>
#include <bit>
#include <charconv>
#include <cstdio>
#include <initializer_list>

namespace brittle::tools {

namespace {

constexpr uint64_t most_bodies = 100'000'000; // a damaged count must not add up to nonsense

uint16_t check_of(const physics::World& world, physics::BodyId body) {
    const physics::Pose pose = world.pose(body);
    const glm::vec3 linear = world.linear_velocity(body), angular = world.angular_velocity(body);
    const glm::quat& q = pose.orientation;
    uint64_t hash = 0xcbf29ce484222325; // FNV-1a on words
    for (const float value : {pose.position.x, pose.position.y, pose.position.z, q.w, q.x, q.y, q.z, linear.x,
                              linear.y, linear.z, angular.x, angular.y, angular.z}) {
        hash ^= std::bit_cast<uint32_t>(value);
        hash *= 0x100000001b3;
    }
    return static_cast<uint16_t>(hash ^ (hash >> 16) ^ (hash >> 32) ^ (hash >> 48));
}

void append_run(std::string& text, uint64_t& run) {
    if (run > 0) text += "(" + std::to_string(run) + ")";
    run = 0;
}

// One body's digits, or a run without any.
struct Token {
    std::string_view digits;
    uint64_t bodies = 1;
};

// Takes a token off the front; nothing where there is none.
std::optional<Token> take(std::string_view& text) {
    if (text.starts_with('(')) {
        Token run;
        const char* end = text.data() + text.size();
        const auto [at, error] = std::from_chars(text.data() + 1, end, run.bodies);
        if (error != std::errc{} || at == end || *at != ')' || run.bodies == 0 || run.bodies > most_bodies)
            return {};
        text.remove_prefix(static_cast<size_t>(at - text.data()) + 1);
        return run;
    }
    const std::string_view digits = text.substr(0, 4);
    if (digits.size() < 4 || digits.find_first_not_of("0123456789abcdef") != digits.npos) return {};
    text.remove_prefix(4);
    return Token{digits};
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

std::optional<uint64_t> count_bodies(std::string_view text) {
    uint64_t count = 0;
    while (!text.empty()) {
        const std::optional<Token> token = take(text);
        if (!token) return {};
        count += token->bodies;
        if (count > most_bodies) return {};
    }
    return count;
}

std::optional<uint64_t> first_difference(std::string_view a, std::string_view b) {
    uint64_t body = 0;
    Token left{{}, 0}, right{{}, 0};
    const auto refill = [](Token& token, std::string_view& text) {
        if (token.bodies > 0) return true;
        const std::optional<Token> next = take(text);
        token = next.value_or(Token{{}, 0});
        return next.has_value();
    };
    while (refill(left, a) && refill(right, b)) {
        if (left.digits != right.digits) return body;
        const uint64_t both = std::min(left.bodies, right.bodies);
        body += both;
        left.bodies -= both;
        right.bodies -= both;
    }
    return {};
}

} // namespace brittle::tools
