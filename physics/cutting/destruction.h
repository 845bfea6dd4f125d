// Breakable objects: a blow cuts a piece into smaller pieces while the world runs, and those can break again.
//
//     Destruction destruction;
//     Result<ObjectId> statue = destruction.add(world, mesh, {.solid = {.material = stone}});
//     each step:  world.step();  destruction.update(world);
//     each frame: DestructionEvents events = destruction.take_events();   // removed pieces first, then added ones
//                 destruction.visit_poses(world, alpha, 0,
//                                         [&](uint32_t slot, const Pose& pose) { poses[slot] = pose; });
//
// An object starts whole, as one closed mesh and one body, or as a Structure of bonded pieces, which glued objects
// share (assemble()). A piece is one closed mesh with mass, collision hulls and a PieceId (solid_piece.h). Its body is
// its own, or in a structure the body of its island. A piece that reaches into an anchor is fixed. Each piece has a
// slot, an index into the caller's array of poses; the slot is reused once the piece is gone.
//
// From a contact to new pieces:
//  1. Blow. update() sums contacts that came in faster than impact_speed into blows, each over as many steps as it
//     lasts (contact_blows.h). A structure reports the impacts on its pieces itself.
//  2. Judgement. A blow breaks a piece if its force exceeds the piece's bearable_force() (solid_piece.h) and its energy
//     is enough for a cut (damage_of() in impact_pattern.h). A blow that the piece bears breaks the weakest section of
//     a held piece elsewhere (islands_after_blow() in held_blocks.h), or else chips the piece at the contact, as far as
//     the contact's crack reaches. Chipping takes the energy that the contact dissipated; the striker bounces as the
//     world solved it, and steps 3 and 5 leave the contact alone.
//  3. Suspension. The piece moves on whole until its job is done. The striker rests at the piece: its bounce is taken
//     back (suspended_contact.h).
//  4. Job, on a worker thread. It places sites around the contact, cuts the solid, and makes masses, hulls, body forms
//     and payloads. Pieces that are held and now too weak for their load are cut along their blocks in the same job. A
//     piece has at most one job. Later blows to it are summed; the hardest of them is kept for step 6.
//  5. Commit, on the main thread. Both bodies get the contact's impulse back, less the share of energy that the cracks
//     took. The piece's body is replaced by those of the new pieces, which inherit its motion, v + w x r. The contact
//     is solved again, inelastically, with the piece nearest to it. New pieces of a bonded piece keep the bonds that
//     their areas bear (Structure::divide()); a contact that the structure has solved again stays as it is.
//  6. Next blow. The piece nearest to the hardest waiting blow takes the summed blow, and may start its own job.
//  7. Events. take_events() reports removed, added and fading pieces to a renderer.
//
// A job is committed as a whole, in the order of job numbers. A commit takes microseconds for each piece, since the job
// has prepared everything else; a time budget is therefore spent in whole jobs.
//
// Joints. A joint of a piece goes on with the new piece that is nearest to its anchor.
//
// Momentum and angular momentum are conserved. Energy is lost to cracks and to inelastic contacts, never gained. Where
// a piece is fixed, the world is the other side of the exchange: a part that comes loose takes the blow as a free body
// would, and the world keeps the share of the cracks.
//
// Loads. A fixed piece that is too thin for its weight, or for bodies that rest on it, is cut at its overloaded
// sections (held_blocks.h): when it is added, in the job that cuts it, and in a job of its own when the load on it
// grows.
//
// Debris. Free pieces that came off, alone or bonded, are retired beyond DebrisLimits (debris.h). A piece with a job,
// and pieces bonded to it, stay until the commit. In a crowd, new small pieces do not collide with each other
// (crowd.h); an object that is added whole always collides.
//
// Determinism. With Timing::fixed_latency a job is committed in the step it is due, and update() waits for a late one.
// With Timing::scripted, commits follow a log. Both repeat bit for bit with any number of threads. Timing::when_ready
// depends on the clock; commits() is the log that repeats it.
//
// Threads. Not thread-safe: every call comes from one thread, with one World. Workers read immutable solids alone.
// World coordinates unless stated; metres, kilograms, seconds.
#pragma once

