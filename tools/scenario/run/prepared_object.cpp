#include "tools/scenario/run/prepared_object.h"

#include <algorithm>
#include <limits>
#include <span>

#include <glm/geometric.hpp>
#include <glm/gtc/quaternion.hpp>

#include "fracture/pieces/certificate.h"
#include "physics/bonds/anchor.h"
#include "physics/world/state_hash.h"
#include "tools/scenario/base/failure.h"

namespace brittle::tools {

namespace {

constexpr double anchor_height = 0.01; // m above an object's lowest point: WorldOptions::anchored holds what is below

physics::PayloadMaker payload_of(const PreparedObject& object, const DrawingMaker& maker) {
    if (!maker) return {};
    return [maker, looks = object.looks](const physics::SolidPiece& solid, const physics::SolidPiece* cut_from) {
        return maker(solid, cut_from, looks.get());
    };
}

std::vector<physics::AnchorRegion> anchor_regions(const PreparedObject& object) {
    std::vector<physics::AnchorRegion> regions;
    if (object.world.anchored) {
        const glm::dvec3 up = glm::conjugate(glm::dquat(object.placement.orientation)) * glm::dvec3(0.0, 1.0, 0.0);
        double lowest = std::numeric_limits<double>::infinity();
        for (const glm::dvec3& p : object.fragments->positions) lowest = std::min(lowest, glm::dot(up, p));
        regions.push_back(physics::HalfSpace{up, lowest + anchor_height});
    }
    for (const Anchor& anchor : object.world.anchors)
        regions.push_back(physics::Ball{anchor.at + glm::dvec3(0.0, foot_height(object.world), 0.0), anchor.radius});
    return regions;
}

} // namespace

physics::Material plain_material(const physics::MaterialPreset* preset) {
    return preset ? preset->material : physics::Material{};
}

physics::Material flawed_material(const PreparedObject& object) {
    return physics::scale_strength(plain_material(physics::material_preset(object.material)),
                                   physics::flawed_strength * static_cast<float>(object.world.strength));
}

physics::StructureDesc structure_desc(const PreparedObject& object) {
    physics::StructureDesc desc{.material = flawed_material(object)};
    desc.motion.placement = object.placement;
    desc.wear.strength_scale /= physics::flawed_strength; // a share of handbook strength; the material is scaled
    desc.anchored = physics::anchor_to(*object.fragments, anchor_regions(object));
    return desc;
}

physics::BreakableDesc breakable_desc(const PreparedObject& object, const DrawingMaker& payload) {
    const WorldOptions& options = object.world;
    physics::BreakableDesc desc;
    desc.motion.placement = object.placement;
    desc.solid.breakable = !object.rigid;
    desc.solid.material = flawed_material(object);
    desc.solid.blocks.strength_scale /= physics::flawed_strength; // as WearSettings::strength_scale
    desc.solid.min_size = options.min_size;
    desc.solid.rough = options.rough;
    desc.payload = payload_of(object, payload);
    desc.pattern.seed = options.seed;
    const physics::MaterialPreset* preset = physics::material_preset(object.material);
    if (options.blows) {
        desc.pattern.kind = options.blows->kind;
        desc.pattern.slenderness = options.blows->slenderness;
        desc.pattern.diagram = options.blows->diagram;
        desc.pattern.placement = options.blows->placement;
    } else if (preset) {
        const bool laid = preset->pattern.kind == fracture::PatternKind::bricks && !starts_whole(options);
        desc.pattern.kind = laid ? fracture::PatternKind::uniform : preset->pattern.kind; // a single brick crumbles
        desc.pattern.slenderness = preset->pattern.slenderness;
    }
    desc.max_pieces = options.blow_pieces;
    if (object.fixed()) return desc;
    desc.pattern.bond = physics::fitted(options.bond, fracture::bounds(object.fragments->positions));
    desc.solid.anchors = anchor_regions(object);
    return desc;
}

void prepare(PreparedObject& object, const DrawingMaker& payload, uint32_t threads) {
    object.bodies = {};
    if (object.fixed()) {
        object.bodies.solids.push_back(must(physics::fixed_solid(*object.surface)));
    } else if (object.world.breakable || object.rigid) {
        object.bodies.solids = must(physics::solids_of(*object.fragments, breakable_desc(object, payload).solid,
                                                       !object.world.bonded, threads));
    } else {
        object.bodies.hulls = physics::collision_hulls(*object.fragments, {}, threads);
        return;
    }
    object.bodies.payloads = physics::payloads_of(object.bodies.solids, payload_of(object, payload), threads);
}

PreparedObject copy_of(const PreparedObject& object, const DrawingMaker& payload, uint32_t threads) {
    PreparedObject copy{.name = object.name,
                        .fragments = object.fragments,
                        .surface = object.surface,
                        .world = object.world,
                        .material = object.material,
                        .rigid = object.rigid,
                        .looks = object.looks,
                        .placement = object.placement};
    copy.bodies.solids = object.bodies.solids;
    copy.bodies.payloads = physics::payloads_of(copy.bodies.solids, payload_of(copy, payload), threads);
    return copy;
}

uint64_t pieces_hash(std::span<const PreparedObject> objects) {
    const auto hash_of = [](const PreparedObject& object) {
        if (!object.fixed()) return fracture::hash(*object.fragments);
        physics::StateHash hash;
        for (const glm::dvec3& p : object.surface->positions)
            for (int axis = 0; axis < 3; ++axis) hash.add(p[axis]);
        return hash.value();
    };
    if (objects.size() == 1) return hash_of(objects.front());
    physics::StateHash all;
    for (const PreparedObject& object : objects) all.add(hash_of(object));
    return all.value();
}

} // namespace brittle::tools
