// The session of the studio: the document, the mesh on its stage, and the actions on both. Panels and tools read it and
// call it; it depends on neither Dear ImGui nor the mouse. Each lasting change of the object is an edit of the recipe, so
// that the command line can repeat it.
//
//     Session session(options, object, renderer, classifier);
//     session.edit(SetMaterial{"glass"});
//     session.break_all();
//     each frame: session.update(seconds); renderer.present(session.scene(camera), ui);
//
// Parts of it have classes of their own: files() opens and writes, activity() holds long work and messages, sites() the
// sites and their selection, preview() the preview of a fracture.
//
// For one thread; workers are internal. Failures of a user's request become messages, those of the device are thrown.
#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <set>
#include <span>
#include <string>
#include <vector>

#include "engine/render/renderer.h"
#include "tools/brittle/stage/stage.h"
#include "tools/brittle/studio/activity.h"
#include "tools/brittle/studio/document.h"
#include "tools/brittle/studio/object.h"
#include "tools/brittle/studio/piece_view.h"
#include "tools/brittle/studio/session_files.h"
#include "tools/brittle/studio/stage_preview.h"
#include "tools/brittle/studio/stage_sites.h"
#include "tools/brittle/studio/tool_settings.h"
#include "tools/scenario/base/failure.h"
#include "tools/scenario/replay/recorder.h"

namespace brittle::tools {

struct Playback {
    bool paused = false;
    float speed = 1.0f; // seconds of the simulation per second; below 1: slow motion
};

class Session {
  public:
    // The renderer and the classifier (null for the CPU) outlive the session. A scene that is not prepared is shown, and
    // prepared on a worker.
    Session(FractureOptions recipe, std::shared_ptr<const Object> object, engine::Renderer& renderer,
            fracture::Classifier* classifier);
    ~Session();
    Session(const Session&) = delete;
    Session& operator=(const Session&) = delete;

    // --- the recipe ---
    [[nodiscard]] const Document& document() const { return document_; }
    [[nodiscard]] const FractureOptions& recipe() const { return document_.recipe(); }
    PictureOptions& picture() { return document_.picture(); }
    ExportSettings& exports() { return document_.exports(); }
    void edit(const Edit& edit, uint64_t gesture = 0);
    [[nodiscard]] uint64_t begin_gesture() { return document_.begin_gesture(); }
    void undo();
    void redo();
    [[nodiscard]] const StageSites& sites() const { return sites_; }
    [[nodiscard]] StageSites& sites() { return sites_; }
    // Turns the sites of the pattern, with their weights and groups, into sites placed by hand, which can be edited.
    void take_sites(uint64_t gesture);
    // Selects an object of a scene, beside those that are selected if `add`; or takes it out again.
    void select(uint32_t object, bool add);
    // Changes the selected objects of a scene.
    void change_selected(const std::function<void(SceneObject&)>& change, uint64_t gesture = 0);
    void duplicate_selected();
    // Adds an object with a mesh, a file or shape:NAME, and selects it. It lies at a point, or on what is in the middle of
    // the view.
    void add_object(const std::string& mesh, const std::optional<glm::dvec3>& at = std::nullopt);
    // Sets the places of objects; both lists are equally long.
    void set_places(std::span<const uint32_t> objects, std::span<const ObjectPlacement> places, uint64_t gesture);
    // Selects, beside those that are selected, the objects of which every corner of the box is within a region.
    void select_within(const std::function<bool(const glm::vec3& corner)>& contains);
    // The box around the selected objects; nothing without one, and while the scene is played.
    [[nodiscard]] std::optional<engine::Bounds> box_of_selected() const;
    // The point on the surface of other objects, or of the ground, that a ray meets; nothing where it meets none.
    [[nodiscard]] std::optional<glm::dvec3> surface_at(const glm::dvec3& from, const glm::dvec3& direction,
                                                       std::span<const uint32_t> except) const;
    // A hidden object is not drawn, and the mouse passes it by; it still collides. A locked one is not selected in the
    // view. Neither is part of the recipe. Kept by name.
    [[nodiscard]] bool is_hidden(uint32_t object) const;
    [[nodiscard]] bool is_locked(uint32_t object) const;
    void hide(uint32_t object, bool hidden);
    void lock(uint32_t object, bool locked);
    void rename(uint32_t object, const std::string& name, uint64_t gesture = 0);
    // The nearest piece along a ray that is drawn; for selection, also not of a locked object.
    [[nodiscard]] std::optional<PieceHit> first_piece(const glm::dvec3& from, const glm::dvec3& direction,
                                                      bool selects = false) const;
    // The object of a scene that a ray meets first, also while it is being prepared; for selection, also not a locked one.
    [[nodiscard]] std::optional<uint32_t> first_object(const glm::dvec3& from, const glm::dvec3& direction,
                                                       bool selects = false) const;
    // The middle of the boxes of the selected objects; nothing without one, and while the scene is played.
    [[nodiscard]] std::optional<glm::vec3> middle_of_selected() const;
    void remove_selected(); // the last object stays: a scene needs one
    // Converts anchors, which are relative to the foot of the mesh (world_options.h).
    [[nodiscard]] Anchor anchor_at(const glm::dvec3& on_stage) const;
    [[nodiscard]] glm::dvec3 on_stage(const Anchor& anchor) const;

