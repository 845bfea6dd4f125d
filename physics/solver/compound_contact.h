// Contacts of a body of several hulls: with a body of one hull, with another compound, or with the ground.
//
// The compound's tree of bounds finds the hulls that are near; each pair of hulls has contacts of its own
// (hull_contact.h, ground_contact.h), which live as long as their bounds overlap.
//
// A limit: there are no contacts until bounds overlap, so none is speculative.
#pragma once

#include <memory>

#include "physics/solver/pair_contacts.h"

namespace brittle::physics {

struct Body;

// At least one of the two is a compound; null for b: the ground.
[[nodiscard]] std::unique_ptr<PairContacts> make_compound_contacts(const Body& a, const Body* b);

} // namespace brittle::physics
