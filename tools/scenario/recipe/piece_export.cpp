#include "tools/scenario/recipe/piece_export.h"

#include <cstdio>
#include <utility>

#include "fracture/io/import.h"
#include "physics/material.h"
#include "tools/scenario/base/failure.h"
#include "tools/scenario/recipe/recipe.h"

namespace brittle::tools {

namespace {

double density_of(const ExportSettings& settings, const physics::MaterialPreset* preset) {
    return settings.density > 0.0 ? settings.density
                                  : double{(preset ? preset->material : physics::Material{}).density};
}

} // namespace

void check_export(const ExportSettings& settings, const std::string& output_option) {
    const auto refuse_if = [](bool given, const std::string& option, const std::string& why) {
        if (given) throw Failure(exit_usage, option + ": " + why);
    };
    const std::string& file = settings.output;
    const std::string no_file = "there is no file to write; give " + output_option + " FILE";
    const std::string not_glb = file + " cannot hold bodies; give a name that ends with .glb";
    const bool is_glb = file.ends_with(".glb"), has_images = is_glb || file.ends_with(".obj");
    for (const auto& [given, option] :
         {std::pair(!settings.hulls.empty(), "--hulls"), std::pair(settings.rigid_bodies, "--rigid-bodies")}) {
        refuse_if(given && file.empty(), option, no_file);
        refuse_if(given && !is_glb, option, not_glb);
    }
    refuse_if(settings.hull_parts > 0 && !wants_hulls(settings), "--hull-parts",
              settings.hulls == "godot" ? "Godot makes the shapes from the drawn mesh; add --rigid-bodies for hulls"
                                        : "there are no hulls; add --hulls unreal or --rigid-bodies");
    refuse_if(settings.density > 0.0 && !settings.rigid_bodies, "--density", "there are no masses; add --rigid-bodies");
    refuse_if(settings.per_piece && file.empty(), "--per-piece", no_file);
    refuse_if(settings.one_file && file.empty(), "--one-file", no_file);
    refuse_if(!settings.interior_texture.empty() && file.empty(), "--interior-texture", no_file);
    refuse_if(!settings.interior_texture.empty() && !has_images, "--interior-texture",
              file + " cannot hold images; give a name that ends with .glb or .obj");
}

bool splits_files(const ExportSettings& settings, size_t pieces) {
    return settings.per_piece || (!settings.one_file && pieces > 1 && settings.output.ends_with(".stl"));
}

void print_split_note(const ExportSettings& settings, const std::vector<std::filesystem::path>& files) {
    if (settings.per_piece || files.size() < 2) return;
    std::fprintf(stderr,
                 "brittle: %s: STL does not tell pieces apart, so each piece has a file of its own; --one-file joins "
                 "them\n",
                 settings.output.c_str());
}

bool wants_hulls(const ExportSettings& settings) {
    return settings.hulls == "unreal" || settings.rigid_bodies;
}

physics::HullMeshSettings hull_settings(const ExportSettings& settings) {
    physics::HullMeshSettings hulls;
    if (settings.hull_parts > 0) hulls.max_parts = settings.hull_parts;
    return hulls;
}

fracture::ExportOptions export_options(const ExportSettings& settings, const FractureOptions& recipe,
                                       const Input& source) {
    fracture::ExportOptions options{.name = source.name, .recipe = recipe_json(recipe), .source = &source.model};
    options.rough = !roughness_of(recipe).is_flat();
    const physics::MaterialPreset* preset = physics::material_preset(recipe.material);
    if (preset) {
        options.exterior = fracture::Material{
            .name = recipe.material, .base_colour = glm::dvec4(preset->exterior, 1.0), .roughness = 0.85};
        options.interior =
            fracture::Material{.name = "interior", .base_colour = glm::dvec4(preset->interior, 1.0), .roughness = 0.95};
    }
    if (settings.hulls == "godot") options.body_names = fracture::BodyNames::godot;
    if (settings.hulls == "unreal") options.body_names = fracture::BodyNames::unreal;
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
    options.per_piece = splits_files(settings, broken.fragments.pieces.size());
    std::vector<std::vector<fracture::TriangleMesh>> hulls;
    if (wants_hulls(settings)) {
        hulls = physics::hull_meshes(broken.fragments, hull_settings(settings));
        options.hulls = hulls;
    }
    return must(fracture::export_pieces(settings.output, broken.fragments, broken.certificate, options));
}

} // namespace brittle::tools
