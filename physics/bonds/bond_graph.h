// The bonds between the pieces of a breakable object: their strength and health, and the islands that live bonds
// connect.
//
// A bond is the contact area of two pieces. Against an impulse it bears strength [Pa] * impact_seconds [s] * area
// [m^2], in N s. The strength depends on the direction of the impulse against the bond's normal:
// - Tension: the tensile strength. Shear: the shear strength. Between them: the ellipse of the two.
// - Compression: the smaller of the tensile and the compressive strength. A compressed body splits, as compression
//   causes tension across it (Hiramatsu and Oka, "Determination of the tensile strength of rock by a compression test
//   of an irregular test piece", 1966).
// - Tension and shear are multiplied by the lever min(1, area / (distance of the centres of mass)^2) of thin parts: a
//   pane breaks by bending over its span before it shears through.
// - All are multiplied by contact_strength_share() of the area: the crack of a hard contact weakens brittle materials.
// Health is the remaining share of strength: 1 intact, 0 broken. A broken bond never heals.
//
// Breaking a bond costs its area times its Material::fracture_energy of the blow's energy, and a blow breaks only what
// its energy pays for: glass shatters where wood, which is weaker, holds.
//
// Coordinates are those of the fragments; SI units. No bodies and no time: structure.h adds them. Deterministic. Not
// thread-safe.
//
//     BondGraph graph(fragments, material);
//     graph.blow(piece, impulse, energy);
//     for (const uint32_t bond : graph.take_broken()) ...
//     std::vector<std::vector<uint32_t>> islands = graph.islands(pieces);
#pragma once

#include <cstdint>
#include <limits>
#include <span>
#include <vector>

#include <glm/vec3.hpp>

#include "fracture/pieces/fragments.h"
#include "physics/material.h"

namespace brittle::physics {

// The share of a bond that goes to a part of one of its pieces.
struct BondShare {
    uint32_t bond = 0;
    uint32_t part = 0;        // of those that the piece is cut into
    double share = 1.0;       // of the area, 0 .. 1
    glm::dvec3 centroid{0.0}; // of this share
};

class BondGraph {
  public:
    struct Bond {
        uint32_t a = 0, b = 0; // pieces
        double area = 0.0;     // m^2
        glm::dvec3 centroid{0.0};
        glm::dvec3 normal{0.0}; // unit, from a to b
        double lever = 1.0;     // 0 .. 1, see above
        double share = 1.0;     // contact_strength_share() of the area
        double health = 1.0;    // 1 .. 0
        uint32_t material = 0;  // index into materials()

        [[nodiscard]] bool live() const { return health > 0.0; }
        [[nodiscard]] uint32_t other(uint32_t piece) const { return piece == a ? b : a; }
    };

    BondGraph() = default;
    // A bond without area, or one that names a piece that does not exist, is broken from the start.
    BondGraph(const fracture::Fragments& fragments, const Material& material);
    // The same with a material for each bond, in the order of Fragments::bonds.
    BondGraph(const fracture::Fragments& fragments, std::vector<Material> materials);

    [[nodiscard]] size_t piece_count() const { return first_.empty() ? 0 : first_.size() - 1; }
    [[nodiscard]] std::span<const Bond> bonds() const { return bonds_; }
    [[nodiscard]] std::span<const uint32_t> bonds_of(uint32_t piece) const;
    [[nodiscard]] size_t live_count() const;
    [[nodiscard]] std::span<const Material> materials() const { return materials_; } // one of all bonds, or one a bond

    // Replaces a piece by parts with these centres of mass, whose numbers begin at piece_count(). The piece itself stays,
    // without bonds. `shares` divide its live bonds, as share_bonds() does (bond_shares.h): the first share of a bond
    // takes the place of the whole, the others are added behind all bonds. Health stays as it was. The parts have no
    // bonds between them.
    void divide(uint32_t piece, std::span<const glm::dvec3> centres, std::span<const BondShare> shares);

    // Takes `share` (0 .. 1) of health from a bond. A bond that breaks is listed by take_broken().
    void weaken(uint32_t bond, double share);
    // Takes health from each bond whose area (as a disc) is nearer than radius to the point: `amount` at the point,
    // linearly less to 0 at the radius. inside: by piece; bonds whose piece a has 0 are skipped.
    void damage(const glm::dvec3& point, double radius, double amount, std::span<const uint8_t> inside);
    // Takes `amount` of health from each bond whose area (as a disc) is within radius of the segment.
    void damage_segment(const glm::dvec3& from, const glm::dvec3& to, double radius, double amount,
                        std::span<const uint8_t> inside);
    // Returns the impulse, N s, that an intact bond bears along a unit direction when piece `from` passes it on.
    [[nodiscard]] double impulse_strength(const Bond& bond, uint32_t from, const glm::dvec3& direction) const;
    // Returns the impulse, N s, that the bonds of a piece bear along a unit direction at their present health.
    [[nodiscard]] double bearing(uint32_t piece, const glm::dvec3& direction) const;
    // Returns the energy, J, that breaks all bonds of a piece.
    [[nodiscard]] double breaking_energy(uint32_t piece) const;
    // Applies a blow of `impulse` (N s) to a piece and returns the energy (J) that it spent on bonds.
    // - The bonds of the piece share the impulse in proportion to their impulse_strength().
    // - Half of a broken bond's excess passes to the piece behind it. The piece that was hit passes on at most
    //   max_passed (N s) in all: once loose, it pushes with its own momentum only.
    // - A blow below a tenth of the strength of all the piece's bonds leaves no damage.
    // - Where the remaining energy pays for a part of the damage to a piece's bonds only, each bond loses that part of
    //   it, none breaks, and the blow ends.
    double blow(uint32_t piece, const glm::dvec3& impulse, double energy,
                double max_passed = std::numeric_limits<double>::infinity());

    // Returns the bonds that broke since the last call, in order of breaking.
    [[nodiscard]] std::vector<uint32_t> take_broken();

    // Returns the connected components of a set of pieces, ordered by their lowest piece; pieces ascend within each.
    [[nodiscard]] std::vector<std::vector<uint32_t>> islands(std::span<const uint32_t> pieces) const;

  private:
    [[nodiscard]] const Material& material_of(const Bond& bond) const { return materials_[bond.material]; }
    [[nodiscard]] double energy_share(const Bond& bond) const;
    void find_strength(Bond& bond) const;
    void list_bonds();

    std::vector<Material> materials_;
    std::vector<glm::dvec3> centres_; // of mass, by piece
    std::vector<Bond> bonds_;
    std::vector<uint32_t> first_;    // by piece: begin of its range in of_piece_; piece_count() + 1 entries
    std::vector<uint32_t> of_piece_; // bonds, grouped by piece; without those that were broken when they were listed
    std::vector<uint32_t> broken_;
};

} // namespace brittle::physics
