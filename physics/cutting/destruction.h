// Things that break where they are hit, again and again, while the world goes on.
//
//     Destruction destruction;
//     Result<ObjectId> statue = destruction.add(world, mesh, {.solid = {.material = stone}, .motion = {.placement = at}});
//     each step:  world.step();  destruction.update(world);
//     each frame: for (what is in destruction.take_events()) add it to the renderer or take it out;
//                 destruction.visit_poses(world, alpha, 0, [&](uint32_t slot, const Pose& pose) { poses[slot] = pose; });
//
// - An object starts whole, as one body and one closed mesh, or as a Structure of bonded pieces. Contacts that came in faster
//   than impact_speed are a blow, one for as many steps as it takes (contact_blows.h); one that is harder than the piece bears
//   (bearable_impulse() in solid_piece.h, compared as for a blow of a kilogram, impact_seconds in material.h) breaks it: sites are
//   laid around the contact (impact_pattern.h), and what comes of it can break again, down to min_size.
// - Cutting, masses, hulls and what a renderer draws are made by a job on another thread. Until it is committed the piece
//   moves on whole, with what hit it resting at it: a bounce off what is about to give way is taken back. Pieces then start
//   with the motion of that moment, v + w x r. The impulse that the contact had is given back to both sides, less what the
//   cracks took of the energy, and solved anew against the piece that was hit alone. Momentum and angular momentum are kept. (Of bonded pieces the
//   contact stays as Structure leaves it.) Where a piece is held, the world is the other side: it gives back what the contact
//   gave it, friction with it, so what comes loose takes the blow as a free body would; of what the cracks took it keeps all.
// - One job a piece at a time. Later blows to it are summed up, and what comes out nearest to the hardest takes them; the
//   contact of the hardest is solved anew likewise.
// - A piece that reaches into an anchor is fixed; what no longer does, falls. What is held and too thin for its weight, for
//   what rests on it or for a blow to another place of it parts there (held_blocks.h): when it is added, after a cut in the
//   same job, and in a job of its own when more comes to rest on it or a blow breaks nothing where it lands.
// - Commits: a job is committed as a whole, in the order of job numbers. What the main thread does then is to take one body
//   out and put at most some dozens of prepared ones in: microseconds each, since masses and hulls are there. So a
//   budget is divided by jobs: when_ready takes jobs while the budget lasts, at least one a step.
// - Deterministic with Timing::fixed_latency (commits in the step they are due, waiting where a job is late) and with
//   Timing::scripted (commits as a log says). Timing::when_ready looks at the clock; commits() is the log to keep.
// - A slot is an index that the piece's pose is written to; it is used again once the piece is gone.
// - Debris: retire_debris() in debris.h says what goes when there is too much, bonded pieces that came off their structure among
//   it; not what is being cut, nor what is bonded to that. crowd.h says which parts of what breaks do not meet each other when
//   more than enough do. What is added whole always collides.
//
// World coordinates where nothing else is said; metres, kilograms, seconds. Every call gets the same world. Not thread-safe.
#pragma once

#include <compare>
#include <cstdint>
#include <functional>
#include <iosfwd>
#include <map>
#include <memory>
#include <optional>
#include <set>
#include <span>
#include <string>
#include <unordered_map>
#include <vector>

#include <glm/vec3.hpp>

#include "physics/bonds/structure.h"
#include "physics/cutting/background.h"
#include "physics/cutting/contact_blows.h"
#include "physics/cutting/debris.h"
#include "physics/cutting/impact_pattern.h"
#include "physics/cutting/piece_payload.h"
#include "physics/cutting/solid_piece.h"
#include "physics/world/pieces.h"
#include "physics/world/world.h"

namespace brittle::physics {

// Never used again within a Destruction.
struct ObjectId {
    uint32_t value = UINT32_MAX; // the default names none

