#include <cstdio>
#include <span>

#include "fracture/io/atomic_file.h"
#include "tools/brittle/base/interrupt.h"
#include "tools/brittle/base/progress.h"
#include "tools/brittle/commands/commands.h"
#include "tools/brittle/commands/report.h"
#include "tools/brittle/pictures/view.h"
#include "tools/brittle/stage/classify_choice.h"
#include "tools/brittle/stage/loading.h"
#include "tools/scenario/base/failure.h"
#include "tools/scenario/recipe/piece_export.h"
#include "tools/scenario/recipe/recipe.h"

namespace brittle::tools {

namespace {

// The peak of memory grows with the sites: measured on the bunny of 70,000 triangles, with 200,000 sites inside it. GLB
// files describe each piece in JSON.
constexpr double bytes_per_site = 7'400.0;
constexpr double bytes_per_glb_piece = 11'000.0;
constexpr double file_bytes_per_glb_piece = 5'600.0;
constexpr double max_glb_bytes = 4294967296.0; // a limit of the format
constexpr double told_bytes = 1e9;             // less is not worth a word

void say_memory(const Input& input, const std::string& output) {
    const auto sites = static_cast<double>(input.sites.size());
    const bool is_glb = output.ends_with(".glb");
    const double bytes = sites * (bytes_per_site + (is_glb ? bytes_per_glb_piece : 0.0));
    if (bytes < told_bytes) return;
    std::fprintf(stderr, "brittle: %zu sites may take %.1f GB of memory%s\n", input.sites.size(), bytes / 1e9,
                 !is_glb ? ""
                 : sites * file_bytes_per_glb_piece > max_glb_bytes
                     ? "; the file may exceed the 4 GiB of GLB, choose .ply"
                     : "; .ply takes less");
}

} // namespace

int run_fracture(const FractureCommand& command) {
    catch_interrupts();
    const InterruptDeadline deadline;
    const Input input = open_input(command.fracture, true);
    for (const std::string& note : input.model.notes)
        std::fprintf(stderr, "brittle: %s: %s\n", input.name.c_str(), note.c_str());
    const ClassifyPath path = classify_path(command.classify);
    std::unique_ptr<engine::Device> device;
    ClassifyChoice choice;
    if (path != ClassifyPath::cpu) {
        device = open_device({});
        choice = choose_classifier(path, *device, input, command.fracture);
        std::fprintf(stderr, "brittle: classification on the %s\n", choice.why.c_str());
    }
    say_memory(input, command.files.output);
    const Broken broken = [&] {
        Progress progress("fracturing " + input.name);
        return break_input(
            input, command.fracture, [&](double share) { progress.update(share); }, choice.classifier.get(),
            is_interrupted);
    }();

    const auto files = write_pieces(command.files, command.fracture, input, broken);
    std::printf("%s", report_text(input, broken).c_str());
    if (!files.empty()) std::printf("  written    %s", files.front().c_str());
    std::printf(files.size() > 1 ? " to %s\n" : "\n", files.size() > 1 ? files.back().c_str() : "");
    print_split_note(command.files, files);
    if (!command.report.empty()) {
        const std::string json = report_json(input, broken, recipe_json(command.fracture));
        must(fracture::write_file_atomically(command.report, std::as_bytes(std::span(json))));
        std::printf("  report     %s\n", command.report.c_str());
    }
    if (!command.fracture.save_recipe.empty()) std::printf("  recipe     %s\n", command.fracture.save_recipe.c_str());
    if (const std::string overlap = command.fracture.unite ? std::string() : overlap_of(input.model.mesh);
        !overlap.empty())
        std::fprintf(stderr, "brittle: %s: %s; --unite makes one solid of it\n", input.name.c_str(), overlap.c_str());
    if (!broken.certificate.closed) {
        throw Failure(exit_failure, std::to_string(broken.certificate.open_pieces) + " of "
                                        + std::to_string(broken.certificate.pieces)
                                        + " pieces are not closed; please report this mesh with these options");
    }
    return exit_success;
}

} // namespace brittle::tools
