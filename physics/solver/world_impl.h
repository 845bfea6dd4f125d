// What is behind a World: its bodies in their order, and Bullet.
#pragma once

#include <algorithm>
#include <cassert>
#include <cstdint>
#include <memory>
#include <unordered_map>
#include <utility>
#include <vector>

#include <btBulletDynamicsCommon.h>

#include "physics/solver/body_record.h"
#include "physics/solver/compound_contact.h"
#include "physics/solver/ground_contact.h"
#include "physics/solver/hull_contact.h"
#include "physics/solver/piece_solver.h"
#include "physics/solver/stepped_world.h"
#include "physics/solver/sweep_broadphase.h"
#include "physics/world/world.h"

namespace brittle::physics {

// Contact points further apart than this, in metres, are near but not touching.
inline constexpr float touching_distance = 1e-3f;

// Everything of Bullet's that a history can hide in; made anew by clear().
struct Engine {
    btDefaultCollisionConfiguration configuration{pool_sizes()};
    btCollisionDispatcher dispatcher{&configuration};
    GroundContacts ground_contacts{dispatcher};
    HullContacts hull_contacts{dispatcher};
    CompoundContacts compound_contacts{dispatcher};
    fracture::Threads threads;
    SweepBroadphase broadphase{threads};
    PieceSolver solver;
    std::unique_ptr<SteppedWorld> world;
    std::unique_ptr<btStaticPlaneShape> ground_shape;
    std::unique_ptr<btRigidBody> ground;

    Engine(const WorldSettings& settings, const std::vector<std::unique_ptr<BodyRecord>>& bodies);
    ~Engine();
    Engine(const Engine&) = delete;
    Engine& operator=(const Engine&) = delete;

  private:
    static btDefaultCollisionConstructionInfo pool_sizes();
};

// How many bodies are awake, without those that are debris and of those.
struct AwakeCount {
    size_t colliding = 0, debris = 0;
    [[nodiscard]] size_t& of(bool is_debris) { return is_debris ? debris : colliding; }
};

struct World::Impl {
    WorldSettings settings;
    std::vector<std::unique_ptr<BodyRecord>> bodies; // in body order; the rigid bodies' user index points here
    std::vector<BodyId> ids;                         // in body order, and so ascending: they are given in that order
    // By body: see World::last_moved_step(). Apart from the rest of a body, as each step asks for all of them.
    std::vector<uint64_t> moved_steps;
    AwakeCount awake;           // right whenever World has returned
    uint32_t last_siblings = 0; // the last number given
    uint32_t next_id = 0;       // never goes back
    uint64_t removed = 0;       // nor does the number of those removed
    std::unique_ptr<Engine> engine;
    // Hulls that bodies share, by address: an entry holds its hull, so an address in here names one hull.
    std::unordered_map<const CollisionHull*, std::shared_ptr<SharedShape>> shared_shapes;
    size_t shapes_to_keep = 64; // beyond so many, those without a body are let go
    double pending_seconds = 0.0;
    uint64_t steps = 0;

    explicit Impl(const WorldSettings& given) : settings(given) { make_engine(); }
    ~Impl() { drop_bodies(); }
    Impl(const Impl&) = delete;
    Impl& operator=(const Impl&) = delete;

    void make_engine();
    // Bullet must let go of a body before the body goes.
    void drop_bodies() {
        for (size_t i = bodies.size(); i-- > 0;) (void)engine->world->take_out(*bodies[i]);
        removed += bodies.size();
        bodies.clear();
        ids.clear();
        moved_steps.clear();
        awake = {};
    }
    std::shared_ptr<SharedShape> shared_shape(const std::shared_ptr<const CollisionHull>& hull);
    void make_compound(NewBody& made, const BodyDesc& desc); // what make_body() left out
    // All or none. describe(i) gives the description of the i-th or a reference to it: see World::add_bodies().
    template<class Describe>
    Result<std::vector<BodyId>> add(size_t count, const Describe& describe);
    // By halving: a table by number would grow for ever where things break again and again.
    [[nodiscard]] const BodyRecord* find(BodyId id) const {
        const auto at = std::ranges::lower_bound(ids, id);
        return at != ids.end() && *at == id ? bodies[static_cast<size_t>(at - ids.begin())].get() : nullptr;
    }
    [[nodiscard]] BodyRecord* find(BodyId id) { return const_cast<BodyRecord*>(std::as_const(*this).find(id)); }
    [[nodiscard]] const BodyRecord& get(BodyId id) const {
        const BodyRecord* body = find(id);
        assert(body && "no such body in this world");
        return *body;
    }
    [[nodiscard]] uint64_t& moved_step(const BodyRecord& body) {
        return moved_steps[static_cast<size_t>(body.rigid->getUserIndex())];
    }
    void wake(BodyRecord& body) {
        body.still_seconds = body.quiet_seconds = body.rest_seconds = 0.0f;
        if (!settings.sleeping || body.fixed) return;
        if (!body.awake()) ++awake.of(body.debris);
        body.rigid->forceActivationState(ACTIVE_TAG);
    }
};

} // namespace brittle::physics
