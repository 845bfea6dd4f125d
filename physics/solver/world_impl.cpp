#include "physics/solver/world_impl.h"

#include <algorithm>

namespace brittle::physics {

Engine::Engine(const WorldSettings& settings, const std::vector<std::unique_ptr<BodyRecord>>& bodies)
    : threads(settings.threads), solver(settings, bodies, ground_contacts) {
    world =
        std::make_unique<SteppedWorld>(&dispatcher, &broadphase, &solver, &configuration, settings, bodies, threads);
    world->setGravity(metres_to_bullet(settings.gravity));
    if (!settings.ground_height) return;
    ground_shape = std::make_unique<btStaticPlaneShape>(btVector3(0, 1, 0), *settings.ground_height * bullet_units);
    ground = std::make_unique<btRigidBody>(blank_body());
    ground->setCollisionShape(ground_shape.get());
    ground->setMassProps(0.0f, {0, 0, 0});
    ground->updateInertiaTensor();
    ground->setFriction(settings.ground_friction);
    ground->setRestitution(settings.ground_restitution);
    ground->setUserIndex(-1);
    world->addRigidBody(ground.get());
}

// The pools of the dispatcher do not check what is put into them in release builds.
btDefaultCollisionConstructionInfo Engine::pool_sizes() {
    btDefaultCollisionConstructionInfo info;
    info.m_customCollisionAlgorithmMaxElementSize =
        std::max({HullContacts::pair_size(), GroundContacts::pair_size(), CompoundContacts::pair_size()});
    return info;
}

Engine::~Engine() {
    if (ground) world->removeRigidBody(ground.get());
}

void World::Impl::make_engine() {
    engine = std::make_unique<Engine>(settings, bodies);
}

std::shared_ptr<SharedShape> World::Impl::shared_shape(const std::shared_ptr<const CollisionHull>& hull) {
    if (const auto known = shared_shapes.find(hull.get()); known != shared_shapes.end()) return known->second;
    if (shared_shapes.size() >= shapes_to_keep) {
        std::erase_if(shared_shapes, [](const auto& entry) { return entry.second.use_count() == 1; });
        shapes_to_keep = std::max<size_t>(64, 2 * shared_shapes.size());
    }
    auto made = std::make_shared<SharedShape>();
    made->hull = hull;
    made->shape.reserve(hull->points.size());
    for (const glm::vec3& point : hull->points) made->shape.addPoint(metres_to_bullet(point), false);
    made->shape.setMargin(hull->margin * bullet_units);
    made->shape.finish();
    shared_shapes.emplace(hull.get(), made);
    return made;
}

void World::Impl::make_compound(NewBody& made, const BodyDesc& desc) {
    BodyRecord& body = *made.record;
    const std::vector<BodyPart>& parts = desc.parts;
    const glm::quat from_body = glm::conjugate(body.to_principal);
    body.compound = std::make_unique<btCompoundShape>(true, static_cast<int>(parts.size()));
    for (const BodyPart& part : parts) {
        body.shared.push_back(shared_shape(part.hull));
        const btTransform frame(to_bullet(from_body), metres_to_bullet(from_body * part.offset));
        body.compound->addChildShape(frame, &body.shared.back()->shape);
    }
    finish_compound(body, parts);
    make_rigid(made, desc, settings);
}

} // namespace brittle::physics
