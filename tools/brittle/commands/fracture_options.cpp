#include <memory>

#include "tools/brittle/commands/command_line.h"
#include "tools/brittle/commands/option_groups.h"

namespace brittle::tools {

void add_fracture(CLI::App& app, Run& run) {
    const auto command = std::make_shared<FractureCommand>();
    CLI::App& fracture = *app.add_subcommand("fracture", "Break a mesh and write the pieces to GLB, OBJ, PLY or STL");
    add_fracture_options(fracture, command->fracture);
    fracture
        .add_option("-o,--output", command->files.output,
                    "File for the pieces. Its ending gives the format: .glb, .obj (with .mtl), .ply or .stl.")
        ->required()
        ->check(check_export_ending)
        ->type_name("FILE");
    add_export_options(fracture, command->fracture.exports);
    add_classify_option(fracture, command->classify);
    fracture.add_option("--report", command->report, "JSON file for counts, certificate and times")
        ->type_name("FILE.json");
    fracture.callback([&run, &fracture, command] {
        command->files = settle_export(fracture, command->fracture.exports, command->files.output, "--output");
        run = [command] { return run_fracture(*command); };
    });
}

} // namespace brittle::tools
