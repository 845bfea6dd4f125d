// The pieces of a running simulation by number, at the poses at which they are drawn: for picking, and for blows of the
// hammer. A view: everything that it refers to must outlive it.
//
//     const PieceView pieces{simulation, *fragments, radii, poses};
//     if (auto hit = pieces.first(eye, direction)) simulation.apply(hammer_blow(simulation, *hit, direction, 0.3, 48));
#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <span>
#include <vector>

#include "engine/render/scene.h"
#include "fracture/pieces/fragments.h"
#include "tools/scenario/run/simulation.h"

namespace brittle::tools {

// A piece under the cursor.
struct PieceHit {
    uint32_t piece = 0;
    glm::vec3 point{0.0f}; // in the world
    glm::vec3 grip{0.0f};  // the point in the piece's frame
    double distance = 0.0; // m

    friend bool operator==(const PieceHit&, const PieceHit&) = default;
};

struct PieceView {
    const Simulation& simulation;
    const fracture::Fragments& fragments;    // fragments that the simulation was started with
    std::span<const float> radii;            // radii of the fragments' pieces; unused in a breakable world
    std::span<const engine::BodyPose> poses; // poses by slot

    [[nodiscard]] std::vector<uint32_t> numbers() const; // ascending
    [[nodiscard]] bool contains(uint32_t piece) const;
    // For pieces that exist:
    [[nodiscard]] const physics::SolidPiece* solid(uint32_t piece) const; // null in a world that is not breakable
    // Nothing for a piece that is too new to have been drawn.
    [[nodiscard]] std::optional<engine::BodyPose> pose(uint32_t piece) const;
    [[nodiscard]] double volume(uint32_t piece) const; // m^3
    [[nodiscard]] size_t triangles(uint32_t piece) const;
    [[nodiscard]] float radius(uint32_t piece) const; // m, around the centre of mass
    // The box around the ball of that radius, as drawn; nothing for a piece that is too new to have been drawn.
    [[nodiscard]] std::optional<engine::Bounds> bounds(uint32_t piece) const;

    // Returns the nearest piece along a ray, of those for which `skips` is false. `direction` is a unit vector.
    [[nodiscard]] std::optional<PieceHit> first(const glm::dvec3& from, const glm::dvec3& direction,
                                                const std::function<bool(uint32_t piece)>& skips = {}) const;

  private:
    [[nodiscard]] std::optional<double> distance_to(uint32_t piece, const glm::dvec3& from,
                                                    const glm::dvec3& direction) const;
};

// Returns the poses of all pieces after the last step, by slot. Precondition: the world is breakable.
[[nodiscard]] std::vector<engine::BodyPose> poses_by_slot(const Simulation& simulation);

// Returns the point of a hit in the simulation, which has advanced since the frame, or may be drawn exploded.
[[nodiscard]] glm::dvec3 place_of(const Simulation& simulation, const PieceHit& hit);

// Returns a hammer blow at a breakable piece that damages it within `radius`, m, into at most `max_pieces` pieces. The
// impulse is raised if that would not break the piece. `direction` is a unit vector.
[[nodiscard]] Hammer hammer_blow(const Simulation& simulation, const PieceHit& hit, const glm::dvec3& direction,
                                 double radius, uint32_t max_pieces);

} // namespace brittle::tools
