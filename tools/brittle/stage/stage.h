// A mesh on a stage: whole at first, then broken into pieces that fall. The stage draws a Simulation: fragments become
// geometry, and the poses of moved pieces go straight into the renderer's instance buffer. A blow uploads new geometry
// only. The thread that cuts the piece makes this geometry (piece_drawing.h).
//
// Lengths are metres: the mesh is scaled and stands on the ground (y = 0) or above it (stage_placement.h).
//
//     Input input = placed_on_stage(load_input(options));
//     Stage stage(renderer, input.mesh);
//     Broken broken = break_input(input, options);                                  // these two on any thread
//     PreparedPieces ahead = prepare_pieces(renderer, broken.fragments, world_of(options), options.material);
//     stage.stand(broken.fragments, world_of(options), std::move(ahead));
//     each frame: stage.advance(1.0 / 60.0); renderer.render(stage.scene(), size);
#pragma once

#include <map>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "engine/render/renderer.h"
#include "engine/render/scene.h"
#include "fracture/mesh/mesh.h"
#include "fracture/pieces/fragments.h"
#include "physics/cutting/piece_payload.h"
#include "physics/world/world.h"
#include "tools/brittle/stage/break_particles.h"
#include "tools/brittle/stage/mesh_looks.h"
#include "tools/brittle/stage/piece_drawing.h"
#include "tools/scenario/recipe/input.h"
#include "tools/scenario/run/scene.h"
#include "tools/scenario/run/simulation.h"
#include "tools/scenario/run/stage_placement.h"

namespace brittle::tools {

// Returns the unbroken mesh in the form that the renderer draws. On any thread. Throws a Failure.
[[nodiscard]] engine::PieceBatch batch_of(const fracture::TriangleMesh& mesh, const MeshLooks* looks = nullptr);

// Results of the slow part of putting pieces on the stage.
struct PreparedPieces {
    PreparedObject object;    // without fragments, which stand() is given
    engine::PieceBatch batch; // geometry of a world that is not breakable
    std::vector<float> radii; // radius of each piece of `batch` around its centre of mass, m
};

// Prepares pieces for the renderer and material of a stage, on any thread. `threads` 0 is one per core. Throws a
// Failure.
[[nodiscard]] PreparedPieces prepare_pieces(const engine::Renderer& renderer, const fracture::Fragments& fragments,
                                            const WorldOptions& world, const std::string& material,
                                            uint32_t threads = 0, std::shared_ptr<const MeshLooks> looks = {});

// Returns what makes the payloads of breakable pieces for a renderer, on any thread.
[[nodiscard]] DrawingMaker payload_maker(const engine::Renderer& renderer);

// The meshes of a scene as its objects show them, for a stage on which they have no bodies yet.
struct SceneMeshes {
    struct Object {
        uint32_t batch = 0;        // of `batches`
        physics::Pose placement{}; // from the object's coordinates to the world
        std::string material{};    // name of a preset, or empty
        std::shared_ptr<const MeshLooks> looks{};
    };
    std::vector<engine::PieceBatch> batches{}; // of one piece each
    std::vector<Object> objects{};
};

// Equal meshes become one batch. On any thread. Throws a Failure.
[[nodiscard]] SceneMeshes meshes_of(const LoadedScene& scene);

class Stage {
  public:
    // Shows the unbroken mesh, or a batch made from it, in its box. The renderer must outlive the stage. `material` is
    // the name of a preset, or empty. `looks`: of the mesh, with which the batch was made; or null.
    Stage(engine::Renderer& renderer, const fracture::TriangleMesh& mesh, const std::string& material = {},
          std::shared_ptr<const MeshLooks> looks = {});
    Stage(engine::Renderer& renderer, const fracture::Box& box, engine::PieceBatch whole,
          const std::string& material = {}, std::shared_ptr<const MeshLooks> looks = {});
    // Shows nothing until stand(). `home`: the bounds that home_bounds() returns.
    Stage(engine::Renderer& renderer, const fracture::Box& home) : Stage(renderer, home, {}) {}

