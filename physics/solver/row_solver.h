// The solver of a step: projected Gauss-Seidel over constraint rows of contacts and friction (row.h).
//
// - The first points of all pairs come first, then all second points, so that rows beside each other have at most one
//   body in common and the processor works on several at a time.
// - Contacts with static bodies come behind all others: each sweep ends with no velocity into the ground. Otherwise a
//   heavy piece presses a light one below it millimetres into the ground and holds it there.
// - A sweep over contacts is followed by one over their friction.
// - Bodies that do not act on each other have their sweeps on different threads (bundles.h). Those that touch nothing
//   that moves have all sweeps at once (static_rows.h, and on the ground lone_bodies.h).
// - Overlap is corrected by split impulses: rows of their own change positions, not velocities.
// - One friction direction a point: the direction of sliding. Points that do not slide alternate between two tangents.
//   No joints, no rolling friction.
// - Two moving bodies meet in one point, midway across the gap or overlap. With a point on each side, friction would
//   turn the two more than it should.
// - A resting body (sleeping.h) has infinite mass; between two resting bodies impulses stay what they were.
// - Warm starting: the solution starts from 0.85 of the impulses that the points have from the last one.
//
// Metres, seconds, kilograms. Not thread-safe, but works on several threads itself.
//
// E. Catto, "Iterative Dynamics with Temporal Coherence", 2005.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include <glm/vec3.hpp>

#include "fracture/base/threads.h"
#include "physics/solver/body.h"
#include "physics/solver/bundles.h"
#include "physics/solver/lone_bodies.h"
#include "physics/solver/manifold.h"
#include "physics/solver/row.h"
#include "physics/solver/static_rows.h"

namespace brittle::physics {

class RowSolver {
  public:
    struct Step {
        float seconds = 0.0f;
        int sweeps = 0;
        glm::vec3 gravity{0.0f};
        float separation_speed = 0.0f; // m/s, the fastest correction of overlap between moving bodies
        float min_bounce_speed = 0.0f; // m/s; slower impacts do not bounce
    };
    // What became of one point between two bodies.
    struct Solved {
        const Manifold* manifold;
        ContactPoint* point;
        glm::vec3 position; // where it acts on what moves
        float distance;     // overlap as far as it counts
        float speed;        // m/s, at which the bodies approached along the normal
        float impulse;      // N s, on the first body, along the normal
        glm::vec3 friction; // N s, on the first body, across the normal; until the sweeps are done, its direction
    };

    // Awake bodies in body order, and all contacts of theirs. Changes the velocities by gravity and contacts, leaves
    // impulses in the points of the manifolds, and in the bodies the correction of overlap.
    void solve(std::span<Body* const> bodies, std::span<const AnyManifold> manifolds, const Step& step,
               fracture::Threads& threads);
    // In the order of manifolds and their points, without those on the ground, which keep it themselves (GroundPoint).
    [[nodiscard]] std::span<const Solved> solved() const { return solved_; }

  private:
    static constexpr uint32_t none = UINT32_MAX;
    // The solver bodies of a manifold; none where the side is static.
    struct Sides {
        uint32_t a, b;
        uint32_t count; // points
        [[nodiscard]] bool one_sided() const { return a == none || b == none; }
    };
    // One side of a contact: a solver body, or nothing where it is static.
    struct Side {
        const SolverBody* body;
        uint32_t index;
        glm::vec3 arm;
    };
    // What the rows of a contact are made of.
    struct Touch {
        Side a, b; // a moves
        glm::vec3 normal;
        float distance, correction_part;        // overlap as far as it counts, and the part of it that is corrected
        float restitution, coefficient;         // of friction
        float normal_impulse, friction_impulse; // for warm starting
        glm::vec3 tangent;                      // in which friction acted on a
        bool odd;                               // its place among its manifold's points
    };
    struct Made {
        float speed;       // m/s, at which the sides approach
        glm::vec3 tangent; // of friction on a
    };
    // Rows of contacts with overlap to correct: of two moving bodies, and with static ones.
    struct Deep {
        std::vector<Row> between, one_sided;
    };

