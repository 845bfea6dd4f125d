// A breakable object of bonded pieces. Connected pieces move as one rigid body; broken bonds split it into islands.
//
//     Result<Structure> wall = Structure::create(world, fragments, {.material = concrete,
//         .motion = {.placement = at}, .anchored = anchor_to_ground(fragments, at)});
//     wall->damage(world, point, 0.3f, 1.0f);
//     each step:
//         world.step();
//         const Structure::Changes& changes = wall->update(world);
//     each frame:
//         wall->visit_poses(world, alpha, 0, [&](uint32_t piece, const Pose& pose) { instances[piece] = pose; });
//
// - A body is a compound of its pieces' hulls. Its mass is the sum of theirs, its inertia the sum by parallel axes. Its
//   axes are those of the fragments; its origin is its centre of mass.
// - A body with an anchored piece is fixed. When it breaks, the islands without an anchor fall.
// - Bodies break in update() only. A new body starts with the velocity v + w x r of the old one at its centre of mass
//   and with its angular velocity w, which conserves momentum and angular momentum.
// - A blow is an impact that can break something: the contacts of one piece with one other body in one step whose
//   approach was faster than impact_speed. BondGraph::blow() turns it into damage. For equal impulse a heavier striker
//   breaks less, as its impact lasts longer (impact_seconds in material.h). bond_blows.h judges a blow that spreads
//   over several steps as one, so the result does not depend on how it falls on the steps.
// - A blow that splits a body rewinds the step for that body and for all bodies that touch it, directly or through
//   others: positions and velocities return to those before the contacts. The contacts are solved again for the
//   islands, inelastic and without friction, and the bodies move on by one step. A ball thus passes through a pane
//   that would have stopped it; momentum is conserved and energy does not rise. World::contacts() then holds the new
//   results.
// - In the rest of that step the striker meets further pieces of the broken body (World::cast()). Each is struck in
//   turn, as by a perfectly inelastic impact along the striker's motion. Its bonds hold if they bear the impulse that
//   stops the striker, or if its energy does not pay for them. Otherwise the piece breaks off: the body, and thus its
//   anchors, get the impulse that the bonds bear, and the striker pushes the free piece. The striker's speed behind the
//   body is therefore that of an inelastic impact with the mass in its way, whatever the number of pieces. A striker of
//   several hulls meets only what it touches.
// - A joint of a body goes on with the island of the piece that is nearest to its anchor. Its impulses are not taken
//   back by a rewind.
// - A piece that is cut goes on as its parts: divide() gives each of them the bonds that its area bears.
// - A single piece that comes off while more bodies collide than the limit allows becomes debris (crowd.h). A body of
//   several bonded pieces never does.
// - An assembly has pieces of several objects: with materials and hulls of their own, bonds of glue with a strength of
//   their own, and supports, which stand for what is fixed (StructureDesc). assembly.h makes one.
// - The weight of anchored bodies and contacts slower than impact_speed are loads. Overloaded bonds wear (wear.h).
//
// Bonded convex pieces, compounds and islands: Mueller, Chentanez and Kim, "Real Time Dynamic Fracture with Volumetric
// Approximate Convex Decompositions", SIGGRAPH 2013, section 4.
//
// World coordinates, right-handed; metres, kilograms, seconds. The fragments may be destroyed after create(). A body
// that other code removes from the world is gone together with its pieces. Every call takes the World that create()
// got. Deterministic. Not thread-safe.
#pragma once

#include <cstdint>
#include <functional>
#include <map>
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
#include "physics/world/joint.h"
#include "physics/world/piece_mass.h"
#include "physics/world/pieces.h"
#include "physics/world/world.h"

