// A breakable object: bonded pieces that move as one body until bonds break, and then as the islands that are left.
//
//     Result<Structure> wall = Structure::create(world, fragments, {.material = concrete,
//         .motion = {.placement = at}, .anchored = anchor_to_ground(fragments, at)});
//     wall->damage(world, point, 0.3f, 1.0f);
//     each step:
//         world.step();
//         const Structure::Changes& changes = wall->update(world);
//     each frame: wall->visit_poses(world, alpha, 0, [&](uint32_t piece, const Pose& pose) { instances[piece] = pose; });
//
// - A body is a compound of the hulls of its pieces, with the sum of their masses and, by parallel axes, of their
//   inertias. Its axes are those of the fragments, its origin is its centre of mass.
// - A body that holds an anchored piece is fixed. When it breaks, islands without an anchor fall.
// - Bodies break in update() only. The new ones start with the velocity v + w x r of the old one at their centres and
//   its angular velocity w: momentum and angular momentum are those of before.
// - Contacts of the last step that came in faster than impact_speed are blows: see BondGraph::blow(). Those of heavy
//   bodies take longer and break less for their impulse (impact_seconds in material.h). How a blow falls on the steps does not
//   matter: it is judged whole (bond_blows.h). Where a blow splits a body,
//   the step is taken back for it and for all that touches it, directly or not: positions and velocities are those of
//   before the contacts. These are solved anew, as dead blows, for the islands, and all move on by a step: a ball goes
//   through a pane that would have held it, momentum is kept and no energy comes of it. World::contacts() then tells
//   what became of them. Where more than some hundred contacts hang together, the islands share what the body got.
// - A single piece that comes off while more than enough collide is debris (crowd.h); several that are bonded never are.
// - Weight of what is anchored, and contacts slower than that, are loads: bonds that carry too much wear (wear.h).
//
// Bonded convex pieces, compounds and islands: Mueller, Chentanez and Kim, "Real Time Dynamic Fracture with Volumetric
// Approximate Convex Decompositions", SIGGRAPH 2013, section 4.
//
// World coordinates, metres, kilograms, seconds. The fragments are not needed after create(). Bodies that someone
// else takes out of the world are gone, with their pieces. Every call gets the world it was created in.
// Deterministic; not thread-safe.
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <unordered_map>
#include <vector>

#include <glm/mat3x3.hpp>
#include <glm/vec3.hpp>

#include "fracture/pieces/fragments.h"
#include "physics/bonds/bond_blows.h"
#include "physics/bonds/bond_graph.h"
#include "physics/bonds/wear.h"
#include "physics/material.h"
#include "physics/world/hull.h"
#include "physics/world/pieces.h"
#include "physics/world/world.h"

namespace brittle::physics {

struct StructureDesc {
    Material material{};
    PlacedMotion motion{}; // an anchored body keeps its placement and does not move
    HullSettings hull{};
    PieceHulls hulls{}; // made ahead, one a piece (collision_hulls()); if there are any, hull is not looked at
    std::vector<uint32_t> anchored{}; // pieces held by the world (anchor.h)
    float impact_speed = 0.5f;        // m/s; slower contacts are no blows
    WearSettings wear{};
};

class Structure {
  public:
    // Adds the object's bodies to the world, as many as its bonds and anchors leave islands. Fails as add_pieces()
    // does, and on an anchored piece that does not exist (invalid_setting); then no body is added.
    static Result<Structure> create(World& world, const fracture::Fragments& fragments, const StructureDesc& desc = {});

    // Breaks bonds, indices as in Fragments::bonds. As all of the following it shows with the next update().
    void break_bonds(std::span<const uint32_t> bonds);
    // Breaks all bonds of a piece.
    void isolate(uint32_t piece);
    // Bonds whose area comes within radius (m) of the point lose up to amount of their health, which is 1 when intact;
    // linearly less with distance.
    void damage(const World& world, glm::vec3 point, float radius, float amount);
    // Bonds whose area comes within radius (m) of the segment lose amount: a saw, a bullet's path.
    void damage_segment(const World& world, glm::vec3 from, glm::vec3 to, float radius, float amount = 1.0f);
    // As if something of a kilogram hit the piece with this impulse, N s; nothing moves of it.
    void blow(const World& world, uint32_t piece, glm::vec3 impulse);
    // The world lets go of pieces.
    void release_anchors(std::span<const uint32_t> pieces);

    struct Changes {
        std::vector<uint32_t> broken; // bonds
        std::vector<BodyId> removed;
        std::vector<BodyId> added;
        std::vector<Impact> impacts;
    };
    // To be called after each step of the world: takes up its contacts, wears bonds and splits what broke. The result
    // is valid until the next call.
    const Changes& update(World& world);

    // Takes a piece out of world and structure, if it is alone in its body; nothing otherwise. Its motion is that
    // of the coordinates of the fragments: what it is cut into continues with it (StructureDesc::motion).
    std::optional<PlacedMotion> take_piece(World& world, uint32_t piece);
    // Takes the body of a piece out of world and structure with all its pieces. Their bonds break.
    void remove_body(World& world, uint32_t piece);
    // Takes all bodies out of the world.
    void remove(World& world);

