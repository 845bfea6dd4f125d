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
#include "tools/scenario/run/broken_scene.h"
#include "tools/scenario/run/state_export.h"

namespace brittle::tools {

namespace {

// The peak of memory grows with the sites: measured on the bunny of 70,000 triangles, with 200,000 sites inside it. GLB
// files describe each piece in JSON.
constexpr double bytes_per_site = 7'400.0;
constexpr double bytes_per_glb_piece = 11'000.0;
constexpr double file_bytes_per_glb_piece = 5'600.0;
constexpr double max_glb_bytes = 4294967296.0; // a limit of the format
constexpr double told_bytes = 1e9;             // less is not worth a word

void say_memory(size_t count, const ExportSettings& files, bool of_scene) {
    const auto sites = static_cast<double>(count);
    const bool is_glb = files.stream == "glb" || files.output.ends_with(".glb");
    const double bytes = sites * (bytes_per_site + (is_glb ? bytes_per_glb_piece : 0.0));
    if (bytes < told_bytes) return;
    const bool is_too_large = is_glb && sites * file_bytes_per_glb_piece > max_glb_bytes;
    std::string advice = is_too_large ? "; the file may exceed the 4 GiB of GLB" : "";
    if (of_scene)
        advice += "; break fewer objects, or into fewer pieces";
    else if (is_glb)
        advice += is_too_large ? ", choose .ply" : "; .ply takes less";
    tell("%zu sites may take %.1f GB of memory%s", count, bytes / 1e9, advice.c_str());
}

// Returns the files; none for standard output.
std::vector<std::filesystem::path> write(const FractureCommand& command, const Input& input, const Broken& broken) {
    if (command.files.stream.empty()) return write_pieces(command.files, command.fracture, input, broken);
    write_standard_output(pieces_in_memory(command.files, command.fracture, input, broken));
    return {};
}

// Prints the report as text or JSON, and writes the JSON to its file.
void report(const FractureCommand& command, const std::string& text, const std::string& json,
            const std::vector<std::filesystem::path>& files) {
    if (!command.report.empty()) must(fracture::write_file_atomically(command.report, std::as_bytes(std::span(json))));
    if (command.json) {
        std::fputs(json.c_str(), stdout);
        return;
    }
    print_report("%s", text.c_str());
    if (files.empty())
        print_report("  written    standard output\n");
    else if (files.size() == 1)
        print_report("  written    %s\n", files.front().c_str());
    else
        print_report("  written    %s to %s\n", files.front().c_str(), files.back().c_str());
    if (!command.report.empty()) print_report("  report     %s\n", command.report.c_str());
    if (!command.fracture.save_recipe.empty()) print_report("  recipe     %s\n", command.fracture.save_recipe.c_str());
}

void refuse_open_pieces(size_t open, size_t pieces) {
    if (open > 0)
        throw Failure(exit_failure, std::to_string(open) + " of " + std::to_string(pieces)
                                        + " pieces are not closed; please report this mesh with these options");
}

// Breaks each object of a scene by its pattern.
void fracture_scene(const FractureCommand& command) {
    check_export_of_scene(command.fracture, command.files, "--output");
    if (classify_path(command.classify) == ClassifyPath::gpu)
        throw Failure(exit_usage, "--classify gpu: objects of a scene are cut side by side, on the CPU; leave it out");
    print_idle_note(command.fracture);
    const Host host = program_host();
    FractureOptions options = command.fracture;
    for (const std::string& note : expand_level(options)) tell("%s", note.c_str());
    LoadedScene scene = open_scene(with_cuts(options), host, nullptr, true);
    if (!command.fracture.save_recipe.empty()) write_recipe(command.fracture.save_recipe, command.fracture);
    size_t sites = 0;
    for (const LoadedObject& object : scene.objects) sites += object.input->sites.size();
    say_memory(sites, command.files, true);
    const std::vector<BrokenObject> objects = [&] {
        Progress progress("fracturing the scene");
        return break_scene(scene, host, [&](double share) { progress.update(share); });
    }();
    for (const std::string& note : scene.notes) tell("%s", note.c_str());
    fracture::ObjectExport file;
    add_pieces(file, command.files, scene, objects);
    std::vector<std::filesystem::path> files;
    if (command.files.stream.empty()) {
        must(file.write(command.files.output));
        files.emplace_back(command.files.output);
    } else {
        write_standard_output(must(file.bytes()));
    }
    report(command, report_text(scene, objects), report_json(scene, objects, recipe_json(command.fracture)), files);
    for (size_t k = 0; k < objects.size(); ++k)
        if (!objects[k].overlap.empty())
            tell("object %s: %s; \"unite\": true makes one solid of it", scene.objects[k].object.name.c_str(),
                 objects[k].overlap.c_str());
    const SceneCertificate all = certify(objects);
    refuse_open_pieces(all.open_pieces, all.pieces);
}

} // namespace

int run_fracture(const FractureCommand& command) {
    catch_interrupts();
    const InterruptDeadline deadline;
    if (!command.files.stream.empty()) {
        if (command.files.stream != "obj") refuse_terminal_output();
        keep_standard_output_for_data();
    }
    if (is_scene(command.fracture)) {
        fracture_scene(command);
        return exit_success;
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
    say_memory(input.sites.size(), command.files, false);
    const Broken broken = [&] {
        Progress progress("fracturing " + input.name);
        return break_input(
            input, command.fracture, [&](double share) { progress.update(share); }, choice.classifier.get(),
            is_interrupted);
    }();

    const std::vector<std::filesystem::path> files = write(command, input, broken);
    report(command, report_text(input, broken), report_json(input, broken, recipe_json(command.fracture)), files);
    print_split_note(command.files, files);
    if (const std::string overlap = command.fracture.unite ? std::string() : overlap_of(input.model.mesh);
        !overlap.empty())
        tell("%s: %s; --unite makes one solid of it", input.name.c_str(), overlap.c_str());
    refuse_open_pieces(broken.certificate.open_pieces, broken.certificate.pieces);
    return exit_success;
}

} // namespace brittle::tools