    // --- the stage ---
    [[nodiscard]] const Object& object() const { return *object_; }
    [[nodiscard]] const std::shared_ptr<const Object>& shared_object() const { return object_; }
    [[nodiscard]] const Stage& stage() const { return *stage_; }
    [[nodiscard]] bool broken() const { return stage_->broken(); }
    // Whether time passes, unless it is paused: a mesh is broken, or a scene was started. A scene that is not played
    // stands at its first moment, and can be edited.
    [[nodiscard]] bool playing() const { return playing_; }
    // The pieces on the stage; none while the mesh is whole. Valid until the stage changes.
    [[nodiscard]] PieceView pieces() const;
    // The bounds of all pieces except distant ones; of the whole mesh while there are none.
    [[nodiscard]] engine::Bounds all_bounds() const;

    // While a scene is being prepared or read, the last call of break_all(), strike_along(), shoot() or step_once() waits
    // for it.
    //
    // Breaks the mesh by the pattern or the sites, without strikes. Lets the time of a scene begin.
    void break_all();
    // Hits the first thing along a ray with the hammer.
    void strike_along(const glm::dvec3& from, const glm::dvec3& direction);
    // Hits the whole mesh, or a piece, with the hammer. A breakable world is cut where it is hit and goes on. Otherwise the
    // whole mesh is broken anew, by the recipe with one more strike.
    void strike(const glm::dvec3& at, const glm::dvec3& direction);
    void strike(const PieceHit& hit, const glm::dvec3& direction);
    // Shoots a ball. A whole mesh is cut first, into pieces that stay in place.
    void shoot(const glm::vec3& from, const glm::vec3& direction);
    void grab(const PieceHit& hit);
    void drag(const glm::vec3& to); // target of the grabbed point
    void let_go();
    // Makes the mesh whole again and removes strikes. Puts the objects of a scene back to their places. Pieces are no
    // longer drawn apart.
    void reset();
    // Pauses, and runs one step of physics in the next update().
    void step_once();
    // The most pieces that a blow of the hammer makes of a piece on the stage.
    [[nodiscard]] uint32_t blow_pieces(uint32_t of) const;

    // For people: of the mesh, or of the file of a scene.
    [[nodiscard]] std::string name() const;

    std::string recipe_file; // the recipe's file; empty without one
    ToolSettings tools;
    Playback playback;
    bool bonds = false;             // show bonds and their loads
    std::optional<uint32_t> piece;  // the selected piece
    std::vector<uint32_t> selected; // indices of the selected objects of a scene

    [[nodiscard]] SessionFiles& files() { return files_; }
    [[nodiscard]] const Activity& activity() const { return activity_; }
    [[nodiscard]] Activity& activity() { return activity_; }
    [[nodiscard]] const StagePreview& preview() const { return preview_; }
    [[nodiscard]] StagePreview& preview() { return preview_; }

    // --- each frame ---
    void watch(const engine::Camera& camera, float aspect); // before update()
    void update(double seconds);
    [[nodiscard]] engine::Scene scene(const engine::Camera& camera);

