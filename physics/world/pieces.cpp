#include "physics/world/pieces.h"

#include <algorithm>
#include <optional>
#include <string>
#include <utility>

#include <glm/geometric.hpp>

#include "fracture/base/threads.h"
#include "physics/world/crowd.h"
#include "physics/world/piece_mass.h"

namespace brittle::physics {

namespace {

using fracture::Error;
using fracture::Fragments;
using fracture::Piece;
using fracture::Status;

// Pieces per chunk below which waking another thread costs more than it saves.
constexpr uint32_t min_pieces = 64;

// Prefetches the beginning of the form `ahead` places on: forms are scattered in memory.
void prefetch_form(const PieceForms& forms, size_t at) {
    constexpr size_t ahead = 4, bytes = 128, cache_line = 64;
    const auto* const form = reinterpret_cast<const char*>(forms[std::min(at + ahead, forms.size() - 1)].get());
    for (size_t byte = 0; byte < bytes; byte += cache_line) __builtin_prefetch(form + byte);
}

void set_mass(BodyDesc& body, const BodyMass& mass) {
    body.mass = static_cast<float>(mass.mass);
    body.inertia = glm::mat3(mass.inertia);
}

// Falls back to the bounding box for a sliver whose integrals round to a mass or inertia that no body can have.
Result<std::shared_ptr<const BodyForm>> form_of(const Fragments& fragments, const Piece& piece,
                                                const Material& material,
                                                const std::shared_ptr<const CollisionHull>& hull) {
    BodyDesc body;
    body.parts = {{hull, glm::vec3(0.0f)}};
    set_mass(body, true_mass(piece, material.density));
    if (Result<std::shared_ptr<const BodyForm>> form = make_form(body)) return form;
    set_mass(body, box_mass(fragments.positions_of(piece), material.density));
    return make_form(body);
}

Error wrong_count(size_t given, const std::string& what, const Fragments& fragments) {
    return {Status::invalid_setting, std::to_string(given) + " " + what + " were given for "
                                         + std::to_string(fragments.pieces.size()) + " pieces"};
}

std::vector<BatchBody> batch_of(const Fragments& fragments) {
    std::vector<BatchBody> batch;
    batch.reserve(fragments.pieces.size());
    for (const Piece& piece : fragments.pieces) batch.push_back({.size = piece.mass.volume});
    return batch;
}

} // namespace

Result<std::vector<BodyId>> add_pieces(World& world, const Fragments& fragments, const Material& material,
                                       const PlacedMotion& motion, const HullSettings& hull) {
    if (const Result<void> checked = check_pieces(fragments, material); !checked) return checked.error();
    return add_pieces(world, fragments, material, motion, collision_hulls(fragments, hull));
}

Result<PieceForms> piece_forms(const Fragments& fragments, const Material& material, const PieceHulls& hulls,
                               uint32_t threads) {
    if (const Result<void> checked = check_pieces(fragments, material); !checked) return checked.error();
    const auto count = static_cast<uint32_t>(fragments.pieces.size());
    if (hulls.size() != count) return wrong_count(hulls.size(), "hulls", fragments);
    PieceForms forms(count);
    fracture::Threads pool(threads);
    std::vector<std::optional<Error>> faults(pool.chunks(count, min_pieces)); // the first of each chunk
    pool.for_chunks(count, min_pieces, [&](uint32_t chunk, uint32_t begin, uint32_t end) {
        for (uint32_t i = begin; i < end && !faults[chunk]; ++i) {
            Result<std::shared_ptr<const BodyForm>> form = form_of(fragments, fragments.pieces[i], material, hulls[i]);
            if (form)
                forms[i] = std::move(*form);
            else
                faults[chunk] = Error{form.error().status,
                                      "piece " + std::to_string(i) + " cannot become a body: " + form.error().message};
        }
    });
    for (const std::optional<Error>& fault : faults)
        if (fault) return *fault;
    return forms;
}

Result<std::vector<BodyId>> add_pieces(World& world, const Fragments& fragments, const Material& material,
                                       const PlacedMotion& motion, const PieceHulls& hulls) {
    const Result<PieceForms> forms = piece_forms(fragments, material, hulls, world.settings().threads);
    if (!forms) return forms.error();
    return add_pieces(world, fragments, material, motion, *forms);
}

Result<std::vector<BodyId>> add_pieces(World& world, const Fragments& fragments, const Material& material,
                                       const PlacedMotion& motion, const PieceForms& forms) {
    if (forms.size() != fragments.pieces.size()) return wrong_count(forms.size(), "forms", fragments);
    if (const auto missing = std::ranges::find(forms, nullptr); missing != forms.end())
        return Error{Status::invalid_setting, "piece " + std::to_string(missing - forms.begin()) + " has no form"};
    BodyDesc body;
    body.siblings = world.new_siblings();
    body.friction = material.friction;
    body.restitution = material.restitution;
    body.angular_velocity = motion.angular_velocity;
    const std::vector<uint8_t> debris = choose_debris(batch_of(fragments), colliding_room(world));
    return world.add_bodies(forms.size(), [&](size_t i) {
        prefetch_form(forms, i);
        const glm::dvec3 arm = glm::dquat(motion.placement.orientation) * fragments.pieces[i].mass.centre_of_mass;
        BodyDesc one = body;
        one.form = forms[i];
        one.debris = debris[i] != 0;
        one.pose = {glm::vec3(glm::dvec3(motion.placement.position) + arm), motion.placement.orientation};
        one.linear_velocity = motion.linear_velocity + glm::cross(motion.angular_velocity, glm::vec3(arm));
        return one;
    });
}

} // namespace brittle::physics
