#include "physics/solver/joint_rows.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include <glm/geometric.hpp>
#include <glm/matrix.hpp>

namespace brittle::physics {

namespace {

// Solutions that find v_target: each reduces its error by the angle of a substep.
constexpr int target_solutions = 3;
// Changes of the set of reached bounds in one sweep, at most. The next sweep goes on.
constexpr int max_set_changes = 8;
// m/s; a bound that is violated by less is not.
constexpr double speed_slack = 1e-9;
// m and rad; smaller errors are not corrected: positions far from the origin have no finer steps.
constexpr double error_slack = 5e-6;
// Newton iterations of a step, and the largest error, m and rad, that one of them corrects.
constexpr int max_corrections = 4;
constexpr double max_corrected_error = 0.2;
// Of fixed joints: the share by which diagonal entries grow, of the strongest joint and of the weakest. Well above
// Skyline::min_pivot, so that redundant rows keep their pivots, and so small that nobody sees them yield.
constexpr double min_softness = 1e-6, max_softness = 1e-4;
// Halvings of the interval in which the impulse of a joint that breaks is found.
constexpr int impulse_halvings = 40;
// m; below this distance of the anchors the direction of a distance joint is the vertical.
constexpr double min_distance = 1e-9;

// The change of a vector that turns by u = h w, by the map that the bodies turn by (free_rotation.h):
// (u x r + u x (u x r) / 2) / (1 + u . u / 4).
glm::dvec3 turned(const glm::dvec3& u, const glm::dvec3& r) {
    const glm::dvec3 once = glm::cross(u, r);
    return (once + 0.5 * glm::cross(u, once)) / (1.0 + 0.25 * glm::dot(u, u));
}

// Two unit vectors across a unit axis.
std::array<glm::dvec3, 2> across(const glm::dvec3& axis) {
    const glm::dvec3 other = std::abs(axis.x) < 0.6 ? glm::dvec3(1, 0, 0) : glm::dvec3(0, 1, 0);
    const glm::dvec3 first = glm::normalize(glm::cross(axis, other));
    return {first, glm::cross(axis, first)};
}

// The least moment of inertia about an axis across a unit one, in the principal axes: the smaller eigenvalue of the
// tensor's part across it.
double min_moment_across(const glm::dvec3& axis, const glm::dvec3& moments) {
    const auto [u, v] = across(axis);
    const double uu = glm::dot(u * u, moments), vv = glm::dot(v * v, moments), uv = glm::dot(u * v, moments);
    return 0.5 * (uu + vv) - std::sqrt(0.25 * (uu - vv) * (uu - vv) + uv * uv);
}

glm::dvec3 point_of(const Body* body, const glm::vec3& local) {
    const glm::dvec3 point(local);
    return body ? glm::dmat3(body->frame.basis) * point + glm::dvec3(body->frame.origin) : point;
}
glm::dvec3 direction_of(const Body* body, const glm::vec3& local) {
    const glm::dvec3 direction(local);
    return body ? glm::dmat3(body->frame.basis) * direction : direction;
}

uint32_t rows_of(JointKind kind) {
    constexpr std::array<uint32_t, joint_kinds.size()> rows{3, 5, 1, 6};
    return rows[static_cast<size_t>(kind)];
}

} // namespace

void JointSystem::take(std::span<SolverJoint* const> joints) {
    joints_.assign(joints.begin(), joints.end());
    bodies_.clear();
    for (const SolverJoint* joint : joints_)
        for (Body* body : {joint->a, joint->b})
            if (is_driven(body)) bodies_.push_back({.body = body});
    const auto by_index = [](const DrivenBody& a, const DrivenBody& b) { return a.body->index < b.body->index; };
    const auto same = [](const DrivenBody& a, const DrivenBody& b) { return a.body == b.body; };
    std::ranges::sort(bodies_, by_index);
    bodies_.erase(std::unique(bodies_.begin(), bodies_.end(), same), bodies_.end());
    placed_.assign(joints_.size(), {});
    const auto place_of = [&](Body* body) {
        if (!is_driven(body)) return none;
        return static_cast<uint32_t>(std::ranges::lower_bound(bodies_, DrivenBody{.body = body}, by_index)
                                     - bodies_.begin());
    };
    for (size_t i = 0; i < joints_.size(); ++i) {
        placed_[i].a = place_of(joints_[i]->a);
        placed_[i].b = place_of(joints_[i]->b);
    }
    order();
}

// Orders the joints so that those that share a body are near each other (Cuthill and McKee, 1969): breadth first, from
// a joint at the end of the system. Then gives each joint its rows.
void JointSystem::order() {
    const auto count = static_cast<uint32_t>(joints_.size());
    std::vector<std::vector<uint32_t>> of_body(bodies_.size());
    for (uint32_t i = 0; i < count; ++i)
        for (const uint32_t body : {placed_[i].a, placed_[i].b})
            if (body != none) of_body[body].push_back(i);
    std::vector<uint32_t> order;
    const auto search = [&](uint32_t start) {
        std::vector<uint8_t> seen(count, 0), opened(bodies_.size(), 0);
        order = {start};
        seen[start] = 1;
        for (size_t next = 0; next < order.size(); ++next)
            for (const uint32_t body : {placed_[order[next]].a, placed_[order[next]].b}) {
                if (body == none || std::exchange(opened[body], uint8_t{1})) continue;
                for (const uint32_t joint : of_body[body])
                    if (!std::exchange(seen[joint], uint8_t{1})) order.push_back(joint);
            }
    };
    search(0);
    search(order.back());
    std::vector<SolverJoint*> joints;
    std::vector<Placed> placed;
    joint_of_row_.clear();
    for (uint32_t i = 0; i < count; ++i) {
        joints.push_back(joints_[order[i]]);
        placed.push_back(placed_[order[i]]);
        placed[i].first = static_cast<uint32_t>(joint_of_row_.size());
        placed[i].count = rows_of(joints[i]->kind);
        joint_of_row_.insert(joint_of_row_.end(), placed[i].count, i);
    }
    joints_ = std::move(joints);
    placed_ = std::move(placed);
    std::vector<uint32_t> first_of_body(bodies_.size(), none); // row
    firsts_.clear();
    for (const Placed& joint : placed_) {
        uint32_t first = joint.first;
        for (const uint32_t body : {joint.a, joint.b})
            if (body != none) first = std::min(first, first_of_body[body] = std::min(first_of_body[body], joint.first));
        firsts_.insert(firsts_.end(), joint.count, first);
    }
    rows_.assign(joint_of_row_.size(), {});
    soften();
}

void JointSystem::soften() {
    const auto is_fixed = [](const SolverJoint* joint) { return joint->kind == JointKind::fixed; };
    double strongest = 0.0; // N
    for (const SolverJoint* joint : joints_)
        if (is_fixed(joint) && std::isfinite(joint->max_force))
            strongest = std::max(strongest, static_cast<double>(joint->max_force));
    softness_.clear();
    for (const SolverJoint* joint : joints_)
        softness_.push_back(is_fixed(joint)
                                ? std::clamp(min_softness * strongest / static_cast<double>(joint->max_force),
                                             min_softness, max_softness)
                                : 0.0);
}

void JointSystem::start(std::span<const uint32_t> indices, const Step& step) {
    step_seconds_ = static_cast<double>(step.seconds);
    seconds_ = static_cast<double>(step.substep_seconds);
    for (DrivenBody& body : bodies_) {
        body.index = indices[body.body->index];
        body.linear = glm::dvec3(body.body->velocity.linear);
        body.angular = glm::dvec3(body.body->velocity.angular);
        body.linear_given = body.angular_given = glm::dvec3(0.0);
    }
    for (Placed& placed : placed_) placed.given = {};
}

void JointSystem::start_substep(const VelocityChange* changes, const Displacement* moved) {
    load(changes);
    for (DrivenBody& body : bodies_) {
        const Displacement& own = moved[body.index];
        body.way = glm::dvec3(own.linear[0], own.linear[1], own.linear[2]);
        body.rotation = glm::dvec3(own.angular[0], own.angular[1], own.angular[2]);
        body.linear_before = body.linear_now;
        body.angular_before = body.angular_now;
        body.added_inertia = 0.0;
        body.damping = glm::dvec3(0.0);
    }
    fresh_ = true;
    reset();
}

// Builds the rows anew, without impulses.
void JointSystem::reset() {
    for (JointRow& row : rows_) row = {};
    place_all();
    for (DrivenBody& body : bodies_) {
        body.linear_now = body.linear_before;
        body.angular_now = body.angular_before + body.damping;
    }
    for (uint32_t i = 0; i < rows_.size(); ++i) {
        JointRow& row = rows_[i];
        row.frozen = joints_[joint_of_row_[i]]->broken;
        row.active = row.bound == Bound::equal && !row.frozen;
        row.before = speed_of(placed_[joint_of_row_[i]], row);
    }
    factored_ = false;
}

void JointSystem::place_all() {
    for (DrivenBody& driven : bodies_) {
        const Body& body = *driven.body;
        driven.inverse_mass = static_cast<double>(body.inverse_mass);
        driven.inverse_inertia = glm::dmat3(body.inverse_inertia);
        if (driven.added_inertia == 0.0) continue;
        const glm::dmat3 basis(body.frame.basis);
        const glm::dmat3 added =
            driven.added_inertia * (glm::dmat3(1.0) - glm::outerProduct(driven.tension, driven.tension));
        const glm::dmat3 inertia{glm::dvec3(body.moments.x, 0, 0), glm::dvec3(0, body.moments.y, 0),
                                 glm::dvec3(0, 0, body.moments.z)};
        driven.inverse_inertia = basis * glm::inverse(inertia + added) * glm::transpose(basis);
        driven.damping = -(driven.inverse_inertia * (basis * added * (driven.angular_before * basis)));
    }
    for (uint32_t i = 0; i < joints_.size(); ++i) place(i);
}

// The turn of a body, as turned() takes it, by a small rotation since the frame: with the gyroscopic term, as its
// motion has it (free_rotation.h).
glm::dvec3 JointSystem::turn_of(uint32_t side, const glm::dvec3& rotation) const {
    const Body& body = *bodies_[side].body;
    const glm::dmat3 basis(body.frame.basis);
    const glm::dvec3 momentum = basis * (body.moments * (rotation * basis));
    return rotation + 0.5 * (glm::dmat3(body.inverse_inertia) * glm::cross(momentum, rotation));
}

// Sets J and C of a joint's rows where the bodies are at the start of the substep.
void JointSystem::place(uint32_t index) {
    const SolverJoint& joint = *joints_[index];
    Placed& placed = placed_[index];
    const auto arm = [](const Body* body, const glm::vec3& anchor) {
        return body ? direction_of(body, anchor) : glm::dvec3(0.0);
    };
    const auto displaced = [&](uint32_t side, const glm::dvec3& v) {
        return side == none ? v : v + turned(turn_of(side, bodies_[side].rotation), v);
    };
    const auto way_of = [&](uint32_t side) { return side == none ? glm::dvec3(0.0) : bodies_[side].way; };
    placed.frame_arm_a = arm(joint.a, joint.anchor_a);
    placed.frame_arm_b = arm(joint.b, joint.anchor_b);
    placed.arm_a = displaced(placed.a, placed.frame_arm_a);
    placed.arm_b = displaced(placed.b, placed.frame_arm_b);
    placed.apart = point_of(joint.a, joint.anchor_a) - point_of(joint.b, joint.anchor_b)
                   + (way_of(placed.a) + placed.arm_a - placed.frame_arm_a)
                   - (way_of(placed.b) + placed.arm_b - placed.frame_arm_b);
    const auto put_along = [&](uint32_t row, const glm::dvec3& n, double error) {
        put_row(row, placed, n, glm::cross(placed.arm_a, n), glm::cross(n, placed.arm_b), error);
    };
    if (joint.kind == JointKind::distance) {
        const double length = glm::length(placed.apart);
        const double low = static_cast<double>(joint.min_length), high = static_cast<double>(joint.max_length);
        const glm::dvec3 n = length > min_distance ? placed.apart / length : glm::dvec3(0.0, 1.0, 0.0);
        const bool upper = length - low > high - length;
        put_along(placed.first, n, length - (upper ? high : low));
        rows_[placed.first].bound = low == high ? Bound::equal : upper ? Bound::at_most : Bound::at_least;
        return;
    }
    for (int axis = 0; axis < 3; ++axis) {
        glm::dvec3 n(0.0);
        n[axis] = 1.0;
        put_along(placed.first + static_cast<uint32_t>(axis), n, placed.apart[axis]);
    }
    if (joint.kind == JointKind::ball) return;
    const glm::dvec3 axis_b = direction_of(joint.b, joint.axis_b);
    const glm::dvec3 axis_a = glm::normalize(glm::dvec3(joint.axis_a));
    std::array<glm::dvec3, 3> on_a{}; // in a's frame, so that they turn with it
    placed.frame_on_b = {axis_b, axis_b, axis_b};
    if (joint.kind == JointKind::fixed) {
        const glm::dvec3 up_a(joint.up_a), side_a = glm::cross(axis_a, up_a);
        on_a = {up_a, side_a, side_a};
        placed.frame_on_b[2] = direction_of(joint.b, joint.up_b);
        placed.axis = displaced(placed.b, axis_b);
    } else {
        const std::array<glm::dvec3, 2> tangents = across(axis_a);
        on_a = {tangents[0], tangents[1], glm::dvec3(0.0)};
    }
    for (uint32_t i = 0; i + 3 < placed.count; ++i) {
        placed.frame_on_a[i] = joint.a ? glm::dmat3(joint.a->frame.basis) * on_a[i] : on_a[i];
        const glm::dvec3 t = displaced(placed.a, placed.frame_on_a[i]), s = displaced(placed.b, placed.frame_on_b[i]);
        const glm::dvec3 angular = glm::cross(t, s);
        put_row(placed.first + 3 + i, placed, glm::dvec3(0.0), angular, -angular, glm::dot(t, s));
    }
}

void JointSystem::put_row(uint32_t index, const Placed& placed, const glm::dvec3& linear, const glm::dvec3& angular_a,
                          const glm::dvec3& angular_b, double error) {
    JointRow& row = rows_[index];
    row.linear = linear;
    row.angular_a = angular_a;
    row.angular_b = angular_b;
    if (placed.a != none) row.inverse_inertia_angular_a = bodies_[placed.a].inverse_inertia * angular_a;
    if (placed.b != none) row.inverse_inertia_angular_b = bodies_[placed.b].inverse_inertia * angular_b;
    row.error = error;
}

// J M^-1 J^T of the active rows; the others get a row of the identity.
void JointSystem::factor() {
    matrix_.shape(firsts_);
    for (uint32_t i = 0; i < rows_.size(); ++i) {
        JointRow& row = rows_[i];
        if (!row.active) {
            matrix_.at(i, i) = 1.0;
            continue;
        }
        const Placed& own = placed_[joint_of_row_[i]];
        for (uint32_t j = firsts_[i]; j <= i; ++j) {
            const JointRow& other = rows_[j];
            if (!other.active) continue;
            const Placed& its = placed_[joint_of_row_[j]];
            const auto shared = [&](uint32_t body, const glm::dvec3& linear, const glm::dvec3& turn, uint32_t its_body,
                                    const glm::dvec3& its_linear, const glm::dvec3& its_angular) {
                if (body == none || body != its_body) return 0.0;
                return bodies_[body].inverse_mass * glm::dot(linear, its_linear) + glm::dot(turn, its_angular);
            };
            const glm::dvec3 &rotation_a = row.inverse_inertia_angular_a, &rotation_b = row.inverse_inertia_angular_b;
            matrix_.at(i, j) = shared(own.a, row.linear, rotation_a, its.a, other.linear, other.angular_a)
                               + shared(own.a, row.linear, rotation_a, its.b, -other.linear, other.angular_b)
                               + shared(own.b, -row.linear, rotation_b, its.a, other.linear, other.angular_a)
                               + shared(own.b, -row.linear, rotation_b, its.b, -other.linear, other.angular_b);
        }
        row.softness = softness_[joint_of_row_[i]] * matrix_.at(i, i);
        matrix_.at(i, i) += row.softness;
    }
    matrix_.factor();
    factored_ = true;
}

double JointSystem::speed_of(const Placed& placed, const JointRow& row) const {
    double speed = 0.0;
    if (placed.a != none)
        speed +=
            glm::dot(row.linear, bodies_[placed.a].linear_now) + glm::dot(row.angular_a, bodies_[placed.a].angular_now);
    if (placed.b != none)
        speed +=
            glm::dot(row.angular_b, bodies_[placed.b].angular_now) - glm::dot(row.linear, bodies_[placed.b].linear_now);
    return speed;
}

// The speed that v_target is for: of a soft row, with that at which it yields to its impulse.
double JointSystem::closing_of(uint32_t row) const {
    return speed_of(placed_[joint_of_row_[row]], rows_[row]) + rows_[row].softness * rows_[row].impulse;
}

void JointSystem::apply(const Placed& placed, const JointRow& row, double impulse) {
    if (placed.a != none) {
        bodies_[placed.a].linear_now += row.linear * (impulse * bodies_[placed.a].inverse_mass);
        bodies_[placed.a].angular_now += row.inverse_inertia_angular_a * impulse;
    }
    if (placed.b != none) {
        bodies_[placed.b].linear_now -= row.linear * (impulse * bodies_[placed.b].inverse_mass);
        bodies_[placed.b].angular_now += row.inverse_inertia_angular_b * impulse;
    }
}

void JointSystem::find_bends() {
    const double h = seconds_;
    // The turn since the frame at the end of the substep.
    const auto end_of = [&](uint32_t side) {
        if (side == none) return glm::dvec3(0.0);
        return turn_of(side, bodies_[side].rotation + h * bodies_[side].angular_now);
    };
    const auto angular_of = [&](uint32_t side) { return side == none ? glm::dvec3(0.0) : bodies_[side].angular_now; };
    const auto linear_of = [&](uint32_t side) { return side == none ? glm::dvec3(0.0) : bodies_[side].linear_now; };
    for (const Placed& placed : placed_) {
        const SolverJoint& joint = *joints_[joint_of_row_[placed.first]];
        const glm::dvec3 end_a = end_of(placed.a), end_b = end_of(placed.b);
        const glm::dvec3 w_a = angular_of(placed.a), w_b = angular_of(placed.b);
        // Ways of the anchors in the substep: by the body's motion, and by its velocity alone.
        const glm::dvec3 rotated = (placed.frame_arm_a + turned(end_a, placed.frame_arm_a) - placed.arm_a)
                                   - (placed.frame_arm_b + turned(end_b, placed.frame_arm_b) - placed.arm_b);
        const glm::dvec3 speed = glm::cross(w_a, placed.arm_a) - glm::cross(w_b, placed.arm_b);
        const glm::dvec3 bend = rotated - h * speed;
        if (joint.kind == JointKind::distance) {
            JointRow& row = rows_[placed.first];
            const glm::dvec3 way = h * (linear_of(placed.a) - linear_of(placed.b) + speed);
            const double length = glm::length(placed.apart);
            const double curvature = glm::length(placed.apart + way + bend) - length - glm::dot(row.linear, way);
            const double gap = row.bound == Bound::equal     ? 0.0
                               : row.bound == Bound::at_most ? std::max(-row.error, 0.0)
                                                             : std::min(-row.error, 0.0);
            row.gap = gap / h;
            row.bend = -curvature / h;
            continue;
        }
        for (int axis = 0; axis < 3; ++axis) rows_[placed.first + static_cast<uint32_t>(axis)].bend = -bend[axis] / h;
        for (uint32_t i = 3; i < placed.count; ++i) {
            JointRow& row = rows_[placed.first + i];
            const glm::dvec3 &t = placed.frame_on_a[i - 3], &s = placed.frame_on_b[i - 3];
            const double end = glm::dot(t + turned(end_a, t), s + turned(end_b, s));
            row.bend = -(end - row.error - h * glm::dot(row.angular_a, w_a - w_b)) / h;
        }
    }
}

// Chooses the share of the bends for which the joints do no work, and sets v_target. With a share s, impulses are
// L0 + s L1, and their work, with the mean of the velocities before gravity and after the step, is
//     (L0 + s L1) . (J v_before + gap + s bend) / 2,
// a polynomial of second degree, whose greatest s in [0, 1] without a positive value is taken; 0 if there is none.
void JointSystem::set_targets() {
    steady_.resize(rows_.size());
    bending_.resize(rows_.size());
    for (uint32_t i = 0; i < rows_.size(); ++i) {
        const JointRow& row = rows_[i];
        steady_[i] = row.active ? row.gap - closing_of(i) : 0.0;
        bending_[i] = row.active ? row.bend : 0.0;
    }
    matrix_.solve(steady_);
    matrix_.solve(bending_);
    double constant = 0.0, linear = 0.0, square = 0.0;
    for (size_t i = 0; i < rows_.size(); ++i) {
        const JointRow& row = rows_[i];
        if (!row.active) continue;
        const double impulse = row.impulse + steady_[i], speed = row.before + row.gap;
        constant += impulse * speed;
        linear += impulse * row.bend + bending_[i] * speed;
        square += bending_[i] * row.bend;
    }
    bend_share_ = 1.0;
    if (constant + linear + square > 0.0) {
        const double root = linear * linear - 4.0 * square * constant;
        bend_share_ =
            root > 0.0 && square > 0.0 ? std::clamp((std::sqrt(root) - linear) / (2.0 * square), 0.0, 1.0) : 0.0;
    }
    for (JointRow& row : rows_) row.target = row.gap + bend_share_ * row.bend;
}

bool JointSystem::activate_violated() {
    bool changed = false;
    for (uint32_t i = 0; i < rows_.size(); ++i) {
        JointRow& row = rows_[i];
        if (row.active || row.frozen) continue;
        const double over = speed_of(placed_[joint_of_row_[i]], row) - row.target;
        row.active = row.bound == Bound::at_most ? over > speed_slack : over < -speed_slack;
        changed = changed || row.active;
    }
    return changed;
}

bool JointSystem::release_pushing() {
    bool changed = false;
    for (uint32_t i = 0; i < rows_.size(); ++i) {
        JointRow& row = rows_[i];
        if (!row.active || row.bound == Bound::equal) continue;
        if (row.bound == Bound::at_most ? row.impulse <= 0.0 : row.impulse >= 0.0) continue;
        apply(placed_[joint_of_row_[i]], row, -std::exchange(row.impulse, 0.0));
        row.active = false;
        changed = true;
    }
    return changed;
}

// What the joint gives a in the substep.
JointSystem::Push JointSystem::push_of(const Placed& placed) const {
    Push push;
    for (uint32_t i = placed.first; i < placed.first + placed.count; ++i) {
        push.impulse += rows_[i].impulse * rows_[i].linear;
        if (i >= placed.first + 3) push.moment += rows_[i].impulse * rows_[i].angular_a;
    }
    return push;
}

// What a joint has given in a step, as a share of what it bears.
double JointSystem::load_share(const SolverJoint& joint, const Placed& placed, const Push& push) const {
    const double force = static_cast<double>(joint.max_force) * step_seconds_;
    if (joint.kind != JointKind::fixed) return glm::length(push.impulse) / force;
    glm::dvec3 impulse = push.impulse;
    if (joint.bears_pressure) impulse -= std::min(glm::dot(impulse, placed.axis), 0.0) * placed.axis;
    return glm::length(impulse) / force
           + glm::length(push.moment) / (static_cast<double>(joint.max_torque) * step_seconds_);
}

bool JointSystem::break_overloaded() {
    bool changed = false;
    for (size_t i = 0; i < joints_.size(); ++i) {
        const Placed& placed = placed_[i];
        const Push added = push_of(placed);
        const auto overloads = [&](double part) {
            const Push push{placed.given.impulse + part * added.impulse, placed.given.moment + part * added.moment};
            return load_share(*joints_[i], placed, push) > 1.0;
        };
        if (joints_[i]->broken || !overloads(1.0)) continue;
        joints_[i]->broken = true;
        double part = 0.0, more = 1.0; // the greatest part that the joint bears lies between them
        for (int k = 0; k < impulse_halvings; ++k) {
            const double middle = 0.5 * (part + more);
            (overloads(middle) ? more : part) = middle;
        }
        for (uint32_t r = placed.first; r < placed.first + placed.count; ++r) {
            JointRow& row = rows_[r];
            const double kept = row.impulse * part;
            apply(placed, row, kept - std::exchange(row.impulse, kept));
            row.active = false;
            row.frozen = true;
        }
        changed = true;
    }
    return changed;
}

void JointSystem::load(const VelocityChange* changes) {
    for (DrivenBody& body : bodies_) {
        const VelocityChange& change = changes[body.index];
        body.linear_now = body.linear + glm::dvec3(change.linear[0], change.linear[1], change.linear[2]);
        body.angular_now = body.angular + glm::dvec3(change.angular[0], change.angular[1], change.angular[2]);
    }
}

// Adds inertia to the links that are too light for the tension that the first solution found. Returns whether it did.
bool JointSystem::stiffen() {
    // N m per rad: sum of arm . force over the joints, and the arm that pulls most.
    std::vector<std::pair<double, glm::dvec3>> pulls(bodies_.size(), {0.0, glm::dvec3(0.0)});
    std::vector<double> most(bodies_.size(), 0.0);
    for (const Placed& placed : placed_) {
        glm::dvec3 force(0.0); // on a
        for (uint32_t r = placed.first; r < placed.first + placed.count; ++r)
            force += rows_[r].linear * (rows_[r].impulse / seconds_);
        const auto pull = [&](uint32_t side, const glm::dvec3& arm, const glm::dvec3& on) {
            if (side == none) return;
            const double stiffness = glm::dot(arm, on);
            pulls[side].first += std::max(stiffness, 0.0);
            if (stiffness > most[side]) pulls[side].second = arm;
            most[side] = std::max(most[side], stiffness);
        };
        pull(placed.a, placed.arm_a, force);
        pull(placed.b, placed.arm_b, -force);
    }
    bool changed = false;
    for (size_t i = 0; i < bodies_.size(); ++i) {
        DrivenBody& driven = bodies_[i];
        if (!(most[i] > 0.0)) continue;
        const glm::dvec3 along = glm::normalize(pulls[i].second * glm::dmat3(driven.body->frame.basis));
        const double needed = seconds_ * seconds_ * pulls[i].first - min_moment_across(along, driven.body->moments);
        if (!(needed > 0.0)) continue;
        driven.added_inertia = needed;
        driven.tension = along;
        changed = true;
    }
    return changed;
}

void JointSystem::sweep_rows(Solution solution) {
    solution_.resize(rows_.size());
    const bool first = solution == Solution::first;
    for (int target = 0; target < (first ? target_solutions : 1); ++target) {
        if (first) find_bends();
        for (int change = 0; change < max_set_changes; ++change) {
            const bool entered = activate_violated();
            if (change > 0 && factored_ && !entered) break;
            if (!factored_ || entered) factor();
            if (first) set_targets();
            for (uint32_t i = 0; i < rows_.size(); ++i)
                solution_[i] = rows_[i].active ? rows_[i].target - closing_of(i) : 0.0;
            matrix_.solve(solution_);
            for (uint32_t i = 0; i < rows_.size(); ++i) {
                rows_[i].impulse += solution_[i];
                apply(placed_[joint_of_row_[i]], rows_[i], solution_[i]);
            }
            const bool released = release_pushing();
            const bool broke = !first && break_overloaded();
            factored_ = !released && !broke;
        }
    }
}

void JointSystem::solve(VelocityChange* changes, Solution solution) {
    load(changes);
    sweep_rows(solution);
    if (std::exchange(fresh_, false) && stiffen()) {
        reset();
        load(changes);
        for (DrivenBody& body : bodies_) body.angular_now += body.damping;
        sweep_rows(solution);
    }
    for (const DrivenBody& body : bodies_) {
        VelocityChange& change = changes[body.index];
        const glm::dvec3 linear = body.linear_now - body.linear, angular = body.angular_now - body.angular;
        for (int axis = 0; axis < 3; ++axis) {
            change.linear[axis] = static_cast<float>(linear[axis]);
            change.angular[axis] = static_cast<float>(angular[axis]);
        }
    }
}

void JointSystem::finish_substep() {
    for (size_t i = 0; i < rows_.size(); ++i) {
        const JointRow& row = rows_[i];
        const Placed& placed = placed_[joint_of_row_[i]];
        if (placed.a != none) {
            bodies_[placed.a].linear_given += row.linear * (row.impulse * bodies_[placed.a].inverse_mass);
            bodies_[placed.a].angular_given += row.inverse_inertia_angular_a * row.impulse;
        }
        if (placed.b != none) {
            bodies_[placed.b].linear_given -= row.linear * (row.impulse * bodies_[placed.b].inverse_mass);
            bodies_[placed.b].angular_given += row.inverse_inertia_angular_b * row.impulse;
        }
    }
    for (DrivenBody& body : bodies_) body.angular_given += body.damping;
    for (Placed& placed : placed_) {
        const Push push = push_of(placed);
        placed.given.impulse += push.impulse;
        placed.given.moment += push.moment;
    }
}

void JointSystem::store() const {
    for (const DrivenBody& body : bodies_) {
        body.body->unhindered.linear += glm::vec3(body.linear_given);
        body.body->unhindered.angular += glm::vec3(body.angular_given);
    }
    for (size_t i = 0; i < joints_.size(); ++i)
        joints_[i]->force = static_cast<float>(glm::length(placed_[i].given.impulse) / step_seconds_);
}

void JointSystem::correct() {
    for (DrivenBody& body : bodies_) body.way = body.rotation = glm::dvec3(0.0);
    for (int iteration = 0; iteration < max_corrections; ++iteration) {
        place_all();
        double largest = 0.0;
        for (JointRow& row : rows_) {
            if (row.bound != Bound::equal) row.active = row.bound == Bound::at_most ? row.error > 0.0 : row.error < 0.0;
            if (row.frozen) row.active = false;
            if (row.active) largest = std::max(largest, std::abs(row.error));
        }
        if (!(largest > error_slack)) return;
        const double part = std::min(1.0, max_corrected_error / largest);
        factor();
        for (size_t i = 0; i < rows_.size(); ++i) solution_[i] = rows_[i].active ? -part * rows_[i].error : 0.0;
        matrix_.solve(solution_);
        for (DrivenBody& body : bodies_) body.linear_now = body.angular_now = glm::dvec3(0.0);
        for (uint32_t i = 0; i < rows_.size(); ++i) {
            const bool pushes = rows_[i].bound == Bound::at_most    ? solution_[i] > 0.0
                                : rows_[i].bound == Bound::at_least ? solution_[i] < 0.0
                                                                    : false;
            if (!pushes) apply(placed_[joint_of_row_[i]], rows_[i], solution_[i]);
        }
        for (const DrivenBody& driven : bodies_) {
            const Transform& frame = driven.body->frame;
            const glm::dvec3 half = 0.5 * driven.angular_now;
            const glm::dquat turn = glm::normalize(glm::dquat(1.0, half.x, half.y, half.z));
            const glm::dquat orientation = turn * glm::dquat(rotation_of(frame.basis));
            driven.body->set_frame(
                {matrix_of(glm::quat(orientation)), glm::vec3(glm::dvec3(frame.origin) + driven.linear_now)});
        }
    }
}

} // namespace brittle::physics
