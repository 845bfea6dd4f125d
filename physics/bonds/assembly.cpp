#include "physics/bonds/assembly.h"

#include <algorithm>
#include <cmath>
#include <memory>
#include <string>
#include <utility>

#include <glm/geometric.hpp>
#include <glm/mat3x3.hpp>

#include "physics/world/hull.h"

namespace brittle::physics {

namespace {

using fracture::Error;
using fracture::Fragments;
using fracture::Piece;
using fracture::Status;

// Equal orientations give the identity exactly, so that hulls are shared and positions keep their bits.
PartPlacement placement_in(const Pose& first, const Pose& part) {
    const glm::dquat back = glm::conjugate(glm::normalize(glm::dquat(first.orientation)));
    PartPlacement placement;
    if (part.orientation != first.orientation)
        placement.turn = glm::normalize(back * glm::normalize(glm::dquat(part.orientation)));
    placement.move = back * (glm::dvec3(part.position) - glm::dvec3(first.position));
    return placement;
}

Result<void> check_glue(std::span<const AssemblyPart> parts, const GlueBond& bond, size_t index) {
    const auto wrong = [&](const std::string& what) {
        return Error{Status::invalid_setting, "glue bond " + std::to_string(index) + ": " + what};
    };
    for (const GlueBond::Side& side : {bond.a, bond.b.value_or(bond.a)}) {
        if (side.part >= parts.size())
            return wrong("there is no part " + std::to_string(side.part) + ", only " + std::to_string(parts.size()));
        const size_t pieces = parts[side.part].fragments->pieces.size();
        if (side.piece >= pieces)
            return wrong("there is no piece " + std::to_string(side.piece) + " in part " + std::to_string(side.part)
                         + ", only " + std::to_string(pieces));
    }
    if (bond.b && bond.b->part == bond.a.part) return wrong("both of its sides are of one part");
    if (!(bond.area > 0.0) || !std::isfinite(bond.area)) return wrong("its area must be positive");
    if (!(bond.strength > 0.0f) || !std::isfinite(bond.strength)) return wrong("its strength must be positive");
    return {};
}

// Builds the fragments and the description of one structure.
class Builder {
  public:
    explicit Builder(const StructureDesc& first) {
        desc_.material = first.material;
        desc_.motion = first.motion;
        desc_.impact_speed = first.impact_speed;
        desc_.wear = first.wear;
    }

    void add(const AssemblyPart& part, const PartPlacement& placement) {
        const Fragments& from = *part.fragments;
        const auto pieces = static_cast<uint32_t>(all_.pieces.size());
        const auto positions = static_cast<uint32_t>(all_.positions.size());
        const auto triangles = static_cast<uint32_t>(all_.triangles.size());
        for (const glm::dvec3& p : from.positions) all_.positions.push_back(placement.to_structure(p));
        all_.triangles.insert(all_.triangles.end(), from.triangles.begin(), from.triangles.end());
        for (Piece piece : from.pieces) {
            piece.vertices = {piece.vertices.begin + positions, piece.vertices.end + positions};
            piece.triangles = {piece.triangles.begin + triangles, piece.triangles.end + triangles};
            piece.mass.centre_of_mass = placement.to_structure(piece.mass.centre_of_mass);
            piece.mass.inertia = placement.to_structure(piece.mass.inertia);
            all_.pieces.push_back(piece);
        }
        for (fracture::Bond bond : from.bonds) {
            bond.a += pieces;
            bond.b += pieces;
            bond.centroid = placement.to_structure(bond.centroid);
            bond.normal = placement.turn * bond.normal;
            all_.bonds.push_back(bond);
        }
        add_lists(part, placement, pieces);
    }

    // The contact is in coordinates of the structure. `a` and `b` are pieces of the structure; without `b`, a support
    // is added.
    void glue(const GlueBond& bond, uint32_t a, std::optional<uint32_t> b, const glm::dvec3& centroid,
              const glm::dvec3& normal) {
        const uint32_t other = b ? *b : add_support(a, centroid, normal, bond);
        const bool ordered = a < other;
        all_.bonds.push_back({std::min(a, other), std::max(a, other), bond.area, centroid, ordered ? normal : -normal});
        const float weaker = std::min(desc_.piece_materials[a].tensile, desc_.piece_materials[other].tensile);
        desc_.bond_strength.push_back(bond.strength * weaker);
    }

    Result<Structure> create(World& world) const { return Structure::create(world, all_, desc_); }