    friend auto operator<=>(ObjectId, ObjectId) = default;
};

struct BreakableDesc {
    SolidSettings solid{};
    ImpactPattern pattern{};   // its seed is the object's: that of a blow derives from it, the object's number, the
                               // piece's ancestry and how many blows to the piece were worked on before
    uint32_t max_pieces = 48;  // of one blow
    PlacedMotion motion{};     // an anchored object keeps its placement and does not move
    float impact_speed = 0.5f; // m/s
    PayloadMaker payload{};    // for each piece, handed over with its PieceAdded
};

// When jobs are committed, see above.
enum class Timing { fixed_latency, when_ready, scripted };

struct DestructionSettings {
    Timing timing = Timing::fixed_latency;
    uint32_t latency = 2;        // steps from blow to commit, at least 1; for fixed_latency
    uint32_t commits_a_step = 0; // for fixed_latency, at most so many; 0: all that are due
    uint32_t workers = 1;        // threads, each with a job of its own; they give way to frames (background.h)
    DebrisLimits debris{};
};

// What a blow makes of a piece: all that it takes to carry it out, on any thread.
struct PlannedCut {
    SolidPtr solid;
    std::shared_ptr<const BreakableDesc> desc;
    Blow blow; // in the coordinates of the object
    Damage damage;
    uint64_t seed = 0;
    glm::dvec3 gravity{0.0}; // m/s^2, likewise: what is held and left too thin comes apart as well
};
// The pieces, one where it withstands. Where no brick comes off by itself, crumbs do, and crumbs that are each too small come off
// together, where they and what is left are each enough for a piece. Fails as break_solid() does.
[[nodiscard]] Result<std::vector<SolidPtr>> carry_out(const PlannedCut& cut,
                                                      const std::function<bool()>& cancelled = {});

// A job that was committed, and the World::steps_taken() of then.
struct Commit {
    uint64_t step = 0;
    uint32_t job = 0;

    friend bool operator==(const Commit&, const Commit&) = default;
};

struct PieceAdded {
    PieceId id;
    ObjectId object;
    uint32_t slot = 0;
    uint32_t depth = 0; // how often what it is of was cut
    SolidPtr solid;
    PieceId of{};         // what was cut; none at the beginning
    PayloadPtr payload{}; // what BreakableDesc::payload made, null without one
};
struct PieceRemoved {
    PieceId id;
    uint32_t slot = 0;
};
struct PieceFading {
    PieceId id;
    uint32_t slot = 0;
    float share = 1.0f; // of it that is left, 1 to 0; it is removed after the last
};
// Since the last call; to be taken in this order, as slots are used again. A piece that came and went between two calls
// is in none.
struct DestructionEvents {
    std::vector<PieceRemoved> removed;
    std::vector<PieceAdded> added;
    std::vector<PieceFading> fading; // the last share of each piece
};

class Destruction {
  public:
    struct Statistics {
        uint32_t blows = 0; // that began a job
        uint32_t commits = 0;
        uint32_t overloads = 0; // jobs that took a held piece apart under its load, or after a blow elsewhere
        uint32_t breaks = 0;    // commits by which a piece came apart
        uint32_t withstood =
            0; // blows that cut nothing where they land: all that they would take off, or leave, is below min_size
        uint32_t failed = 0;         // jobs whose cut was refused: such a piece is not cut again
        uint32_t retired = 0;        // debris
        double longest_commit = 0.0; // s, of the main thread, with Timing::when_ready
        std::string last_failure;
    };

    explicit Destruction(const DestructionSettings& settings = {});

    // A whole object. Fails as make_solid() does, which is called here on this thread; or was, on any, for the second.
    Result<ObjectId> add(World& world, const fracture::TriangleMesh& mesh, const BreakableDesc& desc);
    Result<ObjectId> add(World& world, SolidPtr whole, const BreakableDesc& desc, PayloadPtr payload = {});
    // Bonded pieces. Fails as Structure::create() does; `structure` holds for how they hold together, `pieces` for how they
    // break themselves. The parts of a broken piece are anchored by pieces.solid.anchors alone. Where solids_of() was
    // called ahead, its result, one a piece; their hulls are then the structure's.
    Result<ObjectId> add(World& world, const fracture::Fragments& fragments, const StructureDesc& structure,
                         const BreakableDesc& pieces, std::span<const SolidPtr> solids = {},
                         std::vector<PayloadPtr> payloads = {});
    // Takes an object out with all its pieces, and calls its jobs off.
    void remove(World& world, ObjectId object);

    // To be called after each step of the world. budget: s of the main thread for commits, for Timing::when_ready.
    void update(World& world, double budget = 2e-3);
    // A blow by hand: nothing moves of it. The normal points into the piece. False where the piece is not there or does not
    // break of it.
    bool strike(const World& world, PieceId piece, const glm::vec3& point, const glm::vec3& normal, double energy);
    // What strike() would make of it, without doing it. Nothing where it would not break, or while another blow breaks it.
    [[nodiscard]] std::optional<PlannedCut> foresee(const World& world, PieceId piece, const glm::vec3& point,
                                                    const glm::vec3& normal, double energy) const;
    // What to commit when, for Timing::scripted: a log of commits(), in its order. Jobs that are not in it are not committed.
    void follow(std::span<const Commit> log) { script_.assign(log.begin(), log.end()); }
    [[nodiscard]] std::span<const Commit> commits() const { return commits_; } // of the last update()

