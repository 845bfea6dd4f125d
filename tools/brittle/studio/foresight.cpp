#include "tools/brittle/studio/foresight.h"

#include <algorithm>
#include <utility>

#include "tools/brittle/studio/piece_view.h"
#include "tools/scenario/base/failure.h"
#include "tools/scenario/run/state_export.h"

namespace brittle::tools {

namespace {

// Returns solids as fragments at the places where they were cut.
Foreseen as_fragments(std::span<const physics::SolidPtr> solids) {
    Snapshot state;
    for (const physics::SolidPtr& solid : solids)
        state.pieces.push_back({static_cast<uint32_t>(state.pieces.size()), solid, {}});
    Foreseen foreseen{live_pieces(state, {}).fragments, {}};
    foreseen.falls.assign(solids.size(), 0);
    return foreseen;
}

void mark_what_falls(std::span<const physics::SolidPtr> cut, std::span<uint8_t> falls) {
    const auto largest = std::max_element(cut.begin(), cut.end(),
                                          [](const auto& a, const auto& b) { return a->mass.volume < b->mass.volume; });
    for (size_t k = 0; k < cut.size(); ++k) falls[k] = cut.begin() + static_cast<std::ptrdiff_t>(k) != largest;
}

} // namespace

Foreseen foresee(const physics::PlannedCut& cut, const std::function<bool()>& cancelled) {
    const std::vector<physics::SolidPtr> made = must(physics::carry_out(cut, cancelled));
    Foreseen foreseen = as_fragments(made);
    mark_what_falls(made, foreseen.falls);
    return foreseen;
}

void Foresight::stand(const std::shared_ptr<const Object>& object, const FractureOptions& recipe, uint64_t version,
                      const std::function<bool()>& cancelled) {
    if (simulation_ && object_ == object && version_ == version) return;
    simulation_.reset();
    FractureOptions options = recipe;
    options.world.shots.clear();
    fragments_ = break_input(object->with_sites(options), options, {}, nullptr, cancelled).fragments;
    auto simulation = std::make_unique<Simulation>(options.material);
    simulation->start(fragments_, world_of(options, object->scale()));
    simulation_ = std::move(simulation);
    object_ = object;
    version_ = version;
}

Foreseen Foresight::of_whole(const std::shared_ptr<const Object>& object, const FractureOptions& recipe,
                             uint64_t version, const AimedBlow& blow, const std::function<bool()>& cancelled) {
    stand(object, recipe, version, cancelled);
    const std::optional<Hammer> hammer = hammer_at(*simulation_, fragments_, blow, recipe.world.blow_pieces);
    const std::optional<physics::PlannedCut> cut = hammer ? simulation_->foresee(*hammer) : std::nullopt;
    const physics::Destruction& destruction = *simulation_->destruction();
    std::vector<physics::SolidPtr> solids;
    for (const physics::PieceId id : destruction.pieces())
        if (!cut || id.value != hammer->piece) solids.push_back(destruction.solid(id));
    const size_t others = solids.size();
    if (cut) {
        const std::vector<physics::SolidPtr> made = must(physics::carry_out(*cut, cancelled));
        solids.insert(solids.end(), made.begin(), made.end());
    }
    Foreseen foreseen = as_fragments(solids);
    mark_what_falls(std::span(solids).subspan(others), std::span(foreseen.falls).subspan(others));
    return foreseen;
}

std::optional<Hammer> hammer_at(const Simulation& simulation, const fracture::Fragments& fragments,
                                const AimedBlow& blow, uint32_t max_pieces) {
    const std::vector<engine::BodyPose> poses = poses_by_slot(simulation);
    const PieceView pieces{simulation, fragments, {}, poses};
    const auto hit = pieces.first(blow.at - blow.radius * blow.direction, blow.direction);
    if (!hit) return std::nullopt;
    return hammer_blow(simulation, *hit, blow.direction, blow.radius, max_pieces);
}

} // namespace brittle::tools
