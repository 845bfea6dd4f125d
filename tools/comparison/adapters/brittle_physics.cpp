// Brittle's rigid bodies for tools/compare --physics.
//
//     compare_brittle_physics SCENE THREADS solver    its own solver
//     compare_brittle_physics SCENE THREADS bullet    stock Bullet behind the same interface
//
// All bodies collide as hulls, none sleeps, and there is no air, as in the peers.
#include <glm/gtc/quaternion.hpp>

#include "physics/world/hull.h"
#include "physics/world/world.h"
#include "tools/comparison/adapters/physics.h"

namespace brittle::comparison {

namespace {

using namespace brittle::physics;

constexpr uint32_t max_vertices = 256; // of a hull: no corner is left out but those of crumbs

glm::vec3 vector_of(const Numbers3& p) {
    return {static_cast<float>(p[0]), static_cast<float>(p[1]), static_cast<float>(p[2])};
}

WorldSettings settings_of(const RigidScene& scene, const std::vector<std::string>& words) {
    const std::string engine = words.empty() ? "solver" : words[0];
    if (engine != "solver" && engine != "bullet")
        throw std::runtime_error("there is no engine '" + engine + "', only solver and bullet");
    WorldSettings settings;
    settings.engine = engine == "bullet" ? EngineKind::bullet : EngineKind::solver;
    settings.gravity = vector_of(scene.numbers.gravity);
    settings.step = static_cast<float>(scene.numbers.step);
    settings.threads = scene.threads;
    if (!scene.ground) settings.ground_height.reset();
    settings.ground_friction = static_cast<float>(scene.numbers.ground_friction);
    settings.ground_restitution = static_cast<float>(scene.numbers.ground_restitution);
    settings.air_density = 0.0f;
    settings.debris_size = 0.0f;
    settings.max_colliding = 0;
    settings.sleeping = false;
    if (const auto valid = validate(settings); !valid) throw std::runtime_error(valid.error().message);
    return settings;
}

BodyDesc body_of(const RigidBody& body) {
    const BodyNumbers& numbers = body.numbers;
    std::vector<glm::dvec3> corners;
    for (const Numbers3& p : body.corners) corners.emplace_back(p[0], p[1], p[2]);
    BodyDesc desc{.hull = collision_hull(corners, glm::dvec3(0.0), {.max_vertices = max_vertices})};
    desc.fixed = body.fixed;
    desc.mass = static_cast<float>(numbers.mass);
    for (int k = 0; k < 3; ++k) desc.inertia[k][k] = static_cast<float>(numbers.moments[static_cast<size_t>(k)]);
    const Numbers4& turn = numbers.pose.orientation;
    desc.pose = {vector_of(numbers.pose.position), glm::quat(glm::dquat(turn[3], turn[0], turn[1], turn[2]))};
    desc.linear_velocity = vector_of(numbers.velocity);
    desc.angular_velocity = vector_of(numbers.angular_velocity);
    desc.friction = static_cast<float>(numbers.friction);
    desc.restitution = static_cast<float>(numbers.restitution);
    return desc;
}

struct Simulation {
    Simulation(const RigidScene& scene, const std::vector<std::string>& words) : world(settings_of(scene, words)) {
        std::vector<BodyDesc> descs;
        for (const RigidBody& body : scene.bodies) descs.push_back(body_of(body));
        auto added = world.add_bodies(descs);
        if (!added) throw std::runtime_error(added.error().message);
        bodies = std::move(*added);
    }
    void step() { world.step(); }
    [[nodiscard]] BodyPose pose(size_t body) const {
        const Pose at = world.pose(bodies[body]);
        const glm::dvec3 position(at.position);
        const glm::dquat turn(at.orientation);
        return {{position.x, position.y, position.z}, {turn.x, turn.y, turn.z, turn.w}};
    }

    World world;
    std::vector<BodyId> bodies;
};

} // namespace

} // namespace brittle::comparison

int main(int count, char** words) {
    using namespace brittle::comparison;
    return serve_physics<Simulation>(count, words, std::string("Brittle ") + BRITTLE_VERSION);
}