namespace brittle::physics {

struct StructureDesc {
    Material material{};
    PlacedMotion motion{}; // of the whole; an anchored body takes the placement only
    HullSettings hull{};
    PieceHulls hulls{};               // precomputed, one a piece (collision_hulls()); replaces `hull` unless empty
    std::vector<uint32_t> anchored{}; // pieces that are fixed to the world (anchor.h)
    float impact_speed = 0.5f;        // m/s; faster contacts are blows, slower ones loads
    WearSettings wear{};
    // Of an assembly: bodies of several objects whose bonds are glue or mortar (fracture/pieces/contacts.h finds them).
    // Each list is empty, or has an entry for each piece or bond.
    std::vector<Material> piece_materials{}; // in place of `material`; a body slides and bounces as its heaviest piece
    // Pa, tensile, >= 0; the other strengths of the bond are in proportion. 0: the weaker material of its two pieces.
    std::vector<float> bond_strength{};
    std::vector<std::vector<BodyPart>> piece_parts{}; // hulls, in place of `hulls`, from the piece's centre of mass
    // Pieces that stand for something fixed that others are glued to, such as a body that the world already has. They
    // are anchored, and have neither mass, hulls nor a body of their own.
    std::vector<uint32_t> supports{};
    std::vector<uint32_t> piece_objects{}; // numbers of the pieces' objects: is_detached() asks how much of one is left
};

class Structure {
  public:
    // Adds one body per island of the bond graph. Fails as add_pieces() does, and with invalid_setting on an anchored
    // piece or a support that does not exist, on a wrong number of entries in a list, and on an invalid strength. On
    // failure the world is unchanged.
    // check() finds all faults but those of bodies that the world refuses.
    [[nodiscard]] static Result<void> check(const fracture::Fragments& fragments, const StructureDesc& desc);
    static Result<Structure> create(World& world, const fracture::Fragments& fragments, const StructureDesc& desc = {});

    // The following functions damage bonds or anchors; bodies split in the next update().
    //
    // Breaks bonds, given by their indices in Fragments::bonds.
    void break_bonds(std::span<const uint32_t> bonds);
    // Breaks all bonds of a piece.
    void isolate(uint32_t piece);
    // Takes health (1: intact, 0: broken) from each bond whose area is nearer than radius (m) to the point: `amount`
    // at the point, linearly less to 0 at the radius.
    void damage(const World& world, glm::vec3 point, float radius, float amount);
    // Takes `amount` of health from each bond whose area is within radius (m) of the segment: a saw, a bullet's path.
    void damage_segment(const World& world, glm::vec3 from, glm::vec3 to, float radius, float amount = 1.0f);
    // Damages bonds as an impulse (N s) of a striker of 1 kg on the piece would. No body receives the impulse.
    void blow(const World& world, uint32_t piece, glm::vec3 impulse);
    // Removes the anchors of pieces.
    void release_anchors(std::span<const uint32_t> pieces);

    struct Changes {
        std::vector<uint32_t> broken; // bonds, in the order in which they broke
        std::vector<BodyId> removed;
        std::vector<BodyId> added;
        std::vector<Impact> impacts; // blows that exceed what their piece bears
        // Impulses, N s, that fixed bodies took on the way of a striker; World::contacts() does not have them.
        struct Held {
            glm::vec3 impulse{0.0f};
            glm::vec3 point{0.0f};
        };
        std::vector<Held> held;
    };
    // Applies the contacts of the last step to the bonds, wears overloaded bonds and splits bodies. Call it after each
    // World::step(). The result is valid until the next call.
    const Changes& update(World& world);

    // Removes a piece that is alone in its body from world and structure; returns nothing for any other piece. The
    // returned motion is that of the fragments' coordinate system: parts that the piece is cut into continue it
    // (StructureDesc::motion).
    std::optional<PlacedMotion> take_piece(World& world, uint32_t piece);

    // A part of a piece that is cut.
    struct Part {
        glm::dvec3 centre{0.0};                 // of mass, in the fragments
        BodyMass mass{};                        // kg, kg m^2
        std::vector<BodyPart> hulls{};          // from the centre of mass
        std::shared_ptr<const BodyForm> form{}; // of its body while alone and free; null: none was made ahead
        Material material{};
        bool anchored = false; // has an effect on the parts of an anchored piece alone
    };
    // Replaces a piece by its parts, at least one, whose numbers begin at piece_count(); the piece itself stays without
    // a body. Each bond of the piece goes to the parts that its area lies on (bond_shares.h), so the neighbours hold
    // what touches them, and the rest comes off. The body is replaced in the world by those of its islands, which
    // continue its motion. False, without effect, for a removed piece, and where no body can have the mass of a part.
    bool divide(World& world, uint32_t piece, std::span<const Part> parts);
    // Removes the body of a piece, with all its pieces, from world and structure; to remove one of several pieces would
    // change the mass of a moving body. The bonds of these pieces break.
    void remove_body(World& world, uint32_t piece);
    // Removes pieces from world and structure. What is left of their bodies moves on, split where it falls apart.
    void remove_pieces(World& world, std::span<const uint32_t> pieces);
    // Removes all bodies from the world.
    void remove(World& world);