    [[nodiscard]] DestructionEvents take_events();
    // Whether someone sees any of a ball around a piece: centre and radius, m. Asked when debris is to go, in update().
    // None set: all is seen. It is an input of the run: a log of one must have it.
    void set_view(std::function<bool(const glm::vec3&, float)> visible) { visible_ = std::move(visible); }

    // Calls visit for each piece in the order of PieceId, with its slot and the interpolated pose of its centre of mass, in
    // the axes of the object. Pieces of bodies with World::last_moved_step() < since are skipped.
    using PoseVisitor = std::function<void(uint32_t slot, const Pose& pose)>;
    void visit_poses(const World& world, float alpha, uint64_t since, const PoseVisitor& visit) const;
    [[nodiscard]] uint32_t slot_count() const { return slot_count_; } // all slots are below this

    [[nodiscard]] std::vector<PieceId> pieces() const; // in the order in which they came
    [[nodiscard]] bool contains(PieceId piece) const { return pieces_.contains(piece); }
    // Of a piece that exists:
    [[nodiscard]] const SolidPtr& solid(PieceId piece) const { return pieces_.at(piece).solid; }
    [[nodiscard]] uint32_t slot(PieceId piece) const { return pieces_.at(piece).slot; }
    [[nodiscard]] uint32_t depth(PieceId piece) const { return pieces_.at(piece).depth; }
    [[nodiscard]] ObjectId object(PieceId piece) const { return pieces_.at(piece).object; }
    [[nodiscard]] BodyId body(PieceId piece) const {
        return body_of(pieces_.at(piece));
    }                                                                  // none once someone else removed it
    [[nodiscard]] PieceId next_piece() const { return {next_piece_}; } // all that have been are below
    // Of bonded pieces, or null: for blows by hand to their bonds. Its pieces are those with the object's first numbers.
    [[nodiscard]] Structure* structure(ObjectId object);
    [[nodiscard]] const Structure* structure(ObjectId object) const;
    // Which piece of its structure it is; nothing for one that is in none.
    [[nodiscard]] std::optional<uint32_t> bonded(PieceId piece) const;
    [[nodiscard]] size_t jobs_in_flight() const { return jobs_.size(); }
    [[nodiscard]] const Statistics& statistics() const { return statistics_; }
    // Of the pieces and what they have borne, what is being cut, and of structures: what World::state_hash() does not know.
    [[nodiscard]] uint64_t state_hash() const;

  private:
    static constexpr uint32_t none = UINT32_MAX;

    struct Hit { // a blow in the coordinates of the object
        Blow blow{};
        double sharp = 0.0; // N s, as of a kilogram
        BodyId striker{};
        glm::vec3 owed{0.0f};   // N s, world: what the piece got and the striker against it, to be solved anew
        glm::vec3 rubbed{0.0f}; // likewise of friction, where the piece is held; a free one has taken that over
        glm::vec3 arm{0.0f};    // m, world axes: from the striker's centre of mass to the contact, when it was
        double lost = 0.0;      // J, by that contact: no more comes back; the blow's energy may be that of several
    };
    struct Object {
        std::shared_ptr<const BreakableDesc> desc;
        std::unique_ptr<Structure> structure;
        std::vector<PieceId> bonded; // by piece of the structure
        uint32_t pieces = 0;
    };
    struct Live {
        ObjectId object;
        SolidPtr solid{};
        uint32_t depth = 0;
        PieceId of{};
        uint64_t seed = 0;
        uint32_t slot = 0;
        BodyId own{};           // none for a piece of a structure
        uint32_t bonded = none; // piece of the structure
        uint32_t job = none;
        uint32_t blows = 0;           // that began a job
        bool unbreakable = false;     // a cut of it was refused
        std::optional<Hit> waiting{}; // blows while the job runs
        uint64_t born = 0;            // steps; of a piece of a structure, when it came off
        uint64_t slept = 0;           // steps
        uint64_t fading = 0;          // steps that are left of it; 0: not fading
        double load = 0.0;            // N, mean of what rests on a held piece,
        double looked_at = 0.0;       // and the least since its blocks were looked at
    };
    struct Job {
        PieceId piece;
        uint64_t due = 0; // steps
        Hit hit{};
        bool parts = false; // along its blocks, of a load, where hit is none, or of a blow elsewhere
    };
    struct Made { // a piece, all that its commit takes
        SolidPtr solid;
        std::shared_ptr<const BodyForm> form; // null where it has several hulls
        PayloadPtr payload;
    };
    struct Broken {
        std::vector<Made> pieces; // none where the piece withstands, else two or more
        std::string failure;      // empty: none
    };
    struct Motion { // of a piece, in the world
        Pose pose, previous;
        glm::vec3 linear{0.0f}, angular{0.0f};
    };

