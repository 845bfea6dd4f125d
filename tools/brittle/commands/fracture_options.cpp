#include <memory>

#include "tools/brittle/commands/command_line.h"
#include "tools/brittle/commands/option_groups.h"

namespace brittle::tools {

void add_fracture(CLI::App& app, Run& run) {
    const auto command = std::make_shared<FractureCommand>();
    CLI::App& fracture = *app.add_subcommand(
        "fracture", "Break a mesh, or each object of a scene, and write the pieces to GLB, OBJ, PLY or STL");
    add_fracture_options(fracture, command->fracture);
    start_group(fracture, "Mesh and recipe");
    add_format_option(fracture, command->fracture.format);
    start_group(fracture, "Output");
    add_output_options(fracture, command->files.output, command->files.stream,
                       "File for the pieces. Its ending gives the format: .glb, .obj (with .mtl), .ply or .stl.");
    fracture.add_option("--report", command->report, "JSON file for counts, certificate and times")
        ->type_name("FILE.json");
    add_export_options(fracture, command->fracture.exports);
    start_group(fracture, "Threads and devices");
    add_threads_option(fracture, command->fracture.threads);
    add_classify_option(fracture, command->classify);
    add_general_options(fracture, &command->json);
    fracture.footer("Examples:\n"
                    "  brittle fracture bunny.obj -n 100 -o pieces.glb\n"
                    "  brittle fracture vase.glb --material ceramic --hulls unreal -o pieces.glb\n"
                    "  brittle fracture wall.stl --strike 0,1,0,0.3 --repair -o pieces.obj\n"
                    "  brittle fracture bunny.obj -n 100 --save-recipe bunny.json -o pieces.glb\n"
                    "  brittle fracture bunny.json --seed 2 -o others.glb\n"
                    "  brittle fracture room.json -o room_in_pieces.glb\n"
                    "  curl -s https://example.org/bunny.obj | brittle fracture - -o - --quiet > pieces.glb\n"
                    "  brittle fracture bunny.obj -o pieces.glb --json | jq .volume_error");
    fracture.callback([&run, &fracture, command] {
        check_standard_input(fracture, command->fracture.mesh);
        settle_output(fracture, command->files.output, command->files.stream, command->json);
        command->files = settle_export(fracture, command->fracture.exports, command->files, "--output");
        run = [command] { return run_fracture(*command); };
    });
}

} // namespace brittle::tools