#include <compare>
#include <cstdint>
#include <deque>
#include <functional>
#include <iosfwd>
#include <limits>
#include <map>
#include <memory>
#include <optional>
#include <set>
#include <span>
#include <string>
#include <unordered_map>
#include <vector>

#include <glm/vec3.hpp>

#include "physics/bonds/assembly.h"
#include "physics/bonds/structure.h"
#include "physics/cutting/background.h"
#include "physics/cutting/contact_blows.h"
#include "physics/cutting/debris.h"
#include "physics/cutting/impact_pattern.h"
#include "physics/cutting/piece_payload.h"
#include "physics/cutting/solid_piece.h"
#include "physics/cutting/suspended_contact.h"
#include "physics/world/pieces.h"
#include "physics/world/world.h"

namespace brittle::physics {

// Names an object of one Destruction; never reused there.
struct ObjectId {
    uint32_t value = UINT32_MAX; // the default names none

    friend auto operator<=>(ObjectId, ObjectId) = default;
};

// Names glued objects of one Destruction.
struct AssemblyId {
    uint32_t value = UINT32_MAX; // the default names none

    friend auto operator<=>(AssemblyId, AssemblyId) = default;
};

struct BreakableDesc {
    SolidSettings solid{};
    // The seed is the object's. The seed of a blow derives from it, the object's number, the piece's ancestry and the
    // number of earlier jobs of the piece.
    ImpactPattern pattern{};
    uint32_t max_pieces = 48;  // of one blow
    PlacedMotion motion{};     // an anchored object keeps its placement and does not move
    float impact_speed = 0.5f; // m/s; a slower contact is no blow
    PayloadMaker payload{};    // makes the payload of each piece, which its PieceAdded hands over
};

// When jobs are committed: a fixed number of steps after the blow, as soon as they are ready, or by a log.
enum class Timing { fixed_latency, when_ready, scripted };

struct DestructionSettings {
    Timing timing = Timing::fixed_latency;
    uint32_t latency = 2;        // steps from blow to commit, at least 1; for fixed_latency
    uint32_t commits_a_step = 0; // limit for fixed_latency; 0: all that are due
    uint32_t workers = 1;        // threads of low priority (background.h), each with a job of its own
    DebrisLimits debris{};
};

// The cut that a blow makes, with all that it takes to carry it out on any thread.
struct PlannedCut {
    SolidPtr solid;
    std::shared_ptr<const BreakableDesc> desc;
    Blow blow; // in the coordinates of the object
    Damage damage;
    uint64_t seed = 0;
    glm::dvec3 gravity{0.0}; // m/s^2, in the coordinates of the object; loads held parts that the cut leaves too thin
};
// The pieces of a cut; a single piece where the solid withstands. The cracks take no more energy than the blow has: a
// cut that would is repeated with less damage. If no whole brick comes off, crumbs do. Crumbs that
// are each below the minimum size come off as one piece, if that piece and the rest are both large enough. Fails as
// break_solid() does.
[[nodiscard]] Result<std::vector<SolidPtr>> carry_out(const PlannedCut& cut,
                                                      const std::function<bool()>& cancelled = {});

// The commit of a job.
struct Commit {
    uint64_t step = 0; // World::steps_taken() at the commit
    uint32_t job = 0;

