// Which piece holds which: the bonds of a breakable object, their health, and the islands they leave.
//
// A bond is the contact area of two pieces. Against a blow it impulse_strength strength [Pa] * impact_seconds * area [m^2], in N
// s: the tensile strength where it is pulled, that for shear across, and in between by the ellipse of them. Where it is
// pressed the tensile one as well, or the compressive one if that is less: what is pressed splits, as that pulls across it
// (Hiramatsu and Oka, "Determination of the tensile strength of rock by a compression test of an irregular test piece",
// 1966). Where it is not pressed, the lever min(1, area / (distance of the centres)^2) of thin parts counts, too: a pane
// breaks by bending over its span, not by shearing through. Health is the share of all that is left: 1 intact, 0 broken;
// broken bonds do not come back.
//
// What breaks takes its area times Material::fracture_energy of the blow's energy, and no more breaks than that pays for:
// glass goes to pieces where wood, which is weaker, holds.
//
// Coordinates are those of the fragments. No bodies, no time: structure.h has those. Everything is deterministic.
#pragma once

#include <cstdint>
#include <limits>
#include <span>
#include <vector>

#include <glm/vec3.hpp>

#include "fracture/pieces/fragments.h"
#include "physics/material.h"

namespace brittle::physics {

class BondGraph {
  public:
    struct Bond {
        uint32_t a = 0, b = 0; // pieces
        double area = 0.0;     // m^2
        glm::dvec3 centroid{0.0};
        glm::dvec3 normal{0.0}; // unit, from a to b
        double lever = 1.0;     // 0 .. 1
        double health = 1.0;    // 1 .. 0

        [[nodiscard]] bool live() const { return health > 0.0; }
        [[nodiscard]] uint32_t other(uint32_t piece) const { return piece == a ? b : a; }
    };

    BondGraph() = default;
    // Bonds without area or between pieces that do not exist are broken from the start.
    BondGraph(const fracture::Fragments& fragments, const Material& material);

    [[nodiscard]] size_t piece_count() const { return first_.empty() ? 0 : first_.size() - 1; }
    [[nodiscard]] std::span<const Bond> bonds() const { return bonds_; }
    [[nodiscard]] std::span<const uint32_t> bonds_of(uint32_t piece) const;
    [[nodiscard]] size_t live_count() const;

    // Takes a share of health, 0 to 1, from a bond; what breaks is found in take_broken().
    void weaken(uint32_t bond, double share);
    // A ball: a bond whose area comes within radius of the point loses amount, less with distance, nothing at the
    // radius. Of the pieces for which inside is not zero.
    void damage(const glm::dvec3& point, double radius, double amount, std::span<const uint8_t> inside);
    // A rod: a bond whose area comes within radius of the segment loses amount.
    void damage_segment(const glm::dvec3& from, const glm::dvec3& to, double radius, double amount,
                        std::span<const uint8_t> inside);
    // What a bond impulse_strength, N s, when the impulse along a unit direction comes from one of its pieces; as if it were intact.
    [[nodiscard]] double impulse_strength(const Bond& bond, uint32_t from, const glm::dvec3& direction) const;
    // A blow against a piece, N s. Its bonds share it by what they bear. Of what is more than a bond can bear, half goes
    // on to the piece behind, from the piece that was hit not more than max_passed in all: once it is loose, it can push
    // with its own momentum only. Blows below a tenth of what the piece's bonds bear together leave no trace. Where
    // the energy, J, pays for only a part of what the bonds of a piece would lose, each loses so much less, none breaks, and
    // the blow ends. Returns how much of it was spent.
    double blow(uint32_t piece, const glm::dvec3& impulse, double energy,
                double max_passed = std::numeric_limits<double>::infinity());

    // Bonds broken since the last call, in the order in which they broke.
    [[nodiscard]] std::vector<uint32_t> take_broken();

    // The connected parts of a set of pieces, in the order of their first pieces; pieces within one in ascending order.
    [[nodiscard]] std::vector<std::vector<uint32_t>> islands(std::span<const uint32_t> pieces) const;

  private:
    Material material_;
    std::vector<Bond> bonds_;
    std::vector<uint32_t> first_;    // by piece, into of_piece_; one more than there are pieces
    std::vector<uint32_t> of_piece_; // bonds of each piece
    std::vector<uint32_t> broken_;
};

} // namespace brittle::physics
