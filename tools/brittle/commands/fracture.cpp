#include <cstdio>
#include <filesystem>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "fracture/io/atomic_file.h"
#include "tools/brittle/base/console.h"
#include "tools/brittle/base/interrupt.h"
#include "tools/brittle/base/progress.h"
#include "tools/brittle/commands/commands.h"
#include "tools/brittle/commands/report.h"
#include "tools/brittle/pictures/view.h"
#include "tools/brittle/stage/classify_choice.h"
#include "tools/brittle/stage/loading.h"
#include "tools/brittle/stage/standard_streams.h"
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

void say_memory(const Input& input, const ExportSettings& files) {
    const auto sites = static_cast<double>(input.sites.size());
    const bool is_glb = files.stream == "glb" || files.output.ends_with(".glb");
    const double bytes = sites * (bytes_per_site + (is_glb ? bytes_per_glb_piece : 0.0));
    if (bytes < told_bytes) return;
    tell("%zu sites may take %.1f GB of memory%s", input.sites.size(), bytes / 1e9,
         !is_glb                                            ? ""
         : sites * file_bytes_per_glb_piece > max_glb_bytes ? "; the file may exceed the 4 GiB of GLB, choose .ply"
                                                            : "; .ply takes less");
}

// Returns the files; none for standard output.
std::vector<std::filesystem::path> write(const FractureCommand& command, const Input& input, const Broken& broken) {
    if (command.files.stream.empty()) return write_pieces(command.files, command.fracture, input, broken);
    write_standard_output(pieces_in_memory(command.files, command.fracture, input, broken));
    return {};
}

void report(const FractureCommand& command, const Input& input, const Broken& broken,
            const std::vector<std::filesystem::path>& files) {
    print_report("%s", report_text(input, broken).c_str());
    if (files.empty())
        print_report("  written    standard output\n");
    else if (files.size() == 1)
        print_report("  written    %s\n", files.front().c_str());
    else
        print_report("  written    %s to %s\n", files.front().c_str(), files.back().c_str());
    if (!command.report.empty()) print_report("  report     %s\n", command.report.c_str());
    if (!command.fracture.save_recipe.empty()) print_report("  recipe     %s\n", command.fracture.save_recipe.c_str());
}

} // namespace

int run_fracture(const FractureCommand& command) {
    catch_interrupts();
    const InterruptDeadline deadline;
    if (!command.files.stream.empty()) {
        if (command.files.stream != "obj") refuse_terminal_output();
        keep_standard_output_for_data();
    }
    const Input input = open_input(command.fracture, true);
    for (const std::string& note : input.model.notes) tell("%s: %s", input.name.c_str(), note.c_str());
    const ClassifyPath path = classify_path(command.classify);
    std::unique_ptr<engine::Device> device;
    ClassifyChoice choice;
    if (path != ClassifyPath::cpu) {
        device = open_device({});
        choice = choose_classifier(path, *device, input, command.fracture);
        tell("classification on the %s", choice.why.c_str());
    }
    say_memory(input, command.files);
    const Broken broken = [&] {
        Progress progress("fracturing " + input.name);
        return break_input(
            input, command.fracture, [&](double share) { progress.update(share); }, choice.classifier.get(),
            is_interrupted);
    }();

    const std::vector<std::filesystem::path> files = write(command, input, broken);
    const std::string json = report_json(input, broken, recipe_json(command.fracture));
    if (!command.report.empty()) must(fracture::write_file_atomically(command.report, std::as_bytes(std::span(json))));
    if (command.json)
        std::fputs(json.c_str(), stdout);
    else
        report(command, input, broken, files);
    print_split_note(command.files, files);
    if (const std::string overlap = command.fracture.unite ? std::string() : overlap_of(input.model.mesh);
        !overlap.empty())
        tell("%s: %s; --unite makes one solid of it", input.name.c_str(), overlap.c_str());
    if (!broken.certificate.closed) {
        throw Failure(exit_failure, std::to_string(broken.certificate.open_pieces) + " of "
                                        + std::to_string(broken.certificate.pieces)
                                        + " pieces are not closed; please report this mesh with these options");
    }
    return exit_success;
}

} // namespace brittle::tools