    friend bool operator==(const Commit&, const Commit&) = default;
};

// A blow that cut nothing, for messages to people. It is no part of the state.
struct BorneBlow {
    uint64_t step = 0; // World::steps_taken()
    PieceId piece;
    BodyId striker;
    Blow blow{};         // its energy includes the bounce
    double bounce = 0.0; // J of the energy that the striker kept
    Material material{};
    double volume = 0.0; // m^3, of the piece
    DamageLimits limits{};
};

struct PieceAdded {
    PieceId id;
    ObjectId object;
    uint32_t slot = 0;
    uint32_t depth = 0; // number of cuts between the original object and this piece
    SolidPtr solid;
    PieceId parent{};     // the piece that was cut; none for a piece of the original object
    PayloadPtr payload{}; // made by BreakableDesc::payload; or null
};
struct PieceRemoved {
    PieceId id;
    uint32_t slot = 0;
};
struct PieceFading {
    PieceId id;
    uint32_t slot = 0;
    float share = 1.0f; // visible share, falling from 1 to 0; the piece is removed afterwards
};
// Changes since the last call. Apply them in the order of the members, because added pieces reuse the slots of removed
// ones. A piece that was added and removed between two calls appears in none.
struct DestructionEvents {
    std::vector<PieceRemoved> removed;
    std::vector<PieceAdded> added;
    std::vector<PieceFading> fading; // the latest share of each piece
};

class Destruction {
  public:
    struct Statistics {
        uint32_t blows = 0; // that started a job
        uint32_t commits = 0;
        // Commits that cut a held piece along its blocks, under its load or after a blow elsewhere.
        uint32_t overloads = 0;
        uint32_t breaks = 0;    // commits by which a piece broke
        uint32_t chips = 0;     // of these, those of local damage
        uint32_t withstood = 0; // blows that cut nothing: all that they would take off, or leave, is below min_size
        uint32_t failed = 0;    // jobs whose cut failed; that piece is not cut again
        uint32_t retired = 0;   // pieces of debris
        double longest_commit = 0.0; // s on the main thread, with Timing::when_ready
        std::string last_failure;
    };

    explicit Destruction(const DestructionSettings& settings = {});

    // Adds a whole object. The first overload makes the solid on this thread and fails as make_solid() does. The second
    // takes a solid that was made on any thread, with its payload, which may be null; without it, desc.payload makes one
    // here.
    Result<ObjectId> add(World& world, const fracture::TriangleMesh& mesh, const BreakableDesc& desc);
    Result<ObjectId> add(World& world, SolidPtr whole, const BreakableDesc& desc,
                         std::optional<PayloadPtr> payload = std::nullopt);
    // Adds bonded pieces. Fails as Structure::create() does. `structure` describes the bonds between the pieces,
    // `pieces` how each piece breaks. The parts of a broken piece are anchored by pieces.solid.anchors alone, those of
    // a bonded one only where the piece was anchored. `solids` and `payloads` are results of solids_of() and
    // payloads_of() that were made ahead, one a piece; the solids' hulls are then the structure's.
    Result<ObjectId> add(World& world, const fracture::Fragments& fragments, const StructureDesc& structure,
                         const BreakableDesc& pieces, std::span<const SolidPtr> solids = {},
                         std::vector<PayloadPtr> payloads = {});
    // Adds glued objects (assembly.h): assemble() makes their common structure and its bodies, then add() makes each
    // part an object, before the next update(). The hulls of a part's description are those of its solids. Fails as
    // physics::assemble() does.
    //     AssemblyId glued = *destruction.assemble(world, parts, glue);
    //     for (uint32_t part = 0; part < parts.size(); ++part)
    //         objects.push_back(destruction.add(glued, part, descs[part], solids[part], payloads[part]));
    Result<AssemblyId> assemble(World& world, std::span<const AssemblyPart> parts, std::span<const GlueBond> glue);
    ObjectId add(const World& world, AssemblyId assembly, uint32_t part, const BreakableDesc& pieces,
                 std::span<const SolidPtr> solids, std::vector<PayloadPtr> payloads = {});
    // Removes an object with all its pieces and cancels its jobs. What was glued to it stays.
    void remove(World& world, ObjectId object);

    // Call after each step of the world. budget: s of the main thread for commits, with Timing::when_ready; at least
    // one ready job is committed a call.
    void update(World& world, double budget = 2e-3);
    // Strikes a piece with a blow of `energy` J and `force` N that has no impulse. The normal points into the piece.
    // False for an unknown piece or a blow that does not break it.
    bool strike(const World& world, PieceId piece, const glm::vec3& point, const glm::vec3& normal, double energy,
                double force = std::numeric_limits<double>::infinity());
    // The cut that strike() would start. Nothing for a blow that would not break the piece, or while a job cuts it.
    [[nodiscard]] std::optional<PlannedCut> foresee(const World& world, PieceId piece, const glm::vec3& point,
                                                    const glm::vec3& normal, double energy,
                                                    double force = std::numeric_limits<double>::infinity()) const;
    // The log for Timing::scripted, in the order of commits(). A job without an entry is never committed.
    void follow(std::span<const Commit> log) { script_.assign(log.begin(), log.end()); }
    [[nodiscard]] std::span<const Commit> commits() const { return commits_; } // of the last update()

