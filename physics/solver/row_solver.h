// The solver of a step: projected Gauss-Seidel over contacts and friction, as Bullet's own, on rows made for it.
//
// Bullet's makes rows of twice the size and solves the points of one contact after the other: each row waits for the one
// before, as both change the same two bodies. Here the first points of all pairs come first, then all second ones, so that
// rows beside each other have at most one body in common, and the processor works on several at a time. What has a body
// that never moves comes behind all others, so that each sweep ends with nothing going into the ground: otherwise a heavy
// piece presses a light one beneath it millimetres deep and holds it there. A sweep over contacts is followed by one over
// their friction. Bodies that have nothing to do with each other have their sweeps on different threads (bundles.h), those that touch
// nothing that moves all of them at once (held_rows.h, and on the ground lone_bodies.h); and beside them overlap is undone by moving
// (split impulses).
//
// - One friction direction a point: that in which it slides; where it does not, points beside each other take turns between
//   two. No joints, no rolling friction.
// - Where both bodies move they meet in one point, midway across a gap or an overlap. Bullet pushes each at its own side, and
//   friction then turns the two by more than it should.
// - A body that rests (SteppedWorld::let_rest()) is moved by nothing; between those that do, impulses stay what they were.
// - The solution starts from 0.85 of the impulses that the points have from the last one.
// - Bullet's units throughout. Not thread-safe, but works on several threads itself.
//
// E. Catto, "Iterative Dynamics with Temporal Coherence", 2005.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include <btBulletDynamicsCommon.h>

#include "fracture/base/parallel.h"
#include "physics/solver/any_manifold.h"
#include "physics/solver/body_record.h"
#include "physics/solver/bundles.h"
#include "physics/solver/held_rows.h"
#include "physics/solver/lone_bodies.h"
#include "physics/solver/row.h"

namespace brittle::physics {

class RowSolver {
  public:
    struct Step {
        float seconds = 0.0f;
        int sweeps = 0;
        btVector3 gravity{0, 0, 0};
        float separation_speed = 0.0f; // at which overlap of bodies that both move is undone, at most
        float min_bounce_speed = 0.0f; // slower blows do not bounce
    };
    // What became of one point of a contact of two bodies.
    struct Solved {
        const btPersistentManifold* manifold;
        btManifoldPoint* point;
        btVector3 position; // where it acts on what moves
        float distance;     // overlap as far as it counts
        float speed;        // at which the bodies approached along the normal
        float impulse;      // on the first body, along the normal
        btVector3 friction; // likewise, across it; until the sweeps are done, its direction
    };

    // Of bodies that are awake, in their order, and all contacts that any of them has. Changes their velocities by gravity and contacts, leaves
    // impulses in the points of the manifolds, and in the bodies the repair of overlap.
    void solve(std::span<BodyRecord* const> bodies, std::span<const AnyManifold> manifolds, const Step& step,
               fracture::Threads& threads);
    // In the order of manifolds and their points; of contacts with the ground, those keep it (GroundPoint).
    [[nodiscard]] std::span<const Solved> solved() const { return solved_; }

  private:
    // The movers of a manifold.
    static constexpr uint32_t nobody = UINT32_MAX;
    struct Between {
        uint32_t mover_a, mover_b; // nobody where it never moves
        uint32_t count;            // points
        [[nodiscard]] bool held() const { return mover_a == nobody || mover_b == nobody; }
    };
    // One side of a contact: a mover, or nothing where it never moves.
    struct Side {
        const Mover* mover;
        uint32_t index;
        btVector3 arm;
    };

    // What the rows of a contact are made of.
    struct Touch {
        Side a, b;                      // a moves
        btVector3 normal;               // from b to a
        float distance, undone_part;    // overlap as far as it counts, and the part of it that is undone
        float restitution, coefficient; // of friction
        float impulse, friction;        // to start from
        btVector3 along;                // in which friction acted on a
        bool odd;                       // the place among its manifold's points
    };

