#include "tools/brittle/stage.h"

#include <algorithm>
#include <cmath>

#include <glm/geometric.hpp>
#include <glm/gtc/color_space.hpp>

#include "tools/brittle/failure.h"

namespace brittle::tools {

namespace {

constexpr double stage_size = 2.0;     // m, longest side of the mesh
constexpr float piece_tint_strength = 0.9f;
constexpr float material_tint_strength = 0.15f; // a material shows its own colour
constexpr float site_radius = 0.02f;   // m
constexpr float bounds_limit = 12.0f;  // m, debris that rolls further away casts no shadow and moves no camera

uint32_t packed(const glm::vec3& linear) {
    const glm::uvec3 c(glm::convertLinearToSRGB(glm::clamp(linear, 0.0f, 1.0f)) * 255.0f + 0.5f);
    return engine::srgb8(c.x, c.y, c.z);
}

} // namespace

Input placed_on_stage(Input input, const WorldOptions& world) {
    const fracture::Box box = fracture::bounds(input.model.mesh);
    const double longest = std::max({box.size().x, box.size().y, box.size().z});
    if (!(longest > 0.0) || !std::isfinite(longest)) return input;
    const double scale = stage_size / longest;
    const double height = world.anchored ? 0.0 : world.height;
    const glm::dvec3 foot(box.centre().x, box.min.y, box.centre().z);
    const auto place = [&](glm::dvec3& p) { p = (p - foot) * scale + glm::dvec3(0.0, height, 0.0); };
    std::for_each(input.model.mesh.positions.begin(), input.model.mesh.positions.end(), place);
    std::for_each(input.sites.begin(), input.sites.end(), place);
    for (double& weight : input.weights) weight *= scale * scale;
    return input;
}

Stage::Stage(engine::Renderer& renderer, const fracture::TriangleMesh& mesh, const std::string& material)
    : renderer_(renderer), simulation_(material) {
    reset(mesh);
}

void Stage::reset(const fracture::TriangleMesh& mesh) {
    simulation_.clear();
    radii_.clear();
    const fracture::Box box = fracture::bounds(mesh);
    home_ = {glm::vec3(box.min), glm::vec3(box.max)};
    const std::vector<glm::vec3> positions(mesh.positions.begin(), mesh.positions.end());
    const engine::PieceMesh whole{.positions = positions,
                                  .triangles = mesh.triangles,
                                  .exterior_triangles = static_cast<uint32_t>(mesh.triangles.size())};
    must(renderer_.set_pieces({&whole, 1}));
    moved_ = true;
}

void Stage::stand(const fracture::Fragments& fragments, const WorldOptions& world) {
    simulation_.start(fragments, world);
    upload(fragments);
}

void Stage::shoot(const Shot& shot) {
    if (broken()) simulation_.apply(Shoot{shot.from, shot.velocity, shot.radius, shot.density});
}

// What is drawn of the fragments, with a body's pose a piece.
void Stage::upload(const fracture::Fragments& fragments) {
    alpha_ = 1.0f;
    std::vector<glm::vec3> positions(fragments.positions.size());
    std::vector<engine::PieceMesh> meshes;
    radii_.clear();
    for (const fracture::Piece& piece : fragments.pieces) {
        float radius = 0.0f;
        for (uint32_t v = piece.vertices.begin; v < piece.vertices.end; ++v) {
            positions[v] = glm::vec3(fragments.positions[v] - piece.mass.centre_of_mass);
            radius = std::max(radius, glm::length(positions[v]));
        }
        const auto body = static_cast<uint32_t>(meshes.size());
        radii_.push_back(radius);
        meshes.push_back({.positions = std::span(positions).subspan(piece.vertices.begin, piece.vertices.size()),
                          .triangles = fragments.triangles_of(piece),
                          .exterior_triangles = piece.exterior_triangles,
                          .body = body,
                          .tint = engine::piece_tint(body)});
    }
    must(renderer_.set_pieces(meshes));
    moved_ = true;
}

void Stage::advance(double seconds) {
    if (!broken()) return;
    moved_ = true;
    alpha_ = simulation_.advance(seconds);
}

void Stage::show_sites(std::span<const glm::dvec3> sites) {
    spheres_.clear();
    for (const glm::dvec3& s : sites) spheres_.push_back({.centre = glm::vec3(s), .radius = site_radius});
}

engine::Scene Stage::scene() {
    engine::Scene scene;
    scene.bounds = home_;
    scene.look.tint = piece_tint_strength;
    if (const physics::MaterialPreset* material = simulation_.material()) {
        scene.look.exterior = material->exterior;
        scene.look.interior = material->interior;
        scene.look.tint = material_tint_strength;
    }
    if (broken()) {
        poses_.resize(radii_.size());
        simulation_.write_poses(poses_, alpha_);
        for (physics::Pose& pose : poses_) pose.position += explode_ * (pose.position - home_.centre());
        const glm::vec3 limit(bounds_limit);
        scene.bounds = {limit, -limit};
        for (size_t i = 0; i < poses_.size(); ++i) {
            const glm::vec3 centre = glm::clamp(poses_[i].position, -limit, limit);
            scene.bounds.min = glm::min(scene.bounds.min, centre - radii_[i]);
            scene.bounds.max = glm::max(scene.bounds.max, centre + radii_[i]);
        }
        scene.write_poses = [this](std::span<engine::BodyPose> out, uint64_t) {
            for (size_t i = 0; i < std::min(out.size(), poses_.size()); ++i) {
                out[i] = {.rotation = poses_[i].orientation, .position = poses_[i].position};
            }
        };
    }
    shown_spheres_ = spheres_;
    for (const Simulation::Ball& ball : simulation_.balls()) {
        const glm::vec3 before = world().previous_pose(ball.body).position, now = world().pose(ball.body).position;
        shown_spheres_.push_back({before + alpha_ * (now - before), ball.radius});
    }
    scene.spheres = shown_spheres_;
    scene.spheres_on_top = simulation_.balls().empty();
    lines_ = own_lines_;
    if (hulls_) {
        debug_lines_.clear();
        world().debug_lines(debug_lines_);
        for (const physics::DebugLine& line : debug_lines_) {
            lines_.push_back({line.from, packed(line.colour)});
            lines_.push_back({line.to, packed(line.colour)});
        }
    }
    scene.lines = lines_;
    scene.lines_on_top = true;
    scene.moved = moved_;
    moved_ = false;
    return scene;
}

} // namespace brittle::tools
