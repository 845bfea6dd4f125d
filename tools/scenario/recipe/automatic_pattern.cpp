#include "tools/scenario/recipe/automatic_pattern.h"

#include <algorithm>
#include <cmath>

#include <glm/geometric.hpp>

#include "fracture/mesh/mass_properties.h"

namespace brittle::tools {

namespace {

constexpr double min_pieces = 8, max_pieces = 1000;

double area_of(const fracture::TriangleMesh& mesh) {
    double area = 0.0;
    for (const fracture::Triangle& t : mesh.triangles)
        area += 0.5
                * glm::length(
                    glm::cross(mesh.positions[t.y] - mesh.positions[t.x], mesh.positions[t.z] - mesh.positions[t.x]));
    return area;
}

double piece_size(const physics::Material& material) {
    const auto ratio = [](const physics::Material& m) {
        return static_cast<double>(m.fracture_toughness) / static_cast<double>(m.density);
    };
    const double to_stone = ratio(material) / ratio(physics::material_preset("stone")->material);
    return stone_piece_size * std::cbrt(to_stone * to_stone);
}

} // namespace

fracture::Pattern automatic_pattern(const AutomaticPattern& automatic, const fracture::Pattern& shape,
                                    const fracture::TriangleMesh& mesh, const physics::Material& material) {
    const double volume = std::abs(fracture::signed_volume(mesh.positions, mesh.triangles));
    const double thickness = 2.0 * volume / std::max(area_of(mesh), 1e-300); // of a plate
    const double size = automatic.scale * piece_size(material);
    const double pieces = volume / (size * size * std::min(size, thickness));
    fracture::Pattern pattern = shape;
    pattern.piece_size = 0.0;
    pattern.count =
        static_cast<uint32_t>(std::clamp(std::isfinite(pieces) ? std::round(pieces) : 0.0, min_pieces, max_pieces));
    if (pattern.kind == fracture::PatternKind::uniform) pattern.kind = fracture::PatternKind::thickness;
    return pattern;
}

uint64_t seed_of_name(std::string_view name) {
    uint64_t hash = 0xcbf29ce484222325;
    for (const char c : name) {
        hash ^= static_cast<unsigned char>(c);
        hash *= 0x100000001b3;
    }
    return hash;
}

} // namespace brittle::tools
