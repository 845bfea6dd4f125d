// Contacts of hulls with the ground: the corners that have one, against each corner by itself; warm starting; hulls of
// a compound.
#include "physics/solver/ground_contact.h"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <memory>
#include <numbers>
#include <optional>
#include <span>
#include <vector>

#include <doctest/doctest.h>
#include <glm/geometric.hpp>
#include <glm/gtc/quaternion.hpp>

#include "physics/solver/body.h"
#include "physics/solver/hull_shape.h"
#include "physics/solver/manifold.h"
#include "tests/physics/convex_pieces.h"

using namespace brittle;
using namespace brittle::physics;

namespace {

constexpr float step_seconds = 1.0f / 120.0f;
constexpr float gravity = -9.81f;

ContactStep step_above(float ground_height) {
    return {.seconds = step_seconds,
            .gravity = gravity,
            .ground_height = ground_height,
            .ground_friction = 0.6f,
            .ground_restitution = 0.3f};
}

// A body of one hull, and its contacts with the ground.
class OnGround {
  public:
    OnGround(HullShape hull, float ground_height) : step_(step_above(ground_height)) {
        auto form = std::make_shared<SolverForm>();
        form->shape = std::move(hull);
        body.form = std::move(form);
        body.inverse_mass = 1.0f;
    }
    // Makes it a compound of that one hull.
    void make_compound() {
        auto shared = std::make_shared<SharedHull>();
        shared->shape = body.hull();
        body.compound = std::make_unique<CompoundShape>(
            std::vector<CompoundShape::Child>{{.hull = std::move(shared), .frame = {}}});
    }
    // Finds the contacts of a step where the body is; null where there are none.
    GroundManifold* find() {
        if (!contacts_)
            contacts_ =
                make_ground_contacts({.body = &body,
                                      .shape = body.compound ? &body.compound->children()[0].shape() : &body.hull(),
                                      .local = body.compound ? &body.compound->children()[0].frame : nullptr});
        contacts_->update(step_);
        return manifold();
    }
    // Moves the contacts that were found with the body.
    GroundManifold* refresh() {
        contacts_->refresh();
        return manifold();
    }
    [[nodiscard]] bool is_out_of_reach() const { return is_out_of_reach_of_ground(body, step_); }

    Body body;

  private:
    [[nodiscard]] GroundManifold* manifold() const {
        std::vector<AnyManifold> found;
        contacts_->collect(found);
        return found.empty() ? nullptr : found[0].ground;
    }

