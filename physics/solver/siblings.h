// Pieces of one cut that come to the world together and fly as one.
//
// They do not overlap (BodyDesc::siblings promises it). As long as none of them touches anything else and they move
// as one rigid body, no force acts between them, and their pairs need no search until two have moved against each
// other. A thousand new pieces in the air then cost the first step a fifth of a full search. Where one touches the
// ground or another body, or they move apart or into each other, their pairs are searched as all others.
//
// Body::siblings holds the number of the cut for the body's first step, and 0 afterwards.
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "physics/solver/body.h"
#include "physics/solver/sweep_broadphase.h"

namespace brittle::physics {

class Siblings {
  public:
    // A body that has not been in a step.
    void add(Body& body) {
        if (body.siblings != 0) bodies_.push_back(&body);
    }
    void remove(const Body& body);
    // Before pairs are searched: clears the number of bodies that do not fly as one. Nothing for the height: no ground.
    void check(const SweptPairs& pairs, std::optional<float> ground_height);
    // After the search.
    void forget();

    [[nodiscard]] static bool fly_as_one(const Body& a, const Body& b) {
        return a.siblings != 0 && a.siblings == b.siblings;
    }

  private:
    std::vector<Body*> bodies_;   // that have not been in a step
    std::vector<uint32_t> apart_; // numbers of cuts that do not fly as one
};

} // namespace brittle::physics