    [[nodiscard]] const BondGraph& graph() const { return graph_; }
    [[nodiscard]] const Wear& wear() const { return wear_; }
    [[nodiscard]] size_t piece_count() const { return pieces_.size(); }
    [[nodiscard]] BodyId body_of(uint32_t piece) const; // BodyId{} for a removed piece
    // The piece at hull `part` of a body, or UINT32_MAX if the body is not of this structure.
    [[nodiscard]] uint32_t piece_at(BodyId body, uint32_t part) const;
    [[nodiscard]] bool anchored(uint32_t piece) const { return pieces_[piece].anchored; }
    // Returns all pieces of the piece's body, itself included, in ascending order; empty for a removed piece.
    [[nodiscard]] std::span<const uint32_t> pieces_of_body(uint32_t piece) const;
    // Returns whether the piece's body is not fixed and has at most half as many pieces as the piece's object had in
    // the piece's first body. The parts of a piece that was cut count as one, each by its share of the mass.
    [[nodiscard]] bool is_detached(uint32_t piece) const;
    // Returns the piece's centre of mass in body coordinates, m; zero for a removed piece. With `centre` the piece's
    // centre of mass in the fragments, vertex p of the fragments is at p - centre in the pose of visit_poses(), and at
    // p - centre + offset in the body.
    [[nodiscard]] glm::vec3 offset(uint32_t piece) const;
    // The position in body coordinates, m, of a point of the fragments that moves with a piece; zero for a removed piece.
    [[nodiscard]] glm::vec3 in_body(uint32_t piece, const glm::dvec3& point) const;
    [[nodiscard]] std::vector<BodyId> bodies() const; // in order of creation
    // Hashes the state that World::state_hash() lacks: health of bonds, anchors, and the body of each piece.
    [[nodiscard]] uint64_t state_hash() const;

    // Calls visit for each piece with the interpolated pose of its centre of mass, in the axes of the fragments: the
    // pose of the piece's body under add_pieces(). Order: by body, then by piece. Removed pieces and pieces of bodies
    // with World::last_moved_step() < since are skipped.
    using PoseVisitor = std::function<void(uint32_t piece, const Pose& pose)>;
    void visit_poses(const World& world, float alpha, uint64_t since, const PoseVisitor& visit) const;

  private:
    struct PieceState {
        glm::dvec3 centre{0.0}; // of mass, in the fragments
        double mass = 0.0;      // kg
        glm::dmat3 inertia{0.0};
        double impact_threshold = 0.0;          // N s by 1 kg; a harder blow is an Impact
        std::vector<BodyPart> parts;            // hulls, from the centre of mass; none of a support
        std::shared_ptr<const BodyForm> form{}; // of its body while alone and free; null if make_form() failed
        uint32_t body = UINT32_MAX;             // index into bodies_; none once removed
        double initial_pieces = 0.0;            // those of its object in its first body
        double count = 1.0;                     // of pieces: below 1 for a part of one
        float friction = 0.0f, restitution = 0.0f;
        bool anchored = false;
    };
    struct BodyState {
        BodyId id;              // BodyId{} once split or removed
        glm::dvec3 centre{0.0}; // of mass, in the fragments
        std::vector<uint32_t> pieces;
        std::vector<uint32_t> piece_of_part; // by hull; empty where each piece has one
        double count = 0.0;                  // of pieces; less than pieces.size() with parts of a piece that was cut
        bool fixed = false;
    };
    struct Motion { // of a body, in the world
        Pose pose;
        Pose previous;
        glm::vec3 linear{0.0f};
        glm::vec3 angular{0.0f};
        glm::dvec3 centre{0.0}; // point of the fragments at pose.position
    };

