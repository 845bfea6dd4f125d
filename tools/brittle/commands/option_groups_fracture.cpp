// The options of FractureOptions: mesh, recipe, pattern, sites and algorithm.
#include <algorithm>
#include <cstdio>
#include <string>
#include <vector>

#include <glm/geometric.hpp>

#include "fracture/io/import.h"
#include "fracture/shapes/shapes.h"
#include "physics/material.h"
#include "tools/brittle/commands/option_groups.h"
#include "tools/brittle/commands/option_values.h"
#include "tools/scenario/recipe/recipe.h"

namespace brittle::tools {

namespace {

void add_vector_option(CLI::App& command, const char* name, glm::dvec3& target, const char* help) {
    command
        .add_option_function<std::vector<double>>(
            name,
            [&target](const std::vector<double>& v) {
                target = {v[0], v[1], v[2]};
            },
            help)
        ->expected(3)
        ->delimiter(',')
        ->check(finite_number())
        ->type_name("X,Y,Z");
}

void add_mesh_options(CLI::App& command, FractureOptions& options) {
    start_group(command, "Mesh and recipe");
    command
        .add_option_function<std::string>(
            "--recipe", [&options](const std::string& file) { read_recipe(file, options); },
            "Recipe that gives mesh and options (assets/recipe.schema.json). Options on the command line override it.")
        ->type_name("FILE.json");
    command
        .add_option("--save-recipe", options.save_recipe,
                    "File to which mesh and options are written as a recipe, besides other outputs")
        ->type_name("FILE.json");
    command
        .add_option_function<std::string>(
            "mesh",
            [&options](const std::string& mesh) {
                if (mesh.ends_with(".json"))
                    read_recipe(mesh, options);
                else
                    options.mesh = mesh;
            },
            mesh_help() + ", or a recipe (.json)")
        ->type_name("MESH");
    command
        .add_option_function<std::string>(
            "--units", [&options](const std::string& name) { options.units = *length_unit(name); },
            "Length of a unit of the mesh file on the stage of `render` and `demo`. fit: the mesh is 2 m long there.")
        ->check(CLI::IsMember({"fit", "m", "cm", "mm", "inch"}))
        ->type_name("UNIT")
        ->default_str("fit");
}

// --material comes before --pattern and its shape, which override it.
void add_pattern_options(CLI::App& command, FractureOptions& options) {
    start_group(command, "Material and pattern");
    fracture::Pattern& pattern = options.pattern;
    auto* count =
        command
            .add_option("-n,--pieces", pattern.count,
                        "Number of pieces to aim at: of Voronoi sites, each of which makes a piece if it is inside "
                        "the solid")
            ->check(number_from(1, 1'000'000))
            ->capture_default_str();
    command
        .add_option("--seed", pattern.seed,
                    "Seed of all random numbers: those of patterns and of the cuts that blows make. Equal seeds give "
                    "equal pieces.")
        ->check(non_negative_number())
        ->capture_default_str();
    std::vector<std::string> materials;
    for (const auto& preset : physics::material_presets()) materials.emplace_back(preset.name);
    command
        .add_option_function<std::string>(
            "--material", [&options](const std::string& name) { use_material(name, options); },
            "Material, which decides how the mesh breaks, moves and looks: glass, stone, concrete, wood, ceramic or "
            "brick")
        ->check(known_words(materials))
        ->type_name("NAME");
    const auto names = fracture::pattern_names();
    const auto set_kind = [&pattern, names](const std::string& name) {
        pattern.kind = static_cast<fracture::PatternKind>(std::find(names.begin(), names.end(), name) - names.begin());
    };
    command
        .add_option_function<std::string>(
            "--pattern", set_kind,
            "Arrangement of the sites: uniform, clustered (dense at the focus), radial (as glass breaks), grid, "
            "bricks, slices, splinters (as wood breaks), curve (a crack), curvature (dense where the surface bends), "
            "thickness (small pieces where the solid is thin)")
        ->check(CLI::IsMember(std::vector<std::string>(names.begin(), names.end())))
        ->type_name("NAME")
        ->default_str("uniform");
    add_vector_option(command, "--focus", pattern.focus,
                      "Point where the pattern is densest, from 0 to 1 along each side of the mesh's box");
    add_vector_option(command, "--axis", pattern.axis,
                      "Direction along which shards and splinters run, and across which slices are cut");
    command
        .add_option("--jitter", pattern.jitter,
                    "Irregularity of the pattern, from 0 to 1. The default depends on the pattern.")
        ->check(number_from(0.0, 1.0));
    command
        .add_option("--piece-size", pattern.piece_size,
                    "Size of a piece, metres. The number of sites is the volume of the solid divided by its cube.")
        ->check(positive_number())
        ->excludes(count);
    command
        .add_option("--grading", pattern.grading,
                    "Spread of the sizes of pieces: from 0 (nearly equal) to 1 (from crumbs to lumps)")
        ->check(number_from(0.0, 1.0));
    command
        .add_option(
            "--cells-per-piece", pattern.cells_per_piece,
            "Cells that make up each piece: 1 gives convex pieces, about 16 pieces of many facets, as of crushed "
            "stone")
        ->check(number_from(1, 1000))
        ->capture_default_str();
    auto* inside =
        command.add_flag("--inside", pattern.inside,
                         "Place sites inside the solid only, so that each site makes a piece: the default of "
                         "the patterns uniform and clustered");
    command
        .add_flag_callback(
            "--sites-in-box", [&pattern] { pattern.inside = false; },
            "Place sites in the whole box of the mesh, as the paper does. Those outside the solid may give no piece.")
        ->excludes(inside);
}

void place_inside_by_default(const CLI::App& command, fracture::Pattern& pattern) {
    const bool is_random =
        pattern.kind == fracture::PatternKind::uniform || pattern.kind == fracture::PatternKind::clustered;
    const bool is_open = command.count("--inside") == 0 && command.count("--sites-in-box") == 0;
    if (is_open && is_random && recipe_file(command).empty()) pattern.inside = true;
}

void add_site_options(CLI::App& command, FractureOptions& options) {
    start_group(command, "Sites and blows");
    command
        .add_option("--sites", options.sites_file,
                    "File of sites to use instead of a pattern: one line `x y z` for each, or `x y z radius` for cells "
                    "of graded sizes")
        ->type_name("FILE")
        ->excludes("--pieces")
        ->excludes("--pattern");
    command.add_flag("--fit-sites", options.fit_sites, "Scale and move the sites of --sites onto the mesh's box");
    add_vector_option(command, "--turn-sites", options.sites_placement.turn,
                      "Rotation of the sites of --sites, degrees about X, then Y, then Z");
    command
        .add_option("--scale-sites", options.sites_placement.scale,
                    "Factor by which the sites of --sites are scaled about the centre of their box")
        ->check(positive_number());
    add_vector_option(command, "--move-sites", options.sites_placement.move,
                      "Translation of the sites of --sites, metres");
    command
        .add_option_function<std::vector<std::string>>(
            "--strike",
            [&options](const std::vector<std::string>& strikes) {
                options.strikes.clear();
                for (const std::string& text : strikes) {
                    const Ball ball = parse_ball("--strike", text);
                    Strike strike;
                    strike.at = ball.centre;
                    strike.radius = ball.radius;
                    options.strikes.push_back(strike);
                }
            },
            "Break only the part of the mesh within RADIUS of a point, metres. The rest stays one piece. May be given "
            "several times.")
        ->type_name("X,Y,Z,RADIUS");
}

glm::dvec3 parse_grain(const std::vector<double>& v) {
    const glm::dvec3 grain(v[0], v[1], v[2]);
    const double stretch = glm::length(grain);
    if (grain == glm::dvec3(0.0) || (stretch >= min_stretch && stretch <= max_stretch)) return grain;
    char text[160];
    std::snprintf(
        text, sizeof text,
        "'%g,%g,%g' has the length %g; give a direction as long as the factor of its stretch, from 1/16 to 16, "
        "or 0,0,0",
        grain.x, grain.y, grain.z, stretch);
    throw CLI::ValidationError("--grain", text);
}

// These come after --material, whose roughness they override.
void add_roughness_options(CLI::App& command, FractureOptions& options) {
    start_group(command, "Rough cuts");
    fracture::Roughness& rough = options.rough;
    command
        .add_option("--roughness", rough.amount,
                    "Roughness of the cuts, those of blows included: from 0 (flat) to 1. The default is that of "
                    "--material; 0 without one.")
        ->check(number_from(0.0, 1.0));
    command
        .add_option("--rough-size", rough.wavelength,
                    "Size of the largest bumps of rough cuts, metres. The default, 0, is the typical distance of "
                    "adjacent sites.")
        ->check(non_negative_number());
    command
        .add_option_function<std::vector<double>>(
            "--grain", [&rough](const std::vector<double>& v) { rough.grain = parse_grain(v); },
            "Direction of the grain of rough cuts. Its length, 1/16 to 16, stretches their bumps along it: 4 for "
            "the splinters of wood, 0.25 for the layers of slate.")
        ->expected(3)
        ->delimiter(',')
        ->check(finite_number())
        ->type_name("X,Y,Z");
    command
        .add_option("--detail", rough.detail,
                    "Octaves of rough cuts, each with bumps of half the size. One more makes four times as many "
                    "triangles. The default is that of --material; 1 without one.")
        ->check(number_from(1, max_detail));
}

// The grain of a material follows the pattern's axis. The sequential algorithm makes flat cuts only.
void adapt_roughness_of_material(const CLI::App& command, FractureOptions& options) {
    if (command.count("--material") == 0) return;
    if (command.count("--grain") == 0) options.rough.grain = grain_of_material(options, options.pattern.axis);
    if (command.count("--roughness") == 0 && options.algorithm == fracture::Algorithm::sequential)
        options.rough.amount = 0.0;
}

void add_algorithm_options(CLI::App& command, FractureOptions& options) {
    start_group(command, "Repair and algorithm");
    command.add_flag("--repair", options.repair,
                     "Repair the mesh first, as `brittle repair` does, and print what was done");
    command.add_flag("--unite", options.unite,
                     "Unite parts that pass through each other, after the repair, so that space counts once");
    const auto set_algorithm = [&options](const std::string& name) {
        options.algorithm = name == "exact" ? fracture::Algorithm::exact : fracture::Algorithm::sequential;
    };
    command
        .add_option_function<std::string>(
            "--algorithm", set_algorithm,
            "exact: fast, and every decision is made by exact predicates. sequential: clips by one bisector after the "
            "other, as the paper does.")
        ->check(CLI::IsMember({"exact", "sequential"}))
        ->type_name("NAME")
        ->default_str("exact");
    command
        .add_option("--min-volume", options.min_volume,
                    "Minimum volume of a piece, cubic metres. A smaller piece joins the neighbour with the largest "
                    "contact area.")
        ->check(non_negative_number())
        ->capture_default_str();
}

} // namespace

std::string mesh_help() {
    std::string endings;
    for (const std::string& e : fracture::importable_extensions()) endings += (endings.empty() ? "" : " ") + e;
    std::string shapes;
    for (const std::string_view s : fracture::shape_names())
        shapes.append(shapes.empty() ? "shape:" : " shape:").append(s);
    return "Triangle mesh: a file (" + endings + "), - for standard input, or a shape that is built in (" + shapes
           + ")";
}

void add_pieces_option(CLI::App& command, FractureOptions& options) {
    start_group(command, "Mesh and recipe");
    command
        .add_option(
            "--pieces-from", options.pieces_from,
            "Instead of a mesh: a .glb or .gltf file whose nodes are pieces already. They are bonded where they "
            "touch, and blows break them. The file is in metres unless --units says otherwise.")
        ->type_name("SET.glb")
        ->excludes(command.get_option("mesh"));
}

std::string recipe_file(const CLI::App& command) {
    std::string found;
    for (const std::string option : {"--recipe", "mesh"})
        for (const std::string& file : command.get_option(option)->results())
            if (option == "--recipe" || file.ends_with(".json")) found = file;
    return found;
}

void add_fracture_options(CLI::App& command, FractureOptions& options) {
    add_mesh_options(command, options);
    add_pattern_options(command, options);
    add_site_options(command, options);
    add_roughness_options(command, options);
    add_algorithm_options(command, options);
    command.parse_complete_callback([&command, &options] {
        place_inside_by_default(command, options.pattern);
        adapt_roughness_of_material(command, options);
    });
}

} // namespace brittle::tools
