#include "tools/scenario/recipe/piece_export.h"

#include <algorithm>
#include <optional>
#include <utility>

#include "fracture/io/import.h"
#include "physics/material.h"
#include "tools/scenario/base/failure.h"
#include "tools/scenario/recipe/json_reader.h"
#include "tools/scenario/recipe/recipe.h"

namespace brittle::tools {

namespace {

double density_of(const ExportSettings& settings, const physics::MaterialPreset* preset) {
    return settings.density > 0.0 ? settings.density
                                  : double{(preset ? preset->material : physics::Material{}).density};
}

// A setting that has no effect on the file: its option, and why.
struct IdleSetting {
    std::string option;
    std::string why;
};

// Returns the first setting that has no effect.
std::optional<IdleSetting> idle_setting(const ExportSettings& settings, const std::string& output_option) {
    const bool streams = !settings.stream.empty(), none = settings.output.empty() && !streams;
    const std::string file = streams ? "standard output as " + settings.stream : settings.output;
    const auto choose = [&](const char* formats) {
        return std::string("; give ") + (streams ? "--output-format and one of " : "a name that ends with ") + formats;
    };
    const std::string no_file = "there is no file to write; give " + output_option + " FILE";
    const bool is_glb = settings.stream == "glb" || settings.output.ends_with(".glb");
    const bool is_obj = settings.stream == "obj" || settings.output.ends_with(".obj");
    const std::string not_glb = file + " cannot hold bodies" + choose(streams ? "glb" : ".glb");
    for (const auto& [given, option] :
         {std::pair(!settings.hulls.empty(), "--hulls"), std::pair(settings.rigid_bodies, "--rigid-bodies")}) {
        if (given && none) return IdleSetting{option, no_file};
        if (given && !is_glb) return IdleSetting{option, not_glb};
    }
    if (settings.hull_parts > 0 && !wants_hulls(settings))
        return IdleSetting{"--hull-parts", settings.hulls == "godot" ? "Godot makes the shapes from the drawn mesh; "
                                                                       "add --rigid-bodies for hulls"
                                                                     : "there are no hulls; add --hulls unreal or "
                                                                       "--rigid-bodies"};
    if (settings.density > 0.0 && !settings.rigid_bodies)
        return IdleSetting{"--density", "there are no masses; add --rigid-bodies"};
    if (settings.per_piece && none) return IdleSetting{"--per-piece", no_file};
    if (settings.per_piece && streams) return IdleSetting{"--per-piece", "standard output holds one file"};
    if (settings.one_file && none) return IdleSetting{"--one-file", no_file};
    if (!settings.interior_texture.empty() && none) return IdleSetting{"--interior-texture", no_file};
    if (!settings.interior_texture.empty() && is_obj && streams)
        return IdleSetting{"--interior-texture",
                           "the images of an OBJ file are files beside it; give --output-format glb"};
    if (!settings.interior_texture.empty() && !is_glb && !is_obj)
        return IdleSetting{"--interior-texture",
                           file + " cannot hold images" + choose(streams ? "glb" : ".glb or .obj")};
    if (!settings.name.empty() && none) return IdleSetting{"--name", no_file};
    if (!settings.name.empty() && !is_glb && !is_obj)
        return IdleSetting{"--name", file + " cannot hold names" + choose(streams ? "glb or obj" : ".glb or .obj")};
    return std::nullopt;
}

// Calls visit(option, member) for each setting that a recipe keeps, as a pointer to the member.
void visit_options(const auto& visit) {
    visit("--name", &ExportSettings::name);
    visit("--per-piece", &ExportSettings::per_piece);
    visit("--one-file", &ExportSettings::one_file);
    visit("--hulls", &ExportSettings::hulls);
    visit("--rigid-bodies", &ExportSettings::rigid_bodies);
    visit("--hull-parts", &ExportSettings::hull_parts);
    visit("--density", &ExportSettings::density);
    visit("--interior-texture", &ExportSettings::interior_texture);
    visit("--export-as", &ExportSettings::as);
}

void copy_option(const std::string& option, const ExportSettings& from, ExportSettings& to) {
    visit_options([&](const char* name, auto member) {
        if (option == name) to.*member = from.*member;
    });
}

} // namespace

ExportSettings effective_export(ExportSettings settings, const std::string& output_option,
                                const std::function<bool(const std::string& option)>& given,
                                std::vector<std::string>& notes) {
    while (const std::optional<IdleSetting> idle = idle_setting(settings, output_option)) {
        if (given(idle->option)) throw Failure(exit_usage, idle->option + ": " + idle->why);
        copy_option(idle->option, {}, settings);
        if (!settings.output.empty() || !settings.stream.empty())
            notes.push_back("the recipe's " + idle->option + " has no effect: " + idle->why);
    }
    return settings;
}

ExportSettings overridden_export(ExportSettings recipe, const ExportSettings& line,
                                 const std::function<bool(const std::string& option)>& given) {
    // Each of the two excludes the other.
    if (given("--per-piece") || given("--one-file")) recipe.per_piece = recipe.one_file = false;
    visit_options([&](const char* option, auto) {
        if (given(option)) copy_option(option, line, recipe);
    });
    return recipe;
}

std::string refusal_of_name(const std::string& name) {
    if (name.size() > max_name_bytes)
        return "a name of " + std::to_string(name.size()) + " bytes; give " + std::to_string(max_name_bytes)
               + " at most";
    if (std::ranges::any_of(name, [](unsigned char c) { return c < 0x20 || c == 0x7f; }))
        return "a name with control characters; leave them out";
    if (!is_utf8(name)) return "a name that is not UTF-8; spell it in UTF-8";
    return {};
}

bool splits_files(const ExportSettings& settings, size_t pieces) {
    return settings.per_piece || (!settings.one_file && pieces > 1 && settings.output.ends_with(".stl"));
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
    fracture::ExportOptions options{.name = settings.name.empty() ? source.name : settings.name,
                                    .recipe = recipe_json(recipe),
                                    .source = &source.model};
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

namespace {

// The options of an export of the pieces where they were cut, with the hulls that they refer to.
struct PieceOptions {
    PieceOptions(const ExportSettings& settings, const FractureOptions& recipe, const Input& input,
                 const Broken& broken)
        : options(export_options(settings, recipe, input)) {
        options.sites = input.sites;
        options.per_piece = splits_files(settings, broken.fragments.pieces.size());
        if (!wants_hulls(settings)) return;
        hulls = physics::hull_meshes(broken.fragments, hull_settings(settings));
        options.hulls = hulls;
    }
    PieceOptions(const PieceOptions&) = delete;
    PieceOptions& operator=(const PieceOptions&) = delete;

    std::vector<std::vector<fracture::TriangleMesh>> hulls{};
    fracture::ExportOptions options;
};

} // namespace

std::vector<std::filesystem::path> write_pieces(const ExportSettings& settings, const FractureOptions& recipe,
                                                const Input& input, const Broken& broken) {
    const PieceOptions pieces(settings, recipe, input, broken);
    return must(fracture::export_pieces(settings.output, broken.fragments, broken.certificate, pieces.options));
}

std::vector<std::byte> pieces_in_memory(const ExportSettings& settings, const FractureOptions& recipe,
                                        const Input& input, const Broken& broken) {
    PieceOptions pieces(settings, recipe, input, broken);
    pieces.options.single_file = true;
    std::vector<fracture::ExportedFile> files = must(fracture::export_pieces_to_memory(
        "pieces." + settings.stream, broken.fragments, broken.certificate, pieces.options));
    return std::move(files.front().bytes);
}

} // namespace brittle::tools