    [[nodiscard]] DestructionEvents take_events();
    // Sets the test for whether a ball (centre and radius, m) around a piece is visible. update() calls it when debris
    // is to be retired. Without one, everything is visible. The test is an input of the run: a log that repeats it must
    // hold it.
    void set_view(std::function<bool(const glm::vec3&, float)> visible) { visible_ = std::move(visible); }

    // Calls visit for each piece in the order of PieceId, with its slot and the interpolated pose of its centre of
    // mass, in the axes of the object. Pieces of bodies with World::last_moved_step() < since are skipped.
    using PoseVisitor = std::function<void(uint32_t slot, const Pose& pose)>;
    void visit_poses(const World& world, float alpha, uint64_t since, const PoseVisitor& visit) const;
    [[nodiscard]] uint32_t slot_count() const { return slot_count_; } // all slots are below this

    [[nodiscard]] std::vector<PieceId> pieces() const; // ascending
    [[nodiscard]] bool contains(PieceId piece) const { return pieces_.contains(piece); }
    // Precondition of these five: contains(piece).
    [[nodiscard]] const SolidPtr& solid(PieceId piece) const { return pieces_.at(piece).solid; }
    [[nodiscard]] uint32_t slot(PieceId piece) const { return pieces_.at(piece).slot; }
    [[nodiscard]] uint32_t depth(PieceId piece) const { return pieces_.at(piece).depth; }
    [[nodiscard]] ObjectId object(PieceId piece) const { return pieces_.at(piece).object; }
    // The world no longer contains the body if the caller removed it there.
    [[nodiscard]] BodyId body(PieceId piece) const { return body_of(pieces_.at(piece)); }
    [[nodiscard]] PieceId next_piece() const { return {next_piece_}; } // above all pieces so far
    // Pose of the piece's centre of mass in the axes of its object. Precondition: its body is in the world.
    [[nodiscard]] Pose pose(const World& world, PieceId piece) const { return *pose_of(world, pieces_.at(piece)); }
    // The bonds of an object, for damage by hand; null for an object without bonds. Glued objects share them. The
    // indices of its pieces are those of bonded(): in order, the first PieceIds of the object, then those of bonded
    // pieces that were cut.
    [[nodiscard]] Structure* structure(ObjectId object);
    [[nodiscard]] const Structure* structure(ObjectId object) const;
    [[nodiscard]] std::vector<Structure*> structures(); // each once, in the order of their objects
    [[nodiscard]] std::vector<const Structure*> structures() const;
    // From the coordinates of an object with bonds to those of its structure.
    [[nodiscard]] PartPlacement placement_in_structure(ObjectId object) const { return objects_.at(object).placement; }
    // Index of the piece in its structure; nothing for a piece outside one.
    [[nodiscard]] std::optional<uint32_t> bonded(PieceId piece) const;
    [[nodiscard]] size_t jobs_in_flight() const { return jobs_.size(); }
    [[nodiscard]] const Statistics& statistics() const { return statistics_; }
    // The last blows that cut nothing of pieces that can be cut, newest last; at most max_borne.
    [[nodiscard]] const std::deque<BorneBlow>& borne() const { return borne_; }
    static constexpr size_t max_borne = 64;
    // Hash of pieces, their loads, jobs and structures: the state that World::state_hash() does not cover.
    [[nodiscard]] uint64_t state_hash() const;

  private:
    static constexpr uint32_t none = UINT32_MAX;