    // Replaces the unbroken mesh by unbonded pieces, which fall from their places.
    void shatter(const fracture::Fragments& fragments) { stand(fragments, {}); }
    // Replaces the unbroken mesh by pieces that are bonded and breakable as the options say, and schedules the options'
    // shots. `ahead` must belong to these fragments and options.
    void stand(const fracture::Fragments& fragments, const WorldOptions& world);
    void stand(const fracture::Fragments& fragments, const WorldOptions& world, PreparedPieces ahead);
    // Empties the stage and shows the meshes of a scene, whose objects carry() and hide() know by their index. They do
    // not collide, and no time passes, until stand().
    void show(const SceneMeshes& meshes);
    // Empties the stage and puts several prepared objects on it (Simulation::start()). Their payloads must be of
    // payload_maker().
    void stand(std::vector<PreparedObject> objects, const WorldOptions& world);
    // Shoots a ball at once, whatever the time of the shot. No effect while the mesh is whole.
    void shoot(const Shot& shot);

    // Sets the camera, without its shift, for the removal of unseen debris (Watch in action.h). The next advance()
    // passes it to the simulation.
    void watch(const engine::Camera& camera, float aspect);
    // Advances physics by the time of a frame. No effect while the mesh is whole.
    void advance(double seconds);

    // Draws sites as red spheres through the pieces. An empty span removes them.
    void show_sites(std::span<const glm::dvec3> sites);
    // Moves the drawn pieces apart, by this share of their distance from the middle of home_bounds().
    void explode(float share);
    // Draws the pieces of objects elsewhere: moved from where they are, by object, before a run has begun. Empty: none.
    void carry(std::vector<physics::Pose> moves);
    // Leaves out the pieces of objects, by object. Empty: all are drawn.
    void hide(std::vector<bool> hidden);
    // Draws lines through the pieces.
    void show_lines(std::vector<engine::LineVertex> lines) { own_lines_ = std::move(lines); }
    void colour_by(PieceColours colours) { colours_ = colours; }
    // Whether the scene is drawn with materials: as colour_by() says, or where a mesh has some.
    [[nodiscard]] bool shows_materials() const { return tools::shows_materials(colours_, has_materials_); }
    // Share of the dust and splinters of breaks that is drawn, 0 to 1; 0, none, at first.
    void dust(float amount) { particles_.set_amount(amount); }
    void show_hulls(bool show) { hulls_ = show; } // collision hulls as red lines

    // Returns the scene at this moment, without a camera; valid until the stage changes.
    [[nodiscard]] engine::Scene scene();
    [[nodiscard]] engine::Bounds home_bounds() const { return home_; } // bounds of the unbroken mesh
    // For actions and observers. Only the stage may call start() and clear().
    [[nodiscard]] Simulation& simulation() { return simulation_; }
    [[nodiscard]] const Simulation& simulation() const { return simulation_; }
    [[nodiscard]] const physics::World& world() const { return simulation_.world(); }
    [[nodiscard]] bool broken() const { return simulation_.running(); }
    // Returns whether the passing of time changes nothing: no body has moved for some steps, no cut is under way, no
    // bond wears, no debris is beyond the limit, and no dust is left.
    [[nodiscard]] bool still() const;

