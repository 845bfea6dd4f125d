// The `brittle` program: parses the command line and hands over to one function a command.

#include <algorithm>
#include <cstdio>
#include <exception>
#include <filesystem>
#include <functional>
#include <new>
#include <string>
#include <vector>

#include <CLI/CLI.hpp>

#include "fracture/io/export.h"
#include "fracture/io/import.h"
#include "fracture/shapes.h"
#include "tools/brittle/commands.h"
#include "tools/brittle/failure.h"
#include "tools/brittle/recipe.h"

namespace brittle::tools {
namespace {

constexpr const char* description =
    "Brittle breaks triangle meshes into watertight pieces along Voronoi cells, in real time.\n\n"
    "First steps:\n"
    "  brittle demo shape:animal                        break it in a window (Space)\n"
    "  brittle fracture bunny.obj -n 100 -o pieces.glb  pieces for any engine that reads glTF\n"
    "  brittle render bunny.obj -n 50 -o fall_%04d.png  pictures, without a display";

constexpr const char* exit_codes_help =
    "Exit codes: 0 success, 1 failure, 2 wrong command line, 3 input file missing or damaged,\n"
    "            4 mesh or sites cannot be fractured, 5 output not written, 6 no Vulkan device, a lost one\n"
    "            or no display, 130 interrupted (Ctrl+C); nothing half-written is left";

std::string mesh_help() {
    std::string endings;
    for (const std::string& e : fracture::importable_extensions()) endings += (endings.empty() ? "" : " ") + e;
    std::string shapes;
    for (const std::string_view s : fracture::shape_names()) shapes.append(" shape:").append(s);
    return "The mesh to break: a closed triangle mesh in a file (" + endings + ") or one of" + shapes;
}

void add_fracture_options(CLI::App& command, FractureOptions& options) {
    // First, because options take effect in this order: those on the command line outdo the recipe.
    command
        .add_option_function<std::string>(
            "--recipe", [&options](const std::string& file) { read_recipe(file, options); },
            "Take mesh and options from a recipe (assets/recipe.schema.json); options given besides outdo it")
        ->type_name("FILE.json");
    command.add_option("--save-recipe", options.save_recipe, "Also write mesh and options as a recipe")
        ->type_name("FILE.json");
    command.add_option("mesh", options.mesh, mesh_help())->type_name("MESH");
    fracture::Pattern& pattern = options.pattern;
    auto* count = command.add_option("-n,--pieces", pattern.count,
                                     "Number of Voronoi sites; those outside the solid give no piece")
                      ->check(CLI::Range(1u, 1'000'000u))
                      ->capture_default_str();
    auto* seed = command.add_option("--seed", pattern.seed, "Seed of what is random: equal seeds, equal pieces")
                     ->capture_default_str();
    // Before --pattern and its shape, which outdo it.
    command
        .add_option_function<std::string>(
            "--material", [&options](const std::string& name) { use_material(name, options); },
            "What it is made of, which says how it breaks, moves and looks: glass, stone, concrete, wood or ceramic")
        ->type_name("NAME");
    const auto names = fracture::pattern_names();
    const auto set_kind = [&pattern, names](const std::string& name) {
        pattern.kind = static_cast<fracture::PatternKind>(std::find(names.begin(), names.end(), name) - names.begin());
    };
    command
        .add_option_function<std::string>("--pattern", set_kind,
                                          "How the sites lie: uniform, clustered at the focus, radial (glass), grid, "
                                          "bricks, slices, splinters (wood), curve (a crack), curvature (edges), thickness (small where thin)")
        ->check(CLI::IsMember(std::vector<std::string>(names.begin(), names.end())))
        ->type_name("NAME")
        ->default_str("uniform");
    const auto add_vector = [&command](const char* name, glm::dvec3& target, const char* help) {
        command.add_option_function<std::vector<double>>(
                   name, [&target](const std::vector<double>& v) { target = {v[0], v[1], v[2]}; }, help)
            ->expected(3)
            ->delimiter(',')
            ->type_name("X,Y,Z");
    };
    add_vector("--focus", pattern.focus, "Where a pattern is densest, 0 to 1 along each side of the mesh's box");
    add_vector("--axis", pattern.axis, "Along which shards and splinters run, and across which slices are cut");
    command.add_option("--jitter", pattern.jitter, "How irregular a pattern is, 0 to 1; its own if not given")
        ->check(CLI::Range(0.0, 1.0));
    command.add_option("--piece-size", pattern.piece_size, "Metres; as many sites as pieces of that size have room")
        ->check(CLI::PositiveNumber)
        ->excludes(count);
    command.add_option("--grading", pattern.grading, "0: pieces of like sizes; to 1: from crumbs to lumps")
        ->check(CLI::Range(0.0, 1.0));
    command.add_flag("--inside", pattern.inside, "Only sites inside the solid, so that each makes a piece");
    command.add_option("--sites", options.sites_file, "Read the sites from FILE instead: a line `x y z` each, or `x y z radius` for cells of graded sizes")
        ->type_name("FILE")
        ->excludes(count)
        ->excludes(seed)
        ->excludes("--pattern");
    command.add_flag("--fit-sites", options.fit_sites, "Scale and move the sites of --sites onto the mesh's box");
    add_vector("--turn-sites", options.sites_placement.turn, "Turn them, degrees about X, then Y, then Z");
    command.add_option("--scale-sites", options.sites_placement.scale, "Scale them about their middle")
        ->check(CLI::PositiveNumber);
    add_vector("--move-sites", options.sites_placement.move, "Move them, metres");
    command.add_flag("--repair", options.repair,
                     "First remove patches that double the surface, a common flaw of models; says what it removed");
    const auto set_algorithm = [&options](const std::string& name) {
        options.algorithm = name == "exact" ? fracture::Algorithm::exact : fracture::Algorithm::sequential;
    };
    command
        .add_option_function<std::string>("--algorithm", set_algorithm,
                                          "exact: every decision by exact predicates, fast; sequential: clip by one "
                                          "bisector after the other, as the paper does")
        ->check(CLI::IsMember({"exact", "sequential"}))
        ->type_name("NAME")
        ->default_str("exact");
    command
        .add_option("--min-volume", options.min_volume,
                    "Cubic metres; smaller pieces join the neighbour with the largest contact")
        ->check(CLI::NonNegativeNumber)
        ->capture_default_str();
    command.add_option("--threads", options.threads, "Worker threads; 0 is one a core. Never changes the result")
        ->check(CLI::Range(0u, 1024u))
        ->capture_default_str();
}

void add_view_options(CLI::App& command, ViewOptions& view) {
    const auto parse_size = [&view](const std::string& text) {
        unsigned width = 0;
        unsigned height = 0;
        char rest = 0;
        const bool read = std::sscanf(text.c_str(), "%5ux%5u%c", &width, &height, &rest) == 2;
        if (!read || width < 16 || height < 16 || width > 8192 || height > 8192) {
            throw CLI::ValidationError("--size", "'" + text + "' is no size; give WIDTHxHEIGHT, each between 16 and "
                                                              "8192, e.g. 1280x720");
        }
        view.width = width;
        view.height = height;
    };
    command.add_option_function<std::string>("--size", parse_size, "Picture size in pixels")
        ->type_name("WIDTHxHEIGHT")
        ->default_str("1280x720");
    command
        .add_option("--device", view.device,
                    "Vulkan device: cpu, gpu, an index or a part of its name; the best one if not given")
        ->type_name("DEVICE");
    command.add_flag("--validation", view.validation,
                     "Run under the Vulkan validation layer; fail if it has something to say");
}

void add_commands(CLI::App& app, std::function<int()>& run) {
    static FractureCommand fracture_command;
    auto* fracture = app.add_subcommand("fracture", "Break a mesh and write the pieces: GLB, OBJ, PLY or STL");
    add_fracture_options(*fracture, fracture_command.fracture);
    fracture->add_option("-o,--output", fracture_command.output,
                         "The file to write; its ending says the format: .glb, .obj (with .mtl), .ply or .stl")
        ->required()
        ->check([](const std::string& file) {
            const auto& known = fracture::exportable_extensions();
            const std::string ending = std::filesystem::path(file).extension().string();
            if (std::find(known.begin(), known.end(), ending) != known.end()) return std::string();
            std::string list;
            for (const std::string& one : known) list += (list.empty() ? "" : ", ") + one;
            return "'" + file + "' does not end with one of " + list;
        })
        ->type_name("FILE");
    fracture->add_flag("--per-piece", fracture_command.per_piece, "A file for each piece: FILE_000, FILE_001, ...");
    fracture->add_option("--hulls", fracture_command.hulls,
                         "GLB: also collision hulls, named so that the engine finds them")
        ->check(CLI::IsMember({"godot", "unreal"}))
        ->type_name("ENGINE");
    fracture->add_flag("--rigid-bodies", fracture_command.rigid_bodies,
                       "GLB: also masses and hulls by KHR_physics_rigid_bodies, the draft of 2024");
    fracture->add_option("--density", fracture_command.density, "kg/m^3, of --rigid-bodies; the material's if not given")
        ->check(CLI::PositiveNumber);
    fracture->add_option("--interior-texture", fracture_command.interior_texture,
                         "An image for the cuts, repeated every metre (PNG or JPEG)")
        ->type_name("FILE");
    fracture->add_option("--report", fracture_command.report, "Also write counts, proof and times as JSON")
        ->type_name("FILE.json");
    fracture->callback([&run] { run = [] { return run_fracture(fracture_command); }; });

    static InspectCommand inspect_command;
    auto* inspect = app.add_subcommand("inspect", "Say what is the matter with a mesh, and what fracture will do with it");
    inspect->add_option("mesh", inspect_command.mesh, mesh_help())->required()->type_name("MESH");
    inspect->add_flag("--json", inspect_command.json, "As JSON");
    inspect->add_option("--marks", inspect_command.marks, "Also write the mesh with what was found marked, for any viewer")
        ->type_name("FILE.glb");
    inspect->add_option("--picture", inspect_command.picture, "Also draw the mesh with what was found marked")
        ->type_name("FILE.png");
    add_view_options(*inspect, inspect_command.view);
    inspect->footer("Ends with 0 where the mesh can be fractured, with 4 where it cannot.");
    inspect->callback([&run] { run = [] { return run_inspect(inspect_command); }; });

    static RenderCommand render_command;
    auto* render = app.add_subcommand("render", "Break a mesh, let it fall and write pictures; needs no display");
    add_fracture_options(*render, render_command.fracture);
    render->add_option("--frames", render_command.frames, "Frames to simulate after the first picture, 60 a second")
        ->check(CLI::Range(0u, 100'000u))
        ->capture_default_str();
    render->add_option("--every", render_command.every, "Write every so many-th frame")
        ->check(CLI::Range(1u, 100'000u))
        ->capture_default_str();
    render->add_option("-o,--output", render_command.output, "Where to: %04d stands for the frame's number")
        ->type_name("FILE_%04d.png")
        ->capture_default_str();
    render->add_flag("--whole", render_command.whole, "Draw the unbroken mesh at rest");
    render->add_option("--explode", render_command.explode,
                       "Draw the pieces moved apart, by this share of their distance to the middle")
        ->check(CLI::Range(0.0f, 10.0f))
        ->capture_default_str();
    render->add_flag("--show-sites", render_command.sites, "Draw the sites as red spheres");
    render->add_flag("--show-hulls", render_command.hulls, "Draw the collision hulls as red lines");
    add_view_options(*render, render_command.view);
    render->callback([&run] { run = [] { return run_render(render_command); }; });

    static DemoCommand demo_command;
    auto* demo = app.add_subcommand("demo", "Break a mesh in a window (Space breaks, R resets, H lists all keys)");
    demo_command.fracture.mesh = "shape:animal";
    add_fracture_options(*demo, demo_command.fracture);
    demo->get_option("mesh")->capture_default_str();
    add_view_options(*demo, demo_command.view);
    demo->callback([&run] { run = [] { return run_demo(demo_command); }; });

    static ProfileCommand profile_command;
    auto* profile = app.add_subcommand("profile", "Measure the fracture and the frames around it: median and p95");
    add_fracture_options(*profile, profile_command.fracture);
    profile->add_option("--repeats", profile_command.repeats, "Measured fractures, after one to warm up")
        ->check(CLI::Range(1u, 10'000u))
        ->capture_default_str();
    profile->add_option("--frames", profile_command.frames, "Measured frames before and after the fracture; 0 for none, without a device")
        ->check(CLI::Range(0u, 100'000u))
        ->capture_default_str();
    profile
        ->add_option_function<std::string>(
            "--classify", [](const std::string& where) { profile_command.classify_on_device = where == "gpu"; },
            "Where vertices and triangles are classified: cpu, or gpu (the Vulkan device, even if that is a CPU)")
        ->check(CLI::IsMember({"cpu", "gpu"}))
        ->type_name("WHERE")
        ->default_str("cpu");
    profile->add_flag("--json", profile_command.json, "Print JSON instead of a table");
    profile->add_option("-o,--output", profile_command.output, "Also write the JSON to FILE")->type_name("FILE.json");
    add_view_options(*profile, profile_command.view);
    profile->callback([&run] { run = [] { return run_profile(profile_command); }; });
}

int run(int argc, char** argv) {
    CLI::App app(description, "brittle");
    app.set_version_flag("--version", "brittle " BRITTLE_VERSION);
    app.require_subcommand(1);
    app.footer(exit_codes_help);
    std::function<int()> command;
    add_commands(app, command);
    try {
        app.parse(argc, argv);
    } catch (const CLI::ParseError& e) {
        return app.exit(e) == 0 ? exit_success : exit_usage;
    }
    return command();
}

} // namespace
} // namespace brittle::tools

int main(int argc, char** argv) {
    try {
        return brittle::tools::run(argc, argv);
    } catch (const brittle::tools::Failure& failure) {
        std::fprintf(stderr, "brittle: %s\n", failure.what());
        return failure.code();
    } catch (const std::bad_alloc&) {
        std::fputs("brittle: out of memory; use a smaller mesh or fewer sites\n", stderr);
    } catch (const std::exception& e) {
        std::fprintf(stderr, "brittle: %s\n", e.what());
    }
    return brittle::tools::exit_failure;
}