    ContactStep step_;
    std::unique_ptr<PairContacts> contacts_;
};

std::vector<glm::vec3> random_points(test::Random& random, int count, const glm::vec3& half) {
    std::vector<glm::vec3> points;
    for (int i = 0; i < count; ++i) points.push_back(glm::vec3(random.point(glm::dvec3(-1.0), glm::dvec3(1.0))) * half);
    return points;
}

glm::mat3 random_basis(test::Random& random) {
    const glm::vec3 axis(static_cast<float>(random.uniform(-1.0, 1.0)), 0.5f,
                         static_cast<float>(random.uniform(-1.0, 1.0)));
    return matrix_of(glm::angleAxis(static_cast<float>(random.uniform(-3.0, 3.0)), glm::normalize(axis)));
}

// A corner of a hull, from its own point and in double.
struct Corner {
    glm::dvec3 position; // margin included
    double distance;     // above the ground
    double ahead;        // distance at the end of the step if nothing stops it
    double reached;      // distance below which it has a contact
    int index;
};

std::vector<Corner> corners_of(const Body& body, double ground_height) {
    const HullShape& hull = body.hull();
    const glm::dvec3 spin(body.velocity.angular);
    const double falling = static_cast<double>(body.velocity.linear.y) + static_cast<double>(gravity) * step_seconds;
    std::vector<Corner> corners;
    for (int i = 0; i < hull.point_count(); ++i) {
        const glm::dvec3 arm = glm::dmat3(body.frame.basis) * glm::dvec3(hull.points()[static_cast<size_t>(i)]);
        glm::dvec3 position = arm + glm::dvec3(body.frame.origin);
        position.y -= static_cast<double>(hull.margin());
        const double approach = -(falling + glm::cross(spin, arm).y), distance = position.y - ground_height;
        const double resting = 0.02 * static_cast<double>(hull.rotation_radius());
        corners.push_back({position, distance, distance - approach * step_seconds,
                           resting + 2.0 * std::max(0.0, approach) * step_seconds, i});
    }
    return corners;
}

// Each in its turn must be the best of those that are left, up to rounding.
void check_choice(std::span<const Corner> chosen, std::vector<Corner> left) {
    constexpr double rounding = 1e-5; // m, or m^2
    const auto take = [&](const Corner& one, const auto& score) {
        std::erase_if(left, [&](const Corner& other) { return other.index == one.index; });
        for (const Corner& other : left) CHECK(score(one) >= score(other) - rounding);
    };
    const glm::dvec3 first = chosen[0].position, line = chosen[1].position - first;
    const auto side = [&](const Corner& corner) { return glm::cross(line, corner.position - first).y; };
    const double other_side = side(chosen[2]) > 0.0 ? -1.0 : 1.0;
    take(chosen[0], [](const Corner& corner) { return -corner.ahead; });
    take(chosen[1], [&](const Corner& corner) { return glm::dot(corner.position - first, corner.position - first); });
    take(chosen[2], [&](const Corner& corner) { return std::abs(side(corner)); });
    take(chosen[3], [&](const Corner& corner) { return other_side * side(corner); });
    constexpr double sunk = -1e-4;
    std::erase_if(left, [](const Corner& corner) { return corner.ahead > sunk; });
    for (size_t i = 4; i < chosen.size(); ++i) {
        CHECK(chosen[i].ahead <= sunk + rounding);
        take(chosen[i], [&](const Corner& corner) {
            double apart = 1e30;
            for (const Corner& taken : chosen.first(i))
                apart = std::min(apart, glm::dot(corner.position - taken.position, corner.position - taken.position));
            return apart;
        });
    }
    if (chosen.size() < GroundManifold::max_points)
        CHECK(std::ranges::all_of(left, [](const Corner& corner) { return corner.ahead > sunk - rounding; }));
}

} // namespace

TEST_CASE("ground contact: a body is out of the ground's reach only if no corner can come down to it in the step") {
    size_t out = 0, within = 0;
    for (uint64_t seed = 0; seed < 4000; ++seed) {
        CAPTURE(seed);
        test::Random random(seed);
        const auto number = [&](double low, double high) { return static_cast<float>(random.uniform(low, high)); };
        const glm::vec3 sides(random.point(glm::dvec3(0.001), glm::dvec3(0.2))); // needles and plates, too
        const float ground_height = number(-0.3, 0.3);
        const std::vector<glm::vec3> points = random_points(random, 12, sides);
        OnGround on_ground({points, number(0.0, 0.005)}, ground_height);
        Body& body = on_ground.body;
        body.frame = {random_basis(random), {0.0f, ground_height + number(0.0, 1.2), 0.0f}};
        body.velocity = {glm::vec3(random.point({-5.0, -30.0, -5.0}, {5.0, 10.0, 5.0})),
                         glm::vec3(random.point(glm::dvec3(-60.0), glm::dvec3(60.0)))};
        const bool is_out = on_ground.is_out_of_reach();
        ++(is_out ? out : within);
        // A bound of every way that a corner can take in the step.
        float lowest = 1e9f;
        for (const glm::vec3& point : points) {
            const glm::vec3 arm = body.frame.basis * point;
            const float margin = body.hull().margin();
            const float turning = glm::length(body.velocity.angular) * (glm::length(arm) + margin) * step_seconds;
            const float falling = std::min(0.0f, (body.velocity.linear.y + gravity * step_seconds) * step_seconds);
            lowest = std::min(lowest, body.frame.origin.y + arm.y - margin - turning + falling - ground_height);
        }
        if (is_out) CHECK(lowest > 0.0f);
        body.frame.origin.y = ground_height + 100.0f;
        CHECK(on_ground.is_out_of_reach());
    }
    CHECK(out > 500);
    CHECK(within > 500);
}

