#include "physics/solver/joints.h"

#include <algorithm>
#include <cassert>
#include <numeric>

#include "fracture/base/union_find.h"

namespace brittle::physics {

namespace {

// Fewer systems than this are not worth waking another thread for.
constexpr uint32_t min_systems = 16;

// Two bodies may have several joints, so each joint has an entry.
void forbid_contacts(const SolverJoint& joint) {
    if (joint.collide || !joint.a || !joint.b) return;
    joint.a->apart.push_back(joint.b);
    joint.b->apart.push_back(joint.a);
}
void allow_contacts(const SolverJoint& joint) {
    if (joint.collide || !joint.a || !joint.b) return;
    joint.a->apart.erase(std::ranges::find(joint.a->apart, joint.b));
    joint.b->apart.erase(std::ranges::find(joint.b->apart, joint.a));
}

} // namespace

void Joints::add(const SolverJoint& joint) {
    const auto after = [](JointId id, const std::unique_ptr<SolverJoint>& other) { return id < other->id; };
    joints_.insert(std::upper_bound(joints_.begin(), joints_.end(), joint.id, after),
                   std::make_unique<SolverJoint>(joint));
    for (Body* body : {joint.a, joint.b})
        if (body) ++body->joints;
    forbid_contacts(joint);
    update_pairs();
}

size_t Joints::find(JointId id) const {
    const auto at = std::ranges::lower_bound(joints_, id, {}, [](const auto& joint) { return joint->id; });
    assert(at != joints_.end() && (*at)->id == id);
    return static_cast<size_t>(at - joints_.begin());
}

SolverJoint Joints::remove(JointId id) {
    const size_t index = find(id);
    const SolverJoint joint = *joints_[index];
    for (Body* body : {joint.a, joint.b})
        if (body) --body->joints;
    allow_contacts(joint);
    joints_.erase(joints_.begin() + static_cast<std::ptrdiff_t>(index));
    system_count_ = 0; // systems point to joints
    update_pairs();
    return joint;
}

const SolverJoint& Joints::at(JointId id) const {
    return *joints_[find(id)];
}

void Joints::update_pairs() {
    pairs_.clear();
    for (const auto& joint : joints_)
        if (joint->a && joint->b && !joint->a->fixed && !joint->b->fixed) pairs_.emplace_back(joint->a, joint->b);
}

void Joints::start(const JointSystem::Step& step, size_t bodies) {
    step_ = step;
    system_count_ = 0;
    broken_.clear();
    if (joints_.empty()) return;
    std::vector<uint32_t> parents(bodies); // by body
    std::iota(parents.begin(), parents.end(), 0u);
    std::vector<std::pair<uint32_t, SolverJoint*>> driven; // root of the system and joint
    for (const auto& joint : joints_)
        if (is_driven(joint->a) && is_driven(joint->b)) fracture::unite(parents, joint->a->index, joint->b->index);
    for (const auto& joint : joints_)
        if (is_driven(joint->a) || is_driven(joint->b))
            driven.emplace_back(fracture::root_of(parents, (is_driven(joint->a) ? joint->a : joint->b)->index),
                                joint.get());
    std::ranges::stable_sort(driven, {}, [](const auto& entry) { return entry.first; });
    std::vector<SolverJoint*> system;
    for (size_t i = 0; i < driven.size(); ++i) {
        system.push_back(driven[i].second);
        if (i + 1 < driven.size() && driven[i + 1].first == driven[i].first) continue;
        if (system_count_ == systems_.size()) systems_.emplace_back();
        systems_[system_count_++].take(system);
        system.clear();
    }
}

namespace {

// Calls visit for each body that a joint can move; every joint of a system has one, and they are connected.
void for_each_driven(const JointSystem& system, const auto& visit) {
    for (const SolverJoint* joint : system.joints())
        for (const Body* body : {joint->a, joint->b})
            if (is_driven(body)) visit(*body);
}

uint32_t first_body(const JointSystem& system) {
    const SolverJoint& joint = *system.joints().front();
    return (is_driven(joint.a) ? joint.a : joint.b)->index;
}

} // namespace

// A system of one body joins it with itself, so that it has a bundle.
void Joints::join(Bundles& bundles, std::span<const uint32_t> indices) const {
    for (const JointSystem& system : std::span(systems_).first(system_count_)) {
        const uint32_t first = indices[first_body(system)];
        for_each_driven(system, [&](const Body& body) { bundles.join(first, indices[body.index], 1); });
    }
}

// A jointed body counts as touched by two manifolds: it is no lone body.
void Joints::touch(std::span<uint32_t> manifolds, std::span<const uint32_t> indices) const {
    for (const JointSystem& system : std::span(systems_).first(system_count_))
        for_each_driven(system, [&](const Body& body) { manifolds[indices[body.index]] += 2; });
}

// A jointed body counts as one with a contact: it does not fall along a parabola.
void Joints::mark_jointed(std::span<uint8_t> is_jointed, std::span<const uint32_t> indices) const {
    for (const JointSystem& system : std::span(systems_).first(system_count_))
        for_each_driven(system, [&](const Body& body) { is_jointed[indices[body.index]] = 1; });
}

void Joints::make(const Bundles& bundles, std::span<const uint32_t> indices) {
    by_bundle_.clear();
    for (uint32_t i = 0; i < system_count_; ++i) {
        systems_[i].start(indices, step_);
        by_bundle_.emplace_back(bundles.of(indices[first_body(systems_[i])]), i);
    }
    std::ranges::sort(by_bundle_);
}

void Joints::for_each_of(uint32_t bundle, const auto& visit) {
    const auto bundle_of = [](const auto& entry) { return entry.first; };
    for (auto at = std::ranges::lower_bound(by_bundle_, bundle, {}, bundle_of);
         at != by_bundle_.end() && at->first == bundle; ++at)
        visit(systems_[at->second]);
}

void Joints::start_substep(uint32_t bundle, const VelocityChange* changes, const Displacement* moved) {
    for_each_of(bundle, [&](JointSystem& system) { system.start_substep(changes, moved); });
}

void Joints::solve(uint32_t bundle, VelocityChange* changes, Solution solution) {
    for_each_of(bundle, [&](JointSystem& system) { system.solve(changes, solution); });
}

void Joints::finish_substep(uint32_t bundle) {
    for_each_of(bundle, [](JointSystem& system) { system.finish_substep(); });
}

void Joints::store() {
    for (const JointSystem& system : std::span(systems_).first(system_count_)) {
        system.store();
        for (const SolverJoint* joint : system.joints())
            if (joint->broken) broken_.push_back(joint->id);
    }
    std::ranges::sort(broken_);
}

void Joints::correct(fracture::Threads& threads) {
    threads.for_chunks(static_cast<uint32_t>(system_count_), min_systems, [&](uint32_t, uint32_t begin, uint32_t end) {
        for (uint32_t i = begin; i < end; ++i) systems_[i].correct();
    });
    for (const JointId id : broken_) remove(id);
}

} // namespace brittle::physics
