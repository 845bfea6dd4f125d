#include "physics/solver/ground_contact.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <span>
#include <vector>

#include "physics/solver/bearing_points.h"
#include "physics/solver/body.h"
#include "physics/solver/float4.h"
#include "physics/solver/hull_shape.h"
#include "physics/solver/manifold.h"
#include "physics/solver/prefetch.h"

namespace brittle::physics {

namespace {

// Corners nearer to the ground than this part of the hull's rotation radius touch it: a body at rest keeps its
// contacts while it trembles.
constexpr float resting_part = 0.02f;
// As the body moves, a contact ends beyond this part of its rotation radius.
constexpr float breaking_part = 0.02f;
constexpr size_t max_corners = GroundManifold::max_points;
constexpr size_t carrying_corners = 4;
// A corner that would be deeper than this at the end of the step, m, has a contact even where four others carry the
// body.
constexpr float sunk_depth = 1e-4f;
// The impact of one corner turns the body, and another comes down faster than it did: a rod's other end by half.
constexpr float approach_factor = 2.0f;

struct Corner {
    glm::vec3 position; // on the hull, margin included
    float distance;     // above the ground
    float ahead;        // distance at the end of the step if nothing stops it
    float apart;        // squared distance from the nearest kept corner
    int index;
};

// Keeps the carrying corners, and of the corners that would sink those farthest from all kept ones.
void keep_best(std::vector<Corner>& corners) {
    if (corners.size() <= carrying_corners) return;
    find_bearing(
        std::span(corners), [](const Corner& c) { return -c.ahead; }, [](const Corner& c) { return c.position; },
        [](const Corner&) { return glm::vec3(0, 1, 0); });
    const auto others = corners.begin() + carrying_corners;
    corners.erase(std::remove_if(others, corners.end(), [](const Corner& c) { return c.ahead > -sunk_depth; }),
                  corners.end());
    for (size_t i = carrying_corners; i < corners.size(); ++i) corners[i].apart = unbounded;
    const auto keep_away = [&](const glm::vec3& from, size_t behind) {
        for (size_t i = behind; i < corners.size(); ++i)
            corners[i].apart = std::min(corners[i].apart, length_squared(corners[i].position - from));
    };
    for (size_t i = 0; i < carrying_corners; ++i) keep_away(corners[i].position, carrying_corners);
    const size_t kept = std::min(corners.size(), max_corners);
    for (size_t place = carrying_corners; place < kept; ++place) {
        take_best(std::span(corners), place, [](const Corner& c) { return c.apart; });
        keep_away(corners[place].position, place + 1);
    }
    corners.resize(kept);
}

// The greatest height above the ground at which a corner may have a contact, of a hull whose origin is at a distance
// from the body's centre of mass.
float max_contact_height(const HullShape& hull, const Body& body, float arm, const ContactStep& step) {
    const float falling = body.velocity.linear.y + step.gravity * step.seconds;
    const float fastest = std::abs(falling) + glm::length(body.velocity.angular) * (arm + hull.radius());
    return resting_part * hull.rotation_radius() + approach_factor * fastest * step.seconds;
}

// The data of a contact that persists to the next step.
struct Known {
    int corner = 0;
    PointImpulse last, start;
};

class GroundContacts final : public PairContacts {
  public:
    explicit GroundContacts(const HullOf& hull)
        : hull_(hull), breaking_threshold_(breaking_part * hull.body->rotation_radius()) {}

    void update(const ContactStep& step) override {
        if (manifold_) prefetch(manifold_.get()); // the corners come first
        std::vector<Corner>& corners = find_corners(step);
        keep_best(corners);
        if (!manifold_ && corners.empty()) return;
        if (!manifold_) manifold_ = std::make_unique<GroundManifold>();
        replace_contacts(corners, step);
    }
    void refresh() override {
        if (!manifold_) return;
        const Transform& frame = hull_.body->frame;
        const auto gone = [&](const GroundPoint& point) {
            const glm::vec3 now = frame * point.local;
            const glm::vec3 below = point.position - glm::vec3(0, point.distance, 0);
            const float distance = now.y - below.y;
            const glm::vec3 aside = below - (now - glm::vec3(0, distance, 0));
            return distance > breaking_threshold_ || length_squared(aside) > breaking_threshold_ * breaking_threshold_;
        };
        const std::span<GroundPoint> points = manifold_->points();
        manifold_->count = static_cast<uint32_t>(std::remove_if(points.begin(), points.end(), gone) - points.begin());
    }
    void collect(std::vector<AnyManifold>& to) const override {
        if (manifold_ && manifold_->count > 0) to.emplace_back(*manifold_);
    }

