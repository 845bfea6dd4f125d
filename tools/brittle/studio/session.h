// What the studio's window works on: the document, the mesh on its stage, the preview of its cracks, and work that takes
// long. Panels and tools read it and call it; it knows neither Dear ImGui nor the mouse. All that it does to the object
// is an edit of the recipe, so the command line can do it again.
//
//     Session session(options, object, renderer, classifier);
//     session.edit(SetMaterial{"glass"});
//     session.break_all();
//     each frame: session.update(seconds); renderer.present(session.scene(camera), ui);
//
// One thread but for its workers. Failures of what a user asked for become message(); those of the device are thrown.
#pragma once

#include <array>
#include <atomic>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <memory>
#include <mutex>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "engine/render/renderer.h"
#include "tools/brittle/base/failure.h"
#include "tools/brittle/pictures/video.h"
#include "tools/brittle/recipe/piece_export.h"
#include "tools/brittle/recipe/view_options.h"
#include "tools/brittle/replay/recorder.h"
#include "tools/brittle/run/stage.h"
#include "tools/brittle/run/state_export.h"
#include "tools/brittle/studio/document.h"
#include "tools/brittle/studio/object.h"
#include "tools/brittle/studio/piece_view.h"
#include "tools/brittle/studio/preview.h"
#include "tools/brittle/studio/worker.h"

namespace brittle::tools {

// What a blow or a shot of the tools is like. Lengths on the stage, where the mesh is 2 m long.
struct ToolSettings {
    float hammer_radius = 0.3f;  // m
    uint32_t hammer_pieces = 16; // cells in the ball
    float ball_speed = 14.0f;    // m/s
    float ball_radius = 0.1f;    // m
    float brush_radius = 0.15f;  // m, of painted anchors
};

struct Playback {
    bool paused = false;
    float speed = 1.0f; // of the clock: 0.1 is slow motion
};

struct Message {
    std::string text{};
    bool fault = false;
    std::string mend{}; // a mesh that repair would make fit: open it so
};

class Session {
  public:
    // The renderer and the classifier (null for the CPU) outlive the session.
    Session(FractureOptions recipe, std::shared_ptr<const Object> object, engine::Renderer& renderer,
            fracture::Classifier* classifier);
    ~Session();
    Session(const Session&) = delete;
    Session& operator=(const Session&) = delete;

    // --- the recipe ---
    [[nodiscard]] const Document& document() const { return document_; }
    [[nodiscard]] const FractureOptions& recipe() const { return document_.recipe(); }
    PictureOptions& picture() { return document_.picture(); }
    void edit(const Edit& edit, uint64_t gesture = 0);
    [[nodiscard]] uint64_t begin_gesture() { return document_.begin_gesture(); }
    void undo();
    void redo();
    // Sites as they are on the stage, placed by hand or by the pattern.
    [[nodiscard]] const std::vector<glm::dvec3>& sites() const { return sites_; }
    // So that single ones can be edited: what the pattern made becomes sites placed by hand, with its weights and groups.
    void take_sites(uint64_t gesture);

    // As the recipe has them, or would if they were taken; in the order of selection.
    [[nodiscard]] std::vector<PlacedSite> selected_sites() const;
    // Those that are in a group with one that is selected.
    [[nodiscard]] std::vector<uint32_t> fellows_of_selected() const;

    // Anchors are given from the foot of the mesh (world_options.h).
    [[nodiscard]] Anchor anchor_at(const glm::dvec3& on_stage) const;
    [[nodiscard]] glm::dvec3 on_stage(const Anchor& anchor) const;