    struct Hit {
        Blow blow{};                // in the coordinates of the object; of several blows with their summed energy
        double bounce = 0.0;        // J of the energy that the striker keeps, where the piece bears the blow
        SuspendedContact contact{}; // of the hardest blow
    };
    struct SharedStructure { // of an object, or of glued ones
        std::unique_ptr<Structure> structure;
        std::vector<PieceId> pieces; // by piece of the structure; none for a support
        std::vector<uint32_t> first_piece;
        std::vector<PartPlacement> placements; // both by part
    };
    struct Object {
        std::shared_ptr<const BreakableDesc> desc;
        std::shared_ptr<SharedStructure> bonds{}; // null for an object that started whole
        PartPlacement placement{};                // in the structure
        uint32_t pieces = 0;
    };
    struct Live {
        ObjectId object;
        SolidPtr solid{};
        uint32_t depth = 0;
        PieceId parent{};
        uint64_t seed = 0;
        uint32_t slot = 0;
        BodyId own{};                 // none for a piece of a structure
        uint32_t bonded = none;       // index in its structure
        uint32_t job = none;          // number of the job that cuts it
        uint32_t blows = 0;           // that started a job
        bool unbreakable = false;     // its cut failed
        std::optional<Hit> waiting{}; // sum of the blows since the job started
        uint64_t born = 0;            // step of its creation; of a piece of a structure, the step at which it came off
        uint64_t slept = 0;           // steps since it fell asleep
        uint64_t fading = 0;          // steps until it is removed; 0: not fading
        double load = 0.0;            // N, running mean of the forces on a held piece
        double checked_load = 0.0;    // N, lowest load since its blocks were last checked
    };
    struct Job {
        PieceId piece;
        uint64_t due = 0; // step of its commit
        Hit hit{};
        bool along_blocks =
            false; // cuts a held piece along its blocks: under load (hit is empty), or after a blow elsewhere
    };
    struct Made { // a new piece with all that its commit takes
        SolidPtr solid;
        std::shared_ptr<const BodyForm> form; // null for several hulls, or where making it failed
        PayloadPtr payload;
    };
    struct Broken {
        std::vector<Made> pieces;           // empty where the piece withstands, else two or more
        std::vector<Structure::Part> parts; // the same, of a piece that was bonded to others when the job started
        bool chip = false;                  // local damage: the contact stays as the world solved it
        std::string failure;                // message of a failed cut; empty: none
    };
    struct Motion { // of a piece, in the world
        Pose pose, previous;
        glm::vec3 linear{0.0f}, angular{0.0f};
    };

