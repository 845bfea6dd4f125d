// The `brittle` program: parses the command line and hands over to one function a command.

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <exception>
#include <filesystem>
#include <functional>
#include <new>
#include <sstream>
#include <string>
#include <string_view>
#include <vector>

#include <CLI/CLI.hpp>

#include "fracture/io/export.h"
#include "fracture/io/import.h"
#include "fracture/io/text_cursor.h"
#include "fracture/shapes/shapes.h"
#include "tools/brittle/base/failure.h"
#include "tools/brittle/commands/commands.h"
#include "tools/brittle/recipe/recipe.h"

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
    "            or no display, 7 slower than before (profile --compare),\n"
    "            8 another state than the replay log tells,\n"
    "            130 interrupted (Ctrl+C); nothing half-written is left";

std::string mesh_help() {
    std::string endings;
    for (const std::string& e : fracture::importable_extensions()) endings += (endings.empty() ? "" : " ") + e;
    std::string shapes;
    for (const std::string_view s : fracture::shape_names()) shapes.append(" shape:").append(s);
    return "The mesh to break: a closed triangle mesh in a file (" + endings + ") or one of" + shapes;
}

struct Ball {
    glm::dvec3 centre{0.0};
    double radius = 0.0;
};

Ball ball_of(const std::string& option, const std::string& text) {
    Ball ball;
    char rest = 0;
    const bool read = std::sscanf(text.c_str(), "%lf,%lf,%lf,%lf%c", &ball.centre.x, &ball.centre.y, &ball.centre.z,
                                  &ball.radius, &rest)
                      == 4;
    if (!read || !std::isfinite(ball.centre.x + ball.centre.y + ball.centre.z + ball.radius))
        throw CLI::ValidationError(option, "'" + text + "' is not X,Y,Z,RADIUS");
    return ball;
}

