// Contacts of a body of several hulls: with a body of one hull, with another compound, or with the ground.
//
// The compound's tree of bounds finds the pairs of hulls whose bounds overlap. Each pair has contacts of its own
// (hull_contact.h, ground_contact.h), which live as long as the bounds overlap.
//
// A limit: without overlapping bounds there are no contacts, so none is speculative beyond them.
#pragma once

#include <memory>

#include "physics/solver/pair_contacts.h"

namespace brittle::physics {

struct Body;

// Precondition: at least one of the two is a compound. b is null for the ground.
[[nodiscard]] std::unique_ptr<PairContacts> make_compound_contacts(const Body& a, const Body* b);

} // namespace brittle::physics