    // --- what happens on the stage ---
    [[nodiscard]] const Object& object() const { return *object_; }
    [[nodiscard]] bool broken() const { return stage_->broken(); }
    void break_all(); // by the pattern or the sites; forgets strikes
    // A blow on the whole mesh, or on a piece; breaks what is near. What is breakable is cut where it is and moves on; else
    // the whole mesh is broken anew, by the recipe with one more strike.
    void strike(const glm::dvec3& at, const glm::dvec3& direction);
    void strike(const PieceHit& hit, const glm::dvec3& direction);
    // What such a strike would do is shown until another call: on the whole mesh, or on a piece that is at rest.
    void aim(const glm::dvec3& at, const glm::dvec3& direction);
    void aim(const PieceHit& hit, const glm::dvec3& direction);
    void aim_nowhere();
    void shoot(const glm::vec3& from, const glm::vec3& direction); // a whole mesh is cut first and then stands
    void grab(const PieceHit& hit);
    void drag(const glm::vec3& to); // where what is grabbed shall come
    void let_go();
    void reset(); // whole again, without strikes
    [[nodiscard]] std::optional<PieceHit> first_piece(const glm::dvec3& from, const glm::dvec3& direction) const;
    [[nodiscard]] bool contains(uint32_t which) const; // whether there is such a piece
    [[nodiscard]] engine::Bounds piece_bounds(uint32_t of) const;
    [[nodiscard]] engine::Bounds
    all_bounds() const; // of all pieces, but for those that rolled far away; or of the whole mesh
    [[nodiscard]] double piece_volume(uint32_t of) const; // m^3, on the stage
    [[nodiscard]] size_t piece_triangles(uint32_t of) const;
    void step_once(); // a single step of physics
    ToolSettings tools;
    Playback playback;
    bool bonds = false;              // show bonds and how much they carry
    bool preview_wanted = false;     // by the tool in use, whatever the view says
    std::vector<uint32_t> selection; // sites
    std::optional<uint32_t> piece;   // that is selected

    // --- files ---
    void open(const std::string& path, bool repair = false); // a mesh, shape:NAME or a recipe; on a worker
    void save_recipe(const std::filesystem::path& file);
    // On a worker, as `exports` says. Once broken what is on the stage; before, the recipe's pieces as `brittle fracture`
    // writes them, which is also what `made` means where nothing was cut anew.
    void export_pieces(const std::filesystem::path& file, PiecesAs as = PiecesAs::made);
    ExportSettings exports;                              // but for the output
    void save_replay(const std::filesystem::path& file); // of what happened since the break (docs/replay.md)
    void finish_video(std::shared_ptr<Video> video, const std::string& file); // on a worker
    std::function<void(const std::string&)> opened; // told of each mesh and recipe, for the list of recent files

    // --- work that takes long ---
    struct Work {
        std::string what;
        double share = 0.0; // negative: unknown
    };
    [[nodiscard]] std::optional<Work> work() const;
    void cancel();

    [[nodiscard]] const Message& message() const { return message_; }
    void say(Message message) { message_ = std::move(message); }

    // --- the replay log (docs/replay.md): always kept in memory, some 100 bytes a step and 4 a body that moves ---
    void record(const std::filesystem::path& file); // and written in the end; it tells of the last break
    void finish_recording();                        // writes it; nothing where record() was not called

    // --- each frame ---
    void watch(const engine::Camera& camera, float aspect) { stage_->watch(camera, aspect); } // before update()
    void update(double seconds);
    [[nodiscard]] engine::Scene scene(const engine::Camera& camera);

    struct Counts {
        uint32_t pieces = 0;
        size_t awake = 0;
        double milliseconds = 0.0; // of the fracture
        fracture::Certificate certificate;
        std::vector<fracture::Milliseconds> phases;
    };
    [[nodiscard]] const std::optional<Counts>& counts() const { return counts_; } // of the last fracture
    [[nodiscard]] const Stage& stage() const { return *stage_; }
    [[nodiscard]] uint64_t steps() const { return stage_->simulation().steps(); } // of physics since the break
    [[nodiscard]] const Cracked* preview() const {
        return shown_ ? shown_.get() : cracks_ahead_.get();
    } // that is shown, or null
    // Sites that change nothing; none known while the preview does not show them.
    [[nodiscard]] std::span<const uint32_t> idle_sites() const {
        return shown_ && !broken() && shown_->sites.size() == sites_.size()
                   ? std::span<const uint32_t>(shown_->idle_sites)
                   : std::span<const uint32_t>();
    }
    [[nodiscard]] uint32_t preview_pieces() const { return preview() ? preview()->pieces : 0; }
    // Nothing moves, nothing is worked on, nothing is waited for: the next frame would be the same.
    [[nodiscard]] bool quiet() const;
    // True once after each fracture that was put on the stage: for the mark in the graph of frame times.
    [[nodiscard]] bool take_fracture_mark();