    [[nodiscard]] const BreakableDesc& desc_of(const Live& piece) const { return *objects_.at(piece.object).desc; }
    [[nodiscard]] BodyId body_of(const Live& piece) const;
    [[nodiscard]] std::optional<Motion> motion_of(const World& world, const Live& piece) const;
    [[nodiscard]] std::optional<Pose> pose_of(const World& world, const Live& piece) const;
    // Precondition: the piece is in a structure.
    [[nodiscard]] Structure& structure_of(const Live& piece) const {
        return *objects_.at(piece.object).bonds->structure;
    }
    [[nodiscard]] Pose in_axes_of_object(const Live& piece, const Pose& pose) const;
    void forget_empty();
    [[nodiscard]] Pose in_body(const Live& piece, const Pose& body) const;
    Result<PieceId> add_piece(World& world, Live piece, PayloadPtr payload, const Motion& motion,
                              const glm::dvec3& from, bool debris, const std::shared_ptr<const BodyForm>& form = {});
    static BodyDesc body_of(const SolidPiece& solid);
    // `bonds`: the placement of a bonded piece in its structure.
    static Broken broken_into(Result<std::vector<SolidPtr>> pieces, const SolidPiece& cut_from,
                              const BreakableDesc& desc, const std::optional<PartPlacement>& bonds);
    static Structure::Part part_of(const Made& made, const Material& material, const PartPlacement& placement);
    static Broken broken_by(const PlannedCut& cut, const std::optional<PartPlacement>& bonds,
                            const std::function<bool()>& cancelled);
    [[nodiscard]] std::optional<PartPlacement> placement_if_bonded(const Live& piece) const;
    PieceId register_piece(Live piece, PayloadPtr payload);
    void forget_piece(PieceId id);
    void free_elsewhere(SolidPtr solid, PayloadPtr payload = {});
    void remove_lost(const World& world);
    void collect_blows(World& world);
    void update_structures(World& world);
    void suspend_if_cut(World& world, const Live& piece, const glm::vec3& friction, Hit& hit) const;
    [[nodiscard]] bool cuts(const World& world, const Live& piece, const Hit& hit) const;
    void hit_piece(const World& world, PieceId id, const Hit& hit);
    [[nodiscard]] std::optional<Blow> blow_at(const World& world, const Live& piece, const glm::vec3& point,
                                              const glm::vec3& normal, double energy, double force) const;
    void note_borne(const World& world, PieceId id, const Hit& hit);
    [[nodiscard]] DamageLimits limits_of(const Live& piece) const;
    [[nodiscard]] std::optional<PlannedCut> plan(const World& world, const Live& piece, Blow blow,
                                                 double bounce = 0.0) const;
    void start_job(const World& world, PieceId id, const Hit& hit);
    using Parting =
        std::function<std::vector<uint32_t>(const SolidPiece&, const SolidSettings&, const glm::dvec3& gravity)>;
    [[nodiscard]] glm::dvec3 gravity_of(const World& world, const Live& piece) const;
    void break_elsewhere(const World& world, PieceId id, const Hit& hit, const std::optional<PlannedCut>& chip = {});
    void update_loads(const World& world);
    void part_if_overloaded(const World& world, PieceId id);
    void start_parting(const World& world, PieceId id, const Hit& hit, const Parting& parts,
                       const std::optional<PlannedCut>& chip = {});
    void commit_due(World& world, double budget);
    void commit(World& world, uint32_t job);
    [[nodiscard]] bool has_bonds(const Live& piece) const;
    std::vector<PieceId> replace(World& world, PieceId old, Broken& broken);
    std::vector<PieceId> divide(World& world, PieceId old, Broken& broken);
    [[nodiscard]] static Live child_of(const Live& parent, PieceId id, size_t index, SolidPtr solid, uint64_t now);
    [[nodiscard]] PieceId nearest_of(std::span<const PieceId> made, const glm::dvec3& point) const;
    [[nodiscard]] double crack_energy(const Live& piece, const Broken& broken) const;
    void mark_visible(const World& world, std::span<Debris> candidates, size_t pieces, size_t vertices) const;
    [[nodiscard]] std::vector<PieceId> pieces_of_body(PieceId id) const;
    [[nodiscard]] bool is_seen(const World& world, const Live& piece) const;
    [[nodiscard]] bool is_detached(const Live& piece) const;
    [[nodiscard]] bool is_debris(const Live& piece) const;
    void update_debris(World& world);
    [[nodiscard]] std::vector<PieceId> retire_debris(const World& world, size_t count, size_t vertices);
    void take_out(World& world, std::span<const PieceId> gone);

    DestructionSettings settings_;
    std::map<ObjectId, Object> objects_;
    std::map<AssemblyId, std::shared_ptr<SharedStructure>> structures_;
    std::map<PieceId, Live> pieces_;
    std::unordered_map<uint32_t, PieceId>
        piece_of_body_; // pieces with a body of their own, by BodyId::value; never iterated
    std::map<uint32_t, Job> jobs_;
    std::set<uint32_t> free_slots_;
    uint32_t slot_count_ = 0, next_object_ = 0, next_structure_ = 0, next_piece_ = 0, next_job_ = 0;
    uint64_t steps_seen_ = 0, removed_seen_ = 0;
    BlowTracker blows_;
    std::vector<Commit> commits_, script_;
    size_t script_at_ = 0;
    std::map<PieceId, PieceAdded> added_;
    std::map<PieceId, PieceRemoved> removed_;
    std::map<PieceId, PieceFading> fading_;
    std::function<bool(const glm::vec3&, float)> visible_;
    Statistics statistics_;
    std::deque<BorneBlow> borne_;
    Background<Broken> background_; // last member: its threads end before the others are destroyed
};

std::ostream& operator<<(std::ostream& stream, PieceId id);

} // namespace brittle::physics
