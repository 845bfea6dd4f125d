// The contacts of a pair of bodies whose bounds overlap: the interface of the narrow phase.
#pragma once

#include <vector>

namespace brittle::physics {

struct AnyManifold;

// The properties of the step that the narrow phase reads.
struct ContactStep {
    float seconds = 0.0f;
    float gravity = 0.0f; // m/s^2, along Y: adds to the approach within the step
    float ground_height = 0.0f, ground_friction = 0.0f, ground_restitution = 0.0f;
};

// An update reads the bodies of the pair and writes to this object only, so pairs are updated in parallel.
class PairContacts {
  public:
    PairContacts() = default;
    PairContacts(const PairContacts&) = delete;
    PairContacts& operator=(const PairContacts&) = delete;
    virtual ~PairContacts() = default;

    // Finds the contacts of the coming step; contacts that persist keep their impulses.
    virtual void update(const ContactStep& step) = 0;
    // Moves the contacts with the bodies and drops those beyond the breaking threshold, without a search. A compound
    // calls it for all its hulls before it updates any of them.
    virtual void refresh() = 0;
    // Appends the manifolds that have contacts.
    virtual void collect(std::vector<AnyManifold>& to) const = 0;
};

} // namespace brittle::physics
