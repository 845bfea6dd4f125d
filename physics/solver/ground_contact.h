// Contacts of convex hulls with the ground plane y = height.
//
// Every corner of the hull is tested, each with the distance that it can travel in the coming step: a corner that
// would reach the ground has its contact before it does (a speculative contact), and the solver lets it come just as
// far. With contacts that begin at the touch, a piece at 6 m/s and 120 Hz is 5 cm deep in the ground by then, and
// small ones never come up again.
//
// Four corners carry a hull. Up to eight more that would sink have contacts too: with four alone, the deepest and
// those far from it, a piece with two low corners rocks between two choices of four, and each corner sinks
// millimetres deep while it is not chosen.
//
// A limit: the step that ends on the ground does so without a bounce from full speed, so fast impacts on the ground
// bounce less than their restitution says.
#pragma once

#include <memory>

#include "physics/solver/hull_contact.h"
#include "physics/solver/pair_contacts.h"

namespace brittle::physics {

[[nodiscard]] std::unique_ptr<PairContacts> make_ground_contacts(const HullOf& hull);

// Whether a body of one hull is so high above the ground that it has no contact in the step.
[[nodiscard]] bool is_out_of_reach_of_ground(const Body& body, const ContactStep& step);

} // namespace brittle::physics
