// One mesh on a stage: whole at first, then broken into pieces that fall. The place where fragments become rigid bodies
// and rigid bodies become poses in the renderer's instance buffer.
//
// Metres: the mesh is scaled so that its longest side is 2 m and floats above the ground (y = 0), or stands on it.
//
//     Input input = placed_on_stage(load_input(options));
//     Stage stage(renderer, input.mesh);
//     stage.shatter(break_input(input, options).fragments);
//     each frame: stage.advance(1.0 / 60.0); renderer.render(stage.scene(), size);
#pragma once

#include <optional>
#include <vector>

#include "engine/render/renderer.h"
#include "engine/render/scene.h"
#include "fracture/fragments.h"
#include "fracture/mesh.h"
#include "physics/material.h"
#include "physics/structure.h"
#include "physics/world.h"
#include "tools/brittle/input.h"

namespace brittle::tools {

// Scales and moves mesh and sites to the place described above. A mesh without extent is left as it is.
[[nodiscard]] Input placed_on_stage(Input input, const WorldOptions& world = {});

class Stage {
  public:
    // Uploads the unbroken mesh. The renderer must outlive the stage.
    // `material` is a preset's name, or empty.
    Stage(engine::Renderer& renderer, const fracture::TriangleMesh& mesh, const std::string& material = {});

    // Replaces the unbroken mesh by pieces that fall from where they are.
    void shatter(const fracture::Fragments& fragments);
    // Replaces the unbroken mesh by pieces that hold together as the options say.
    void stand(const fracture::Fragments& fragments, const WorldOptions& world);
    // A ball flies from there; nothing while the mesh is whole.
    void shoot(const Shot& shot);
    // Pulls a piece, as by a hand that holds it at a point of it (in its own frame) and is at `target`. Once a frame,
    // before advance(). Nothing where there is no such piece or the world holds it.
    void pull(uint32_t piece, const glm::vec3& grip, const glm::vec3& target);
    // The unbroken mesh again.
    void reset(const fracture::TriangleMesh& mesh);

    // Advances physics by a frame's time; nothing while the mesh is whole.
    void advance(double seconds);

    void show_sites(std::span<const glm::dvec3> sites); // as red spheres seen through the pieces; none for an empty span
    // Draws the pieces moved apart: away from the middle by this share of their distance to it.
    void explode(float share) { explode_ = share; }
    void show_lines(std::vector<engine::LineVertex> lines) { own_lines_ = std::move(lines); } // seen through the pieces
    void show_hulls(bool show) { hulls_ = show; }       // the physics debug drawer, in red lines

    // The scene of this moment; valid until the stage changes. The caller sets the camera.
    [[nodiscard]] engine::Scene scene();
    [[nodiscard]] engine::Bounds home_bounds() const { return home_; } // of the unbroken mesh, for the camera
    [[nodiscard]] const physics::World& world() const { return world_; }
    [[nodiscard]] const physics::Structure* structure() const { return structure_ ? &*structure_ : nullptr; } // of bonded pieces
    [[nodiscard]] bool broken() const { return world_.body_count() > 0; }

  private:
    void upload(const fracture::Fragments& fragments);

    engine::Renderer& renderer_;
    physics::World world_;
    const physics::MaterialPreset* material_ = nullptr;
    engine::Bounds home_;
    std::optional<physics::Structure> structure_; // of bonded pieces
    struct Ball {
        physics::BodyId body;
        float radius;
    };
    std::vector<Ball> balls_;
    std::vector<float> radii_;  // of each piece around its centre of mass
    std::vector<physics::Pose> poses_;
    std::vector<physics::DebugLine> debug_lines_;
    std::vector<engine::LineVertex> own_lines_, lines_;
    std::vector<engine::Sphere> spheres_, shown_spheres_; // sites; with balls
    float alpha_ = 1.0f;
    float explode_ = 0.0f;
    bool hulls_ = false;
    bool moved_ = true;
};

} // namespace brittle::tools