Shot shot_of(const std::string& text) {
    std::vector<double> numbers;
    std::istringstream stream(text);
    double number = 0.0;
    char comma = ',';
    while (comma == ',' && stream >> number) {
        numbers.push_back(number);
        comma = '\0';
        stream >> comma;
    }
    const bool read = comma == '\0' && (numbers.size() == 7 || numbers.size() == 8);
    if (!read || !std::ranges::all_of(numbers, [](double value) { return std::isfinite(value); }))
        throw CLI::ValidationError("--shot", "'" + text + "' is not X,Y,Z,VX,VY,VZ,RADIUS or that and ,SECONDS");
    const Shot shot{.time = numbers.size() == 8 ? numbers[7] : 0.0,
                    .from = {numbers[0], numbers[1], numbers[2]},
                    .velocity = {numbers[3], numbers[4], numbers[5]},
                    .radius = numbers[6]};
    if (shot.radius < 0.001 || shot.radius > 10.0)
        throw CLI::ValidationError("--shot", "'" + text + "' has a radius that is not in [0.001, 10]");
    if (shot.time < 0.0 || shot.time > 1e4)
        throw CLI::ValidationError("--shot", "'" + text + "' has a time that is not in [0, 10000]");
    return shot;
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
    fracture::Pattern& pattern = options.pattern;
    auto* count =
        command
            .add_option("-n,--pieces", pattern.count, "Number of Voronoi sites; those outside the solid give no piece")
            ->check(CLI::Range(1u, 1'000'000u))
            ->capture_default_str();
    command
        .add_option("--seed", pattern.seed, "Seed of what is random, the cuts of blows too: equal seeds, equal pieces")
        ->capture_default_str();
    // Before --pattern and its shape, which outdo it.
    command
        .add_option_function<std::string>(
            "--material", [&options](const std::string& name) { use_material(name, options); },
            "What it is made of, which says how it breaks, moves and looks: glass, stone, concrete, wood, ceramic or "
            "brick")
        ->type_name("NAME");
    const auto names = fracture::pattern_names();
    const auto set_kind = [&pattern, names](const std::string& name) {
        pattern.kind = static_cast<fracture::PatternKind>(std::find(names.begin(), names.end(), name) - names.begin());
    };
    command
        .add_option_function<std::string>(
            "--pattern", set_kind,
            "How the sites lie: uniform, clustered at the focus, radial (glass), grid, "
            "bricks, slices, splinters (wood), curve (a crack), curvature (edges), thickness (small where thin)")
        ->check(CLI::IsMember(std::vector<std::string>(names.begin(), names.end())))
        ->type_name("NAME")
        ->default_str("uniform");
    const auto add_vector = [&command](const char* name, glm::dvec3& target, const char* help) {
        command
            .add_option_function<std::vector<double>>(
                name,
                [&target](const std::vector<double>& v) {
                    target = {v[0], v[1], v[2]};
                },
                help)
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
    command
        .add_option(
            "--sites", options.sites_file,
            "Read the sites from FILE instead: a line `x y z` each, or `x y z radius` for cells of graded sizes")
        ->type_name("FILE")
        ->excludes(count)
        ->excludes("--pattern");
    command.add_flag("--fit-sites", options.fit_sites, "Scale and move the sites of --sites onto the mesh's box");
    add_vector("--turn-sites", options.sites_placement.turn, "Turn them, degrees about X, then Y, then Z");
    command.add_option("--scale-sites", options.sites_placement.scale, "Scale them about their middle")
        ->check(CLI::PositiveNumber);
    add_vector("--move-sites", options.sites_placement.move, "Move them, metres");
    command
        .add_option_function<std::vector<std::string>>(
            "--strike",
            [&options](const std::vector<std::string>& strikes) {
                options.strikes.clear();
                for (const std::string& text : strikes) {
                    const Ball ball = ball_of("--strike", text);
                    Strike strike;
                    strike.at = ball.centre;
                    strike.radius = ball.radius;
                    options.strikes.push_back(strike);
                }
            },
            "Break only what lies within RADIUS of a point of the mesh, metres; the rest stays one piece. May be given "
            "again")
        ->type_name("X,Y,Z,RADIUS");
    command.add_flag("--repair", options.repair, "First mend the mesh as `brittle repair` does; says what was done");
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
            throw CLI::ValidationError("--size", "'" + text
                                                     + "' is no size; give WIDTHxHEIGHT, each between 16 and "
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
    command
        .add_option("--quality", view.quality,
                    "auto: what the device is good for; fast: plain; best: smooth edges, soft shadows, dark corners")
        ->check(CLI::IsMember({"auto", "fast", "best"}))
        ->type_name("NAME")
        ->capture_default_str();
    command.add_flag("--validation", view.validation,
                     "Run under the Vulkan validation layer; fail if it has something to say");
}

void add_world_options(CLI::App& command, WorldOptions& world) {
    command.add_flag("--bonded", world.bonded, "Pieces hold together until blows or loads break their bonds");
    command.add_flag("--anchored", world.anchored, "Bonded, or breakable, and what stands on the ground is held by it");
    command
        .add_option_function<std::vector<std::string>>(
            "--anchor",
            [&world](const std::vector<std::string>& anchors) {
                world.anchors.clear();
                for (const std::string& text : anchors) {
                    const Ball ball = ball_of("--anchor", text);
                    if (ball.radius < 0.001 || ball.radius > 10.0)
                        throw CLI::ValidationError("--anchor",
                                                   "'" + text + "' has a radius that is not in [0.001, 10]");
                    world.anchors.push_back({ball.centre, ball.radius});
                }
            },
            "Bonded, or breakable, and held where it is within RADIUS of a point: metres from the middle of its foot, "
            "with "
            "the mesh 2 m long. May be given again")
        ->type_name("X,Y,Z,RADIUS");
    command
        .add_option_function<std::vector<std::string>>(
            "--shot",
            [&world](const std::vector<std::string>& shots) {
                world.shots.clear();
                for (const std::string& text : shots) world.shots.push_back(shot_of(text));
            },
            "A ball of steel is shot from a point, at a velocity in m/s, after SECONDS (0): metres, the mesh 2 m long "
            "over the "
            "origin of the ground. May be given again")
        ->type_name("X,Y,Z,VX,VY,VZ,RADIUS[,SECONDS]");
    command
        .add_option("--strength", world.strength,
                    "Of bonds and breakable pieces, in the material's own; 0.075 is stone laid in weak mortar")
        ->check(CLI::Range(1e-6, 1e6))
        ->capture_default_str();
    command.add_flag("--breakable", world.breakable,
                     "Cut anew where it is hit, again and again. Without --bonded it starts whole: blows cut in the "
                     "manner of --pattern, or "
                     "along the diagram of --sites, fitted to what is hit; --anchored holds its foot");
    command
        .add_option("--min-size", world.min_size,
                    "Metres, cube root of volume; breakable things give no smaller pieces")
        ->check(CLI::Range(1e-4, 10.0))
        ->capture_default_str();
    command.add_option("--blow-pieces", world.blow_pieces, "Pieces that one blow to a breakable thing makes, at most")
        ->check(CLI::Range(2u, 1000u))
        ->capture_default_str();
    command
        .add_option("--piece-limit", world.piece_limit,
                    "Pieces of breakable things in the world, bonded or not; beyond it debris goes: first what is not "
                    "in the picture, then what "
                    "is small and old. With --bonded alone nothing goes")
        ->check(CLI::Range(1u, 1'000'000u))
        ->capture_default_str();
    command.add_option("--air-density", world.air_density, "Of the air that brakes what moves, kg/m^3; 0 is a vacuum")
        ->check(CLI::Range(0.0, 1e4))
        ->capture_default_str();
    command
        .add_option(
            "--most-colliding", world.max_colliding,
            "Awake pieces that collide with each other, at most; what comes off beyond meets only the ground, what is "
            "held, "
            "balls, and what is at least twice as long, and may lie in its like. Keeps frames short; 0: no limit, for "
            "pictures that may take their time")
        ->check(CLI::Range(0u, 1'000'000u))
        ->capture_default_str();
    command
        .add_option("--height", world.height, "Metres of the mesh above the ground at first; 0 where it is anchored")
        ->check(CLI::Range(0.0, 100.0))
        ->capture_default_str();
}

void add_classify_option(CLI::App& command, std::string& where) {
    command
        .add_option(
            "--classify", where,
            "Where vertices and triangles are classified: cpu, gpu (the Vulkan device, even if that is a CPU), or "
            "auto: whichever a few trials find faster. Never changes the result")
        ->check(CLI::IsMember({"auto", "cpu", "gpu"}))
        ->type_name("WHERE")
        ->capture_default_str();
}

// What is wrong, or nothing.
std::string has_exportable_ending(const std::string& file) {
    const auto& known = fracture::exportable_extensions();
    const std::string ending = std::filesystem::path(file).extension().string();
    if (std::find(known.begin(), known.end(), ending) != known.end()) return {};
    std::string list;
    for (const std::string& one : known) list += (list.empty() ? "" : ", ") + one;
    return "'" + file + "' does not end with one of " + list;
}

void add_export_options(CLI::App& command, ExportSettings& files) {
    command.add_flag("--per-piece", files.per_piece, "A file for each piece: FILE_000, FILE_001, ...");
    command.add_option("--hulls", files.hulls, "GLB: also collision hulls, named so that the engine finds them")
        ->check(CLI::IsMember({"godot", "unreal"}))
        ->type_name("ENGINE");
    command.add_flag("--rigid-bodies", files.rigid_bodies,
                     "GLB: also masses and hulls by KHR_physics_rigid_bodies, the draft of 2024");
    command.add_option("--density", files.density, "kg/m^3, of --rigid-bodies; the material's if not given")
        ->check(CLI::PositiveNumber);
    command
        .add_option("--interior-texture", files.interior_texture,
                    "An image for the cuts, repeated every metre (PNG or JPEG)")
        ->type_name("FILE");
}

void add_state_export(CLI::App& command, StateExport& pieces) {
    command
        .add_option(
            "--export", pieces.files.output,
            "Also write the pieces of the last moment, as blows have cut them by then: .glb, .obj, .ply or .stl")
        ->check(has_exportable_ending)
        ->type_name("FILE");
    command.add_option("--export-as", pieces.as, "lie: turned and moved as they lie; made: where they were cut")
        ->check(CLI::IsMember({"lie", "made"}))
        ->type_name("HOW")
        ->capture_default_str();
    add_export_options(command, pieces.files);
}

void add_profile(CLI::App& app, std::function<int()>& run) {
    static ProfileCommand command;
    ProfilePlan& plan = command.plan;
    auto* profile = app.add_subcommand(
        "profile", "Measure fractures and the frames around them; compare with an earlier run; write a time line");
    // First, so that options on the command line outdo it.
    profile
        ->add_option_function<std::string>(
            "--scenarios", [&plan](const std::string& file) { read_profile_plan(file, plan); },
            "What to measure, from a file (assets/profile.schema.json); for what it leaves open the command line is "
            "asked")
        ->type_name("FILE.json");
    add_fracture_options(*profile, command.fracture);
    profile->add_option("--meshes", command.lists.meshes, "Several meshes instead of MESH")
        ->delimiter(',')
        ->allow_extra_args(false)
        ->excludes("mesh")
        ->type_name("MESH,MESH,...");
    profile->add_option("--counts", command.lists.counts, "Several numbers of sites instead of --pieces")
        ->check(CLI::Range(1u, 1'000'000u))
        ->delimiter(',')
        ->allow_extra_args(false)
        ->excludes("--pieces")
        ->excludes("--piece-size")
        ->type_name("N,N,...");
    profile
        ->add_option(
            "--classify", command.lists.classify,
            "Where vertices and triangles are classified: cpu, gpu (the Vulkan device, even if that is a CPU), "
            "auto (whichever a few trials find faster) or several of them")
        ->check(CLI::IsMember({"auto", "cpu", "gpu"}))
        ->delimiter(',')
        ->allow_extra_args(false)
        ->type_name("WHERE,...")
        ->default_str("cpu");
    profile->add_option("--warm-up", plan.warm_up, "Fractures before those that are measured")
        ->check(CLI::Range(0u, 10'000u))
        ->capture_default_str();
    profile->add_option("--repeats", plan.repeats, "Measured fractures")
        ->check(CLI::Range(1u, 10'000u))
        ->capture_default_str();
    profile
        ->add_option("--frames", plan.frames,
                     "Measured frames before the fracture and as many after it; 0 for none, without a device")
        ->check(CLI::Range(0u, 100'000u))
        ->capture_default_str();
    profile->add_flag("--json", command.json, "Print JSON instead of a table");
    profile->add_option("-o,--output", command.output, "Also write the JSON to FILE")->type_name("FILE.json");
    profile->add_option("--csv", command.csv, "Also write a line a phase")->type_name("FILE.csv");
    profile->add_option("--trace", command.trace, "Also write a time line that Perfetto (ui.perfetto.dev) shows")
        ->type_name("FILE.json");
    auto* compare = profile->add_option("--compare", command.compare, "Compare with a profile that -o wrote earlier")
                        ->type_name("OLD.json");
    profile
        ->add_option("--threshold", command.threshold,
                     "What --compare calls slower: median and minimum more than this many times the old ones")
        ->check(CLI::Range(1.0, 1000.0))
        ->needs(compare)
        ->capture_default_str();
    add_view_options(*profile, command.view);
    profile->footer("Ends with 7 where --compare finds a fracture's total, or the frames before or after it, slower.");
    profile->callback([&run] { run = [] { return run_profile(command); }; });
}

void add_record_option(CLI::App& command, std::string& file) {
    command.add_option("--record", file, "Also write a log of what happens, for `brittle replay`")
        ->type_name("FILE.log");
}

void add_replay(CLI::App& app, std::function<int()>& run) {
    static ReplayCommand command;
    auto* replay =
        app.add_subcommand("replay", "Repeat a recorded run without a display and compare the state after each step");
    replay->add_option("log", command.log, "What --record wrote")->required()->type_name("FILE.log");
    replay->add_option("--render", command.pictures, "Also draw it: %04d stands for the frame's number")
        ->type_name("FILE_%04d.png");
    replay->add_option("--every", command.every, "Write every so many-th frame, 60 a second")
        ->check(CLI::Range(1u, 100'000u))
        ->capture_default_str();
    replay->add_option("--video", command.video, "Also draw it as a video, by the program ffmpeg")
        ->type_name("FILE.mp4");
    replay->add_option("--threads", command.threads, "Worker threads; 0 is one a core. Never changes the result")
        ->check(CLI::Range(0u, 1024u))
        ->capture_default_str();
    add_state_export(*replay, command.pieces);
    replay->get_option("--export")
        ->excludes("--render")
        ->excludes("--video"); // frames may go beyond the log's last step
    add_view_options(*replay, command.view);
    replay->footer("Ends with 0 where all states are those recorded, with 8 where one is not.");
    replay->callback([&run] { run = [] { return run_replay(command); }; });
}

void add_commands(CLI::App& app, std::function<int()>& run) {
    static FractureCommand fracture_command;
    auto* fracture = app.add_subcommand("fracture", "Break a mesh and write the pieces: GLB, OBJ, PLY or STL");
    add_fracture_options(*fracture, fracture_command.fracture);
    fracture
        ->add_option("-o,--output", fracture_command.files.output,
                     "The file to write; its ending says the format: .glb, .obj (with .mtl), .ply or .stl")
        ->required()
        ->check(has_exportable_ending)
        ->type_name("FILE");
    add_export_options(*fracture, fracture_command.files);
    add_classify_option(*fracture, fracture_command.classify);
    fracture->add_option("--report", fracture_command.report, "Also write counts, proof and times as JSON")
        ->type_name("FILE.json");
    fracture->callback([&run] { run = [] { return run_fracture(fracture_command); }; });

    static InspectCommand inspect_command;
    auto* inspect =
        app.add_subcommand("inspect", "Say what is the matter with a mesh, and what fracture will do with it");
    inspect->add_option("mesh", inspect_command.mesh, mesh_help())->required()->type_name("MESH");
    inspect->add_flag("--json", inspect_command.json, "As JSON");
    inspect
        ->add_option("--marks", inspect_command.marks, "Also write the mesh with what was found marked, for any viewer")
        ->type_name("FILE.glb");
    inspect->add_option("--picture", inspect_command.picture, "Also draw the mesh with what was found marked")
        ->type_name("FILE.png");
    add_view_options(*inspect, inspect_command.view);
    inspect->footer("Ends with 0 where the mesh can be fractured, with 4 where it cannot.");
    inspect->callback([&run] { run = [] { return run_inspect(inspect_command); }; });

    static RepairCommand repair_command;
    auto* repair =
        app.add_subcommand("repair", "Mend a mesh: weld cracks, drop what is double, turn, close holes, split");
    repair->add_option("mesh", repair_command.mesh, mesh_help())->required()->type_name("MESH");
    repair->add_option("-o,--output", repair_command.output, "The file to write: .glb, .obj, .ply or .stl")
        ->required()
        ->check(has_exportable_ending)
        ->type_name("FILE");
    repair
        ->add_option(
            "--weld", repair_command.settings.weld_distance,
            "Metres; vertices on the rims of holes this close become one. A millionth of the size if not given")
        ->check(CLI::NonNegativeNumber);
    repair
        ->add_option("--close-holes", repair_command.settings.close_holes,
                     "Metres; only rims up to this length are closed")
        ->check(CLI::NonNegativeNumber);
    repair->add_flag("--cavities", repair_command.settings.cavities,
                     "A part wholly inside another becomes a cavity of it, whichever way it faces");
    repair->add_flag("--overlaps", repair_command.settings.covered_parts,
                     "Parts wholly inside others go, so that space counts once; parts that cross stay");
    repair->footer(
        "Ends with 0 where the result can be fractured, with 4 where it cannot. A sound mesh is not changed.");
    repair->callback([&run] { run = [] { return run_repair(repair_command); }; });

    static RenderCommand render_command;
    auto* render = app.add_subcommand("render", "Break a mesh, let it fall and write pictures; needs no display");
    add_fracture_options(*render, render_command.fracture);
    PictureOptions& picture = render_command.fracture.picture;
    render->add_option("--frames", picture.frames, "Frames to simulate after the first picture, 60 a second")
        ->check(CLI::Range(0u, 100'000u))
        ->capture_default_str();
    render->add_option("--every", render_command.every, "Write every so many-th frame")
        ->check(CLI::Range(1u, 100'000u))
        ->capture_default_str();
    render
        ->add_option(
            "-o,--output", render_command.output,
            "Where to: %04d stands for the frame's number; without it one picture is written, of the last frame")
        ->type_name("FILE_%04d.png")
        ->capture_default_str();
    render->add_flag("--whole", picture.whole, "Draw the unbroken mesh at rest");
    render->add_option("--planes", picture.planes, "Only cut the cell of the first site out, by so many of its planes");
    render
        ->add_option("--explode", picture.explode,
                     "Draw the pieces moved apart, by this share of their distance to the middle")
        ->check(CLI::Range(0.0f, 10.0f))
        ->capture_default_str();
    render->add_flag("--show-sites", picture.sites, "Draw the sites as red spheres");
    render->add_flag("--show-hulls", picture.hulls, "Draw the collision hulls as red lines");
    render->add_flag("--smooth", picture.smooth, "Round exteriors instead of facets");
    render->add_flag("--wireframe", picture.wireframe, "Draw the edges of triangles");
    render->add_flag("--show-cells", picture.cells, "Draw the edges of the Voronoi cells as blue lines");
    render->add_option("--azimuth", picture.azimuth, "Degrees of the camera, from +Z towards +X")
        ->capture_default_str();
    render->add_option("--elevation", picture.elevation, "Degrees of the camera above the ground")
        ->check(CLI::Range(-89.0f, 89.0f))
        ->capture_default_str();
    render->add_option("--distance", picture.distance, "Of the camera; 1 shows the mesh, the ground and some room")
        ->check(CLI::Range(0.1f, 10.0f))
        ->capture_default_str();
    render
        ->add_option(
            "--video", render_command.video,
            "Also write all frames as a video, by the program ffmpeg; without -o no pictures then, nor with --export")
        ->type_name("FILE.mp4");
    add_record_option(*render, render_command.record);
    render
        ->add_option("--ids", render_command.ids,
                     "Also write which piece each pixel shows, one colour a piece, as a PNG beside each picture; "
                     "docs/files.md says how to read it")
        ->type_name("FILE.png");
    render
        ->add_option("--graph", render_command.graph, "Also write the frame graph of the last picture, for `dot -Tsvg`")
        ->type_name("FILE.dot");
    add_state_export(*render, render_command.pieces);
    add_world_options(*render, render_command.fracture.world);
    add_classify_option(*render, render_command.classify);
    add_view_options(*render, render_command.view);
    render->callback([&run, render] {
        const bool other = !render_command.video.empty() || !render_command.pieces.files.output.empty();
        if (other && render->count("--output") == 0) render_command.output.clear();
        run = [] { return run_render(render_command); };
    });

    add_replay(app, run);

    static DemoCommand demo_command;
    auto* demo = app.add_subcommand(
        "demo", "A window to break meshes in: tools, panels, preview (Space breaks, H lists all keys)");
    demo_command.fracture.mesh = "shape:animal";
    add_fracture_options(*demo, demo_command.fracture);
    demo->get_option("mesh")->capture_default_str();
    add_world_options(*demo, demo_command.fracture.world);
    demo->add_option("--ui-scale", demo_command.ui_scale,
                     "Of text and panels: 2 on a display of high density; asks the display if not given")
        ->check(CLI::Range(0.5, 4.0));
    add_classify_option(*demo, demo_command.classify);
    add_record_option(*demo, demo_command.record);
    add_view_options(*demo, demo_command.view);
    demo->callback([&run] { run = [] { return run_demo(demo_command); }; });

    add_profile(app, run);
}

// What to say where the first word is no command. Empty where it is one.
std::string unknown_command(const CLI::App& app, int argc, char** argv) {
    if (argc < 2 || argv[1][0] == '-') return "";
    std::string known;
    for (const CLI::App* command : app.get_subcommands([](const CLI::App*) { return true; })) {
        if (command->get_name() == argv[1]) return "";
        known += (known.empty() ? "" : ", ") + command->get_name();
    }
    return "there is no command " + fracture::quoted(std::string_view(argv[1])) + "; there are: " + known;
}

int run(int argc, char** argv) {
    CLI::App app(description, "brittle");
    app.set_version_flag("--version", "brittle " BRITTLE_VERSION);
    app.require_subcommand(1);
    app.footer(exit_codes_help);
    std::function<int()> command;
    add_commands(app, command);
    if (argc < 2) {
        std::fputs(app.help().c_str(), stderr);
        return exit_usage;
    }
    if (const std::string unknown = unknown_command(app, argc, argv); !unknown.empty())
        throw Failure(exit_usage, unknown);
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
