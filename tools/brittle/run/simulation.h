// Pieces, bonds and balls in a world, moved in fixed steps and by actions; no window, no device. Stage draws
// one, replay logs record and repeat one (replay/), tests run one alone.
//
// - Each step, in this order: the world steps, bonds break (Structure::update) and what was cut anew comes
//   (Destruction::update), what is grabbed is drawn on, the observer is told, scheduled actions of this step take
//   effect.
// - Between calls a simulation always is between two steps: apply() takes effect at once. Equal fragments and
//   equal actions after equal numbers of steps give equal states (state_hash()), whatever advance() was
//   called with; where things are breakable, if cuts are committed after equal numbers of steps too (commit_as()).
// - Actions on pieces that are gone, and on bonds where there are none, do nothing.
// - Not thread-safe; as World, one at a time.
//
//     Simulation simulation("stone");
//     PreparedBodies bodies = prepare_bodies(broken.fragments, world_of(options), "stone");   // on any thread
//     simulation.start(broken.fragments, world_of(options), std::move(bodies));
//     simulation.apply(Shoot{.from = eye, .velocity = 14.0 * direction});
//     each frame: float alpha = simulation.advance(seconds); simulation.visit_poses(alpha, 0, write);
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "fracture/pieces/fragments.h"
#include "physics/bonds/structure.h"
#include "physics/cutting/destruction.h"
#include "physics/cutting/piece_payload.h"
#include "physics/cutting/solid_piece.h"
#include "physics/material.h"
#include "physics/world/hull.h"
#include "physics/world/world.h"
#include "tools/brittle/recipe/world_options.h"
#include "tools/brittle/run/action.h"

namespace brittle::tools {

class Simulation;

// Is told in this order: started, then moved, updated and stepped for each step, acted whenever an action
// takes effect.
class SimulationObserver {
  public:
    virtual ~SimulationObserver() = default;
    // Pieces have been made bodies; nothing has moved, no action has taken effect.
    virtual void started(const Simulation&, const fracture::Fragments&, const WorldOptions&) {}
    // The world has taken a step; bonds have not answered to it yet.
    virtual void moved(const Simulation&) {}
    // Bonds have, and bodies came apart, and cuts were committed. Changes are empty where things are breakable. Not
    // called where they are neither that nor bonded.
    virtual void updated(const Simulation&, const physics::Structure::Changes&) {}
    // A step is done; actions that take effect after it are still to come.
    virtual void stepped(const Simulation&) {}
    // An action has taken effect after so many steps.
    virtual void acted(uint64_t, const Action&) {}
};

// The part of a start that costs milliseconds: a hull a piece, or for breakable pieces a solid and a payload a piece.
struct PreparedBodies {
    physics::PieceHulls hulls;
    std::vector<physics::SolidPtr> solids;
    std::vector<physics::PayloadPtr> payloads;
};

// Callable on any thread. `material` and `payload` must be the simulation's. threads: 0 is one a core. Throws a
// Failure.
[[nodiscard]] PreparedBodies prepare_bodies(const fracture::Fragments& fragments, const WorldOptions& options,
                                            const std::string& material, const physics::PayloadMaker& payload = {},
                                            uint32_t threads = 0);

class Simulation {
  public:
    // `material` is a preset's name, or empty. `payload` makes what take_events() hands over with each piece.
    explicit Simulation(const std::string& material = {}, physics::PayloadMaker payload = {});

    // When cuts are committed, from the next start on: fixed_latency, which repeats by itself, unless this is called;
    // when_ready for a window; scripted by the commits of a log. See destruction.h.
    void commit_as(physics::Timing timing, std::vector<physics::Commit> script = {});

    // Pieces begin to move from where they are, and steps() to count. What was there is gone. Bonded, anchored and
    // breakable as the options say; their shots are scheduled. `ahead` was made by prepare_bodies() for these
    // fragments and options. Throws a Failure for pieces that cannot be bodies.
    void start(const fracture::Fragments& fragments, const WorldOptions& options, PreparedBodies ahead);
    void start(const fracture::Fragments& fragments, const WorldOptions& options);
    // Nothing is there any more; the observer stays.
    void clear();
    [[nodiscard]] bool running() const { return world_.body_count() > 0; }

