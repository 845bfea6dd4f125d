// The first hull that a ray enters (World::cast_rays()).
//
// Rays are sorted by place, and neighbours share a search in the bounds of the broadphase. Bodies are met where they are
// now: those that have left their bounds since the step are given.
//
// Metres. Pure functions; thread-safe.
#pragma once

#include <optional>
#include <span>

#include <glm/vec3.hpp>

#include "physics/solver/body.h"
#include "physics/solver/hull_shape.h"
#include "physics/solver/sweep_broadphase.h"
#include "physics/world/world.h"

namespace brittle::physics {

// The points from + share * along for shares from 0 to 1, in double: single precision would find a small hull at the end
// of a ray of a kilometre to a tenth of a millimetre only.
struct RaySegment {
    glm::dvec3 from, along;

    // In the coordinates of a frame.
    [[nodiscard]] RaySegment in(const Transform& frame) const;
    // Whether a share from 0 to `until` lies in a box.
    [[nodiscard]] bool crosses(const Bounds& box, double until) const;
};

struct HullEntry {
    double share = 0.0;
    glm::vec3 normal{0.0f}; // unit, outward, in the hull's axes
};

// Returns the share below `until` at which a segment in the hull's axes enters the hull: the intersection of the half
// spaces of its faces, moved outwards by its margin. Nothing for a segment that begins inside or on the surface, and for
// a hull without faces.
// T. L. Kay, J. T. Kajiya, "Ray Tracing Complex Scenes", 1986 (intersection of a ray with slabs).
[[nodiscard]] std::optional<HullEntry> entry_of(const RaySegment& ray, const HullShape& hull, double until);

// As Engine::cast_rays(). `strays`: the bodies that may have left their bounds, in body order.
void cast_rays(const SweepBroadphase& broadphase, std::span<const Body* const> strays, std::span<const Ray> rays,
               std::span<std::optional<RayHit>> hits);

} // namespace brittle::physics
