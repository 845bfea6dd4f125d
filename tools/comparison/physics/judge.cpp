#include "tools/comparison/physics/judge.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <limits>
#include <numbers>

#include <glm/geometric.hpp>
#include <glm/gtc/quaternion.hpp>

#include "tools/bench/bounds.h"
#include "tools/bench/overlap.h"
#include "tools/bench/samples.h"
#include "tools/bench/theory.h"

namespace brittle::comparison {

namespace {

// Positions, m, and orientations have single precision in most engines.
constexpr double same_pose = 1e-4;
constexpr double unit_length = 1e-3; // deviation of the length of an orientation
// Of the energy that gravity and the start gave; an engine in single precision stays far below.
constexpr double max_energy_gain = 0.01;
constexpr double free_fall_seconds = 0.2, max_free_fall_error = 0.1; // share of the distance
constexpr double farthest = 1e5;       // m, of a body from the origin; within 10 s one falls 500 m
constexpr uint32_t max_vertices = 256; // of a hull that is judged

template<class... Values>
std::string text(const char* format, Values... values) {
    std::array<char, 200> buffer{};
    std::snprintf(buffer.data(), buffer.size(), format, values...);
    return buffer.data();
}

std::string length_text(double metres) {
    return metres < 1.0 ? text("%.1f mm", 1e3 * metres) : text("%.3g m", metres);
}

// "2 bodies WHAT (3, 7)"; the first three numbers.
std::string bodies_text(const std::vector<size_t>& bodies, const std::string& what) {
    std::string words = text("%zu bod%s ", bodies.size(), bodies.size() == 1 ? "y" : "ies") + what + " (";
    for (size_t k = 0; k < bodies.size() && k < 3; ++k) words += text(k == 0 ? "%zu" : ", %zu", bodies[k]);
    return words + (bodies.size() > 3 ? ", ...)" : ")");
}

glm::dvec3 vector_of(const Numbers3& v) {
    return {v[0], v[1], v[2]};
}
glm::dquat quaternion_of(const Numbers4& q) {
    return {q[3], q[0], q[1], q[2]};
}
double cosine_of_half_angle(const BodyPose& a, const BodyPose& b) {
    return std::abs(glm::dot(quaternion_of(a.orientation), quaternion_of(b.orientation)));
}

struct Judge {
    const SceneInfo& info;
    const RigidScene& scene;
    const Trajectory& run;
    Judgement verdict{};

    void fault(std::string words) { verdict.faults.push_back(std::move(words)); }
    [[nodiscard]] double seconds_of(uint32_t record) const {
        return static_cast<double>(record) * scene.steps_a_record * scene.numbers.step;
    }
    [[nodiscard]] glm::dvec3 place(uint32_t record, size_t body) const {
        return vector_of(run.at(record, body).position);
    }
    [[nodiscard]] uint32_t last() const { return run.records - 1; }

    bool complete();
    void begins_at_scene();
    void keeps_fixed_bodies();
    void gains_no_energy();
    void stays_above_ground();
    void stays_out_of_others();

