#include <cstdio>
#include <span>

#include "fracture/io/atomic_file.h"
#include "fracture/io/export_glb.h"
#include "tools/brittle/commands.h"
#include "tools/brittle/failure.h"
#include "tools/brittle/interrupt.h"
#include "tools/brittle/progress.h"
#include "tools/brittle/recipe.h"
#include "tools/brittle/report.h"

namespace brittle::tools {

int run_fracture(const FractureCommand& command) {
    catch_interrupts();
    const Input input = load_input(command.fracture);
    const Broken broken = [&] {
        Progress progress("fracturing " + input.name);
        return break_input(input, command.fracture, [&](double share) { progress.update(share); });
    }();

    const std::string recipe = recipe_json(command.fracture);
    must(fracture::export_glb(command.output, broken.fragments, broken.certificate,
                              {.name = input.name, .recipe = recipe, .sites = input.sites}));
    std::printf("%s  written    %s\n", report_text(input, broken).c_str(), command.output.c_str());
    if (!command.report.empty()) {
        const std::string json = report_json(input, broken, recipe);
        must(fracture::write_file_atomically(command.report, std::as_bytes(std::span(json))));
        std::printf("  report     %s\n", command.report.c_str());
    }
    if (!command.save_recipe.empty()) {
        write_recipe(command.save_recipe, command.fracture);
        std::printf("  recipe     %s\n", command.save_recipe.c_str());
    }
    if (!broken.certificate.closed) {
        throw Failure(exit_failure, std::to_string(broken.certificate.open_pieces) + " of " +
                                        std::to_string(broken.certificate.pieces) +
                                        " pieces are not closed; please report this mesh with these options");
    }
    return exit_success;
}

} // namespace brittle::tools