    static GroundStep ground_step(const Step& step);
    static SolverBody solver_body(const Body& body, const Step& step);
    void take_bodies(std::span<Body* const> bodies, const Step& step, fracture::Threads& threads);
    // Gives each point its place: by bundles, in each the first points of pairs first; contacts with static bodies
    // last.
    void order(std::span<const AnyManifold> manifolds, fracture::Threads& threads);
    void take_lone(std::span<const AnyManifold> manifolds);
    void order_static();
    [[nodiscard]] Sides sides_of(const AnyManifold& manifold) const;
    void make_rows(std::span<const AnyManifold> manifolds, const Step& step, fracture::Threads& threads);
    // Of a manifold's points, given their places.
    void make_rows(Manifold& manifold, std::span<const uint32_t> places, std::span<Solved> solved, const Step& step);
    void make_rows(GroundManifold& ground, std::span<const uint32_t> places, const Step& step);
    void make_rows_of_resting(GroundManifold& ground, std::span<const uint32_t> places, const Step& step);
    // Of one contact and its friction.
    Made make_row(const Touch& touch, size_t place, const Step& step);
    static Row row_along(const glm::vec3& normal, const Side& a, const Side& b);
    [[nodiscard]] Side side_of(const Body& body, const glm::vec3& position) const;

    // dv += M^-1 J^T impulse; the first for the row's first body only.
    static void apply_first(const Row& row, float impulse, VelocityChange* changes);
    static void apply(const Row& row, float impulse, VelocityChange* changes);
    // One iteration; the second for a row whose b is static.
    static void solve_row(Row& row, VelocityChange* changes, float low, float high);
    static void solve_one_sided(Row& row, VelocityChange* changes);
    static void solve_contacts(std::span<Row> rows, VelocityChange* changes);
    void solve_friction(size_t begin, size_t end);
    // All sweeps over a bundle's contacts and friction.
    void sweep(uint32_t bundle, int count);
    void take_deep();
    void correct_overlap(Deep& deep, int sweeps);
    void solve_rows(const Step& step, fracture::Threads& threads);
    void store(std::span<Body* const> bodies, std::span<const AnyManifold> manifolds, float seconds,
               fracture::Threads& threads);
    void store(Body& body, size_t index, float seconds) const;
    void store(Solved& contact, size_t place) const;
    void store(GroundPoint& contact, size_t place) const;
    [[nodiscard]] StaticRows::Impulses impulses(size_t place) const;
    [[nodiscard]] std::span<const uint32_t> places_of(size_t manifold) const;
    [[nodiscard]] std::span<Solved> solved_of(size_t manifold);

    std::vector<SolverBody> bodies_;
    std::vector<float> inverse_masses_; // of the solver bodies
    Bundles bundles_;                   // of solver bodies
    std::vector<uint32_t> begins_;      // of bundles: their first places
    std::vector<uint32_t> indices_;     // of solver bodies, by body
    std::vector<Solved> solved_;
    std::vector<uint32_t> keys_, starts_, places_; // of order()
    std::vector<Sides> sides_;                     // by manifold
    std::vector<uint32_t> firsts_,
        solved_firsts_;                     // by manifold: its first point among all, and among those of two bodies
    std::vector<Row> contacts_, frictions_; // side by side, where both bodies move
    std::vector<float> coefficients_;       // of friction, beside them
    std::vector<float> corrections_;        // by place: the bias of the split impulse; 0: no overlap
    StaticRows static_rows_;                // the others
    std::vector<uint32_t> static_bodies_;   // of them
    LoneBodies lone_;                       // which need none of that
    uint32_t points_of_lone_ = 0;
    std::vector<uint32_t> touched_; // scratch, by solver body: how many manifolds it has
    std::vector<Deep> deep_;        // by bundle, and behind them of bodies without one
    size_t first_static_ = 0;       // places from here on are those of contacts with static bodies
    std::vector<VelocityChange> changes_, position_changes_; // of velocities, and of the correction of overlap
};

} // namespace brittle::physics