  private:
    void add_lists(const AssemblyPart& part, const PartPlacement& placement, uint32_t first) {
        const StructureDesc& desc = part.desc;
        const size_t pieces = part.fragments->pieces.size(), bonds = part.fragments->bonds.size();
        for (size_t k = 0; k < pieces; ++k)
            desc_.piece_materials.push_back(desc.piece_materials.empty() ? desc.material : desc.piece_materials[k]);
        for (size_t k = 0; k < bonds; ++k)
            desc_.bond_strength.push_back(desc.bond_strength.empty() ? 0.0f : desc.bond_strength[k]);
        desc_.piece_objects.insert(desc_.piece_objects.end(), pieces, parts_);
        ++parts_;
        for (const uint32_t piece : desc.anchored) desc_.anchored.push_back(first + piece);
        for (const uint32_t piece : desc.supports) desc_.supports.push_back(first + piece);
        std::vector<std::vector<BodyPart>> hulls = desc.piece_parts;
        if (hulls.empty())
            for (const auto& hull : desc.hulls.empty() ? collision_hulls(*part.fragments, desc.hull) : desc.hulls)
                hulls.push_back({{hull}});
        for (std::vector<BodyPart>& of_piece : hulls)
            desc_.piece_parts.push_back(placement.to_structure(std::move(of_piece)));
    }

    // Mirrors the piece's centre of mass at the contact, at least as far away as the contact is wide: a concave piece
    // may have its centre of mass in the plane of the contact.
    uint32_t add_support(uint32_t of, const glm::dvec3& centroid, const glm::dvec3& normal, const GlueBond& bond) {
        const auto support = static_cast<uint32_t>(all_.pieces.size());
        const Piece& held = all_.pieces[of];
        const double height = glm::dot(normal, centroid - held.mass.centre_of_mass);
        Piece piece;
        piece.site = held.site;
        piece.mass.centre_of_mass = held.mass.centre_of_mass + std::max(2.0 * height, std::sqrt(bond.area)) * normal;
        all_.pieces.push_back(piece);
        desc_.supports.push_back(support);
        desc_.piece_materials.push_back(bond.fixed_material.value_or(desc_.piece_materials[of]));
        desc_.piece_parts.emplace_back();
        desc_.piece_objects.push_back(UINT32_MAX); // of none of the parts
        return support;
    }

    Fragments all_;
    StructureDesc desc_;
    uint32_t parts_ = 0;
};

} // namespace

glm::dmat3 PartPlacement::to_structure(const glm::dmat3& inertia) const {
    if (!is_turned()) return inertia;
    const glm::dmat3 axes = glm::mat3_cast(turn);
    return axes * inertia * glm::transpose(axes);
}

std::vector<BodyPart> PartPlacement::to_structure(std::vector<BodyPart> hulls) const {
    if (!is_turned()) return hulls;
    for (BodyPart& hull : hulls) {
        hull.hull = std::make_shared<const CollisionHull>(turned(*hull.hull, turn));
        hull.offset = glm::vec3(turn * glm::dvec3(hull.offset));
    }
    return hulls;
}

Result<Assembly> assemble(World& world, std::span<const AssemblyPart> parts, std::span<const GlueBond> glue) {
    if (parts.empty()) return Error{Status::invalid_setting, "an assembly needs a part"};
    for (size_t k = 0; k < parts.size(); ++k)
        if (const Result<void> checked = Structure::check(*parts[k].fragments, parts[k].desc); !checked)
            return Error{checked.error().status,
                         (parts.size() > 1 ? "part " + std::to_string(k) + ": " : "") + checked.error().message};
    for (size_t k = 0; k < glue.size(); ++k)
        if (const Result<void> checked = check_glue(parts, glue[k], k); !checked) return checked.error();
    const Pose& frame = parts.front().desc.motion.placement;
    std::vector<PartPlacement> placements;
    std::vector<uint32_t> first_piece{0};
    for (const AssemblyPart& part : parts) {
        placements.push_back(placement_in(frame, part.desc.motion.placement));
        first_piece.push_back(first_piece.back() + static_cast<uint32_t>(part.fragments->pieces.size()));
    }
    // Nothing to join: a copy of all positions would be the larger part of the cost.
    if (parts.size() == 1 && glue.empty()) {
        Result<Structure> made = Structure::create(world, *parts.front().fragments, parts.front().desc);
        if (!made) return made.error();
        return Assembly{std::move(*made), std::move(first_piece), std::move(placements)};
    }
    Builder builder(parts.front().desc);
    for (size_t k = 0; k < parts.size(); ++k) builder.add(parts[k], placements[k]);
    const glm::dquat to_frame = glm::conjugate(glm::normalize(glm::dquat(frame.orientation)));
    const auto index_of = [&](const GlueBond::Side& side) { return first_piece[side.part] + side.piece; };
    for (const GlueBond& bond : glue) {
        std::optional<uint32_t> b;
        if (bond.b) b = index_of(*bond.b);
        builder.glue(bond, index_of(bond.a), b, to_frame * (bond.centroid - glm::dvec3(frame.position)),
                     to_frame * bond.normal);
    }
    Result<Structure> made = builder.create(world);
    if (!made) return made.error();
    return Assembly{std::move(*made), std::move(first_piece), std::move(placements)};
}

} // namespace brittle::physics