    static GroundStep ground_step(const Step& step);
    static Mover mover_of(const btRigidBody& rigid, const Step& step);
    void take_bodies(std::span<BodyRecord* const> bodies, const Step& step, fracture::Threads& threads);
    // Where each point is solved: by bundles, of each first points of pairs first; contacts with what never moves last.
    void order(std::span<const AnyManifold> manifolds, fracture::Threads& threads);
    void take_lone(std::span<const AnyManifold> manifolds);
    void order_held();
    [[nodiscard]] Between between(const AnyManifold& manifold) const;
    void make_rows(std::span<const AnyManifold> manifolds, const Step& step, fracture::Threads& threads);
    // Of the manifold's points, with their places, and where to note what becomes of them.
    void make_rows(btPersistentManifold& manifold, std::span<const uint32_t> places, std::span<Solved> solved,
                   const Step& step);
    void make_rows(GroundManifold& ground, std::span<const uint32_t> places, const Step& step);
    void make_rows_of_resting(GroundManifold& ground, std::span<const uint32_t> places, const Step& step);
    // Of one contact and its friction.
    struct Made {
        float speed;     // at which the sides approach
        btVector3 along; // of friction on a
    };
    Made make_row(const Touch& touch, size_t place, const Step& step);
    static Row row_along(const btVector3& normal, const Side& a, const Side& b);
    [[nodiscard]] Side side_of(const btCollisionObject* object, const btVector3& position) const;

    // Lets an impulse act along a row; on its first body only.
    static void push_first(const Row& row, float impulse, Motion* motions);
    static void give(const Row& row, float impulse, Motion* motions);
    static void resolve(Row& row, Motion* motions, float low, float high);
    static void resolve_held(Row& row, Motion* motions);
    // Sweeps over all contacts of a bundle and their friction; these two over those of bodies that both move.
    void sweep(uint32_t bundle, int count);
    static void press(std::span<Row> rows, Motion* motions);
    void rub(size_t begin, size_t end);
    // Contacts with overlap that is to be undone: of bodies that both move, and with what never moves.
    struct Deep {
        std::vector<Row> between, held;
    };
    void take_deep();
    void move_apart(Deep& deep, int sweeps);
    void solve_rows(const Step& step, fracture::Threads& threads);
    void hand_back(std::span<BodyRecord* const> bodies, std::span<const AnyManifold> manifolds, float seconds,
                   fracture::Threads& threads);
    void hand_back(BodyRecord& body, size_t mover, float seconds) const;
    void hand_back(Solved& contact, size_t place) const;
    void hand_back(GroundPoint& contact, size_t place) const;
    [[nodiscard]] HeldRows::Impulses impulses(size_t place) const;
    // Places of a manifold's points, and what becomes of them.
    [[nodiscard]] std::span<const uint32_t> places_of(size_t manifold) const;
    [[nodiscard]] std::span<Solved> solved_of(size_t manifold);

    std::vector<Mover> movers_;
    std::vector<float> lights_;     // of the movers
    Bundles bundles_;               // of movers
    std::vector<uint32_t> begins_;  // of bundles: their first places
    std::vector<uint32_t> indices_; // of movers, by the user index of their bodies
    std::vector<Solved> solved_;
    std::vector<uint32_t> keys_, starts_, places_; // of order()
    std::vector<Between> betweens_;                // by manifold
    std::vector<uint32_t> firsts_, solved_firsts_; // likewise: its first point among all, and among those of two bodies
    std::vector<Row> contacts_, frictions_;        // side by side, where both bodies move
    std::vector<float> coefficients_;              // of friction, beside them
    std::vector<float> depths_;                    // by place: wanted where overlap is undone; 0: there is none
    HeldRows held_rows_;                           // the others
    std::vector<uint32_t> held_movers_;            // of them
    LoneBodies lone_;                              // which need none of that
    uint32_t points_of_lone_ = 0;
    std::vector<uint32_t> touched_;         // by mover, scratch: how many it touches
    std::vector<Deep> deep_;                // by bundle, and behind them of movers without one
    size_t held_ = 0;                       // places from here on are those of contacts with what never moves
    std::vector<Motion> motions_, parting_; // of velocities, and of moving apart
};

} // namespace brittle::physics
