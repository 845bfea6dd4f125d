// Solves the contacts of a step: projected Gauss-Seidel over constraint rows of contacts and friction. row.h has the
// equations; comments here use its letters.
//
// - Order of rows: the first points of all pairs, then all second points, and so on. Neighbouring rows then share at
//   most one body, and the processor overlaps their work. Rejected: graph colouring of rows, which was no faster.
// - Rows against static bodies come last, so that each sweep ends without velocity into the ground. Otherwise a heavy
//   piece presses a light one below it millimetres into the ground and holds it there.
// - A sweep begins with the joints, which are solved directly (joint_rows.h).
// - A sweep over contact rows is followed by a sweep over their friction rows.
// - Bodies that do not act on each other are solved on different threads (bundles.h). Bodies that touch no moving body
//   run all their substeps at once (static_rows.h; lone_bodies.h for bodies on the ground).
// - Overlap is corrected in the displacement of the bodies, before each substep, and leaves no velocity.
// - Friction is a cone: two tangents a point, solved together. There is no rolling friction.
// - Bodies move with a first solution, which closes gaps, and leave with a second one, in which contacts that press
//   close no more. Bounces are part of the second solution (row.h).
// - A body on which no contact acts moves along its parabola.
// - The contact point of two moving bodies is midway across the gap or overlap. With a point on each body, the lever
//   arms of friction would differ by the gap and turn the bodies too much.
// - A resting body (sleeping.h) has infinite mass; between two resting bodies impulses stay constant.
// - Warm starting: lambda starts from the point's last impulse, whose growth is limited (start_growth in row.h). A
//   smaller part would leave each step to find the rest anew, and a tall stack would sink. What it adds to the kinetic
//   energy is taken back after the first solution: all impulses of the component are scaled down.
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
#include "physics/solver/joints.h"
#include "physics/solver/lone_bodies.h"
#include "physics/solver/manifold.h"
#include "physics/solver/row.h"
#include "physics/solver/static_rows.h"

namespace brittle::physics {

class RowSolver {
  public:
    struct Step {
        float seconds = 0.0f;
        Substeps substeps;
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
        glm::vec3 friction; // N s, on the first body, across the normal
    };

    // Takes the awake bodies in body order, all their contacts, and their joints, which were started. Adds gravity and
    // the impulses of contacts and joints to the velocities, stores impulses in the points of the manifolds.
    void solve(std::span<Body* const> bodies, std::span<const AnyManifold> manifolds, Joints& joints, const Step& step,
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
        float distance;                 // m, limited as Solved::distance
        float slop;                     // m
        float restitution, coefficient; // e and mu
        PointImpulse start;             // on a
    };
    static GroundStep ground_step(const Step& step);
    static SolverBody solver_body(const Body& body);
    void take_bodies(std::span<Body* const> bodies, fracture::Threads& threads);
    // Assigns each point its place in the order of rows: by bundle, in each bundle by index in the manifold; points
    // against static bodies last.
    void order(std::span<const AnyManifold> manifolds, fracture::Threads& threads);
    void share_points();
    void take_lone(std::span<const AnyManifold> manifolds);
    void order_static();
    [[nodiscard]] Sides sides_of(const AnyManifold& manifold) const;
    void make_rows(std::span<const AnyManifold> manifolds, const Step& step, fracture::Threads& threads);
    // Rows of a manifold's points, with their places.
    void make_rows(Manifold& manifold, std::span<const uint32_t> places, std::span<Solved> solved, const Step& step);
    void make_rows(GroundManifold& ground, std::span<const uint32_t> places, const Step& step);
    void make_rows_of_resting(GroundManifold& ground, std::span<const uint32_t> places, const Step& step);
    // Builds the rows of one contact; returns the approach speed before the step's gravity, m/s.
    float make_row(const Touch& touch, size_t place, const Step& step);
    static Row row_along(const glm::vec3& normal, const Side& a, const Side& b);
    static FrictionRows friction_of(const Touch& touch);
    [[nodiscard]] Side side_of(const Body& body, const glm::vec3& position) const;

