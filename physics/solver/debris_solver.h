// Solves the contacts of debris: a solver of fewer substeps and simpler rows beside RowSolver, for thousands of bodies.
//
// Its *members* are the bodies without joints that contacts connect with a piece of debris that touches a moving body:
// a heap is solved as a whole. It solves all contacts of its members, and all contacts between ellipsoids. Other moving
// bodies in these contacts, those with joints, are *guests*: RowSolver solves their joints and the rest of their contacts
// first, and the change of velocity and displacement that it finds acts on them here, spread over the step. So that
// RowSolver finds guests supported that rest on debris, they start the step with the impulses from which their contacts
// with debris start (push_guests()). Solving only the debris here and the other bodies as guests would shake heaps.
//
// - A step has `substeps` substeps. Each adds gravity, applies the last impulses (warm starting, with the limit of
//   growth of row.h), solves all contacts once with velocities that close gaps, moves the bodies, and solves all
//   contacts again with the target velocity zero (the two solutions of row.h). Bounces follow the last one.
// - Impulses act on both bodies, so they conserve momentum and angular momentum. Those that start a substep, and its
//   first solution, are scaled down where they add energy (limit_energy()). Overlap is corrected in the displacement and
//   leaves no velocity.
// - Bodies are sorted into slabs along the axis on which they spread most. A contact belongs to the lower of its two
//   slabs. Slabs of even numbers are solved side by side, then those of odd numbers, then the contacts that reach
//   farther than a neighbour slab, then those with static bodies. Within a slab contacts are coloured, and four of one
//   colour are solved in lanes.
//   Nothing depends on the number of threads.
//
// Metres, seconds, kilograms. Not thread-safe; works on several threads itself.
//
// M. Macklin et al., "Small steps in physics simulation", 2019; E. Catto, "Solver2D", 2024.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "fracture/base/threads.h"
#include "physics/solver/body.h"
#include "physics/solver/debris_rows.h"
#include "physics/solver/manifold.h"
#include "physics/solver/row_solver.h"

namespace brittle::physics {

class DebrisSolver {
  public:
    static constexpr int substeps = 4;

    struct Step {
        float seconds = 0.0f;
        glm::vec3 gravity{0.0f};
        float separation_speed = 0.0f; // m/s, upper bound of the correction of overlap between moving bodies
        float min_bounce_speed = 0.0f; // m/s; slower impacts do not bounce
        // Parts of an overlap that a step corrects: between moving bodies, and with a static one.
        float push_part = 0.0f, static_push_part = 0.0f;
        // Number of RowSolver's substeps: impulses from which a substep starts are stored as those of its substeps.
        float row_substeps = 1.0f;
    };

    // Chooses the members and divides bodies and manifolds between this solver and RowSolver.
    void choose(std::span<Body* const> awake, std::span<const AnyManifold> manifolds);
    [[nodiscard]] std::span<Body* const> other_bodies() const { return other_bodies_; }
    [[nodiscard]] std::span<const AnyManifold> other_manifolds() const { return other_manifolds_; }
    // Its own manifolds, in the order of all.
    [[nodiscard]] std::span<const AnyManifold> manifolds() const { return manifolds_; }

    // Adds to the velocities of guests. Call it before RowSolver solves.
    void push_guests(const Step& step);
    // Adds gravity and impulses to the velocities of members, and impulses to those of guests; stores impulses in the
    // points of the manifolds. Call it after RowSolver has solved.
    void solve(const Step& step, fracture::Threads& threads);
    // Of points between hulls, in the order of manifolds; points on the ground and of ellipsoids hold their solution.
    [[nodiscard]] std::span<const RowSolver::Solved> solved() const { return solved_; }

  private:
    static constexpr uint32_t none = UINT32_MAX;
    struct Guest {
        uint32_t body;               // index into bodies_
        Velocity before{}, pushed{}; // velocities before push_guests(), and the change by it
        Velocity driven{}, motion{}; // of RowSolver: change in a substep, and the velocity of its displacement
    };
    // A contact point before it has a lane.
    struct Point {
        uint32_t manifold, index; // of the manifold, and of the point in it
        uint32_t a, b;            // bodies; none: static
        uint32_t key;             // slab and colour
    };

    void list_bodies();
    void sort_into_slabs();
    void colour_points();
    void make_groups(const Step& step, fracture::Threads& threads);
    void fill_lane(DebrisRows& rows, size_t lane, const Point& point, const Step& step) const;
    void take_bodies(fracture::Threads& threads);
    void start_guests();
    void add_forces(const glm::vec3& fall);
    void limit_energy(const glm::vec3& fall, fracture::Threads& threads);
    void move_bodies(int substep, float seconds, fracture::Threads& threads);
    [[nodiscard]] Velocity velocity_of(uint32_t body) const;
    void sweep(fracture::Threads& threads, const auto& solve_groups);
    void store_points(const Step& step, fracture::Threads& threads);
    void store_bodies(const Step& step, fracture::Threads& threads);

    std::vector<uint8_t> is_member_; // by body index in the world
    std::vector<uint32_t> local_;    // by body index in the world: index into bodies_
    std::vector<Body*> bodies_;      // members and guests, by slab
    std::vector<uint8_t> is_guest_;  // by body, as are the next two
    std::vector<uint32_t> slabs_;
    std::vector<Guest> guests_;
    std::vector<Body*> other_bodies_;
    std::vector<AnyManifold> manifolds_, other_manifolds_;
    uint32_t slab_count_ = 0; // the last one holds contacts that reach farther than a neighbour slab
    std::vector<Point> points_;
    std::vector<uint32_t> sorted_;        // points by key
    std::vector<uint32_t> lanes_;         // by point: its lane among those of all groups
    std::vector<uint32_t> slab_begins_;   // by slab: its first group
    std::vector<uint32_t> static_begins_; // by slab: its first group against static bodies
    std::vector<uint8_t> one_sided_;      // by group: against static bodies
    std::vector<DebrisRows> groups_;
    DebrisBodies state_;
    std::vector<DebrisBodies::Motion> free_; // before the impulses of the substep
    std::vector<uint32_t> components_;       // by body: the root of those that contacts connect
    std::vector<AddedEnergy> added_;         // by body; of a root: of its component
    std::vector<float> shares_;              // scratch, by body
    std::vector<uint32_t> starts_;           // scratch
    std::vector<uint64_t> colours_;          // scratch: colours in use, by body and kind
    std::vector<RowSolver::Solved> solved_;
    std::vector<uint32_t> solved_firsts_; // by manifold
};

} // namespace brittle::physics
