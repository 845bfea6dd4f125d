// Siblings: pieces of one cut that are added together and move as one rigid body.
//
// Siblings do not overlap: BodyDesc::siblings is a promise. While they move as one and touch nothing else, no force
// acts between them, and the narrow phase skips their pairs. A thousand new pieces in the air then cost their first
// step a fifth of a full search. In the step in which a sibling may reach the ground or another body, and as soon as
// siblings move against each other, all pairs of that cut are searched like others: a piece that is stopped stops those
// behind it in the same step.
//
// Body::siblings holds the number of the cut as long as its pieces move as one, and 0 afterwards.
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "physics/solver/body.h"
#include "physics/solver/sweep_broadphase.h"

namespace brittle::physics {

class Siblings {
  public:
    // Precondition: the body has not been in a step.
    void add(Body& body) {
        if (body.siblings != 0) bodies_.push_back(&body);
    }
    void remove(const Body& body);
    // Clears the number of the cuts whose pieces do not move as one. Call it before the narrow phase of each step.
    // Without ground, the height is empty.
    void check(const SweptPairs& pairs, std::optional<float> ground_height);

    [[nodiscard]] static bool fly_as_one(const Body& a, const Body& b) {
        return a.siblings != 0 && a.siblings == b.siblings;
    }

  private:
    std::vector<Body*> bodies_;   // siblings that move as one
    std::vector<uint32_t> apart_; // numbers of cuts whose pieces do not move as one
};

} // namespace brittle::physics
