#include "tools/brittle/commands/option_groups.h"

#include <algorithm>
#include <filesystem>
#include <utility>
#include <vector>

#include "fracture/io/export.h"
#include "fracture/io/import.h"
#include "tools/brittle/base/console.h"
#include "tools/brittle/commands/option_values.h"
#include "tools/brittle/stage/standard_streams.h"
#include "tools/scenario/base/failure.h"
#include "tools/scenario/recipe/piece_export.h"

namespace brittle::tools {

namespace {

// "glb", "obj" ... of a list of endings.
std::vector<std::string> formats_of(const std::vector<std::string>& extensions) {
    std::vector<std::string> formats;
    for (const std::string& extension : extensions) formats.push_back(extension.substr(1));
    return formats;
}

} // namespace

void start_group(CLI::App& command, const std::string& heading) {
    command.option_defaults()->group(heading);
}

void add_format_option(CLI::App& command, std::string& format) {
    command
        .add_option("--format", format,
                    "Format of the mesh on standard input (MESH is -). By default its first bytes tell it.")
        ->check(CLI::IsMember(formats_of(fracture::importable_extensions())))
        ->type_name("FORMAT");
}

void check_standard_input(const CLI::App& command, const std::string& mesh) {
    if (mesh != standard_stream) {
        if (command.count("--format") > 0)
            throw Failure(exit_usage, "--format: the ending of a file gives its format; only the mesh - needs one");
        return;
    }
    for (const char* option : {"--save-recipe", "--record"})
        if (command.get_option_no_throw(option) && command.count(option) > 0)
            throw Failure(exit_usage, std::string(option)
                                          + ": the file would have to name the mesh, which is on standard input; write "
                                            "the mesh to a file and give its name");
}

void refuse_standard_input(const CLI::App& command, const std::string& mesh) {
    if (mesh == standard_stream)
        throw Failure(exit_usage,
                      "brittle " + command.get_name()
                          + " reads no mesh from standard input; write the mesh to a file and give its name");
}

void add_general_options(CLI::App& command, bool* json) {
    start_group(command, "General");
    command.add_flag_callback(
        "-q,--quiet", [] { set_quiet(true); },
        std::string("Print errors only: no report, no notes, no progress")
            + (json ? ". --json prints its JSON nevertheless." : ""));
    if (json) command.add_flag("--json", *json, "Print JSON instead of text");
    command.set_help_flag(); // so that it is the last one
    command.set_help_flag("-h,--help", "Print this help");
}

void add_view_options(CLI::App& command, ViewOptions& view) {
    start_group(command, "Pictures");
    const auto set_size = [&view](const std::string& text) {
        const glm::uvec2 size = parse_size(text);
        view.width = size.x;
        view.height = size.y;
    };
    command
        .add_option_function<std::string>("--size", set_size, "Size of pictures, or of the window of `demo`, in pixels")
        ->type_name("WIDTHxHEIGHT")
        ->default_str("1280x720");
    command
        .add_option("--quality", view.quality,
                    "auto: as the device can afford. fast: hard shadows, no antialiasing. best: antialiasing, soft "
                    "shadows, ambient occlusion.")
        ->check(CLI::IsMember({"auto", "fast", "best"}))
        ->type_name("NAME")
        ->capture_default_str();
    start_group(command, "Threads and devices");
    command
        .add_option("--device", view.device,
                    "Vulkan device: cpu, gpu, an index or a part of its name. The default is the best device.")
        ->type_name("DEVICE");
    command.add_flag("--validation", view.validation,
                     "Run under the Vulkan validation layer, and fail if it reports anything");
}

void add_threads_option(CLI::App& command, uint32_t& threads) {
    command
        .add_option("--threads", threads,
                    "Number of worker threads; 0 stands for one per core. The result does not depend on it.")
        ->check(number_from(0, 1024))
        ->capture_default_str();
}

void add_classify_option(CLI::App& command, std::string& processor) {
    command
        .add_option("--classify", processor,
                    "Processor that classifies vertices and triangles: cpu, gpu (the Vulkan device, even if it runs on "
                    "the CPU) or auto (the faster one in a few trials). The result does not depend on it.")
        ->check(CLI::IsMember({"auto", "cpu", "gpu"}))
        ->type_name("WHERE")
        ->capture_default_str();
}

void add_record_option(CLI::App& command, std::string& file) {
    command.add_option("--record", file, "File for a log of the run, which `brittle replay` repeats")
        ->type_name("FILE.log");
}

void add_export_options(CLI::App& command, ExportSettings& files) {
    start_group(command, "Contents of the files of pieces");
    command
        .add_option("--name", files.name,
                    "Name of the object in a GLB or OBJ file; its pieces are NAME_000, NAME_001, ... The default is "
                    "the name of the mesh.")
        ->check([](const std::string& name) {
            if (name.empty()) return std::string("'' is no name; leave the option out for the name of the mesh");
            const std::string refusal = refusal_of_name(name);
            return refusal.empty() ? refusal : "the text is " + refusal;
        })
        ->type_name("NAME");
    // Each overrides the other one of a recipe.
    const auto split = [&files](bool per_piece) {
        files.per_piece = per_piece;
        files.one_file = !per_piece;
    };
    auto* per_piece = command.add_flag_callback(
        "--per-piece", [split] { split(true); },
        "Write one file for each piece: FILE_000, FILE_001, ... The default for .stl, which does not tell pieces "
        "apart.");
    command
        .add_flag_callback(
            "--one-file", [split] { split(false); }, "Write all pieces to one file, also in .stl")
        ->excludes(per_piece);
    command
        .add_option("--hulls", files.hulls,
                    "Name the nodes of a GLB file so that this engine makes bodies of the pieces. godot: rigid bodies. "
                    "unreal: collision hulls.")
        ->check(CLI::IsMember({"godot", "unreal"}))
        ->type_name("ENGINE");
    command.add_flag("--rigid-bodies", files.rigid_bodies,
                     "Add masses and collision hulls to a GLB file, by the draft of June 2026 of "
                     "KHR_physics_rigid_bodies");
    command
        .add_option("--hull-parts", files.hull_parts,
                    "Most hulls of one piece. A piece that is far from convex needs several. [16]")
        ->check(number_from(1, max_hull_parts))
        ->type_name("N");
    command
        .add_option("--density", files.density,
                    "Density for the masses of --rigid-bodies, kg/m^3. The default is the material's.")
        ->check(positive_number());
    command
        .add_option("--interior-texture", files.interior_texture,
                    "Image for the cut faces, repeated every metre (PNG or JPEG)")
        ->type_name("FILE");
}

void add_state_export(CLI::App& command, std::string& output, ExportSettings& pieces) {
    start_group(command, "Contents of the files of pieces");
    command
        .add_option("--export", output,
                    "File for the pieces at the end of the run, with all cuts made by blows: .glb, .obj, .ply or .stl")
        ->check(check_export_ending)
        ->type_name("FILE");
    command
        .add_option("--export-as", pieces.as,
                    "Pose of the pieces of --export. lie: as they lie at the end. made: where they were cut.")
        ->check(CLI::IsMember({"lie", "made"}))
        ->type_name("HOW")
        ->capture_default_str();
    add_export_options(command, pieces);
}

void refuse_name_of_scene() {
    throw Failure(exit_usage, "--name: the objects of a scene have names of their own");
}

std::function<bool(const std::string& option)> given_options(const CLI::App& command) {
    return [&command](const std::string& option) { return command.count(option) > 0; };
}

ExportSettings settle_export(const CLI::App& command, const ExportSettings& settings, const ExportSettings& files,
                             const std::string& output_option) {
    ExportSettings settled = settings;
    settled.output = files.output;
    settled.stream = files.stream;
    std::vector<std::string> notes;
    settled = effective_export(std::move(settled), output_option, given_options(command), notes);
    for (const std::string& note : notes) tell("%s", note.c_str());
    return settled;
}

void add_output_options(CLI::App& command, std::string& output, std::string& stream, const std::string& help) {
    command.add_option("-o,--output", output, help + " - is standard output; the report is then on standard error.")
        ->required()
        ->check(
            [](const std::string& file) { return file == standard_stream ? std::string() : check_export_ending(file); })
        ->type_name("FILE");
    command
        .add_option("--output-format", stream, "Format of the mesh on standard output (-o -). OBJ comes without MTL.")
        ->check(CLI::IsMember(formats_of(fracture::exportable_extensions())))
        ->type_name("FORMAT")
        ->default_str("glb");
}

void settle_output(const CLI::App& command, std::string& output, std::string& stream, bool json) {
    if (output != standard_stream) {
        if (!stream.empty())
            throw Failure(exit_usage, "--output-format: the ending of " + output
                                          + " gives the format; only the output - needs one");
        return;
    }
    if (json)
        throw Failure(exit_usage, "--json: standard output holds the mesh; give a file to --output"
                                      + std::string(command.get_option_no_throw("--report") ? " or --report" : ""));
    output.clear();
    if (stream.empty()) stream = "glb";
}

std::string check_export_ending(const std::string& file) {
    const auto& known = fracture::exportable_extensions();
    const std::string ending = std::filesystem::path(file).extension().string();
    if (std::find(known.begin(), known.end(), ending) != known.end()) return {};
    std::string list;
    for (const std::string& one : known) list += (list.empty() ? "" : ", ") + one;
    return "'" + file + "' does not end with one of " + list;
}

} // namespace brittle::tools
