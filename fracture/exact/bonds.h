// The contacts between the pieces of a fracture: one bond for each pair of pieces that share a cap.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include <glm/vec3.hpp>

#include "fracture/pieces/fragments.h"

namespace brittle::fracture::exact {

class BondFinder {
  public:
    // Fills out.bonds, ordered by (a, b), from the pieces, triangle_source and vertex_point. Only the directions
    // between sites are used. Several caps between two pieces (a facet cut into separate regions) make one bond; caps
    // without area make none.
    void run(std::span<const glm::dvec3> sites, Fragments& out);

    // The same for caps that are not flat: the area is that of the contact, the normal the mean over it.
    void run_bent(size_t sites, Fragments& out);

  private:
    template<class Measure>
    void visit_contacts(const Fragments& fragments, const Measure& measure);

    using Entry = std::array<uint32_t, 3>; // site, point, piece
    void index_pieces(size_t sites, const Fragments& fragments);
    // The piece of a site that contains a corner of a cut; no_index where the site has none.
    [[nodiscard]] uint32_t find_piece(uint32_t site, uint32_t point) const;
    [[nodiscard]] uint32_t pieces_of(uint32_t site) const { return first_piece_[site + 1] - first_piece_[site]; }

    std::vector<uint32_t> first_piece_; // per site, and the end: its first index into Fragments::pieces
    std::vector<Entry> islands_;        // sorted; the cut corners of sites with several pieces
};

} // namespace brittle::fracture::exact
