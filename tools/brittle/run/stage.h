// One mesh on a stage: whole at first, then broken into pieces that fall. Draws a Simulation: fragments become geometry,
// and the poses of pieces that moved go straight into the renderer's instance buffer. Of what is cut anew, the new pieces
// alone are uploaded; the thread that cut them has made them ready (PieceLook).
//
// Metres: the mesh is scaled and floats above the ground (y = 0), or stands on it (stage_placement.h).
//
//     Input input = placed_on_stage(load_input(options));
//     Stage stage(renderer, input.mesh);
//     Broken broken = break_input(input, options);                                  // these two on any thread
//     PreparedPieces ahead = prepare_pieces(renderer, broken.fragments, world_of(options), options.material);
//     stage.stand(broken.fragments, world_of(options), std::move(ahead));
//     each frame: stage.advance(1.0 / 60.0); renderer.render(stage.scene(), size);
#pragma once

#include <map>
#include <optional>
#include <string>
#include <vector>

#include "engine/render/renderer.h"
#include "engine/render/scene.h"
#include "fracture/mesh/mesh.h"
#include "fracture/pieces/fragments.h"
#include "physics/world/world.h"
#include "tools/brittle/recipe/input.h"
#include "tools/brittle/run/simulation.h"
#include "tools/brittle/run/stage_placement.h"

namespace brittle::tools {

// Mesh, sites and weights as placement_on_stage() wants them.
[[nodiscard]] Input placed_on_stage(Input input, const WorldOptions& world = {});

// The unbroken mesh, ready to be drawn. On any thread. Throws a Failure.
[[nodiscard]] engine::PieceBatch batch_of(const fracture::TriangleMesh& mesh);

// All that costs milliseconds of putting pieces on the stage.
struct PreparedPieces {
    PreparedBodies bodies;
    engine::PieceBatch batch; // of what is not breakable
    std::vector<float> radii; // of each piece in it around its centre of mass, m
};

// On any thread, for the stage's renderer and material. threads: 0 is one a core. Throws a Failure.
[[nodiscard]] PreparedPieces prepare_pieces(const engine::Renderer& renderer, const fracture::Fragments& fragments,
                                            const WorldOptions& world, const std::string& material,
                                            uint32_t threads = 0);

class Stage {
  public:
    // Shows the unbroken mesh, or what was made of it, in its box. The renderer must outlive the stage.
    // `material` is a preset's name, or empty.
    Stage(engine::Renderer& renderer, const fracture::TriangleMesh& mesh, const std::string& material = {});
    Stage(engine::Renderer& renderer, const fracture::Box& box, engine::PieceBatch whole,
          const std::string& material = {});

    // Replaces the unbroken mesh by pieces that fall from where they are.
    void shatter(const fracture::Fragments& fragments) { stand(fragments, {}); }
    // Replaces the unbroken mesh by pieces that hold together and break as the options say, with the options' shots to
    // come. `ahead` is of the same fragments and options.
    void stand(const fracture::Fragments& fragments, const WorldOptions& world);
    void stand(const fracture::Fragments& fragments, const WorldOptions& world, PreparedPieces ahead);
    // A ball flies from there, whenever the shot is for; nothing while the mesh is whole.
    void shoot(const Shot& shot);

    // Who looks at what is drawn from now on, without a shift: debris that no one sees goes first (Watch in action.h). Told to the
    // simulation by the next advance().
    void watch(const engine::Camera& camera, float aspect);
    // Advances physics by a frame's time; nothing while the mesh is whole.
    void advance(double seconds);

    void
    show_sites(std::span<const glm::dvec3> sites); // as red spheres seen through the pieces; none for an empty span
    // Draws the pieces moved apart: away from the middle by this share of their distance to it.
    void explode(float share);
    void show_lines(std::vector<engine::LineVertex> lines) { own_lines_ = std::move(lines); } // seen through the pieces
    void show_hulls(bool show) { hulls_ = show; } // the physics debug drawer, in red lines

    // The scene of this moment; valid until the stage changes. The caller sets the camera.
    [[nodiscard]] engine::Scene scene();
    [[nodiscard]] engine::Bounds home_bounds() const { return home_; } // of the unbroken mesh, for the camera
    // For actions and observers; start() and clear() are the stage's own.
    [[nodiscard]] Simulation& simulation() { return simulation_; }
    [[nodiscard]] const Simulation& simulation() const { return simulation_; }
    [[nodiscard]] const physics::World& world() const { return simulation_.world(); }
    [[nodiscard]] bool broken() const { return simulation_.running(); }
    // Nothing has moved for some steps, nothing is being cut, no bond wears and no debris is in excess: time changes nothing.
    [[nodiscard]] bool still() const;

  private:
    void draw_anew(engine::PieceBatch batch);
    void take_events();
    void tell_watch();
    [[nodiscard]] glm::vec3 tint_of(const physics::PieceAdded& added, std::span<const physics::PieceAdded> all,
                                    const std::map<physics::PieceId, glm::vec3>& before) const;
    void place(engine::Scene& scene);

    engine::Renderer& renderer_;
    Simulation simulation_;
    engine::Bounds home_;
    std::vector<float> radii_; // by slot, of a piece around its centre of mass
    struct Drawn {
        engine::PieceHandle handle;
        glm::vec3 tint;
    };
    std::map<physics::PieceId, Drawn> drawn_; // of breakable things
    bool untinted_ = false;                   // they start whole, and so as the unbroken mesh is drawn
    size_t max_pieces_ = 0;                   // beyond it debris goes
    uint64_t moment_ = 0;                     // of the scene: steps, and what came before them
    uint64_t moment_before_ = 1;              // that of the start
    uint64_t all_moved_ = 0;                  // the last moment at which every pose changed
    std::vector<physics::DebugLine> debug_lines_;
    std::vector<engine::LineVertex> own_lines_, lines_;
    std::vector<engine::Sphere> spheres_, shown_spheres_; // sites; with balls
    std::optional<Watch> watch_, told_;                   // of this run
    float alpha_ = 1.0f;
    float explode_ = 0.0f;
    bool hulls_ = false;
    uint64_t last_awake_ = 0; // steps
    bool moved_ = true;
};

} // namespace brittle::tools
