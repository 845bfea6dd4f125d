// Contacts of convex hulls with the ground plane y = height.
//
// Each corner of the hull is tested with the distance that it can travel in the coming step. A corner that would reach
// the ground gets a speculative contact, which lets it come down to the ground and no farther. With contacts that begin
// at the touch, a piece at 6 m/s and 120 Hz would already be 5 cm deep in the ground, and small pieces would never rise
// again.
//
// Four corners carry a hull. Up to eight more that would sink get contacts too. With four alone (the deepest and those
// far from it), a piece with two low corners rocks between two choices of four, and each corner sinks by millimetres
// while it is not chosen.
//
// Rejected: six contacts (pieces rock for ever) and contacts for corners farther up (a step up to half longer).
#pragma once

#include <memory>

#include "physics/solver/hull_contact.h"
#include "physics/solver/pair_contacts.h"

namespace brittle::physics {

[[nodiscard]] std::unique_ptr<PairContacts> make_ground_contacts(const HullOf& hull);

// Returns whether a body of one hull is too high above the ground for a contact in the step.
[[nodiscard]] bool is_out_of_reach_of_ground(const Body& body, const ContactStep& step);

} // namespace brittle::physics