  private:
    void draw_anew(engine::PieceBatch batch);
    void take_events();
    void start_particles();
    void place_particles(engine::Scene& scene);
    // What the renderer draws of a breakable piece: all of a small one, or a branch of a large one.
    struct Part {
        std::optional<fracture::ClusterBranch> branch;
        engine::PieceHandle handle;
    };
    struct Drawn {
        std::vector<Part> parts;
        glm::vec3 tint;
        physics::ObjectId object;
    };
    // A mesh that show() put on the stage.
    struct ShownMesh {
        engine::PieceHandle handle;
        physics::Pose pose; // of the middle of its bounding sphere
    };
    // By object and ClusterBranch::key(): objects of one mesh share clusters.
    using PartPool = std::map<std::pair<physics::ObjectId, const void*>, Part>;
    // Parts that are to be added.
    struct FreshParts {
        std::vector<engine::PieceBatch> batches;
        std::vector<std::pair<physics::PieceId, std::optional<fracture::ClusterBranch>>> owners; // by part
    };
    // Whole pieces that appear together: the first of each solid, and those that have its geometry.
    struct Alike {
        std::map<const physics::SolidPiece*, physics::PieceId> originals;
        std::vector<const physics::PieceAdded*> copies;
    };
    [[nodiscard]] engine::PieceAttachment attachment_for(const physics::PieceAdded& added) const;
    void draw(const physics::PieceAdded& added, PieceDrawing& drawing, PartPool& left, FreshParts& fresh);
    void draw(physics::PieceAdded& added, PartPool& left, FreshParts& fresh, Alike& alike);
    void draw_copies(const Alike& alike);
    void show(Drawn& drawn, const std::optional<fracture::ClusterBranch>& branch, engine::PieceHandle handle);
    void pass_view();
    [[nodiscard]] glm::vec3 tint_of(const physics::PieceAdded& added, std::span<const physics::PieceAdded> all,
                                    const std::map<physics::PieceId, glm::vec3>& before) const;
    void place(engine::Scene& scene);
    void choose_surfaces(std::span<const physics::MaterialPreset* const> materials);
    void use_looks(std::vector<std::shared_ptr<const MeshLooks>> looks);
    void draw_all_poses();
    template<class Visit>
    void visit_poses(uint64_t since, const Visit& visit) const;
    [[nodiscard]] physics::Pose drawn_pose(uint32_t slot, const physics::Pose& pose) const;
    [[nodiscard]] bool is_hidden(physics::ObjectId object) const;
    [[nodiscard]] bool is_hidden(uint32_t object) const; // of the scene

    engine::Renderer& renderer_;
    Simulation simulation_;
    engine::Bounds home_;
    std::vector<float> radii_;                            // by slot: radius of the piece around its centre of mass
    std::vector<uint32_t> members_;                       // by slot: the object of the scene, in a breakable world
    std::map<physics::PieceId, Drawn> drawn_;             // pieces of a breakable world
    std::vector<ShownMesh> meshes_;                       // by slot; none once objects stand
    std::vector<engine::SurfaceLook> surfaces_;           // of the scene
    std::vector<uint32_t> surface_of_;                    // by object of the scene: PieceAttachment::surface
    std::vector<std::shared_ptr<const MeshLooks>> looks_; // of the mesh; or by object of the scene
    std::vector<uint32_t> first_materials_;               // by entry of looks_: PieceAttachment::first_material
    bool has_materials_ = false;                          // whether a mesh has some
    PieceColours colours_ = PieceColours::automatic;
    std::vector<physics::Pose> carried_; // by object of the scene: set by carry()
    std::vector<bool> hidden_;           // by object of the scene: set by hide()
    bool untinted_ = false;              // uncut pieces keep the look of the unbroken mesh: the world started whole
    size_t max_pieces_ = 0;              // limit beyond which debris is removed
    uint64_t moment_ = 0;                // number of the scene's pose state: moment_before_ + steps
    uint64_t moment_before_ = 1;         // moment at step 0 of this run
    uint64_t all_moved_ = 0;             // last moment at which every pose changed
    std::vector<physics::DebugLine> debug_lines_;
    std::vector<engine::LineVertex> own_lines_, lines_;
    std::vector<engine::Sphere> spheres_, shown_spheres_; // the sites; sites and balls
    BreakParticles particles_;
    std::vector<engine::Splinter> splinters_;
    std::vector<engine::DustPuff> dust_;
    std::optional<Watch> watch_, passed_watch_; // the view set by watch(), and the last view passed in this run
    float alpha_ = 1.0f;
    float explode_ = 0.0f;
    bool hulls_ = false;
    uint64_t last_awake_ = 0; // steps
    bool moved_ = true;
};

} // namespace brittle::tools
