#include <memory>

#include "tools/brittle/commands/command_line.h"
#include "tools/brittle/commands/option_groups.h"

namespace brittle::tools {

void add_inspect(CLI::App& app, Run& run) {
    const auto command = std::make_shared<InspectCommand>();
    CLI::App& inspect = *app.add_subcommand(
        "inspect", "Report the faults of a mesh and whether it can be fractured; list the objects of a scene");
    inspect.add_option("mesh", command->mesh, mesh_help() + ", or a scene (.json)")->required()->type_name("MESH");
    inspect.add_flag("--json", command->json, "Print JSON instead of text");
    inspect.add_option("--marks", command->marks, "File for the mesh with all faults marked, for any viewer")
        ->type_name("FILE.glb");
    inspect.add_option("--picture", command->picture, "File for a picture of the mesh with all faults marked")
        ->type_name("FILE.png");
    add_view_options(inspect, command->view);
    inspect.footer(
        "The exit code is 0 if the mesh, or all that should break in the scene, can be fractured, and 4 if not.");
    inspect.callback([&run, command] { run = [command] { return run_inspect(*command); }; });
}

} // namespace brittle::tools
