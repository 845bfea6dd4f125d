#include <cstdio>

#include "fracture/doctor/inspect.h"
#include "fracture/doctor/repair.h"
#include "fracture/io/export.h"
#include "tools/brittle/commands/commands.h"
#include "tools/scenario/base/failure.h"

namespace brittle::tools {

int run_repair(const RepairCommand& command) {
    Input input = load_mesh_only(command.mesh, true);
    for (const std::string& note : input.model.notes)
        std::fprintf(stderr, "brittle: %s: %s\n", input.name.c_str(), note.c_str());
    fracture::Repaired repaired = fracture::repair(input.model.mesh, command.settings);
    const std::string done = fracture::describe(repaired.report);
    std::printf("%s\n%s", input.name.c_str(), done.empty() ? "nothing to repair\n" : done.c_str());
    if (repaired.mesh.triangles.empty())
        throw Failure(exit_mesh, input.name
                                     + ": no triangle is left, so no file is written. Weld cracks first: "
                                       "give --weld the width of the widest crack");
    fracture::replace_mesh(input.model, std::move(repaired.mesh), repaired.source_triangle);
    if (command.unite) {
        const std::string united = fracture::describe(unite_parts(input.model, input.name));
        std::printf("%s", united.empty() ? "nothing to unite\n" : united.c_str());
    }
    must(fracture::export_model(command.output, input.model, input.name));
    const fracture::Inspection inspection = fracture::inspect(input.model.mesh);
    std::printf("written to %s\n%s", command.output.c_str(), fracture::describe(inspection).c_str());
    return inspection.refusal ? exit_mesh : exit_success;
}

} // namespace brittle::tools
