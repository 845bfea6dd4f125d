#include "physics/solver/body_cast.h"

#include <algorithm>
#include <optional>
#include <tuple>

#include <glm/geometric.hpp>

#include "physics/solver/time_of_impact.h"

namespace brittle::physics {

namespace {

// The extent of a hull along a direction of the world, margin included.
struct Extent {
    float low, high;

    Extent(const HullShape& hull, const Transform& frame, const glm::vec3& direction)
        : low(-support(hull, frame, -direction) - hull.margin()),
          high(support(hull, frame, direction) + hull.margin()) {}
};

// The middle of the common part of two extents.
float common_middle(const Extent& a, const Extent& b) {
    return 0.5f * (std::max(a.low, b.low) + std::min(a.high, b.high));
}

Trajectory trajectory_of(const Body& body, float seconds) {
    Trajectory path{.start = body.frame, .velocity = body.velocity, .moments = body.moments, .stop = seconds};
    if (body.fixed) path.velocity = {};
    path.find_end();
    return path;
}

// The bounds, in the target's frame, of the way of the cast body. Points between its places at both ends lie off the
// straight line by the sag of an arc at most.
Bounds way_of(const Body& cast, const Trajectory& path, const Trajectory& target, float seconds) {
    const Bounds first = cast.bounds(target.start.to_local(path.start)),
                 last = cast.bounds(target.end.to_local(path.end));
    const float turned = glm::length(target.velocity.angular) * seconds,
                rolled = glm::length(path.velocity.angular) * seconds;
    const float distance = std::max(glm::length(path.start.origin - target.start.origin),
                                    glm::length(path.end.origin - target.end.origin));
    const float sag = 0.125f * (turned * turned * (distance + cast.reach) + rolled * rolled * cast.reach);
    Bounds way{glm::min(first.low, last.low), glm::max(first.high, last.high)};
    return way.grown(glm::vec3(0.0f), sag);
}

} // namespace

std::vector<CastHit> cast_body(const Body& cast, const Body& target, float seconds) {
    std::vector<CastHit> hits;
    if (cast.compound || !(seconds > 0.0f)) return hits;
    const Trajectory path = trajectory_of(cast, seconds), beside = trajectory_of(target, seconds);
    const glm::vec3 relative = path.velocity.linear - beside.velocity.at(path.start.origin - beside.start.origin);
    const float speed = glm::length(relative);
    if (!(speed > 0.0f)) return hits;
    const glm::vec3 direction = relative * (1.0f / speed);
    const Tangents tangents = tangents_of(direction);
    const glm::vec3 &right = tangents.first, &up = tangents.second;
    const Extent right_of_cast(cast.hull(), cast.frame, right), up_of_cast(cast.hull(), cast.frame, up);
    const auto meet = [&](uint32_t part, const HullShape& hull, const Transform& local) {
        const std::optional<float> time =
            time_of_impact({&cast.hull(), {}, &path}, {&hull, local, &beside}, 0.0f, seconds);
        if (!time) return;
        const Transform frame = target.frame * local;
        const glm::vec3 point = common_middle(right_of_cast, {hull, frame, right}) * right
                                + common_middle(up_of_cast, {hull, frame, up}) * up
                                + glm::dot(frame.origin, direction) * direction;
        hits.push_back({part, *time, point, direction});
    };
    if (!target.compound) {
        meet(0, target.hull(), {});
    } else {
        const std::vector<CompoundShape::Child>& children = target.compound->children();
        target.compound->tree().for_each_overlap(way_of(cast, path, beside, seconds), [&](uint32_t part) {
            meet(part, children[part].shape(), children[part].frame);
        });
    }
    std::ranges::sort(hits, {}, [](const CastHit& hit) { return std::tuple(hit.seconds, hit.part); });
    return hits;
}

} // namespace brittle::physics