    [[nodiscard]] const BondGraph& graph() const { return graph_; }
    [[nodiscard]] const Wear& wear() const { return wear_; }
    [[nodiscard]] size_t piece_count() const { return pieces_.size(); }
    [[nodiscard]] BodyId body_of(uint32_t piece) const; // none for a piece that was taken
    [[nodiscard]] bool anchored(uint32_t piece) const { return pieces_[piece].anchored; }
    // Of the body that a piece is in, itself among them, ascending; none for a piece that was taken.
    [[nodiscard]] std::span<const uint32_t> together_with(uint32_t piece) const;
    // Whether it came off and nothing holds it: its body is not fixed and has at most half of the pieces of its first one.
    [[nodiscard]] bool came_off(uint32_t piece) const;
    // Of a piece in its body: a vertex p of the fragments is drawn at p - centre in the pose of
    // visit_poses(), and lies at p - centre + offset in the body.
    [[nodiscard]] glm::vec3 offset(uint32_t piece) const;
    [[nodiscard]] std::vector<BodyId> bodies() const; // in the order in which they were made
    // Of the health of bonds, who is anchored, and in which body: what World::state_hash() does not know.
    [[nodiscard]] uint64_t state_hash() const;

    // Calls visit for each piece with the interpolated pose of its centre of mass, in the axes of the fragments: the pose of
    // the piece's body under add_pieces(). Order: by body, then by piece. Taken pieces and pieces of bodies with
    // World::last_moved_step() < since are skipped.
    using PoseVisitor = std::function<void(uint32_t piece, const Pose& pose)>;
    void visit_poses(const World& world, float alpha, uint64_t since, const PoseVisitor& visit) const;

  private:
    struct PieceState {
        glm::dvec3 centre{0.0}; // of mass, in the fragments
        double mass = 0.0;      // kg
        glm::dmat3 inertia{0.0};
        double impact_threshold = 0.0; // N s; blows above are impacts
        std::shared_ptr<const CollisionHull> hull;
        std::shared_ptr<const BodyForm> form; // of its body once it is alone and free; null where it can have none
        uint32_t body = UINT32_MAX;           // index into bodies_; none once taken
        size_t initial_pieces = 0;            // pieces of its first body
        bool anchored = false;
    };
    struct BodyState {
        BodyId id;              // none once it was split
        glm::dvec3 centre{0.0}; // of mass, in the fragments
        std::vector<uint32_t> pieces;
        bool fixed = false;
    };
    struct Motion { // of a body, in the world
        Pose pose;
        Pose previous;
        glm::vec3 linear{0.0f};
        glm::vec3 angular{0.0f};
        glm::dvec3 centre{0.0}; // what is at the pose's position, in the fragments
    };

    static constexpr uint32_t none = UINT32_MAX;

    [[nodiscard]] Motion motion_of(const World& world, const BodyState& body) const;
    Result<void> add_islands(World& world, std::span<const std::vector<uint32_t>> islands, const Motion& motion,
                             std::span<const uint8_t> debris);
    [[nodiscard]] BodyDesc describe(const std::vector<uint32_t>& island, const Motion& motion, BodyState& body) const;
    void make_forms(uint32_t threads);
    // Which of the islands that a body comes apart into are debris by number.
    [[nodiscard]] std::vector<uint8_t> choose_debris(const World& world,
                                                     std::span<const std::vector<uint32_t>> islands) const;
    [[nodiscard]] bool exists(const World& world, uint32_t body) const;
    [[nodiscard]] uint32_t index_of(BodyId body) const; // into bodies_, or none
    // The piece of ours that a contact's side names, or none.
    [[nodiscard]] uint32_t piece_at(BodyId body, uint32_t part) const;
    [[nodiscard]] std::vector<BondBlows::StepBlow> find_blows(const World& world) const;
    void apply_blow(const World& world, const BondBlows::JudgedBlow& judged);
    void wear_bonds(const World& world);
    // A contact of a body that comes apart, taken back from both.
    struct RewoundContact {
        size_t index; // into World::contacts()
        Contact original;
        uint32_t piece_a = none, piece_b = none;
    };
    [[nodiscard]] std::vector<size_t> contacts_to_rewind(const World& world,
                                                         const std::vector<uint8_t>& breaking) const;
    void solve_rewound(World& world, std::span<const RewoundContact> rewound) const;
    void locate(uint32_t piece, BodyId& body, uint32_t& part) const;
    void split(World& world);
    template<class Damage>
    void damage_bodies(const World& world, const Damage& damage);

    StructureDesc desc_; // without the anchors
    BondGraph graph_;
    BondBlows blows_;
    Wear wear_;
    std::vector<NodeLoad> weights_, contact_loads_; // scratch of one update
    std::vector<PieceState> pieces_;
    std::vector<BodyState> bodies_;
    std::unordered_map<uint32_t, uint32_t> body_of_id_; // by BodyId::value, of our bodies; looked up only
    std::vector<uint8_t> dirty_;                        // by body: may have come apart
    uint64_t steps_seen_ = 0;                           // of the world: contacts of a step are taken up once
    bool new_step_ = false;                             // in the current update
    Changes changes_;
};

} // namespace brittle::physics