    struct Counts {
        uint32_t pieces = 0;
        size_t awake = 0;
        double milliseconds = 0.0; // duration of the fracture
        fracture::Certificate certificate;
        std::vector<fracture::Milliseconds> phases;
    };
    [[nodiscard]] const std::optional<Counts>& counts() const { return counts_; } // of the last fracture
    [[nodiscard]] uint64_t steps() const { return stage_->simulation().steps(); } // of physics since the break
    // Whether the next frame would equal the last one: nothing moves, no work is under way, no result is awaited.
    [[nodiscard]] bool quiet() const;
    // Whether the next frame would differ from the last one by the share of the work alone.
    [[nodiscard]] bool only_works() const;
    // Returns true once after each fracture that was put on the stage, for the mark in the graph of frame times.
    [[nodiscard]] bool take_fracture_mark();

  private:
    friend class SessionFiles;

    void follow(const FractureOptions& before);
    bool follow_places();
    void read_object();
    [[nodiscard]] bool is_still() const; // whether nothing but work may change the next frame
    [[nodiscard]] bool reads() const;    // whether a read that is wanted is under way
    bool stand_now();
    void once_it_stands(const std::string& what, std::function<void()> action); // `what` for people
    void adopt(std::shared_ptr<const Object> object, std::vector<PreparedObject> parts = {});
    void make_stage(std::vector<PreparedObject> parts = {});
    void stand_scene(std::vector<PreparedObject> parts);
    void show_scene();
    void show_hidden();
    void forget_marks(); // of another scene
    void lay_down();
    [[nodiscard]] std::optional<uint32_t> object_named(const std::string& name) const;
    [[nodiscard]] const std::string* name_on_stage(uint32_t object) const; // null for one that is not there
    void tell_notes();
    void leave_piece();
    void start_breaking(const WorldOptions& world);
    void take_pieces(Broken broken, PreparedPieces ahead, const WorldOptions& world);
    void report(const Failure& failure, const std::string& mend = {});
    void place_lines(engine::Scene& scene);
    void tell_borne_shot();
    void add_boxes_of_selected(std::vector<engine::LineVertex>& lines) const;
    void add_bond_lines(std::vector<engine::LineVertex>& lines) const;

    Document document_;
    std::shared_ptr<const Object> object_;
    engine::Renderer& renderer_;
    fracture::Classifier* classifier_;
    std::optional<Recorder> recorder_; // always set after construction
    std::unique_ptr<Stage> stage_;
    StageSites sites_;
    std::shared_ptr<const fracture::Fragments> fragments_; // pieces of the fracture; set once broken
    WorldOptions world_;                                   // world that they were put into
    std::vector<float> radii_;                             // by index of fragments_->pieces
    std::vector<engine::BodyPose> poses_;                  // by slot, as drawn
    std::optional<Counts> counts_;
    std::optional<std::array<glm::vec3, 2>> shot_; // ball to shoot when the pieces are there: from, direction
    std::optional<AimedBlow> blow_;                // blow to strike when the pieces are there
    std::vector<engine::LineVertex> lines_;
    std::vector<physics::Pose> stood_;      // by object of a scene: its place on the stage
    uint64_t reads_ = 0;                    // number of reads so far
    uint64_t valid_reads_ = 1;              // the first read whose result is still wanted
    std::set<std::string> hidden_, locked_; // names of objects
    // An object that was added lies down once its mesh is known.
    struct LayDown {
        std::string name;
        glm::dvec3 at;
        uint64_t gesture;
    };
    std::optional<LayDown> lay_down_;
    std::optional<engine::Camera> camera_; // of the last frame
    // A ball under way. A message follows if it breaks nothing.
    struct WatchedShot {
        uint64_t step; // of the shot
        uint32_t cuts; // before it
        std::optional<physics::BorneBlow> borne{};
    };
    std::optional<WatchedShot> watched_shot_;
    bool moved_ = false;                   // objects are drawn away from their places on the stage
    std::function<void()> due_;            // what the user asked for before the scene stood; or empty
    std::vector<std::string> level_notes_; // of a level that was opened; empty once shown
    uint64_t stages_ = 0;                  // number of stages so far; pieces made for an older one are dropped
    bool fractured_ = false;
    bool playing_ = false;
    bool single_step_ = false;
    StagePreview preview_{*this, renderer_};
    SessionFiles files_{*this};
    Activity activity_{[this](const Failure& failure) { report(failure); }}; // last: its destructor waits for tasks
};

} // namespace brittle::tools