  private:
    struct Shown { // what the preview was last asked for
        uint64_t version;
        const Object* object;
        std::optional<Strike> strike;
        std::optional<AimedBlow> blow;

        friend bool operator==(const Shown&, const Shown&) = default;
    };
    struct AimedPiece {
        PieceHit hit;
        glm::dvec3 direction;
        double radius;

        friend bool operator==(const AimedPiece&, const AimedPiece&) = default;
    };

    void follow(const FractureOptions& before);
    void adopt(std::shared_ptr<const Object> object);
    void make_stage();
    void find_sites();
    void leave_piece(); // what was selected or aimed at
    void start_breaking(const WorldOptions& world);
    void take_pieces(Broken broken, PreparedPieces ahead, const WorldOptions& world);
    [[nodiscard]] Strike strike_at(const glm::dvec3& at,
                                   const glm::dvec3& direction) const; // in the file's coordinates
    [[nodiscard]] AimedBlow blow_at(const glm::dvec3& at, const glm::dvec3& direction) const;
    [[nodiscard]] PieceView pieces() const {
        return {stage_->simulation(), *fragments_, radii_, poses_};
    } // once broken
    void start(const std::string& what, Worker::Task task);
    void post(std::function<void()> completion); // from a worker, to the next update()
    void report(const Failure& failure, const std::string& mend = {});
    void update_preview();
    void leave_preview();
    void look_ahead();
    [[nodiscard]] bool rests(uint32_t of) const;
    void draw_instead(engine::PieceBatch batch); // of all that is drawn
    void place_lines(engine::Scene& scene);
    [[nodiscard]] bool wants_preview() const;
    void add_bond_lines(std::vector<engine::LineVertex>& lines) const;
    void add_cracks_ahead(std::vector<engine::LineVertex>& lines) const;

    Document document_;
    std::shared_ptr<const Object> object_;
    engine::Renderer& renderer_;
    fracture::Classifier* classifier_;
    std::optional<Recorder> recorder_; // always there
    std::unique_ptr<Stage> stage_;
    std::vector<glm::dvec3> sites_;
    std::vector<PlacedSite> placed_;                       // the same in the file's coordinates
    std::shared_ptr<const fracture::Fragments> fragments_; // that broke off first, once broken
    WorldOptions world_;                                   // that they were put into
    std::vector<float> radii_;                             // of its pieces
    std::vector<engine::BodyPose> poses_;                  // by slot, as drawn
    std::optional<Counts> counts_;
    std::optional<Strike> aimed_strike_; // at the whole mesh, to be shown; at most one of the three
    std::optional<AimedBlow> aimed_blow_;
    std::optional<AimedPiece> aimed_piece_;
    std::optional<std::array<glm::vec3, 2>> shot_; // to be fired when the pieces are there: from, direction
    std::optional<AimedBlow> blow_;                // likewise, of the hammer
    std::vector<engine::LineVertex> lines_;
    std::vector<engine::Sphere> spheres_;
    Message message_;
    uint64_t stages_ = 0; // made so far: pieces for an older one come too late
    bool fractured_ = false;
    bool single_step_ = false;

    std::shared_ptr<Cracked> shown_; // uploaded in place of the whole mesh
    std::optional<Shown> asked_;
    std::shared_ptr<Cracked> cracks_ahead_; // of the piece that is aimed at
    std::optional<AimedPiece> asked_ahead_;
    uint64_t preview_key_ = 0;
    Preview preview_{renderer_};

    mutable std::mutex mutex_;
    std::vector<std::function<void()>> completions_;
    std::string work_name_;
    std::atomic<double> work_share_ = 0.0;
    Worker worker_; // last: its destructor waits
};

} // namespace brittle::tools