    void stands_or_falls();
    void slides_or_rests();
    void bounces();
    void wave();
    void piles_up();
};

bool Judge::complete() {
    const uint32_t records = scene.steps / scene.steps_a_record + 1;
    if (run.bodies != scene.bodies.size() || run.records != records) {
        fault(text("%u records of %u bodies, not %u of %zu", run.records, run.bodies, records, scene.bodies.size()));
        return false;
    }
    for (uint32_t record = 0; record < records; ++record)
        for (size_t body = 0; body < run.bodies; ++body) {
            const glm::dvec3 p = place(record, body);
            const glm::dquat q = quaternion_of(run.at(record, body).orientation);
            if (!std::isfinite(p.x + p.y + p.z) || !std::isfinite(glm::length(q))) {
                fault(text("body %zu is nowhere after %.2f s: its pose is not finite", body, seconds_of(record)));
                return false;
            }
            if (std::max({std::abs(p.x), std::abs(p.y), std::abs(p.z)}) > farthest) {
                fault(text("body %zu is %.2g m away after %.2f s", body, glm::length(p), seconds_of(record)));
                return false;
            }
            if (std::abs(glm::length(q) - 1.0) > unit_length) {
                fault(text("the orientation of body %zu has length %.3f after %.2f s", body, glm::length(q),
                           seconds_of(record)));
                return false;
            }
        }
    return true;
}

void Judge::begins_at_scene() {
    for (size_t body = 0; body < run.bodies; ++body) {
        const BodyPose& start = scene.bodies[body].numbers.pose;
        const double away = glm::length(place(0, body) - vector_of(start.position));
        const double turned = 2.0 * std::acos(std::min(1.0, cosine_of_half_angle(run.at(0, body), start)));
        // The cosine of an angle near 0 has half of its digits.
        if (away > same_pose * (1.0 + glm::length(vector_of(start.position))) || turned > 10.0 * same_pose)
            return fault(
                text("body %zu begins %s and %.3f rad from its place", body, length_text(away).c_str(), turned));
    }
}

void Judge::keeps_fixed_bodies() {
    for (size_t body = 0; body < run.bodies; ++body)
        for (uint32_t record = 1; scene.bodies[body].fixed && record < run.records; ++record)
            if (const double away = glm::length(place(record, body) - place(0, body)); away > same_pose)
                return fault(text("fixed body %zu moves by %s", body, length_text(away).c_str()));
}

// Potential energy, and the kinetic energy of the mean velocity between two records, which is less than the true one.
void Judge::gains_no_energy() {
    const glm::dvec3 gravity = vector_of(scene.numbers.gravity);
    double start = 0.0, kinetic = 0.0, mass = 0.0;
    for (const RigidBody& body : scene.bodies) {
        if (body.fixed) continue;
        const BodyNumbers& of = body.numbers;
        const glm::dvec3 v = vector_of(of.velocity);
        const glm::dvec3 w = glm::conjugate(quaternion_of(of.pose.orientation)) * vector_of(of.angular_velocity);
        kinetic += 0.5 * (of.mass * glm::dot(v, v) + glm::dot(w * w, vector_of(of.moments)));
        start -= of.mass * glm::dot(gravity, vector_of(of.pose.position));
        mass += of.mass;
    }
    double least = start, most = start;
    double when = 0.0;
    for (uint32_t record = 1; record < run.records; ++record) {
        double potential = 0.0, energy = -kinetic;
        for (size_t body = 0; body < run.bodies; ++body) {
            if (scene.bodies[body].fixed) continue;
            const double m = scene.bodies[body].numbers.mass;
            const glm::dvec3 from = place(record - 1, body), to = place(record, body);
            const glm::dvec3 v = (to - from) / (seconds_of(record) - seconds_of(record - 1));
            potential -= m * glm::dot(gravity, to);
            energy += 0.5 * m * (glm::dot(v, v) - glm::dot(gravity, from + to));
        }
        least = std::min(least, potential);
        if (energy > most) {
            most = energy;
            when = seconds_of(record);
        }
    }
    const double given = kinetic + start - least, gain = most - start;
    if (gain > max_energy_gain * given + mass * glm::length(gravity) * tools::max_drift)
        fault(text("gains energy: %.3g J after %.2f s, of %.3g J that it got", gain, when, given));
}

void Judge::stays_above_ground() {
    if (!scene.ground) return;
    std::vector<size_t> below;
    double deepest = 0.0;
    for (size_t body = 0; body < run.bodies; ++body) {
        const glm::dquat turn = glm::normalize(quaternion_of(run.at(last(), body).orientation));
        double lowest = std::numeric_limits<double>::infinity();
        for (const Numbers3& corner : scene.bodies[body].corners)
            lowest = std::min(lowest, place(last(), body).y + (turn * vector_of(corner)).y);
        if (lowest < -tools::max_drift) below.push_back(body);
        deepest = std::max(deepest, -lowest);
    }
    if (!below.empty()) fault(bodies_text(below, "through the ground, by up to " + length_text(deepest)));
}

void Judge::stays_out_of_others() {
    std::vector<tools::HullFeatures> hulls;
    std::vector<physics::Pose> poses;
    for (size_t body = 0; body < run.bodies; ++body) {
        std::vector<glm::dvec3> corners;
        for (const Numbers3& corner : scene.bodies[body].corners) corners.push_back(vector_of(corner));
        hulls.push_back(
            tools::features_of(physics::collision_hull(corners, glm::dvec3(0.0), {.max_vertices = max_vertices})));
        poses.push_back({glm::vec3(place(last(), body)),
                         glm::normalize(glm::quat(quaternion_of(run.at(last(), body).orientation)))});
    }
    const std::vector<double> shares = tools::shares_inside(hulls, poses);
    std::vector<size_t> inside;
    for (size_t body = 0; body < run.bodies; ++body)
        if (shares[body] > tools::max_share_inside) inside.push_back(body);
    if (!inside.empty()) fault(bodies_text(inside, "more than a fifth inside another"));
    // Pairs that overlap deeply take long, and bodies that lie in each other have their fault already.
    if (info.outcome != Outcome::piles_up || inside.size() > run.bodies / 10) return;
    const std::vector<double> depths = tools::overlaps(hulls, poses);
    const double most = tools::longest(depths), p95 = tools::percentile_95(depths);
    verdict.result += text(", %zu overlaps, at most %.2f mm, p95 %.2f mm", depths.size(), 1e3 * most, 1e3 * p95);
    if (most > tools::max_overlap || p95 > tools::max_overlap_p95)
        fault(text("bodies overlap by up to %.2f mm, p95 %.2f mm", 1e3 * most, 1e3 * p95));
}

void Judge::stands_or_falls() {
    double aside = 0.0, down = 0.0, up = 0.0; // m
    double fallen = -1.0;                     // s
    for (uint32_t record = 1; record < run.records && fallen < 0.0; ++record)
        for (size_t body = 0; body < run.bodies; ++body) {
            const glm::dvec3 way = place(record, body) - place(0, body);
            aside = std::max(aside, std::hypot(way.x, way.z));
            down = std::max(down, -way.y);
            up = std::max(up, way.y);
            if (std::max({aside, down, up}) >= info.fall) fallen = seconds_of(record);
        }
    const bool is_arch = info.parameter > 0.0;
    const std::string limit =
        is_arch ? text(": at least %.4f stands (Heyman)", tools::min_arch_thickness(tools::arch_stones)) : "";
    // Stones settle where the arch bends; only its fall decides, as in rigid_bodies.
    const double bound = is_arch ? info.fall : tools::max_drift;
    verdict.result = fallen >= 0.0 ? text("falls within %.1f s", fallen)
                                   : text("stands %g s, %.2f mm aside, %.2f down, %.2f up", seconds_of(last()),
                                          1e3 * aside, 1e3 * down, 1e3 * up);
    if (info.outcome == Outcome::falls) {
        verdict.truth = "falls" + limit;
        if (fallen < 0.0) fault("stands");
        return;
    }
    verdict.truth = "stands" + (is_arch ? limit : text(", moves by at most %g mm", 1e3 * tools::max_drift));
    if (fallen >= 0.0)
        fault(verdict.result);
    else if (const double most = std::max({aside, down, up}); most > bound)
        fault(text("moves by %.1f mm", 1e3 * most));
}

void Judge::slides_or_rests() {
    const double angle = std::atan(slope_friction) + info.parameter * std::numbers::pi / 180.0;
    const double seconds = seconds_of(last()), way = glm::length(place(last(), 0) - place(0, 0));
    if (info.outcome == Outcome::rests) {
        verdict.truth = text("rests, moves by at most %g mm", 1e3 * tools::max_drift);
        verdict.result = text("%.2f mm in %g s", 1e3 * way, seconds);
        if (way > tools::max_drift) fault(text("slides by %.1f mm", 1e3 * way));
        return;
    }
    const double theory =
        0.5 * tools::earth_gravity * (std::sin(angle) - slope_friction * std::cos(angle)) * seconds * seconds;
    verdict.truth = text("slides %.3f m, within %g %%", theory, 100.0 * tools::max_speed_error);
    verdict.result = text("%.3f m in %g s", way, seconds);
    if (std::abs(way / theory - 1.0) > tools::max_speed_error) fault(text("slides %.3f m", way));
}

void Judge::bounces() {
    const double touch = place(0, 0).y - bounce_height;
    double top = 0.0; // m, above the height at which it touches, after the first bounce
    bool rises = false;
    for (uint32_t record = 1; record < run.records; ++record) {
        const double rise = place(record, 0).y - place(record - 1, 0).y;
        if (rises && rise < 0.0) break;
        rises = rises || rise > 0.0;
        if (rises) top = std::max(top, place(record, 0).y - touch);
    }
    const double measured = std::sqrt(top / bounce_height);
    verdict.truth = text("restitution %g, within %g", info.parameter, tools::max_restitution_error);
    verdict.result = text("%.3f by height", measured);
    if (!rises) return fault("never bounces");
    if (std::abs(measured - info.parameter) > tools::max_restitution_error)
        fault(text("restitution %.3f by height", measured));
}

void Judge::wave() {
    const tools::Dominoes row;
    const double root = std::sqrt(tools::earth_gravity * row.height), theory = tools::domino_wave_speed(row) / root;
    verdict.truth =
        text("speed / sqrt(g h) %.2f, within %g %% (van Leeuwen 2010)", theory, 100.0 * tools::max_speed_error);
    const auto tilts_at = [&](size_t domino) {
        for (uint32_t record = 1; record < run.records; ++record)
            if (cosine_of_half_angle(run.at(record, domino), run.at(0, domino)) < tools::tilted_cosine)
                return seconds_of(record);
        return -1.0;
    };
    const double from = tilts_at(tools::first_timed_domino), to = tilts_at(tools::last_timed_domino);
    if (from < 0.0 || to <= from) {
        verdict.result = "the wave dies";
        return fault(verdict.result);
    }
    const double speed = static_cast<double>(tools::last_timed_domino - tools::first_timed_domino)
                         * (row.gap + row.thickness) / (to - from) / root;
    verdict.result = text("%.2f", speed);
    if (std::abs(speed / theory - 1.0) > tools::max_speed_error) fault(text("speed / sqrt(g h) %.2f", speed));
}

void Judge::piles_up() {
    const auto height = [&](uint32_t record) {
        double sum = 0.0, mass = 0.0;
        for (size_t body = 0; body < run.bodies; ++body) {
            sum += scene.bodies[body].numbers.mass * place(record, body).y;
            mass += scene.bodies[body].numbers.mass;
        }
        return sum / mass;
    };
    double reach = 0.0;
    for (size_t body = 0; body < run.bodies; ++body)
        reach += std::hypot(place(last(), body).x, place(last(), body).z) / run.bodies;
    const double lost = height(0) - height(last());
    verdict.truth = text("falls freely, ends in a pile, overlaps at most %g mm, p95 %g mm", 1e3 * tools::max_overlap,
                         1e3 * tools::max_overlap_p95);
    verdict.result = text("sinks %.2f m, mean distance %.2f m", lost, reach);
    const auto record =
        static_cast<uint32_t>(std::lround(free_fall_seconds / (scene.numbers.step * scene.steps_a_record)));
    const double fallen = height(0) - height(record);
    const double theory = 0.5 * tools::earth_gravity * seconds_of(record) * seconds_of(record);
    if (std::abs(fallen / theory - 1.0) > max_free_fall_error)
        fault(text("falls %.3f m in the first %g s, not %.3f m", fallen, seconds_of(record), theory));
    if (lost < info.parameter - tools::max_drift)
        fault(text("its centre of mass sinks %.3f m, and it fell %g m", lost, info.parameter));
}

} // namespace

std::string Judgement::reason() const {
    std::string joined;
    for (const std::string& fault : faults) joined += (joined.empty() ? "" : ", ") + fault;
    return joined;
}

Trajectory read_poses(const std::string& file) {
    FileReader reader(file, poses_magic);
    std::array<uint32_t, 2> counts{};
    reader.take(counts.data(), sizeof counts);
    const uint64_t poses = uint64_t{counts[0]} * counts[1];
    if (poses > reader.left / sizeof(BodyPose) || poses * sizeof(BodyPose) != reader.left)
        throw std::runtime_error(file + ": has " + std::to_string(reader.left) + " bytes for " + std::to_string(poses)
                                 + " poses of " + std::to_string(sizeof(BodyPose)) + " bytes");
    Trajectory trajectory{.bodies = counts[0], .records = counts[1], .poses = std::vector<BodyPose>(poses)};
    reader.take(trajectory.poses.data(), poses * sizeof(BodyPose));
    return trajectory;
}

Judgement judge(const SceneInfo& info, const RigidScene& scene, const Trajectory& trajectory) {
    Judge judge{.info = info, .scene = scene, .run = trajectory};
    if (!judge.complete()) return judge.verdict;
    switch (info.outcome) {
    case Outcome::stands:
    case Outcome::falls:
        judge.stands_or_falls();
        break;
    case Outcome::slides:
    case Outcome::rests:
        judge.slides_or_rests();
        break;
    case Outcome::bounces:
        judge.bounces();
        break;
    case Outcome::wave:
        judge.wave();
        break;
    case Outcome::piles_up:
        judge.piles_up();
        break;
    }
    judge.begins_at_scene();
    judge.keeps_fixed_bodies();
    judge.gains_no_energy();
    judge.stays_above_ground();
    judge.stays_out_of_others();
    return judge.verdict;
}

} // namespace brittle::comparison
