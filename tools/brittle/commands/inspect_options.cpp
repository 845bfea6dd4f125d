#include <memory>

#include "tools/brittle/commands/command_line.h"
#include "tools/brittle/commands/option_groups.h"

namespace brittle::tools {

void add_inspect(CLI::App& app, Run& run) {
    const auto command = std::make_shared<InspectCommand>();
    CLI::App& inspect = *app.add_subcommand(
        "inspect", "Report the faults of a mesh and whether it can be fractured; list the objects of a scene");
    start_group(inspect, "Mesh");
    inspect.add_option("mesh", command->mesh, mesh_help() + ", or a scene (.json)")->required()->type_name("MESH");
    add_format_option(inspect, command->format);
    start_group(inspect, "Output");
    inspect.add_option("--marks", command->marks, "File for the mesh with all faults marked, for any viewer")
        ->type_name("FILE.glb");
    inspect.add_option("--picture", command->picture, "File for a picture of the mesh with all faults marked")
        ->type_name("FILE.png");
    add_view_options(inspect, command->view);
    add_general_options(inspect, &command->json);
    inspect.footer(
        "The exit code is 0 if the mesh, or all that should break in the scene, can be fractured, and 4 if not.\n\n"
        "Examples:\n"
        "  brittle inspect bunny.obj\n"
        "  brittle inspect scan.stl --marks faults.glb --picture faults.png\n"
        "  brittle inspect scan.stl --quiet && echo sound\n"
        "  brittle inspect - --format obj < scan.obj");
    inspect.callback([&run, &inspect, command] {
        check_standard_input(inspect, command->mesh);
        run = [command] { return run_inspect(*command); };
    });
}

} // namespace brittle::tools