    [[nodiscard]] const BreakableDesc& desc_of(const Live& piece) const { return *objects_.at(piece.object).desc; }
    [[nodiscard]] BodyId body_of(const Live& piece) const;
    [[nodiscard]] std::optional<Motion> motion_of(const World& world, const Live& piece) const;
    [[nodiscard]] std::optional<Pose> pose_of(const World& world, const Live& piece) const;
    [[nodiscard]] Pose in_body(const Live& piece, const Pose& body) const;
    Result<PieceId> add_piece(World& world, Live piece, PayloadPtr payload, const Motion& motion,
                              const glm::dvec3& from, bool debris, const std::shared_ptr<const BodyForm>& form = {});
    static BodyDesc body_of(const SolidPiece& solid);
    static Broken broken_into(Result<std::vector<SolidPtr>> pieces, const PayloadMaker& payload);
    PieceId register_piece(Live piece, PayloadPtr payload);
    void forget_piece(PieceId id);
    void let_go(SolidPtr solid, PayloadPtr payload = {});
    void remove_lost(const World& world);
    void take_up_blows(World& world);
    void update_structures(World& world);
    [[nodiscard]] bool cuts(const World& world, const Live& piece, const Hit& hit) const;
    void hit_piece(const World& world, PieceId id, const Hit& hit);
    [[nodiscard]] std::optional<Blow> blow_at(const World& world, const Live& piece, const glm::vec3& point,
                                              const glm::vec3& normal, double energy) const;
    [[nodiscard]] std::optional<PlannedCut> plan(const World& world, const Live& piece, const Blow& blow) const;
    void start_job(const World& world, PieceId id, const Hit& hit);
    using Parting =
        std::function<std::vector<uint32_t>(const SolidPiece&, const SolidSettings&, const glm::dvec3& gravity)>;
    [[nodiscard]] glm::dvec3 gravity_of(const World& world, const Live& piece) const;
    void knock(const World& world, PieceId id, const Hit& hit);
    void update_loads(const World& world);
    void part_if_overloaded(const World& world, PieceId id);
    void start_parting(const World& world, PieceId id, const Hit& hit, const Parting& parts);
    static void take_back_bounce(World& world, BodyId own, Hit& hit);
    [[nodiscard]] static double lost_by(const World& world, const Hit& hit, const glm::vec3& impulse);
    void commit_due(World& world, double budget);
    bool commit(World& world, uint32_t job);
    [[nodiscard]] bool is_held(const Live& piece) const;
    std::vector<PieceId> replace(World& world, PieceId old, Broken& broken);
    [[nodiscard]] PieceId nearest_of(std::span<const PieceId> made, const glm::dvec3& point) const;
    [[nodiscard]] double crack_energy(const Live& piece, const Broken& broken) const;
    void exchange(World& world, const Live& piece, double cracks, Hit& hit) const;
    PieceId solve_anew(World& world, std::span<const PieceId> made, Hit& hit) const;
    void see_debris(const World& world, std::span<Debris> candidates, size_t pieces, size_t vertices) const;
    [[nodiscard]] std::vector<PieceId> together_with(PieceId id) const;
    [[nodiscard]] bool is_seen(const World& world, const Live& piece) const;
    [[nodiscard]] bool came_off(const Live& piece) const;
    [[nodiscard]] bool is_debris(const Live& piece) const;
    void update_debris(World& world);
    [[nodiscard]] std::vector<PieceId> retire_debris(const World& world, size_t count, size_t vertices);
    void take_out(World& world, std::span<const PieceId> gone);

    DestructionSettings settings_;
    std::map<ObjectId, Object> objects_;
    std::map<PieceId, Live> pieces_;
    std::unordered_map<uint32_t, PieceId> piece_of_body_; // whole pieces, by BodyId::value; looked up only
    std::map<uint32_t, Job> jobs_;
    std::set<uint32_t> free_slots_;
    uint32_t slot_count_ = 0, next_object_ = 0, next_piece_ = 0, next_job_ = 0;
    uint64_t steps_seen_ = 0, removed_seen_ = 0;
    BlowBook blows_;
    std::vector<Commit> commits_, script_;
    size_t script_at_ = 0;
    std::map<PieceId, PieceAdded> added_;
    std::map<PieceId, PieceRemoved> removed_;
    std::map<PieceId, PieceFading> fading_;
    std::function<bool(const glm::vec3&, float)> visible_;
    Statistics statistics_;
    Background<Broken> background_; // last: its threads end first
};

std::ostream& operator<<(std::ostream& stream, PieceId id);

} // namespace brittle::physics
