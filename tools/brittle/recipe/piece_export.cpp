#include "tools/brittle/recipe/piece_export.h"

#include "fracture/io/import.h"
#include "physics/material.h"
#include "tools/brittle/base/failure.h"
#include "tools/brittle/recipe/recipe.h"

namespace brittle::tools {

namespace {

// Engines add collision margins of their own, so the hull is hardly shrunk.
constexpr float min_margin = 0.001f;

double density_of(const ExportSettings& settings, const physics::MaterialPreset* preset) {
    return settings.density > 0.0 ? settings.density
                                  : double{(preset ? preset->material : physics::Material{}).density};
}

} // namespace

fracture::TriangleMesh collision_mesh(const fracture::Fragments& fragments, const fracture::Piece& piece,
                                      std::span<const physics::HullPlane> planes) {
    const glm::dvec3 centre = piece.mass.centre_of_mass;
    const physics::CollisionHull hull = physics::collision_hull(fragments.positions_of(piece), centre,
                                                                {.margin_fraction = min_margin, .planes = planes});
    fracture::TriangleMesh mesh = physics::hull_mesh(hull.points);
    for (glm::dvec3& p : mesh.positions) p += centre;
    return mesh;
}

bool wants_hulls(const ExportSettings& settings) {
    return !settings.hulls.empty() || settings.rigid_bodies;
}

fracture::ExportOptions export_options(const ExportSettings& settings, const FractureOptions& recipe,
                                       const Input& source) {
    fracture::ExportOptions options{.name = source.name, .recipe = recipe_json(recipe), .source = &source.model};
    options.per_piece = settings.per_piece;
    options.rough = !roughness_of(recipe).is_flat();
    const physics::MaterialPreset* preset = physics::material_preset(recipe.material);
    if (preset) {
        options.exterior = fracture::Material{
            .name = recipe.material, .base_colour = glm::dvec4(preset->exterior, 1.0), .roughness = 0.85};
        options.interior =
            fracture::Material{.name = "interior", .base_colour = glm::dvec4(preset->interior, 1.0), .roughness = 0.95};
    }
    options.hull_names = settings.hulls == "unreal" ? fracture::HullNames::unreal : fracture::HullNames::godot;
    options.rigid_bodies = settings.rigid_bodies;
    options.density = density_of(settings, preset);
    if (!settings.interior_texture.empty())
        options.interior_image = must(fracture::read_image(settings.interior_texture));
    return options;
}

std::vector<std::filesystem::path> write_pieces(const ExportSettings& settings, const FractureOptions& recipe,
                                                const Input& input, const Broken& broken) {
    fracture::ExportOptions options = export_options(settings, recipe, input);
    options.sites = input.sites;
    std::vector<std::vector<fracture::TriangleMesh>> hulls;
    if (wants_hulls(settings)) {
        const std::vector<std::vector<physics::HullPlane>> planes = physics::contact_planes(broken.fragments);
        for (size_t p = 0; p < planes.size(); ++p)
            hulls.push_back({collision_mesh(broken.fragments, broken.fragments.pieces[p], planes[p])});
        options.hulls = hulls;
    }
    return must(fracture::export_pieces(settings.output, broken.fragments, broken.certificate, options));
}

} // namespace brittle::tools
