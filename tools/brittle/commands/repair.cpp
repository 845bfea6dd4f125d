#include "fracture/doctor/repair.h"
#include "fracture/doctor/inspect.h"
#include "fracture/io/export.h"
#include "tools/brittle/base/console.h"
#include "tools/brittle/commands/commands.h"
#include "tools/brittle/stage/loading.h"
#include "tools/brittle/stage/standard_streams.h"
#include "tools/scenario/base/failure.h"

namespace brittle::tools {

int run_repair(const RepairCommand& command) {
    if (!command.stream.empty()) {
        if (command.stream != "obj") refuse_terminal_output();
        keep_standard_output_for_data();
    }
    Input input = load_mesh_only(command.mesh, true, program_host(), command.format);
    for (const std::string& note : input.model.notes) tell("%s: %s", input.name.c_str(), note.c_str());
    fracture::Repaired repaired = fracture::repair(input.model.mesh, command.settings);
    const std::string done = fracture::describe(repaired.report);
    print_report("%s\n%s", input.name.c_str(), done.empty() ? "nothing to repair\n" : done.c_str());
    if (repaired.mesh.triangles.empty())
        throw Failure(exit_mesh, input.name
                                     + ": no triangle is left, so no file is written. Weld cracks first: "
                                       "give --weld the width of the widest crack");
    fracture::replace_mesh(input.model, std::move(repaired.mesh), repaired.source_triangle);
    if (command.unite) {
        const std::string united = fracture::describe(unite_parts(input.model, input.name));
        print_report("%s", united.empty() ? "nothing to unite\n" : united.c_str());
    }
    if (command.stream.empty())
        must(fracture::export_model(command.output, input.model, input.name));
    else
        write_standard_output(
            must(fracture::export_model_to_memory("mesh." + command.stream, input.model, input.name, true))
                .front()
                .bytes);
    const fracture::Inspection inspection = fracture::inspect(input.model.mesh);
    print_report("written to %s\n%s", command.stream.empty() ? command.output.c_str() : "standard output",
                 fracture::describe(inspection).c_str());
    return inspection.refusal ? exit_mesh : exit_success;
}

} // namespace brittle::tools
