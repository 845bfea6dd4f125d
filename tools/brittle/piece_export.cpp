#include "tools/brittle/piece_export.h"

#include "fracture/io/export.h"
#include "fracture/io/import.h"
#include "physics/hull.h"
#include "physics/material.h"
#include "tools/brittle/failure.h"

namespace brittle::tools {

namespace {

// Engines add margins of their own, so hardly any is taken off here.
constexpr float least_margin = 0.001f;

fracture::TriangleMesh collision_mesh(const fracture::Fragments& fragments, const fracture::Piece& piece) {
    const glm::dvec3 centre = piece.mass.centre_of_mass;
    const physics::CollisionHull hull =
        physics::collision_hull(fragments.positions_of(piece), centre, {.margin_fraction = least_margin});
    fracture::TriangleMesh mesh = physics::hull_mesh(hull.points);
    for (glm::dvec3& p : mesh.positions) p += centre;
    return mesh;
}

double density(const FractureCommand& command) {
    const physics::MaterialPreset* preset = physics::material_preset(command.fracture.material);
    return command.density > 0.0 ? command.density : (preset ? preset->material.density : physics::Material{}.density);
}

} // namespace

std::vector<std::filesystem::path> write_pieces(const FractureCommand& command, const Input& input, const Broken& broken,
                                                const std::string& recipe) {
    fracture::ExportOptions options{.name = input.name, .recipe = recipe, .source = &input.model, .sites = input.sites};
    options.per_piece = command.per_piece;
    if (const physics::MaterialPreset* preset = physics::material_preset(command.fracture.material)) {
        options.exterior = fracture::Material{
            .name = command.fracture.material, .base_colour = glm::dvec4(preset->exterior, 1.0), .roughness = 0.85};
        options.interior = fracture::Material{
            .name = "interior", .base_colour = glm::dvec4(preset->interior, 1.0), .roughness = 0.95};
    }
    options.hull_names = command.hulls == "unreal" ? fracture::HullNames::unreal : fracture::HullNames::godot;
    options.rigid_bodies = command.rigid_bodies;
    options.density = density(command);
    std::vector<std::vector<fracture::TriangleMesh>> hulls;
    if (!command.hulls.empty() || command.rigid_bodies) {
        for (const fracture::Piece& piece : broken.fragments.pieces)
            hulls.push_back({collision_mesh(broken.fragments, piece)});
        options.hulls = hulls;
    }
    if (!command.interior_texture.empty()) options.interior_image = must(fracture::read_image(command.interior_texture));
    return must(fracture::export_pieces(command.output, broken.fragments, broken.certificate, options));
}

} // namespace brittle::tools
