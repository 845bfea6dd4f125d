#include "physics/world/world.h"

#include <algorithm>
#include <atomic>
#include <bit>
#include <cassert>
#include <cmath>
#include <ostream>
#include <string>
#include <utility>

#include <glm/common.hpp>

#include "physics/solver/world_impl.h"
#include "physics/world/crowd.h"
#include "physics/world/state_hash.h"
#include "physics/world/world_check.h"

namespace brittle::physics {

namespace {

// Fewer bodies than this are not worth waking another thread for.
constexpr uint32_t min_new_bodies = 32, min_bodies = 256;

fracture::Error refused(BodyId id, const fracture::Error& fault) {
    return {fault.status, text(id, " cannot be added: ", fault.message)};
}

void add(StateHash& hash, const btVector3& v) {
    for (int axis = 0; axis < 3; ++axis) hash.add(v[axis]);
}

} // namespace

std::ostream& operator<<(std::ostream& stream, BodyId id) {
    return id == BodyId{} ? stream << "body none" : stream << "body " << id.value;
}

World::World(const WorldSettings& settings) {
    assert(validate(settings) && "settings from outside go through validate() first");
    impl_ = std::make_unique<Impl>(settings);
}
World::~World() = default;
World::World(World&&) noexcept = default;
World& World::operator=(World&&) noexcept = default;

const WorldSettings& World::settings() const {
    return impl_->settings;
}

// What is done one after the other leaves bodies of one hull alone: half of them lie in another core's cache.
template<class Describe>
Result<std::vector<BodyId>> World::Impl::add(size_t number, const Describe& describe) {
    if (number == 0) return std::vector<BodyId>{};
    const auto count = static_cast<uint32_t>(number);
    const auto set_place = [&, before = bodies.size()](BodyRecord& body, uint32_t i) {
        body.rigid->setUserIndex(static_cast<int>(before + i));
    };
    fracture::Threads& threads = engine->threads;
    std::vector<NewBody> come(count);
    std::vector<BodyId> added(count);
    std::vector<std::optional<fracture::Error>> faults(
        threads.chunks(count, min_new_bodies)); // the first of each chunk
    threads.for_chunks(count, min_new_bodies, [&](uint32_t chunk, uint32_t begin, uint32_t end) {
        for (uint32_t i = begin; i < end; ++i) {
            added[i] = {next_id + i};
            Result<NewBody> body = make_body(describe(i), settings);
            if (!body) {
                faults[chunk] = refused(added[i], body.error());
                return;
            }
            come[i] = std::move(*body);
            come[i].record->id = added[i];
            if (come[i].proxy) set_place(*come[i].record, i);
        }
    });
    for (const std::optional<fracture::Error>& fault : faults)
        if (fault) return *fault;
    for (uint32_t i = 0; i < count; ++i) {
        if (!come[i].proxy) {
            make_compound(come[i], describe(i));
            set_place(*come[i].record, i);
        }
        if (come[i].awake) ++awake.of(come[i].debris);
    }
    const float crowded = crowding(awake.debris, settings.max_colliding);
    for (uint32_t i = 0; i < count; ++i) {
        come[i].proxy->min_partner *= crowded;
        engine->world->put_in(come[i]);
        bodies.push_back(std::move(come[i].record));
    }
    ids.insert(ids.end(), added.begin(), added.end());
    moved_steps.resize(ids.size(), steps);
    next_id += count;
    engine->solver.forget_sleeping();
    return added;
}

Result<BodyId> World::add_body(const BodyDesc& desc) {
    const auto added = impl_->add(1, [&](size_t) -> const BodyDesc& { return desc; });
    if (!added) return added.error();
    return added->front();
}

Result<std::vector<BodyId>> World::add_bodies(std::span<const BodyDesc> descs) {
    return impl_->add(descs.size(), [&](size_t i) -> const BodyDesc& { return descs[i]; });
}

Result<std::vector<BodyId>> World::add_bodies(size_t count, const std::function<BodyDesc(size_t)>& describe) {
    return impl_->add(count, describe);
}

uint32_t World::new_siblings() {
    return ++impl_->last_siblings;
}

bool World::remove_body(BodyId id) {
    BodyRecord* body = impl_->find(id);
    if (!body) return false;
    (void)impl_->engine->solver.solved_contacts(); // they still name it
    impl_->engine->world->siblings().remove(*body->rigid);
    for (const int other : impl_->engine->world->take_out(*body))
        impl_->wake(*impl_->bodies[static_cast<size_t>(other)]);
    if (body->awake()) --impl_->awake.of(body->debris);
    impl_->engine->solver.forget_sleeping();
    const auto order = static_cast<size_t>(body->rigid->getUserIndex());
    impl_->bodies.erase(impl_->bodies.begin() + static_cast<std::ptrdiff_t>(order));
    impl_->ids.erase(impl_->ids.begin() + static_cast<std::ptrdiff_t>(order));
    impl_->moved_steps.erase(impl_->moved_steps.begin() + static_cast<std::ptrdiff_t>(order));
    for (size_t i = order; i < impl_->bodies.size(); ++i) impl_->bodies[i]->rigid->setUserIndex(static_cast<int>(i));
    ++impl_->removed;
    return true;
}

void World::clear() {
    clear(impl_->settings);
}

void World::clear(const WorldSettings& settings) {
    assert(validate(settings) && "settings from outside go through validate() first");
    impl_->drop_bodies();
    impl_->settings = settings;
    impl_->shared_shapes.clear();
    impl_->pending_seconds = 0.0;
    impl_->steps = 0;
    impl_->make_engine();
}

size_t World::body_count() const {
    return impl_->bodies.size();
}
uint64_t World::removed_count() const {
    return impl_->removed;
}
bool World::contains(BodyId id) const {
    return impl_->find(id) != nullptr;
}
std::span<const BodyId> World::bodies() const {
    return impl_->ids;
}
uint64_t World::steps_taken() const {
    return impl_->steps;
}

void World::step() {
    fracture::Threads& threads = impl_->engine->threads;
    threads.for_chunks(static_cast<uint32_t>(impl_->bodies.size()), min_bodies,
                       [&](uint32_t, uint32_t begin, uint32_t end) {
                           for (size_t i = begin; i < end; ++i)
                               if (impl_->moved_steps[i] >= impl_->steps)
                                   impl_->bodies[i]->previous = impl_->bodies[i]->pose(); // else they are the same
                       });
    impl_->engine->world->step(impl_->settings.step);
    ++impl_->steps;
    const std::span<BodyRecord* const> stepped = impl_->engine->world->stepped(); // nobody else is awake
    std::atomic<size_t> colliding = 0, debris = 0;
    threads.for_chunks(static_cast<uint32_t>(stepped.size()), min_bodies, [&](uint32_t, uint32_t begin, uint32_t end) {
        AwakeCount count;
        for (const BodyRecord* body : stepped.subspan(begin, end - begin)) {
            if (body->has_moved()) impl_->moved_step(*body) = impl_->steps;
            if (body->awake()) ++count.of(body->debris);
        }
        colliding += count.colliding;
        debris += count.debris;
    });
    impl_->awake = {.colliding = colliding, .debris = debris};
}

float World::advance(double seconds, const std::function<void()>& after_step) {
    const double step_seconds = impl_->settings.step;
    if (std::isfinite(seconds) && seconds > 0.0) impl_->pending_seconds += seconds;
    for (uint32_t taken = 0; taken < impl_->settings.max_substeps && impl_->pending_seconds >= step_seconds; ++taken) {
        step();
        if (after_step) after_step();
        impl_->pending_seconds -= step_seconds;
    }
    // What is left over now would only grow from frame to frame: a slow machine gets slow motion, not a
    // standstill.
    if (impl_->pending_seconds >= step_seconds)
        impl_->pending_seconds = std::fmod(impl_->pending_seconds, step_seconds);
    return static_cast<float>(impl_->pending_seconds / step_seconds);
}

void World::visit_poses(float alpha, uint64_t since, const PoseVisitor& visit) const {
    for (size_t i = 0; i < impl_->ids.size(); ++i)
        if (impl_->moved_steps[i] >= since) visit(i, interpolated_pose(impl_->ids[i], alpha));
}

uint64_t World::last_moved_step(BodyId id) const {
    return impl_->moved_step(impl_->get(id));
}

Pose World::pose(BodyId id) const {
    return impl_->get(id).pose();
}
Pose World::previous_pose(BodyId id) const {
    return impl_->get(id).previous;
}
Pose World::interpolated_pose(BodyId id, float alpha) const {
    const BodyRecord& body = impl_->get(id);
    const Pose now = body.pose();
    if (alpha >= 1.0f || impl_->moved_step(body) < impl_->steps) return now; // no rounding of a body at rest
    return {glm::mix(body.previous.position, now.position, alpha),
            glm::slerp(body.previous.orientation, now.orientation, alpha)};
}
glm::vec3 World::linear_velocity(BodyId id) const {
    return metres_from_bullet(impl_->get(id).rigid->getLinearVelocity());
}
glm::vec3 World::angular_velocity(BodyId id) const {
    return to_glm(impl_->get(id).rigid->getAngularVelocity());
}
float World::mass(BodyId id) const {
    return impl_->get(id).mass;
}
bool World::fixed(BodyId id) const {
    return impl_->get(id).fixed;
}
bool World::debris(BodyId id) const {
    return impl_->get(id).debris;
}
bool World::awake(BodyId id) const {
    return impl_->get(id).awake();
}
Mechanics World::mechanics(BodyId id) const {
    return mechanics_of(impl_->get(id), impl_->settings.gravity);
}

void World::apply_impulse(BodyId id, glm::vec3 impulse, glm::vec3 point) {
    BodyRecord* body = impl_->find(id);
    assert(body && "no such body in this world");
    assert(finite(impulse) && finite(point));
    if (body->fixed) return;
    impl_->wake(*body);
    body->rigid->applyImpulse(metres_to_bullet(impulse),
                              metres_to_bullet(point) - body->rigid->getCenterOfMassPosition());
}

void World::set_velocity(BodyId id, glm::vec3 linear, glm::vec3 angular) {
    BodyRecord* body = impl_->find(id);
    assert(body && "no such body in this world");
    assert(finite(linear) && finite(angular));
    if (body->fixed) return;
    impl_->wake(*body);
    body->rigid->setLinearVelocity(metres_to_bullet(linear));
    body->rigid->setAngularVelocity(to_bullet(angular));
}

// What else changed its velocity since the step stays.
float World::rewind(BodyId id) {
    BodyRecord* body = impl_->find(id);
    assert(body && "no such body in this world");
    if (body->fixed)
        return impl_->moved_step(*body) < impl_->steps ? impl_->settings.step : 0.0f; // it may just have come
    impl_->wake(*body);
    body->rigid->setCenterOfMassTransform(body->blow_frame);
    body->rigid->setLinearVelocity(body->rigid->getLinearVelocity() + body->unhindered.linear - body->solved.linear);
    body->rigid->setAngularVelocity(body->rigid->getAngularVelocity() + body->unhindered.angular
                                    - body->solved.angular);
    body->unhindered = body->solved = body->velocity();
    return body->left_seconds;
}

void World::move_on(BodyId id, float seconds) {
    BodyRecord* body = impl_->find(id);
    assert(body && "no such body in this world");
    if (body->fixed) return;
    impl_->engine->world->move_on(*body, seconds);
    impl_->moved_step(*body) = impl_->steps;
}

void World::amend_contact(size_t index, const Contact& contact) {
    impl_->engine->solver.amend_contact(index, contact);
}

float World::response(BodyId id, glm::vec3 point, glm::vec3 direction) const {
    const BodyRecord& body = impl_->get(id);
    if (body.fixed) return 0.0f;
    return body.rigid->computeImpulseDenominator(metres_to_bullet(point), to_bullet(direction));
}

std::span<const Contact> World::contacts() const {
    return impl_->engine->solver.contacts(impl_->engine->dispatcher);
}
std::span<const Contact> World::solved_contacts() const {
    return impl_->engine->solver.solved_contacts();
}

void World::wake_all() {
    for (const auto& body : impl_->bodies) impl_->wake(*body);
}

Mechanics World::mechanics() const {
    Mechanics sum;
    for (const auto& body : impl_->bodies) {
        const Mechanics one = mechanics_of(*body, impl_->settings.gravity);
        sum.kinetic += one.kinetic;
        sum.potential += one.potential;
        sum.momentum += one.momentum;
        sum.angular_momentum += one.angular_momentum;
    }
    return sum;
}

size_t World::awake_count() const {
    return impl_->awake.colliding + impl_->awake.debris;
}

size_t World::colliding_count() const {
    return impl_->awake.colliding;
}

size_t World::contact_count() const {
    size_t count = 0;
    for (int i = 0; i < impl_->engine->dispatcher.getNumManifolds(); ++i) {
        const btPersistentManifold* manifold = impl_->engine->dispatcher.getManifoldByIndexInternal(i);
        for (int point = 0; point < manifold->getNumContacts(); ++point)
            count += manifold->getContactPoint(point).getDistance() < touching_distance * bullet_units ? 1u : 0u;
    }
    for (const GroundManifold* manifold : impl_->engine->ground_contacts.manifolds())
        for (const GroundPoint& point : manifold->points())
            count += point.distance < touching_distance * bullet_units ? 1u : 0u;
    return count;
}

uint64_t World::state_hash() const {
    StateHash hash;
    for (const auto& body : impl_->bodies) {
        const btTransform& frame = body->rigid->getWorldTransform();
        add(hash, frame.getOrigin());
        for (int row = 0; row < 3; ++row) add(hash, frame.getBasis()[row]);
        add(hash, body->rigid->getLinearVelocity());
        add(hash, body->rigid->getAngularVelocity());
        hash.add(static_cast<uint8_t>(body->rigid->isActive()));
    }
    return hash.value();
}

} // namespace brittle::physics