    // At once. Asserts that fault_of() finds nothing.
    void apply(const Action& action);
    // After so many steps since the start, in the order of calls; at once where they are over.
    void schedule(uint64_t step, const Action& action);

    void step();
    // What the hammer would cut its piece into, without doing it (Destruction::foresee()); nothing where it would not.
    [[nodiscard]] std::optional<physics::PlannedCut> foresee(const Hammer& blow) const;

    // As World::advance(): as many steps as fit, and how far the time reaches into the next one.
    float advance(double seconds);
    [[nodiscard]] uint64_t steps() const { return world_.steps_taken(); } // since the start

    // Told from now on; or nobody. It must outlive the simulation or be replaced.
    void observe(SimulationObserver* observer) { observer_ = observer; }

    // A piece's slot is its index where nothing is cut anew; else it is used again once the piece is gone.
    // Calls visit for each piece with its slot and the interpolated pose of its centre of mass, in the axes of the
    // fragments. Pieces of bodies with World::last_moved_step() < since are skipped.
    using PoseVisitor = std::function<void(uint32_t slot, const physics::Pose& pose)>;
    void visit_poses(float alpha, uint64_t since, const PoseVisitor& visit) const;
    // Pieces of breakable things that came and went since the last call; nothing else ever does.
    [[nodiscard]] physics::DestructionEvents take_events();
    [[nodiscard]] std::span<const physics::Commit> commits() const; // of the last step
    [[nodiscard]] size_t piece_count() const { return pieces_; }    // at the start
    // All pieces have numbers below this, and none twice.
    [[nodiscard]] uint32_t number_count() const;
    [[nodiscard]] physics::BodyId body_of(uint32_t piece) const; // none for a piece that is gone
    // Of the centre of mass of a piece that has a body, after the last step.
    [[nodiscard]] physics::Pose pose_of(uint32_t piece) const;
    // That a body holds, ascending; none for a ball.
    [[nodiscard]] std::vector<uint32_t> pieces_of(physics::BodyId body) const;

    struct Ball {
        physics::BodyId body;
        float radius; // m
    };
    [[nodiscard]] std::span<const Ball> balls() const { return balls_; }

    // Of bodies, bonds and what is being broken; equal in equal runs.
    [[nodiscard]] uint64_t state_hash() const;

    [[nodiscard]] const physics::World& world() const { return world_; }
    [[nodiscard]] const physics::Structure* structure() const; // of bonded pieces, or null
    [[nodiscard]] const physics::Destruction* destruction() const { return destruction_ ? &*destruction_ : nullptr; }
    [[nodiscard]] const physics::MaterialPreset* material() const { return material_; }

  private:
    struct Grabbed {
        uint32_t piece;
        glm::dvec3 local; // the point, from the piece's centre of mass in its axes
        glm::dvec3 to;
    };

    [[nodiscard]] physics::Structure* bonded();
    [[nodiscard]] bool is_bonded(uint32_t piece) const;
    void start_breakable(const fracture::Fragments& fragments, const WorldOptions& options, PreparedBodies& ahead);
    void after_step();
    void apply_due();
    void pull_grabbed();

    void act(const Shoot& action);
    void act(const Damage& action);
    void act(const Saw& action);
    void act(const Hammer& action);
    void act(const Release& action);
    void act(const Push& action);
    void act(const Grab& action);
    void act(const Drag& action);
    void act(const LetGo& action);
    void act(const Watch& action);

    physics::World world_;
    const physics::MaterialPreset* material_ = nullptr;
    physics::PayloadMaker payload_;
    physics::Timing timing_ = physics::Timing::fixed_latency;
    std::vector<physics::Commit> script_;
    // One of the three has the pieces.
    std::optional<physics::Structure> structure_;
    std::vector<physics::BodyId> loose_; // by piece
    std::optional<physics::Destruction> destruction_;
    physics::ObjectId object_; // the first of the destruction: of bonded pieces the only one
    size_t pieces_ = 0;
    std::vector<Ball> balls_;
    std::vector<std::pair<uint64_t, Action>> scheduled_; // by step, those of equal steps in their order
    std::optional<Grabbed> grabbed_;
    SimulationObserver* observer_ = nullptr;
};

} // namespace brittle::tools
