// The contacts of a pair of bodies whose bounds overlap: the interface of the narrow phase.
#pragma once

#include <vector>

namespace brittle::physics {

struct AnyManifold;

// What a search for contacts needs of the step.
struct ContactStep {
    float seconds = 0.0f;
    float gravity = 0.0f; // m/s^2, along Y: what falls comes down faster than its velocity says
    float ground_height = 0.0f, ground_friction = 0.0f, ground_restitution = 0.0f;
};

// Reads the bodies of its pair and changes nothing but itself: pairs are updated side by side.
class PairContacts {
  public:
    PairContacts() = default;
    PairContacts(const PairContacts&) = delete;
    PairContacts& operator=(const PairContacts&) = delete;
    virtual ~PairContacts() = default;

    // Finds the contacts for the coming step; contacts of the last one keep their impulses.
    virtual void update(const ContactStep& step) = 0;
    // Moves the contacts with the bodies and drops those that have come apart, without a search. For a hull of a
    // compound, before any of its pair's hulls is updated.
    virtual void refresh() = 0;
    // Appends the manifolds that have contacts.
    virtual void collect(std::vector<AnyManifold>& to) const = 0;
};

} // namespace brittle::physics
