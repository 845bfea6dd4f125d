// The pieces of a simulation by their numbers, whole or cut anew, where they are drawn: for picking, and for blows of the
// hammer. A view: all that it is made of must outlive it.
//
//     const PieceView pieces{simulation, *fragments, radii, poses};
//     if (auto hit = pieces.first(eye, direction)) simulation.apply(hammer_blow(simulation, *hit, direction, 0.3, 48));
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "engine/render/scene.h"
#include "fracture/pieces/fragments.h"
#include "tools/brittle/run/simulation.h"

namespace brittle::tools {

// A piece under the cursor.
struct PieceHit {
    uint32_t piece = 0;
    glm::vec3 point{0.0f}; // in the world
    glm::vec3 grip{0.0f};  // the same in the piece's frame
    double distance = 0.0; // m

    friend bool operator==(const PieceHit&, const PieceHit&) = default;
};

struct PieceView {
    const Simulation& simulation;
    const fracture::Fragments& fragments;    // that it was started with
    std::span<const float> radii;            // of their pieces; of what is cut anew none are needed
    std::span<const engine::BodyPose> poses; // by slot

    [[nodiscard]] std::vector<uint32_t> numbers() const; // ascending
    [[nodiscard]] bool contains(uint32_t piece) const;
    // Of a piece that exists:
    [[nodiscard]] const physics::SolidPiece* solid(uint32_t piece) const; // null where nothing is cut anew
    [[nodiscard]] std::optional<engine::BodyPose>
    pose(uint32_t piece) const;                        // none for one that is too new to be drawn
    [[nodiscard]] double volume(uint32_t piece) const; // m^3
    [[nodiscard]] size_t triangles(uint32_t piece) const;
    [[nodiscard]] float radius(uint32_t piece) const; // m, around the centre of mass

    // The nearest along a ray with a unit direction.
    [[nodiscard]] std::optional<PieceHit> first(const glm::dvec3& from, const glm::dvec3& direction) const;

  private:
    [[nodiscard]] std::optional<double> distance_to(uint32_t piece, const glm::dvec3& from,
                                                    const glm::dvec3& direction) const;
};

// Where the hit is in the simulation, which has gone on since it was drawn, or is drawn exploded.
[[nodiscard]] glm::dvec3 place_of(const Simulation& simulation, const PieceHit& hit);

// A blow at what is breakable whose damage reaches so far, m, into so many pieces at most; harder where that would not break
// the piece. `direction` is a unit one.
[[nodiscard]] Hammer hammer_blow(const Simulation& simulation, const PieceHit& hit, const glm::dvec3& direction,
                                 double radius, uint32_t max_pieces);

} // namespace brittle::tools
