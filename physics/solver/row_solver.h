// Solves the contacts of a step: projected Gauss-Seidel over constraint rows of contacts and friction. row.h has the
// equations; comments here use its letters.
//
// - Order of rows: the first points of all pairs, then all second points, and so on. Neighbouring rows then share at
//   most one body, and the processor overlaps their work. Rejected: graph colouring of rows, which was no faster.
// - Rows against static bodies come last, so that each sweep ends without velocity into the ground. Otherwise a heavy
//   piece presses a light one below it millimetres into the ground and holds it there.
// - A sweep over contact rows is followed by a sweep over their friction rows.
// - Bodies that do not act on each other are solved on different threads (bundles.h). Bodies that touch no moving body
//   run all their sweeps at once (static_rows.h; lone_bodies.h for bodies on the ground).
// - Split impulses correct overlap: rows of their own change positions, and no velocities.
// - One friction direction a point: the direction of sliding. Points that do not slide alternate between two tangents.
//   There are no joints and no rolling friction.
// - The contact point of two moving bodies is midway across the gap or overlap. With a point on each body, the lever
//   arms of friction would differ by the gap and turn the bodies too much.
// - A resting body (sleeping.h) has infinite mass; between two resting bodies impulses stay constant.
// - Warm starting: lambda starts from 0.85 of the point's last impulse.
//
// Metres, seconds, kilograms. Not thread-safe; works on several threads itself.
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
    // The solution of one point between two bodies.
    struct Solved {
        const Manifold* manifold;
        ContactPoint* point;
        glm::vec3 position; // m, world: where the impulse acts
        float distance;     // m; an overlap is limited to what a step may correct
        float speed;        // m/s, approach speed along the normal, before the step's gravity
        float impulse;      // N s, on the first body, along the normal
        glm::vec3 friction; // N s, on the first body, across the normal; during the sweeps its unit direction
    };

    // Takes the awake bodies in body order and all their contacts. Adds gravity and contact impulses to the velocities,
    // stores impulses in the points of the manifolds, and the correction of overlap in the bodies.
    void solve(std::span<Body* const> bodies, std::span<const AnyManifold> manifolds, const Step& step,
               fracture::Threads& threads);
    // In the order of manifolds and their points. Points on the ground are left out; GroundPoint holds their solution.
    [[nodiscard]] std::span<const Solved> solved() const { return solved_; }

  private:
    static constexpr uint32_t none = UINT32_MAX;
    // The solver bodies of a manifold; `none` for a static side.
    struct Sides {
        uint32_t a, b;
        uint32_t count; // points
        [[nodiscard]] bool one_sided() const { return a == none || b == none; }
    };
    // One side of a contact; `body` is null for a static side.
    struct Side {
        const SolverBody* body;
        uint32_t index;
        glm::vec3 arm;
    };
    // Input of the rows of one contact.
    struct Touch {
        Side a, b; // a is never static
        glm::vec3 normal;
        float distance, correction_part;        // m, limited as Solved::distance; part of the overlap to correct
        float restitution, coefficient;         // e and mu
        float normal_impulse, friction_impulse; // for warm starting
        glm::vec3 tangent;                      // last direction of friction on a
        bool odd;                               // whether its index in the manifold is odd
    };
    struct Made {
        float speed;       // m/s, approach speed before the step's gravity
        glm::vec3 tangent; // unit direction of friction on a
    };
    // Split-impulse rows of contacts with overlap: between moving bodies, and against static ones.
    struct Deep {
        std::vector<Row> between, one_sided;
    };

    static GroundStep ground_step(const Step& step);
    static SolverBody solver_body(const Body& body, const Step& step);
    void take_bodies(std::span<Body* const> bodies, const Step& step, fracture::Threads& threads);
    // Assigns each point its place in the order of rows: by bundle, in each bundle by index in the manifold; points
    // against static bodies last.
    void order(std::span<const AnyManifold> manifolds, fracture::Threads& threads);
    void take_lone(std::span<const AnyManifold> manifolds);
    void order_static();
    [[nodiscard]] Sides sides_of(const AnyManifold& manifold) const;
    void make_rows(std::span<const AnyManifold> manifolds, const Step& step, fracture::Threads& threads);
    // Rows of a manifold's points, with their places.
    void make_rows(Manifold& manifold, std::span<const uint32_t> places, std::span<Solved> solved, const Step& step);
    void make_rows(GroundManifold& ground, std::span<const uint32_t> places, const Step& step);
    void make_rows_of_resting(GroundManifold& ground, std::span<const uint32_t> places, const Step& step);
    // Builds the row of one contact and of its friction.
    Made make_row(const Touch& touch, size_t place, const Step& step);
    static Row row_along(const glm::vec3& normal, const Side& a, const Side& b);
    [[nodiscard]] Side side_of(const Body& body, const glm::vec3& position) const;

    // dv += M^-1 J^T impulse; apply_first() for side a only.
    static void apply_first(const Row& row, float impulse, VelocityChange* changes);
    static void apply(const Row& row, float impulse, VelocityChange* changes);
    // One iteration (row.h); solve_one_sided() for a row whose b is static, with lambda >= 0.
    static void solve_row(Row& row, VelocityChange* changes, float low, float high);
    static void solve_one_sided(Row& row, VelocityChange* changes);
    static void solve_contacts(std::span<Row> rows, VelocityChange* changes);
    void solve_friction(size_t begin, size_t end);
    // Warm starting and all sweeps over a bundle's contacts and friction.
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
    std::vector<uint32_t> begins_;      // by bundle: its first place
    std::vector<uint32_t> indices_;     // of solver bodies, by body
    std::vector<Solved> solved_;
    std::vector<uint32_t> keys_, starts_, places_; // of order()
    std::vector<Sides> sides_;                     // by manifold
    std::vector<uint32_t> firsts_,
        solved_firsts_;                     // by manifold: its first point in places_ and in solved_
    std::vector<Row> contacts_, frictions_; // by place, of points between moving bodies
    std::vector<float> coefficients_;       // mu, by place
    std::vector<float> corrections_;        // by place: bias of the split impulse, N s; 0 without overlap
    StaticRows static_rows_;                // of points against static bodies
    std::vector<uint32_t> static_bodies_;   // by static row: its solver body
    LoneBodies lone_;                       // bodies without rows in the members above
    uint32_t points_of_lone_ = 0;
    std::vector<uint32_t> touched_;                          // scratch, by solver body: number of its manifolds
    std::vector<Deep> deep_;                                 // by bundle; last: of bodies without a bundle
    size_t first_static_ = 0;                                // places from here on belong to static rows
    std::vector<VelocityChange> changes_, position_changes_; // dv of velocities and of split impulses
};

} // namespace brittle::physics
