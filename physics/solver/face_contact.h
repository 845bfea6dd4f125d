// Contact points of two hulls whose contact direction is known: the intersection of the two faces that look at each
// other, clipped in the plane across the direction.
//
// Face against face, edge against face, parallel edges and a corner on a face are one case: the face that looks most
// along the direction holds the touching edge or corner, and points of the intersection with a larger gap are left out.
// Each point has a feature, the pair of edges that cross there. It names the point from step to step, so the solver can
// start from the point's last impulse.
//
// Metres. Margins are not included. Pure functions; thread-safe.
//
// I. Sutherland, G. Hodgman, "Reentrant polygon clipping", 1974.
#pragma once

#include <cstdint>
#include <vector>

#include <glm/vec3.hpp>

#include "physics/solver/hull_shape.h"
#include "physics/solver/transform.h"

namespace brittle::physics {

// Names no pair of edges.
inline constexpr uint32_t no_feature = UINT32_MAX;

struct FacePoint {
    glm::vec3 on_first{0.0f}, on_second{0.0f}; // on the faces, apart along the normal only
    float gap = 0.0f;                          // from the second hull to the first along the normal
    uint32_t feature = no_feature;
};

// The faces that look at each other, and the direction of the contact.
struct FacingFaces {
    int first = -1, second = -1;
    glm::vec3 normal{0.0f}; // unit, from the second hull to the first
};

// Returns the faces that look at each other along a unit direction from the second hull to the first. All vectors are
// in the first hull's frame; second_in_first is the second hull's frame there. If a face encloses less than two degrees
// with the plane across the direction, its normal replaces the direction, which rounding may have tilted.
[[nodiscard]] FacingFaces facing_faces(const HullShape& first, const HullShape& second,
                                       const Transform& second_in_first, const glm::vec3& direction);

// Replaces `points` by the corners of the intersection of both faces. A corner that is outside the other face by less
// than `tolerance`, m, counts as inside, so that aligned edges do not change features by rounding. The result is empty
// if a hull has no faces, if a face is nearly parallel to the normal (a thin spike), and if the faces miss each other.
void clip_faces(const HullShape& first, const HullShape& second, const Transform& second_in_first,
                const FacingFaces& faces, float tolerance, std::vector<FacePoint>& points);

} // namespace brittle::physics
