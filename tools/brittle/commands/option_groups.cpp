#include "tools/brittle/commands/option_groups.h"

#include <algorithm>
#include <cstdio>
#include <filesystem>
#include <utility>
#include <vector>

#include "fracture/io/export.h"
#include "tools/brittle/commands/option_values.h"
#include "tools/scenario/recipe/piece_export.h"

namespace brittle::tools {

void add_view_options(CLI::App& command, ViewOptions& view) {
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
        .add_option("--device", view.device,
                    "Vulkan device: cpu, gpu, an index or a part of its name. The default is the best device.")
        ->type_name("DEVICE");
    command
        .add_option("--quality", view.quality,
                    "auto: as the device can afford. fast: hard shadows, no antialiasing. best: antialiasing, soft "
                    "shadows, ambient occlusion.")
        ->check(CLI::IsMember({"auto", "fast", "best"}))
        ->type_name("NAME")
        ->capture_default_str();
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
    auto* per_piece =
        command.add_flag("--per-piece", files.per_piece,
                         "Write one file for each piece: FILE_000, FILE_001, ... The default for .stl, which does not "
                         "tell pieces apart.");
    command.add_flag("--one-file", files.one_file, "Write all pieces to one file, also in .stl")->excludes(per_piece);
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

std::function<bool(const std::string& option)> given_options(const CLI::App& command) {
    return [&command](const std::string& option) { return command.count(option) > 0; };
}

ExportSettings settle_export(const CLI::App& command, const ExportSettings& settings, const std::string& output,
                             const std::string& output_option) {
    ExportSettings files = settings;
    files.output = output;
    std::vector<std::string> notes;
    files = effective_export(std::move(files), output_option, given_options(command), notes);
    for (const std::string& note : notes) std::fprintf(stderr, "brittle: %s\n", note.c_str());
    return files;
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