    // dv += M^-1 J^T impulse
    static void apply(const Row& row, float impulse, VelocityChange* changes);
    static void apply(const FrictionRows& rows, const float* impulse, VelocityChange* changes);
    // One iteration (row.h).
    static void solve_row(Row& row, VelocityChange* changes);
    static float along(const Row& row, const VelocityChange* changes);
    static void solve_contacts(std::span<Row> rows, VelocityChange* changes);
    void solve_friction(size_t begin, size_t end);
    // All substeps of a bundle.
    void solve_bundle(uint32_t bundle, const Substeps& substeps);
    void sweep(uint32_t bundle, int count, Solution solution);
    void start(uint32_t bundle, const Substeps& substeps);
    void spread(uint32_t bundle);
    void limit_energy(uint32_t bundle, const Substeps& substeps);
    void move(uint32_t bundle, float seconds);
    void start_second(uint32_t bundle);
    [[nodiscard]] bool start_bounce(uint32_t bundle);
    void finish(uint32_t bundle);
    [[nodiscard]] std::span<Row> contacts_of(uint32_t bundle);
    [[nodiscard]] std::span<const uint32_t> bodies_of(uint32_t bundle) const;
    void list_bodies();
    void solve_rows(const Step& step, fracture::Threads& threads);
    void store(std::span<Body* const> bodies, std::span<const AnyManifold> manifolds, const Step& step,
               fracture::Threads& threads);
    void store(Body& body, size_t index, const Step& step) const;
    void store(Solved& contact, size_t place) const;
    void store(GroundPoint& contact, size_t place) const;
    [[nodiscard]] StaticRows::Impulses impulses(size_t place) const;
    // The friction impulse of a point along the tangents of its normal.
    static glm::vec3 friction_along(const Tangents& tangents, const std::array<float, 2>& impulse);
    [[nodiscard]] std::span<const uint32_t> places_of(size_t manifold) const;
    [[nodiscard]] std::span<Solved> solved_of(size_t manifold);

    Joints* joints_ = nullptr; // of the step
    std::vector<SolverBody> bodies_;
    std::vector<float> inverse_masses_; // of the solver bodies
    Bundles bundles_;                   // of solver bodies
    std::vector<uint32_t> begins_;      // by bundle: its first place
    std::vector<uint32_t> indices_;     // of solver bodies, by body
    std::vector<Solved> solved_;
    std::vector<uint32_t> keys_, starts_, places_; // of order()
    std::vector<Sides> sides_;                     // by manifold
    std::vector<uint32_t> firsts_,
        solved_firsts_;                   // by manifold: its first point in places_ and in solved_
    std::vector<Row> contacts_;           // by place, of points between moving bodies
    std::vector<FrictionRows> frictions_; // parallel to them
    std::vector<float> coefficients_;     // mu, by place
    StaticRows static_rows_;              // of points against static bodies
    std::vector<uint32_t> static_bodies_; // by static row: its solver body
    LoneBodies lone_;                     // bodies without rows in the members above
    uint32_t points_of_lone_ = 0;
    std::vector<uint32_t> touched_; // scratch, by solver body: number of its manifolds
    std::vector<uint32_t> points_;  // scratch, by solver body: number of its contact points
    size_t first_static_ = 0;       // places from here on belong to static rows
    std::vector<VelocityChange> changes_;
    std::vector<Displacement> moved_;
    std::vector<VelocityChange> free_changes_;            // dv after the gravity of the substep, without its impulses
    std::vector<Descent> descents_;                       // by component
    std::vector<AddedEnergy> added_;                      // by component
    std::vector<uint8_t> jointed_;                        // by solver body: 1 for a body with joints
    std::vector<uint8_t> acted_;                          // by solver body, as in StaticRows::State
    std::vector<uint32_t> bundle_bodies_, bundle_begins_; // solver bodies by bundle, and the first of each
};

} // namespace brittle::physics
