#include "tools/scenario/replay/player.h"

#include <cstdio>
#include <vector>

#include "tools/scenario/base/environment.h"
#include "tools/scenario/recipe/json_reader.h"
#include "tools/scenario/replay/body_text.h"

namespace brittle::tools {

namespace {

// "body 3 (pieces 4, 17, 18 and 5 more) at (0.1, 0.2, 0.3) m, moving at (0, -1, 0) m/s".
std::string describe(const Simulation& simulation, uint64_t index) {
    constexpr size_t max_named = 3;
    const physics::World& world = simulation.world();
    const physics::BodyId body = world.bodies()[index];
    const std::vector<uint32_t> pieces = simulation.pieces_of(body);
    std::string text = "body " + std::to_string(index) + " (";
    if (pieces.empty())
        text += "a ball";
    else
        text += pieces.size() == 1 ? "piece " : "pieces ";
    for (size_t k = 0; k < pieces.size() && k < max_named; ++k)
        text += (k == 0 ? "" : ", ") + std::to_string(pieces[k]);
    if (pieces.size() > max_named) text += " and " + std::to_string(pieces.size() - max_named) + " more";
    const glm::vec3 p = world.pose(body).position, v = world.linear_velocity(body);
    char motion[200];
    std::snprintf(motion, sizeof motion, ") at (%.9g, %.9g, %.9g) m, moving at (%.9g, %.9g, %.9g) m/s",
                  static_cast<double>(p.x), static_cast<double>(p.y), static_cast<double>(p.z),
                  static_cast<double>(v.x), static_cast<double>(v.y), static_cast<double>(v.z));
    return text + motion;
}

} // namespace

Player::Player(const ReplayLog& log) : log_(log) {}

void Player::started(const Simulation& simulation, std::span<const PreparedObject> objects, const WorldOptions&) {
    compared_ = 0;
    checks_ = {};
    difference_.reset();
    if (simulation.piece_count() != log_.pieces)
        difference_ = {0, std::to_string(log_.pieces) + " pieces were recorded, but the recipe now gives "
                              + std::to_string(simulation.piece_count())};
    else if (const uint64_t hash = pieces_hash(objects); hash != log_.pieces_hash)
        difference_ = {0, "the pieces are not those recorded: hash " + hash_text(hash) + " instead of "
                              + hash_text(log_.pieces_hash)};
    compare(simulation);
}

void Player::stepped(const Simulation& simulation) {
    compare(simulation);
}

void Player::compare(const Simulation& simulation) {
    const std::string bodies = checks_.next(simulation.world());
    if (done()) return;
    const ReplayLog::State& recorded = log_.states[compared_++];
    const uint64_t hash = simulation.state_hash();
    if (difference_ || hash == recorded.hash) return;
    const uint64_t now = simulation.world().body_count();
    const uint64_t then = count_bodies(recorded.bodies).value_or(0);
    std::string what = std::to_string(then) + " bodies were recorded, but there are " + std::to_string(now);
    if (now == then) {
        what = "state hash " + hash_text(hash) + " instead of " + hash_text(recorded.hash);
        if (const auto first = first_difference(bodies, recorded.bodies))
            what += "; the first to differ of " + std::to_string(now) + " is " + describe(simulation, *first);
        else
            what += "; all bodies are equal, so bonds, sleep states or pending breaks differ";
    }
    difference_ = {simulation.steps(), what};
}

void follow(const ReplayLog& log, Simulation& simulation) {
    simulation.commit_as(physics::Timing::scripted, log.commits);
}

void schedule(const ReplayLog& log, Simulation& simulation) {
    for (const auto& [step, action] : log.actions) simulation.schedule(step, action);
}

std::string other_build(const ReplayLog& log) {
    const nlohmann::ordered_json own = environment();
    std::string text;
    for (const char* key : {"brittle", "commit", "compiler", "build", "system", "processor"}) {
        const auto recorded = log.build.find(key);
        if (recorded != log.build.end() && *recorded == own[key]) continue;
        text += (text.empty() ? "" : ", ") + std::string(key) + " "
                + (recorded == log.build.end() ? "unknown" : shown(*recorded)) + " instead of " + shown(own[key]);
    }
    return text;
}

} // namespace brittle::tools