  private:
    // Corners that touch the ground or may come to it in this step. Valid until the thread's next call.
    std::vector<Corner>& find_corners(const ContactStep& step) const {
        thread_local std::vector<Corner> corners;
        corners.clear();
        const HullShape& shape = *hull_.shape;
        const Body& body = *hull_.body;
        const float height = step.ground_height, seconds = step.seconds;
        const float falling = body.velocity.linear.y + step.gravity * seconds;
        const Transform frame = hull_.frame();
        const glm::vec3 &at = frame.origin, &spin = body.velocity.angular;
        const glm::vec3 arm = at - body.frame.origin;
        const float resting = resting_part * shape.rotation_radius();
        // Most bodies in the air are too high for any of their corners to come down in the step.
        const float above = at.y - height;
        const float highest = max_contact_height(shape, body, glm::length(arm), step);
        if (above - shape.radius() > highest) return corners;
        const bool touched = manifold_ && manifold_->count > 0; // seldom so high then; the corners give the same answer
        const glm::vec3 up = row(frame.basis, 1);
        if (!touched && above - shape.support(-up) - shape.margin() > highest) return corners;
        const std::span<const float> groups = shape.groups();
        for (size_t i = 0; i < groups.size(); i += HullShape::group_size) {
            const auto rotated = [&](int axis) { return HullShape::along(&groups[i], row(frame.basis, axis)); };
            const Float4 y = rotated(1) - Float4::all(shape.margin());
            const Float4 distance = (Float4::all(at.y) + y) - Float4::all(height);
            if (less(distance, Float4::all(highest)) == 0) continue;
            const Float4 x = rotated(0), z = rotated(2);
            const Float4 turning =
                Float4::all(spin.z) * (Float4::all(arm.x) + x) - Float4::all(spin.x) * (Float4::all(arm.z) + z);
            const Float4 none = Float4::all(0.0f), approach = none - (Float4::all(falling) + turning);
            const Float4 reached =
                Float4::all(resting) + Float4::all(approach_factor) * max(none, approach) * Float4::all(seconds);
            const auto first = static_cast<int>(i / HullShape::group_size) * 4;
            const uint32_t points = 0xfu >> std::max(first + 4 - shape.point_count(), 0); // without repetitions
            uint32_t low = less(distance, reached) & points;
            if (low == 0) continue;
            std::array<std::array<float, 4>, 5> lanes;
            for (const auto& [to, from] : {std::pair(&lanes[0], Float4::all(at.x) + x),
                                           {&lanes[1], Float4::all(at.y) + y},
                                           {&lanes[2], Float4::all(at.z) + z},
                                           {&lanes[3], distance},
                                           {&lanes[4], distance - approach * Float4::all(seconds)}})
                from.store(to->data());
            for (; low != 0; low &= low - 1) {
                const auto k = static_cast<size_t>(std::countr_zero(low));
                corners.push_back({{lanes[0][k], lanes[1][k], lanes[2][k]},
                                   lanes[3][k],
                                   lanes[4][k],
                                   0.0f,
                                   first + static_cast<int>(k)});
            }
        }
        return corners;
    }

    // A corner that was a contact before keeps its impulses for warm starting.
    void replace_contacts(const std::vector<Corner>& corners, const ContactStep& step) {
        GroundManifold& manifold = *manifold_;
        std::array<Known, max_corners> old;
        const size_t known = manifold.count;
        std::ranges::transform(manifold.points(), old.begin(), [](const GroundPoint& point) {
            return Known{point.corner, point.last, point.start};
        });
        const Body& body = *hull_.body;
        manifold.body = &body;
        manifold.part = hull_.part;
        manifold.friction = combined_friction(body.friction, step.ground_friction);
        manifold.slop = slop_part * hull_.shape->rotation_radius();
        manifold.restitution = body.restitution * step.ground_restitution;
        manifold.count = static_cast<uint32_t>(corners.size());
        const std::span<const Known> starts = std::span(old).first(known);
        for (size_t i = 0; i < corners.size(); ++i) {
            const Corner& corner = corners[i];
            GroundPoint& point = manifold.all[i];
            const auto same = std::ranges::find(starts, corner.index, &Known::corner);
            const Known before = same != starts.end() ? *same : Known{};
            // Member by member: the copy of a whole point would wait until its members are written (store forwarding).
            point.position = corner.position;
            point.local = hull_.local ? body.frame.to_local(corner.position) : glm::vec3(0.0f);
            point.distance = corner.distance;
            point.corner = corner.index;
            point.speed = 0.0f;
            point.last = before.last;
            point.start = before.start;
        }
    }

    HullOf hull_;
    float breaking_threshold_;
    std::unique_ptr<GroundManifold> manifold_; // since the first corner that touched
};

} // namespace

std::unique_ptr<PairContacts> make_ground_contacts(const HullOf& hull) {
    return std::make_unique<GroundContacts>(hull);
}

bool is_out_of_reach_of_ground(const Body& body, const ContactStep& step) {
    const float above = body.frame.origin.y - step.ground_height;
    return above - body.hull().radius() > max_contact_height(body.hull(), body, 0.0f, step);
}

} // namespace brittle::physics
