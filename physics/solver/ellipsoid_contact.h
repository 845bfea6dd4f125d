// Contacts of debris with moving bodies of its size: each body is the ellipsoid of its hull's proportions, and a pair
// has one contact point.
//
// A heap of debris has four contacts a body. Hull contacts would have four points each, and cost ten times as much to
// find. Ellipsoids roll where hulls stand on their faces; a rolling friction in the contact holds heaps together.
//
// - The normal n, from b to a, is the direction along which the ellipsoids are farthest apart. With h(n) the support of
//   both and c the way from b's centre to a's, the distance is n . c - h(n): it never exceeds the true one.
// - Contacts are speculative: they reach ahead as far as the two may come closer in the step. The normal is that of the
//   predicted moment of touch, so that bodies pass each other freely.
// - Pieces of one cut fill space without gaps, so their ellipsoids overlap from the start. A pair keeps the overlap with
//   which it began as its slop; the slop shrinks with the overlap, and never grows again.
#pragma once

#include <memory>

#include <glm/vec3.hpp>

#include "physics/solver/pair_contacts.h"
#include "physics/solver/transform.h"

namespace brittle::physics {

struct Body;

// The squared semi-axes, m^2, of an ellipsoid about the origin with the proportions of the bounds of a hull and
// its volume; along the hull's axes.
[[nodiscard]] glm::vec3 squared_semi_axes(const Bounds& bounds, float volume);

// Returns whether the contacts of two bodies are those of ellipsoids: both move, one is debris, and neither has four
// times the other's volume.
[[nodiscard]] bool touch_as_ellipsoids(const Body& a, const Body& b);

// Precondition: touch_as_ellipsoids(a, b).
[[nodiscard]] std::unique_ptr<PairContacts> make_ellipsoid_contacts(const Body& a, const Body& b);

} // namespace brittle::physics
