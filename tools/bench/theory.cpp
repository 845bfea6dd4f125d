#include "tools/bench/theory.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>
#include <vector>

#include <glm/geometric.hpp>
#include <glm/vec2.hpp>

namespace brittle::tools {

namespace {

// Half of a symmetric arch from its crown, where a horizontal thrust H acts at height y, down to a joint. The thrust
// crosses the joint between two points of it if the moments about them have opposite signs. The moment about (px, py) is
// (px - x) W - y H + py H, with W the weight of the part and x its centre.
struct Joint {
    double angle;          // rad, from the vertical
    double weight, moment; // of the part above, W and W x
};

// The range that the joints leave for y H, given H; negative: none.
double room_for_thrust(std::span<const Joint> joints, double thickness, double thrust) {
    double low = -std::numeric_limits<double>::infinity(), high = -low;
    for (const Joint& joint : joints) {
        const auto at = [&](double radius) {
            return radius * std::sin(joint.angle) * joint.weight - joint.moment
                   + radius * std::cos(joint.angle) * thrust;
        };
        low = std::max(low, at(1.0 - 0.5 * thickness));
        high = std::min(high, at(1.0 + 0.5 * thickness));
    }
    return high - low;
}

bool thrust_fits(double thickness, int stones) {
    const double inner = 1.0 - 0.5 * thickness, outer = 1.0 + 0.5 * thickness;
    std::vector<Joint> joints;
    for (int i = 0; 2 * i < stones; ++i) {
        const double angle = std::numbers::pi * (i + 0.5) / stones;
        // Sums over the polygon between the joints of each stone; the keystone counts half.
        Joint joint{angle, 0.0, 0.0};
        for (int stone = 0; stone <= i; ++stone) {
            const double to = std::numbers::pi * (stone + 0.5) / stones;
            const double from = stone == 0 ? -to : std::numbers::pi * (stone - 0.5) / stones;
            // Area and first moment of the triangle from the centre to a chord of radius r.
            const auto triangle = [&](double r) { return 0.5 * r * r * std::sin(to - from); };
            const auto first = [&](double r) { return triangle(r) * r * (std::sin(from) + std::sin(to)) / 3.0; };
            // The right half of the keystone is a triangle too, between the vertical and its joint.
            const auto half = [&](double r) { return 0.5 * triangle(r) * r * std::sin(to) / 3.0; };
            joint.weight += (stone == 0 ? 0.5 : 1.0) * (triangle(outer) - triangle(inner));
            joint.moment += stone == 0 ? half(outer) - half(inner) : first(outer) - first(inner);
        }
        joints.push_back(joint);
    }
    double low = 0.0, high = 10.0 * joints.back().weight; // the room is concave in the thrust
    for (int i = 0; i < 200; ++i) {
        const double a = low + (high - low) / 3.0, b = high - (high - low) / 3.0;
        (room_for_thrust(joints, thickness, a) < room_for_thrust(joints, thickness, b) ? low : high) =
            room_for_thrust(joints, thickness, a) < room_for_thrust(joints, thickness, b) ? a : b;
    }
    return room_for_thrust(joints, thickness, 0.5 * (low + high)) >= 0.0;
}

// The dominoes that lean on each other, from the front one backwards. The front one has no contact in front of it. The
// angle of the front one decides all others.
constexpr size_t leaning = 40; // those farther back hardly move

struct Train {
    std::array<double, leaning> angle{}, rate{}; // rad from upright; d angle / d front angle
};

Train train_of(const Dominoes& row, double front) {
    Train train;
    train.angle[0] = front;
    train.rate[0] = 1.0;
    const double pitch = row.gap + row.thickness;
    for (size_t k = 0; k + 1 < leaning; ++k) {
        const double between =
            std::asin(std::clamp((pitch * std::cos(train.angle[k]) - row.thickness) / row.height, -1.0, 1.0));
        train.angle[k + 1] = train.angle[k] + between;
        train.rate[k + 1] = train.rate[k] * (1.0 - pitch * std::sin(train.angle[k]) / (row.height * std::cos(between)));
    }
    return train;
}

// Moment arms, forwards, of a unit normal force between a domino and the one that leans on it from behind.
struct Arms {
    double on_front, on_back;
};

Arms arms_of(const Dominoes& row, const Train& train, size_t front) {
    const double angle = train.angle[front], behind = train.angle[front + 1];
    const glm::dvec2 normal(std::cos(angle), -std::sin(angle)), up(std::sin(angle), std::cos(angle));
    const glm::dvec2 arm_back = row.height * glm::dvec2(std::sin(behind), std::cos(behind));
    const glm::dvec2 arm_front = arm_back - glm::dvec2(row.gap + row.thickness, 0.0);
    const auto moment = [](const glm::dvec2& arm, const glm::dvec2& force) {
        return arm.y * force.x - arm.x * force.y;
    };
    // Speed of the leaning corner along the face, for a forward motion.
    const double slip = train.rate[front + 1] * glm::dot(glm::dvec2(arm_back.y, -arm_back.x), up)
                        - train.rate[front] * glm::dot(glm::dvec2(arm_front.y, -arm_front.x), up);
    const glm::dvec2 force = normal + row.friction * (slip < 0.0 ? -1.0 : 1.0) * up;
    return {moment(arm_front, force), -moment(arm_back, force)};
}

// Solves I (rate_k x + bias_k) = torque_k + on_front_k N_k - on_back_(k-1) N_(k-1) for x, where N_k acts between
// domino k and the one behind it. The last has none behind it.
double solve_train(const Dominoes& row, const Train& train, const std::array<double, leaning>& bias,
                   const std::array<double, leaning>& torque, double inertia) {
    double constant = 0.0, slope = 0.0; // N = constant + slope x
    for (size_t k = leaning - 1; k > 0; --k) {
        const double on_front = k + 1 < leaning ? arms_of(row, train, k).on_front : 0.0;
        const double on_back = arms_of(row, train, k - 1).on_back;
        constant = (inertia * bias[k] - torque[k] - on_front * constant) / on_back;
        slope = (inertia * train.rate[k] - on_front * slope) / on_back;
    }
    const double on_front = arms_of(row, train, 0).on_front;
    return (torque[0] + on_front * constant - inertia * bias[0]) / (inertia - on_front * slope);
}

} // namespace

double min_arch_thickness(int stones) {
    double low = 0.01, high = 0.5;
    for (int i = 0; i < 40; ++i) (thrust_fits(0.5 * (low + high), stones) ? high : low) = 0.5 * (low + high);
    return high;
}

double domino_wave_speed(const Dominoes& row) {
    constexpr double step = 2e-5;                                                           // s
    const double inertia = (row.height * row.height + row.thickness * row.thickness) / 3.0; // per mass, about the foot
    const double touch = std::asin(row.gap / row.height);
    double front_speed = 5.0; // rad/s; the wave forgets it
    double seconds = 0.0;
    for (int domino = 0; domino < 40; ++domino) {
        double angle = 0.0;
        for (seconds = 0.0; angle < touch; seconds += step) {
            const Train train = train_of(row, angle);
            const Train before = train_of(row, angle - 1e-6), after = train_of(row, angle + 1e-6);
            std::array<double, leaning> bias{}, torque{};
            for (size_t k = 0; k < leaning; ++k) {
                bias[k] = (after.rate[k] - before.rate[k]) / 2e-6 * front_speed * front_speed;
                torque[k] = 0.5 * earth_gravity
                            * (row.height * std::sin(train.angle[k]) - row.thickness * std::cos(train.angle[k]));
            }
            front_speed += step * solve_train(row, train, bias, torque, inertia);
            angle += step * front_speed;
            if (front_speed <= 0.0) return 0.0;
        }
        // The front one hits the next one, which leads from now on: momenta before as biases, impulses as forces.
        const Train old = train_of(row, touch), hit = train_of(row, 0.0);
        std::array<double, leaning> lost{};
        for (size_t k = 1; k < leaning; ++k) lost[k] = -old.rate[k - 1] * front_speed;
        front_speed = solve_train(row, hit, lost, {}, inertia);
    }
    return (row.gap + row.thickness) / seconds;
}

} // namespace brittle::tools
