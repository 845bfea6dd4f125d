#include <memory>

#include "tools/brittle/commands/command_line.h"
#include "tools/brittle/commands/option_groups.h"
#include "tools/brittle/commands/option_values.h"

namespace brittle::tools {

void add_repair(CLI::App& app, Run& run) {
    const auto command = std::make_shared<RepairCommand>();
    CLI::App& repair = *app.add_subcommand(
        "repair", "Repair a mesh: weld cracks, drop duplicates, orient faces, close holes, split non-manifold edges");
    start_group(repair, "Mesh");
    repair.add_option("mesh", command->mesh, mesh_help())->required()->type_name("MESH");
    add_format_option(repair, command->format);
    start_group(repair, "Output");
    add_output_options(repair, command->output, command->stream,
                       "File for the repaired mesh: .glb, .obj, .ply or .stl.");
    start_group(repair, "Repair");
    repair
        .add_option("--weld", command->settings.weld_distance,
                    "Distance within which vertices on the rims of holes are merged, metres. The default is a "
                    "millionth of the mesh's size.")
        ->check(non_negative_number());
    repair
        .add_option("--close-holes", command->settings.close_holes,
                    "Maximum length of the rim of a hole that is closed, metres. By default all holes are closed.")
        ->check(non_negative_number());
    using Remesh = fracture::RepairSettings::Remesh;
    repair
        .add_option_function<std::string>(
            "--remesh-holes",
            [command](const std::string& how) {
                command->settings.remesh_holes = how == "flat" ? Remesh::flat : Remesh::smooth;
            },
            "Give the fills of holes new vertices, as dense as the surface around. flat: in the plane of each triangle "
            "of the fill. smooth: so that the curvature around goes on.")
        ->check(CLI::IsMember({"flat", "smooth"}))
        ->type_name("HOW");
    repair.add_flag("--cavities", command->settings.cavities,
                    "Make each part that lies wholly inside another a cavity of it, whichever way it faces");
    repair.add_flag("--overlaps", command->settings.covered_parts,
                    "Remove parts that lie wholly inside others, so that space counts once. Parts that cross stay.");
    repair.add_flag("--unite", command->unite,
                    "Unite parts that pass through each other: the result is the surface around all of them, without "
                    "walls inside. A surface that passes through itself is united, too.");
    add_general_options(repair, nullptr);
    repair.footer(
        "The exit code is 0 if the result can be fractured, and 4 if it cannot. A sound mesh stays as it is.\n\n"
        "Examples:\n"
        "  brittle repair scan.stl -o sound.glb\n"
        "  brittle repair scan.stl --weld 0.001 --remesh-holes smooth -o sound.ply\n"
        "  brittle repair --unite rifle.obj -o one.glb\n"
        "  brittle repair - -o - < scan.ply | brittle fracture - -n 50 -o pieces.glb");
    repair.callback([&run, &repair, command] {
        check_standard_input(repair, command->mesh);
        settle_output(repair, command->output, command->stream, false);
        run = [command] { return run_repair(*command); };
    });
}

} // namespace brittle::tools
