#include "tools/brittle/stage.h"

#include <algorithm>
#include <cmath>

#include <glm/geometric.hpp>
#include <glm/gtc/color_space.hpp>

#include "fracture/mass_properties.h"
#include "fracture/shapes.h"
#include "physics/pieces.h"
#include "tools/brittle/failure.h"

namespace brittle::tools {

namespace {

constexpr double stage_size = 2.0;     // m, longest side of the mesh
// Of the handbook strengths of flawless samples, what things have against blows: at full strength a stone arch turns back
// a ball of a quarter of a ton.
constexpr float flawed = 0.1f;
constexpr float piece_tint_strength = 0.9f;
constexpr float material_tint_strength = 0.15f; // a material shows its own colour
constexpr float pull_rate = 10.0f;     // 1/s; a tenth of a second to the hand
constexpr float pull_speed = 12.0f;    // m/s, at most
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
    : renderer_(renderer), material_(physics::material_preset(material)) {
    reset(mesh);
}

void Stage::reset(const fracture::TriangleMesh& mesh) {
    world_.clear();
    structure_.reset();
    balls_.clear();
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

void Stage::shatter(const fracture::Fragments& fragments) {
    world_.clear();
    structure_.reset();
    balls_.clear();
    must(physics::add_pieces(world_, fragments, material_ ? material_->material : physics::Material{}));
    upload(fragments);
}

void Stage::stand(const fracture::Fragments& fragments, const WorldOptions& world) {
    world_.clear();
    balls_.clear();
    physics::StructureDesc desc{.material = material_ ? material_->material : physics::Material{}};
    for (float* strength : {&desc.material.tensile, &desc.material.compressive, &desc.material.shear}) *strength *= flawed;
    desc.wear.strength_scale /= flawed;
    if (world.anchored) desc.anchored = physics::anchor_to_ground(fragments);
    structure_ = must(physics::Structure::create(world_, fragments, desc));
    upload(fragments);
}

void Stage::shoot(const Shot& shot) {
    if (!broken()) return;
    const fracture::TriangleMesh ball = fracture::icosphere(2, shot.radius);
    const double mass = shot.density * fracture::signed_volume(ball.positions, ball.triangles);
    const auto inertia = static_cast<float>(0.4 * mass * shot.radius * shot.radius);
    balls_.push_back({must(world_.add_body({.hull = physics::collision_hull(ball.positions, glm::dvec3(0.0), {.max_vertices = 64}),
                                            .continuous = true,
                                            .mass = static_cast<float>(mass),
                                            .inertia = glm::mat3(inertia),
                                            .pose = {.position = glm::vec3(shot.from)},
                                            .linear_velocity = glm::vec3(shot.velocity)})),
                      static_cast<float>(shot.radius)});
}

void Stage::pull(uint32_t piece, const glm::vec3& grip, const glm::vec3& target) {
    if (piece >= radii_.size() || !broken()) return;
    const physics::BodyId body = structure_ ? structure_->body_of(piece) : world_.bodies()[piece];
    if (!world_.contains(body) || world_.fixed(body)) return;
    const physics::Pose pose = world_.pose(body);
    const glm::vec3 arm = pose.orientation * (grip + (structure_ ? structure_->offset(piece) : glm::vec3(0.0f)));
    const glm::vec3 velocity = world_.linear_velocity(body) + glm::cross(world_.angular_velocity(body), arm);
    // Towards the velocity that would bring the grip there; half of it each frame gives, as a spring does.
    glm::vec3 wanted = pull_rate * (target - pose.position - arm);
    if (const float speed = glm::length(wanted); speed > pull_speed) wanted *= pull_speed / speed;
    const glm::vec3 change = 0.5f * (wanted - velocity);
    const float length = glm::length(change);
    if (!(length > 0.0f)) return;
    const float response = world_.response(body, pose.position + arm, change / length);
    if (response > 0.0f) world_.apply_impulse(body, change / response, pose.position + arm);
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
    alpha_ = world_.advance(seconds, [this] {
        if (structure_) structure_->update(world_);
    });
}

void Stage::show_sites(std::span<const glm::dvec3> sites) {
    spheres_.clear();
    for (const glm::dvec3& s : sites) spheres_.push_back({.centre = glm::vec3(s), .radius = site_radius});
}

engine::Scene Stage::scene() {
    engine::Scene scene;
    scene.bounds = home_;
    scene.look.tint = piece_tint_strength;
    if (material_) {
        scene.look.exterior = material_->exterior;
        scene.look.interior = material_->interior;
        scene.look.tint = material_tint_strength;
    }
    if (broken()) {
        poses_.resize(radii_.size());
        if (structure_)
            structure_->write_piece_transforms(world_, poses_, alpha_);
        else
            world_.write_transforms(poses_, alpha_); // pieces come before balls
        for (physics::Pose& pose : poses_) pose.position += explode_ * (pose.position - home_.centre());
        const glm::vec3 limit(bounds_limit);
        scene.bounds = {limit, -limit};
        for (size_t i = 0; i < poses_.size(); ++i) {
            const glm::vec3 centre = glm::clamp(poses_[i].position, -limit, limit);
            scene.bounds.min = glm::min(scene.bounds.min, centre - radii_[i]);
            scene.bounds.max = glm::max(scene.bounds.max, centre + radii_[i]);
        }
        scene.write_poses = [this](std::span<engine::BodyPose> out) {
            for (size_t i = 0; i < std::min(out.size(), poses_.size()); ++i) {
                out[i] = {.rotation = poses_[i].orientation, .position = poses_[i].position};
            }
        };
    }
    shown_spheres_ = spheres_;
    for (const Ball& ball : balls_) {
        const glm::vec3 before = world_.previous_pose(ball.body).position, now = world_.pose(ball.body).position;
        shown_spheres_.push_back({before + alpha_ * (now - before), ball.radius});
    }
    scene.spheres = shown_spheres_;
    scene.spheres_on_top = balls_.empty();
    lines_ = own_lines_;
    if (hulls_) {
        debug_lines_.clear();
        world_.debug_lines(debug_lines_);
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
