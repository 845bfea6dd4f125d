// A run: pieces, bonds and balls in a world, advanced in fixed steps and changed by actions. Knows neither window nor
// device: a Stage draws a simulation, replay logs record and repeat one (replay/), tests run one alone.
//
//     Simulation simulation("stone");
//     PreparedObject object{.fragments = fragments, .world = world_of(options), .material = "stone"};
//     prepare(object);                                                                        // on any thread
//     simulation.start(std::move(object));
//     simulation.apply(Shoot{.from = eye, .velocity = 14.0 * direction});
//     each frame: float alpha = simulation.advance(seconds); simulation.visit_poses(alpha, 0, write);
//
// A step, in this order: the world steps; bonds break (Structure::update()) or cuts are committed
// (Destruction::update()); the hand pulls the grabbed piece; the observer is called; the actions scheduled for this
// step take effect.
//
// Between calls a simulation is always between two steps, and apply() takes effect at once. Equal fragments, and equal
// actions after equal numbers of steps, give equal states (state_hash()), whatever times advance() got. With breakable
// pieces this also requires that cuts are committed after equal numbers of steps (commit_as()).
//
// An action on a piece that is gone, or on bonds where there are none, has no effect. Not thread-safe.
#pragma once

#include <cstdint>
#include <functional>
#include <map>
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
#include "physics/world/joint.h"
#include "physics/world/world.h"
#include "tools/scenario/recipe/world_options.h"
#include "tools/scenario/run/action.h"
#include "tools/scenario/run/prepared_object.h"

namespace brittle::tools {

class Simulation;

// Callbacks of a simulation: started() once; moved(), updated() and stepped() in each step; acted() for each action.
class SimulationObserver {
  public:
    virtual ~SimulationObserver() = default;
    // The pieces have bodies; nothing has moved, and no action has taken effect.
    virtual void started(const Simulation&, std::span<const PreparedObject>, const WorldOptions&) {}
    // The world has taken a step; bonds have not responded to it yet.
    virtual void moved(const Simulation&) {}
    // Bonds have broken, bodies have split and cuts have been committed. The changes are empty for breakable pieces.
    // Not called for pieces that are neither bonded nor breakable.
    virtual void updated(const Simulation&, const physics::Structure::Changes&) {}
    // A step is done; its scheduled actions follow.
    virtual void stepped(const Simulation&) {}
    // An action has taken effect after this number of steps.
    virtual void acted(uint64_t, const Action&) {}
};

class Simulation {
  public:
    // `material` is a preset's name, or empty: of a start from fragments. `payload` makes what take_events() hands over
    // with each piece.
    explicit Simulation(const std::string& material = {}, DrawingMaker payload = {});

    // Sets when cuts are committed from the next start on. The default, fixed_latency, repeats by itself; a window uses
    // when_ready; a replay uses scripted, with the commits of its log. See destruction.h.
    void commit_as(physics::Timing timing, std::vector<physics::Commit> script = {});

    // Starts a new run from the places of a prepared object, at step 0, and clears the previous run. Its options decide
    // on bonds, anchors, joints and breakability, and their shots are scheduled. Throws a Failure for a piece that
    // cannot be a body.
    void start(PreparedObject object);
    void start(const fracture::Fragments& fragments, const WorldOptions& options); // prepares them, too
    // Starts a run of several objects. Of `world`, the members count that concern no single object; of the objects'
    // options, the others. Pieces are numbered object by object.
    void start(std::vector<PreparedObject> objects, const WorldOptions& world);
    // Empties the world; the observer stays.
    void clear();
    [[nodiscard]] bool running() const { return world_.body_count() > 0; }

    // Takes effect at once. Precondition: fault_of() finds no fault.
    void apply(const Action& action);
    // Takes effect after the given step since the start; at once if it has passed. Actions of one step keep the order
    // of calls.
    void schedule(uint64_t step, const Action& action);

    void step();
    // The cut that the hammer would make (Destruction::foresee()); nothing if it would not cut the piece.
    [[nodiscard]] std::optional<physics::PlannedCut> foresee(const Hammer& blow) const;

    // Takes as many steps as fit and returns the fraction of the next step that has passed, as World::advance() does.
    float advance(double seconds);
    [[nodiscard]] uint64_t steps() const { return world_.steps_taken(); } // since the start

    // Sets the observer; null for none. It must outlive the simulation or be replaced.
    void observe(SimulationObserver* observer) { observer_ = observer; }