TEST_CASE("ground contact: contacts of a compound's hull follow small movements and end after large ones") {
    std::vector<glm::vec3> cube;
    for (int i = 0; i < 8; ++i) cube.emplace_back(i & 1 ? 0.5f : -0.5f, i & 2 ? 0.5f : -0.5f, i & 4 ? 0.5f : -0.5f);
    const HullShape hull(cube, 0.0f);
    // The number of contacts left of four when the body has moved and rotated since they were found.
    const auto left_after = [&](const glm::vec3& way, float angle) -> uint32_t {
        OnGround on_ground(hull, 0.0f);
        on_ground.make_compound();
        const glm::vec3 at(0.3f, 0.5f, -0.2f);
        on_ground.body.frame = {glm::mat3(1.0f), at};
        const GroundManifold* const found = on_ground.find();
        REQUIRE(found);
        REQUIRE(found->count == 4);
        on_ground.body.frame = {matrix_of(glm::angleAxis(angle, glm::vec3(0, 0, 1))), at + way};
        const GroundManifold* const left = on_ground.refresh();
        return left ? left->count : 0;
    };
    const float far = 2.0f * 0.02f * hull.rotation_radius(); // twice the distance at which a contact ends
    CHECK(left_after({0.0f, 0.0f, 0.0f}, 0.0f) == 4);
    CHECK(left_after({0.1f * far, 0.0f, 0.1f * far}, 0.0f) == 4);
    CHECK(left_after({0.0f, -far, 0.0f}, 0.0f) == 4); // deeper in the ground
    CHECK(left_after({far, 0.0f, 0.0f}, 0.0f) == 0);
    CHECK(left_after({0.0f, far, 0.0f}, 0.0f) == 0);
    // It tips over its two corners at -X.
    const float angle = 2.0f * far; // rad: the corners at +X, a metre away, rise by twice `far`
    const glm::vec3 corner(-0.5f, -0.5f, 0.0f);
    CHECK(left_after(corner - glm::angleAxis(angle, glm::vec3(0, 0, 1)) * corner, angle) == 2);
}

