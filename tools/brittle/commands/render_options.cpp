#include <memory>
#include <utility>

#include "tools/brittle/commands/command_line.h"
#include "tools/brittle/commands/option_groups.h"
#include "tools/brittle/commands/option_values.h"
#include "tools/scenario/base/failure.h"

namespace brittle::tools {

namespace {

// The contents of a picture, as in the "picture" of a recipe.
void add_picture_options(CLI::App& render, PictureOptions& picture) {
    start_group(render, "Pictures");
    render.add_flag("--whole", picture.whole, "Draw the unbroken mesh at rest");
    render.add_option("--planes", picture.planes,
                      "Cut out only the cell of the first site, by this many of its planes");
    render
        .add_option("--explode", picture.explode,
                    "Distance by which pieces are drawn apart, as a share of their distance from the middle")
        ->check(number_from(0.0, 10.0))
        ->capture_default_str();
    render
        .add_option("--dust", picture.dust,
                    "Share of the dust and splinters of breaks that is drawn: 1 all, 0 none. They move no piece.")
        ->check(number_from(0.0, 1.0))
        ->capture_default_str();
    render.add_flag("--show-sites", picture.sites, "Draw the sites as red spheres");
    render.add_flag("--show-hulls", picture.hulls, "Draw the collision hulls as red lines");
    render
        .add_option_function<std::string>(
            "--colors",
            [&picture](const std::string& name) {
                picture.colours = name == "pieces" ? PieceColours::pieces : PieceColours::materials;
            },
            "Colours of the pieces: one for each piece, or the materials and textures of the mesh with a grain in the "
            "cuts. The default is materials where the mesh has some.")
        ->check(CLI::IsMember({"pieces", "materials"}))
        ->type_name("BY");
    render.add_flag("--smooth", picture.smooth, "Shade exteriors smoothly instead of by facets");
    render.add_flag("--wireframe", picture.wireframe, "Draw the edges of triangles");
    render.add_flag("--show-cells", picture.cells, "Draw the edges of the Voronoi cells as blue lines");
    render.add_option("--azimuth", picture.azimuth, "Azimuth of the camera, degrees from +Z towards +X")
        ->check(finite_number())
        ->capture_default_str();
    render.add_option("--elevation", picture.elevation, "Elevation of the camera above the ground, degrees")
        ->check(number_from(-89.0, 89.0))
        ->capture_default_str();
    render
        .add_option("--distance", picture.distance,
                    "Distance of the camera. 1 shows the mesh, the ground and some room around them.")
        ->check(number_from(0.1, 10.0))
        ->capture_default_str();
}

void add_frame_options(CLI::App& render, RenderCommand& command) {
    start_group(render, "Output");
    render
        .add_option("--frames", command.fracture.picture.frames,
                    "Number of frames to simulate after the first picture, at 60 per second")
        ->check(number_from(0, 100'000))
        ->capture_default_str();
    render.add_option("--every", command.fracture.picture.every, "Interval between the frames that are written")
        ->check(number_from(1, 100'000))
        ->capture_default_str();
    render
        .add_option("-o,--output", command.output,
                    "Name of the pictures. %04d stands for the number of the frame; a name without it gives one "
                    "picture, of the last frame.")
        ->type_name("FILE_%04d.png")
        ->capture_default_str();
}

void add_other_outputs(CLI::App& render, RenderCommand& command) {
    start_group(render, "Output");
    render
        .add_option("--video", command.video,
                    "File for a video of all frames, made by the program ffmpeg. With --video or --export, pictures "
                    "are written only if -o is given.")
        ->type_name("FILE.mp4");
    add_record_option(render, command.record);
    render
        .add_option("--ids", command.ids,
                    "PNG file, beside each picture, for the piece that each pixel shows, one colour per piece "
                    "(docs/files.md)")
        ->type_name("FILE.png");
    render.add_option("--graph", command.graph, "File for the frame graph of the last picture, for `dot -Tsvg`")
        ->type_name("FILE.dot");
    add_state_export(render, command.pieces.output, command.fracture.exports);
}

// Size and quality are those of the command line, else those of the recipe, which keeps them.
void settle_view(const CLI::App& render, PictureOptions& picture, ViewOptions& view) {
    if (render.count("--size") > 0) {
        picture.width = view.width;
        picture.height = view.height;
    } else if (picture.width > 0) {
        view.width = picture.width;
        view.height = picture.height;
    }
    if (render.count("--quality") > 0)
        picture.quality = view.quality;
    else if (!picture.quality.empty())
        view.quality = picture.quality;
}

// Pictures show the interior texture, too, so it has an effect without --export.
void settle_pieces(const CLI::App& render, RenderCommand& command) {
    ExportSettings exports = command.fracture.exports;
    std::string& shown = command.fracture.picture.interior_texture;
    if (render.count("--interior-texture") > 0 || shown.empty()) shown = exports.interior_texture;
    const std::string output = command.pieces.output;
    if (!output.ends_with(".glb") && !output.ends_with(".obj")) exports.interior_texture.clear();
    command.pieces = settle_export(render, exports, {.output = output}, "--export");
}

} // namespace

void add_render(CLI::App& app, Run& run) {
    const auto command = std::make_shared<RenderCommand>();
    CLI::App& render =
        *app.add_subcommand("render", "Break a mesh, simulate the pieces and write pictures. Needs no display.");
    add_fracture_options(render, command->fracture);
    add_pieces_option(render, command->fracture);
    add_format_option(render, command->fracture.format);
    add_frame_options(render, *command);
    add_picture_options(render, command->fracture.picture);
    add_other_outputs(render, *command);
    add_world_options(render, command->fracture.world);
    add_view_options(render, command->view);
    add_threads_option(render, command->fracture.threads);
    add_classify_option(render, command->classify);
    add_general_options(render, &command->json);
    render.footer(
        "Examples:\n"
        "  brittle render bunny.obj -n 50 -o fall_%04d.png\n"
        "  brittle render shape:wall --material brick --bonded --anchored --shot 0,0.8,4,0,1,-30,0.15 --video "
        "hit.mp4\n"
        "  brittle render vase.glb --material ceramic --breakable --export rubble.glb\n"
        "  brittle render assets/worlds/room_with_a_view.json -o room_%03d.png --quality best\n"
        "  brittle render bunny.obj --record run.log --export end.glb --json");
    render.callback([&run, &render, command] {
        check_standard_input(render, command->fracture.mesh);
        const bool has_other_output = !command->video.empty() || !command->pieces.output.empty();
        if (has_other_output && render.count("--output") == 0) command->output.clear();
        settle_view(render, command->fracture.picture, command->view);
        settle_pieces(render, *command);
        if (render.count("--name") > 0 && is_scene(command->fracture)) refuse_name_of_scene();
        run = [command] {
            command->fracture = scene_of_pieces(std::move(command->fracture));
            return run_render(*command);
        };
    });
}

} // namespace brittle::tools