    static constexpr uint32_t none = UINT32_MAX;

    [[nodiscard]] Motion motion_of(const World& world, const BodyState& body) const;
    Result<void> add_islands(World& world, std::span<const std::vector<uint32_t>> islands, const Motion& motion,
                             std::span<const uint8_t> debris);
    [[nodiscard]] BodyDesc describe(const std::vector<uint32_t>& island, const Motion& motion, BodyState& body) const;
    static PieceState state_of(const glm::dvec3& centre, const BodyMass& mass, const Material& material,
                               std::vector<BodyPart> hulls);
    static StressNode stress_node(const PieceState& piece);
    void make_forms(uint32_t threads);
    // Returns 1 for each island of a split body that becomes debris because too many bodies collide, else 0.
    [[nodiscard]] std::vector<uint8_t> debris_of_islands(const World& world,
                                                         std::span<const std::vector<uint32_t>> islands) const;
    static Result<void> check_assembly(const fracture::Fragments& fragments, const StructureDesc& desc);
    static std::vector<Material> bond_materials(const fracture::Fragments& fragments, const StructureDesc& desc);
    // The islands without those of supports alone.
    [[nodiscard]] std::vector<std::vector<uint32_t>> with_bodies(std::vector<std::vector<uint32_t>> islands) const;
    // The pieces of a body by its hulls.
    static const std::vector<uint32_t>& pieces_by_part(const BodyState& body) {
        return body.piece_of_part.empty() ? body.pieces : body.piece_of_part;
    }
    [[nodiscard]] bool exists(const World& world, uint32_t body) const;
    [[nodiscard]] uint32_t index_of(BodyId body) const; // into bodies_, or none
    [[nodiscard]] std::vector<BondBlows::StepBlow> find_blows(const World& world) const;
    void apply_blow(const World& world, const BondBlows::JudgedBlow& judged);
    void wear_bonds(const World& world);
    struct Break { // a body and its islands
        uint32_t body = none;
        std::vector<std::vector<uint32_t>> islands;
    };
    struct SolvedContact { // of the step; its impulse is taken back from both bodies
        size_t index = 0;  // into World::contacts()
        Contact original;
        uint32_t piece_a = none, piece_b = none;
    };
    struct Push { // an impulse, N s, of a striker on a piece that it broke off
        uint32_t piece = none;
        glm::vec3 impulse{0.0f};
        glm::vec3 point{0.0f};
    };
    // A joint of a body that splits, and the piece that keeps it.
    struct HeldJoint {
        LooseJoint joint;
        uint32_t piece = none;
    };
    std::vector<HeldJoint> take_joints(World& world, uint32_t body) const;
    [[nodiscard]] std::vector<size_t> contacts_to_rewind(const World& world,
                                                         const std::vector<uint8_t>& breaking) const;
    [[nodiscard]] std::vector<Push> break_ways(World& world, std::span<const SolvedContact> solved,
                                               std::span<const uint8_t> breaking,
                                               const std::map<BodyId, float>& seconds_left);
    Push strike(World& world, BodyId striker, uint32_t piece, const CastHit& hit);
    void replace(World& world, const Break& broken);
    void solve_again(World& world, std::span<const SolvedContact> solved) const;
    void locate(uint32_t piece, BodyId& body, uint32_t& part) const;
    void split(World& world);
    template<class Damage>
    void damage_bodies(const World& world, const Damage& damage);

    StructureDesc desc_; // without the anchors
    BondGraph graph_;
    BondBlows blows_;
    Wear wear_;
    std::vector<NodeLoad> weights_, contact_loads_; // by piece; scratch of one update
    std::vector<PieceState> pieces_;
    std::vector<BodyState> bodies_;
    std::unordered_map<uint32_t, uint32_t> body_of_id_; // index into bodies_ by BodyId::value; never iterated
    std::vector<uint8_t> dirty_;                        // by body: 1 if it may have split
    uint64_t steps_seen_ = 0;                           // World::steps_taken() at the last update
    bool new_step_ = false;                             // whether the current update has contacts of a new step
    Changes changes_;
};

} // namespace brittle::physics
