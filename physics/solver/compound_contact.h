// Contacts of a body of several hulls with one of one hull, or with the ground.
//
// Which of its hulls are near is asked of the compound's tree; each of those has contacts of its own with the other body
// (hull_contact.h, ground_contact.h), which live as long as the boxes of the two overlap. As Bullet's own algorithm, bit for bit,
// but that a pair is followed beside others (narrow_phase.h) in a step in which no hull comes near or goes: a shell of which a
// hundred pieces came off meets all of them. Two compounds are left to Bullet.
//
// A limit: there are no contacts until boxes overlap, so none is made ahead.
#pragma once

#include <memory>

class btCollisionDispatcher;

namespace brittle::physics {

class CompoundContacts {
  public:
    // From now on the dispatcher uses it for such pairs. Must outlive the dispatcher's pairs.
    explicit CompoundContacts(btCollisionDispatcher& dispatcher);
    ~CompoundContacts();

    // Bytes that the dispatcher's pool must have for a pair.
    static int pair_size();

  private:
    struct Impl;
    std::unique_ptr<Impl> impl_;
};

} // namespace brittle::physics
