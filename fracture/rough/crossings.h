// Finds where the rough cuts of a piece pass through its outside or through each other.
//
// A cut that nearly touches the surface, or that meets it where it bends sharply, may cross it after the way back
// (restore.h). The triangles that can cross are few: those of the cuts with a corner on the border of their facet, and
// those of the outside within two rings of triangles around a cut. Pairs of them are tested exactly (intersections.h).
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include <glm/vec3.hpp>

#include "fracture/base/threads.h"
#include "fracture/pieces/fragments.h"

namespace brittle::fracture::rough {

struct Crossing {
    uint32_t piece;
    glm::dvec3 centre; // of a triangle of a cut, m
    double radius;     // of a ball around it that contains the triangle, m
};

// Looks for them in one fracture after the other. Most pieces of a solid that is cut again with a warp that is calmed in
// a few places come out as before, to the bit; those are not looked at again.
class CrossingFinder {
  public:
    // Returns the triangles of cuts that cross another one of their piece, in the order of the pieces. `groups` is one
    // group a site, or empty: cuts within a group are left out. It is the same in all runs until forget().
    [[nodiscard]] std::vector<Crossing> run(const Fragments& pieces, std::span<const uint32_t> groups,
                                            Threads& threads);
    void forget() { last_ = {}; }

  private:
    [[nodiscard]] bool is_known(const Fragments& pieces, const Piece& piece) const;
    void remember(const Fragments& pieces, std::span<const Crossing> crossings);

    Fragments last_; // the pieces of the last run without crossings, in the order of their sites
};

} // namespace brittle::fracture::rough