    // A piece's slot is its index where nothing is cut anew; else it is used again once the piece is gone.
    // Calls visit for each piece with its slot and the interpolated pose of its centre of mass, in the axes of the
    // fragments. Pieces of bodies with World::last_moved_step() < since are skipped.
    using PoseVisitor = std::function<void(uint32_t slot, const physics::Pose& pose)>;
    void visit_poses(float alpha, uint64_t since, const PoseVisitor& visit) const;
    // Changes of breakable pieces since the last call; empty for others.
    [[nodiscard]] physics::DestructionEvents take_events();
    [[nodiscard]] std::span<const physics::Commit> commits() const; // of the last step
    [[nodiscard]] size_t piece_count() const { return pieces_; }    // at the start
    // Upper bound of the numbers of all pieces so far; numbers are never reused.
    [[nodiscard]] uint32_t number_count() const;
    [[nodiscard]] physics::BodyId body_of(uint32_t piece) const; // the default for a piece that is gone
    // Pose of the centre of mass after the last step. Precondition: the piece has a body.
    [[nodiscard]] physics::Pose pose_of(uint32_t piece) const;
    // The pieces in a body, ascending; empty for a ball.
    [[nodiscard]] std::vector<uint32_t> pieces_of(physics::BodyId body) const;

    struct Ball {
        physics::BodyId body;
        float radius; // m
    };
    // Balls that were shot, and the links of chains.
    [[nodiscard]] std::span<const Ball> balls() const { return balls_; }

    // Hash of bodies, bonds and jobs; equal in equal runs.
    [[nodiscard]] uint64_t state_hash() const;

    [[nodiscard]] const physics::World& world() const { return world_; }
    // The bonds of the first object that has some; null without.
    [[nodiscard]] const physics::Structure* structure() const;
    [[nodiscard]] std::vector<const physics::Structure*> structures() const; // of all objects that have bonds
    // The bonds of a piece, and its index in them. Null, and 0, for a piece without.
    [[nodiscard]] std::pair<const physics::Structure*, uint32_t> bonds_of(uint32_t piece) const;
    [[nodiscard]] const physics::Destruction* destruction() const { return destruction_ ? &*destruction_ : nullptr; }
    [[nodiscard]] const physics::MaterialPreset* material() const { return material_; } // of the constructor

    // An object of the run.
    struct Member {
        std::string name;
        const physics::MaterialPreset* material = nullptr;
        physics::Pose placement{}; // at the start
        bool fixed = false;
    };
    [[nodiscard]] std::span<const Member> members() const { return members_; } // one, or those of a scene
    // The index of the object that a piece belongs to. Precondition: the piece is there.
    [[nodiscard]] uint32_t member_of(uint32_t piece) const;
    [[nodiscard]] uint32_t member_of(physics::ObjectId object) const; // in a breakable world

  private:
    struct Grabbed {
        uint32_t piece;
        glm::dvec3 local; // m, the grabbed point, from the piece's centre of mass in its axes
        glm::dvec3 to;    // m, position of the hand
    };

    // A joint with its points in the world, and the pieces that it joins.
    struct PlacedJoint {
        JointOptions options;
        std::optional<uint32_t> a{}, b{}; // none: a ball; the world
    };
    struct GluedPart { // of an object that is glued to others
        physics::AssemblyId assembly;
        uint32_t part = 0;
    };
    void start_glue(std::span<const PreparedObject> objects);
    void start_joints(std::span<const PreparedObject> objects, const WorldOptions& options);
    void join(const PlacedJoint& joint, physics::BodyId a);
    void join_shot(const glm::dvec3& at);
    [[nodiscard]] std::optional<uint32_t> nearest_piece(std::span<const PreparedObject> objects, const glm::dvec3& at,
                                                        physics::BodyId not_of) const;
    physics::BodyId add_ball(const glm::dvec3& at, const glm::dvec3& velocity, double radius, double density,
                             int detail);

    template<class Self>
    static auto structures_of(Self& self) -> std::vector<decltype(&*self.structure_)>;
    template<class Self>
    static auto structure_of(Self& self, uint32_t piece) -> decltype(&*self.structure_); // null for a piece outside
    [[nodiscard]] uint32_t index_in_structure(uint32_t piece) const;                     // precondition: it is in one
    void start_world(const WorldOptions& options);
    void add_breakable(PreparedObject& object, const GluedPart* glued);
    void assemble(std::span<const PreparedObject> objects, std::span<const uint32_t> group,
                  std::map<uint32_t, GluedPart>& glued);
    void run_from(std::span<const PreparedObject> objects, const WorldOptions& options);
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
    DrawingMaker payload_;
    physics::Timing timing_ = physics::Timing::fixed_latency;
    std::vector<physics::Commit> script_;
    // One of these three holds the pieces.
    std::optional<physics::Structure> structure_;
    std::vector<physics::BodyId> loose_; // by piece
    std::optional<physics::Destruction> destruction_;
    std::vector<Member> members_;
    std::vector<physics::ObjectId> first_objects_; // by member: the first object of the destruction; several may follow
    size_t pieces_ = 0;
    std::vector<Ball> balls_;
    std::vector<PlacedJoint> shot_joints_;               // of balls to come
    uint32_t shots_ = 0;                                 // balls that were shot
    std::vector<std::pair<uint64_t, Action>> scheduled_; // ordered by step, then by call
    std::optional<Grabbed> grabbed_;
    SimulationObserver* observer_ = nullptr;
};

} // namespace brittle::tools