TEST_CASE("ground contact: corners near the ground have contacts: four that carry, and those that would sink") {
    size_t none = 0, few = 0, some = 0, most = 0;
    for (uint64_t seed = 0; seed < 3000; ++seed) {
        CAPTURE(seed);
        test::Random random(seed);
        const auto number = [&](double low, double high) { return static_cast<float>(random.uniform(low, high)); };
        const int count = 4 + static_cast<int>(random.uniform(0.0, 30.0));
        const glm::vec3 sides(random.point({0.02, 0.005, 0.02}, {0.4, 0.1, 0.4})); // rods and plates, too
        const float ground_height = number(-0.3, 0.3);
        const std::vector<glm::vec3> corners = random_points(random, count, sides);
        OnGround on_ground({corners, number(0.0, 0.01)}, ground_height);
        Body& body = on_ground.body;
        const HullShape& hull = body.hull();
        body.frame = {random_basis(random), {number(-0.9, 0.9), 0.0f, number(-0.9, 0.9)}};
        body.frame.origin.y =
            ground_height + hull.margin() + hull.support(-row(body.frame.basis, 1)) + number(-0.1, 0.03);
        body.velocity = {glm::vec3(random.point({-0.9, -0.9, -0.9}, {0.9, 0.3, 0.9})),
                         glm::vec3(random.point(glm::dvec3(-20.0), glm::dvec3(20.0)))};

        const std::vector<Corner> all = corners_of(body, static_cast<double>(ground_height));
        if (std::ranges::any_of(all,
                                [](const Corner& corner) { return std::abs(corner.distance - corner.reached) < 1e-5; }))
            continue; // rounding decides
        std::vector<Corner> low, chosen;
        std::ranges::copy_if(all, std::back_inserter(low),
                             [](const Corner& corner) { return corner.distance < corner.reached; });
        const GroundManifold* const found = on_ground.find();
        const std::span<const GroundPoint> points = found ? found->points() : std::span<const GroundPoint>();
        for (const GroundPoint& point : points) {
            const auto same = std::ranges::find(low, point.corner, &Corner::index);
            REQUIRE(same != low.end());
            CHECK(std::ranges::count(points, point.corner, &GroundPoint::corner) == 1);
            CHECK(std::abs(static_cast<double>(point.distance) - same->distance) < 1e-5);
            CHECK(glm::length(glm::dvec3(point.position) - same->position) < 1e-5);
            chosen.push_back(*same);
        }
        ++(low.empty() ? none : low.size() <= 4 ? few : chosen.size() < GroundManifold::max_points ? some : most);
        CHECK(chosen.size() >= std::min<size_t>(low.size(), 4));
        if (low.size() > 4) check_choice(chosen, low);

        body.frame.origin.y += 5.0f;
        CHECK(on_ground.find() == nullptr);
    }
    for (const size_t enough : {none, few, some, most}) CHECK(enough > 100);
}

TEST_CASE("ground contact: a corner that stays in contact keeps its impulses, and a new one has none") {
    std::vector<glm::vec3> drum; // two rings of eight
    for (int i = 0; i < 16; ++i) {
        const float angle = static_cast<float>(i / 2) * std::numbers::pi_v<float> / 4.0f;
        drum.emplace_back(i % 2 == 0 ? -0.3f : 0.3f, 0.2f * std::cos(angle), 0.2f * std::sin(angle));
    }
    const HullShape hull(drum, 0.0f);
    OnGround on_ground(hull, 0.0f);
    size_t kept = 0, fresh = 0;
    std::vector<GroundPoint> before;
    for (int turn = 0; turn < 24; ++turn) { // it rolls by a third of a side at a time
        CAPTURE(turn);
        const glm::mat3 basis =
            matrix_of(glm::angleAxis(static_cast<float>(turn) * std::numbers::pi_v<float> / 12.0f, glm::vec3(1, 0, 0)));
        on_ground.body.frame = {basis, {0.0f, hull.support(-row(basis, 1)), 0.0f}};
        GroundManifold* const found = on_ground.find();
        REQUIRE(found);
        for (GroundPoint& point : found->points()) {
            const auto same = std::ranges::find(before, point.corner, &GroundPoint::corner);
            const bool known = same != before.end();
            ++(known ? kept : fresh);
            CHECK(point.speed == 0.0f);
            const PointImpulse last = known ? same->last : PointImpulse{};
            const PointImpulse start = known ? same->start : PointImpulse{};
            CHECK(point.last.normal == last.normal);
            CHECK(point.last.friction == last.friction);
            CHECK(point.start.normal == start.normal);
            CHECK(point.start.friction == start.friction);
            // As a solution leaves it.
            const auto mark = static_cast<float>(point.corner + 100 * turn + 1);
            point.speed = mark;
            point.last = {2.0f * mark, {mark, 0.0f, -mark}};
            const bool blow = (point.corner + turn) % 5 == 0;
            point.start = blow ? PointImpulse{} : PointImpulse{3.0f * mark, {4.0f * mark, 0.0f, mark}};
        }
        before.assign(found->points().begin(), found->points().end());
    }
    CHECK(kept > 20);
    CHECK(fresh >= 16); // each corner comes down once
}
