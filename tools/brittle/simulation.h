// Pieces, bonds and balls in a world, moved in fixed steps and by actions; no window, no device. Stage draws
// one, replay logs record and repeat one (replay/), tests run one alone.
//
// - Each step, in this order: the world steps, bonds break (Structure::update), what is grabbed is drawn on,
//   the observer is told, scheduled actions of this step take effect.
// - Between calls a simulation always is between two steps: apply() takes effect at once. Equal fragments and
//   equal actions after equal numbers of steps give equal states (World::state_hash), whatever advance() was
//   called with.
// - Actions on pieces that are gone, and on bonds where there are none, do nothing.
// - Not thread-safe; as World, one at a time.
//
//     Simulation simulation("stone");
//     simulation.start(broken.fragments, options.world);
//     simulation.apply(Shoot{.from = eye, .velocity = 14.0 * direction});
//     each frame: float alpha = simulation.advance(seconds); simulation.write_poses(poses, alpha);
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "fracture/fragments.h"
#include "physics/material.h"
#include "physics/structure.h"
#include "physics/world.h"
#include "tools/brittle/action.h"
#include "tools/brittle/world_options.h"

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
    // Bonds have, and bodies came apart. Not called where pieces are not bonded.
    virtual void updated(const Simulation&, const physics::Structure::Changes&) {}
    // A step is done; actions that take effect after it are still to come.
    virtual void stepped(const Simulation&) {}
    // An action has taken effect after so many steps.
    virtual void acted(uint64_t, const Action&) {}
};

class Simulation {
  public:
    // `material` is a preset's name, or empty.
    explicit Simulation(const std::string& material = {});

    // Pieces begin to move from where they are, and steps() to count. What was there is gone. Bonded and
    // anchored as the options say; their shots are scheduled. Throws a Failure for pieces that cannot be
    // bodies.
    void start(const fracture::Fragments& fragments, const WorldOptions& options);
    // Nothing is there any more; the observer stays.
    void clear();
    [[nodiscard]] bool running() const { return world_.body_count() > 0; }

    // At once. Asserts that fault_of() finds nothing.
    void apply(const Action& action);
    // After so many steps since the start, in the order of calls; at once where they are over.
    void schedule(uint64_t step, const Action& action);

    void step();
    // As World::advance(): as many steps as fit, and how far the time reaches into the next one.
    float advance(double seconds);
    [[nodiscard]] uint64_t steps() const { return world_.steps_taken(); } // since the start

    // Told from now on; or nobody. It must outlive the simulation or be replaced.
    void observe(SimulationObserver* observer) { observer_ = observer; }

    // Of all pieces in their order: see Structure::write_piece_transforms().
    void write_poses(std::span<physics::Pose> out, float alpha) const;
    [[nodiscard]] size_t piece_count() const { return pieces_; }
    [[nodiscard]] physics::BodyId body_of(uint32_t piece) const; // none for a piece that is gone
    // That a body holds, ascending; none for a ball.
    [[nodiscard]] std::vector<uint32_t> pieces_of(physics::BodyId body) const;

    struct Ball {
        physics::BodyId body;
        float radius; // m
    };
    [[nodiscard]] std::span<const Ball> balls() const { return balls_; }

    [[nodiscard]] const physics::World& world() const { return world_; }
    [[nodiscard]] const physics::Structure* structure() const { return structure_ ? &*structure_ : nullptr; }
    [[nodiscard]] const physics::MaterialPreset* material() const { return material_; }

  private:
    struct Held {
        uint32_t piece;
        glm::dvec3 local; // the point, from the piece's centre of mass in its axes
        glm::dvec3 to;
    };

    void after_step();
    void act_when_due();
    void draw_held();
    [[nodiscard]] physics::Pose piece_pose(uint32_t piece) const;

    void act(const Shoot& action);
    void act(const Damage& action);
    void act(const Saw& action);
    void act(const Hammer& action);
    void act(const Release& action);
    void act(const Push& action);
    void act(const Grab& action);
    void act(const Drag& action);
    void act(const LetGo& action);

    physics::World world_;
    const physics::MaterialPreset* material_ = nullptr;
    std::optional<physics::Structure> structure_; // of bonded pieces
    std::vector<physics::BodyId> loose_;          // by piece, of pieces that are not
    size_t pieces_ = 0;
    std::vector<Ball> balls_;
    std::vector<std::pair<uint64_t, Action>> due_; // by step, those of equal steps in their order
    std::optional<Held> held_;
    SimulationObserver* observer_ = nullptr;
};

} // namespace brittle::tools
