#include <memory>

#include "tools/brittle/commands/command_line.h"
#include "tools/brittle/commands/option_groups.h"
#include "tools/brittle/commands/option_values.h"

namespace brittle::tools {

namespace {

// Before all other options, which override the file.
void add_scenario_file(CLI::App& profile, ProfilePlan& plan) {
    profile
        .add_option_function<std::string>(
            "--scenarios", [&plan](const std::string& file) { read_profile_plan(file, plan); },
            "File of scenarios to measure (assets/profile.schema.json). The command line gives all settings that the "
            "file leaves open.")
        ->type_name("FILE.json");
}

void add_scenario_lists(CLI::App& profile, ScenarioGroup& lists) {
    profile.add_option("--meshes", lists.meshes, "Several meshes instead of MESH")
        ->delimiter(',')
        ->allow_extra_args(false)
        ->excludes("mesh")
        ->type_name("MESH,MESH,...");
    profile.add_option("--counts", lists.counts, "Several numbers of sites instead of --pieces")
        ->check(number_from(1, 1'000'000))
        ->delimiter(',')
        ->allow_extra_args(false)
        ->excludes("--pieces")
        ->excludes("--piece-size")
        ->type_name("N,N,...");
    profile
        .add_option("--classify", lists.classify,
                    "Processor that classifies vertices and triangles: cpu, gpu (the Vulkan device, even if it runs on "
                    "the CPU), auto (the faster one in a few trials), or several of them")
        ->check(CLI::IsMember({"auto", "cpu", "gpu"}))
        ->delimiter(',')
        ->allow_extra_args(false)
        ->type_name("WHERE,...")
        ->default_str("cpu");
}

void add_repetitions(CLI::App& profile, ProfilePlan& plan) {
    profile
        .add_option("--warm-up", plan.warm_up, "Number of fractures, or starts of a scene, before the measured ones")
        ->check(number_from(0, 10'000))
        ->capture_default_str();
    profile.add_option("--repeats", plan.repeats, "Number of measured fractures, or starts of a scene")
        ->check(number_from(1, 10'000))
        ->capture_default_str();
    profile
        .add_option(
            "--frames", plan.frames,
            "Number of measured frames before the fracture, and again after it; of a scene, while it stands and "
            "while it is played. 0 measures none and needs no device.")
        ->check(number_from(0, 100'000))
        ->capture_default_str();
}

void add_outputs(CLI::App& profile, ProfileCommand& command) {
    profile.add_option("-o,--output", command.output, "File for the JSON")->type_name("FILE.json");
    profile.add_option("--csv", command.csv, "File for a table with one line per phase")->type_name("FILE.csv");
    profile.add_option("--trace", command.trace, "File for a time line that Perfetto (ui.perfetto.dev) shows")
        ->type_name("FILE.json");
    auto* compare = profile.add_option("--compare", command.compare, "Earlier profile, written by -o, to compare with")
                        ->type_name("OLD.json");
    profile
        .add_option("--threshold", command.threshold,
                    "Ratio of new to old above which --compare calls a time slower. Both median and minimum must "
                    "exceed it.")
        ->check(number_from(1.0, 1000.0))
        ->needs(compare)
        ->capture_default_str();
}

} // namespace

void add_profile(CLI::App& app, Run& run) {
    const auto command = std::make_shared<ProfileCommand>();
    CLI::App& profile = *app.add_subcommand(
        "profile", "Measure fractures and frames, compare with an earlier profile, write a time line");
    start_group(profile, "Scenarios");
    add_scenario_file(profile, command->plan);
    add_fracture_options(profile, command->fracture);
    start_group(profile, "Scenarios");
    add_scenario_lists(profile, command->lists);
    add_repetitions(profile, command->plan);
    start_group(profile, "Output");
    add_outputs(profile, *command);
    add_view_options(profile, command->view);
    add_threads_option(profile, command->fracture.threads);
    add_general_options(profile, &command->json);
    profile.footer("The exit code is 7 if --compare finds the total of a fracture or of a scene's start, or the "
                   "frames before or after it, slower.\n\n"
                   "Examples:\n"
                   "  brittle profile bunny.obj -n 100 -o before.json\n"
                   "  brittle profile bunny.obj -n 100 --compare before.json\n"
                   "  brittle profile bunny.obj --counts 10,100,1000 --classify cpu,gpu --frames 0\n"
                   "  brittle profile bunny.obj -n 1000 --trace frames.json\n"
                   "  brittle profile assets/worlds/courtyard.json --repeats 5 --frames 300");
    profile.callback([&run, &profile, command] {
        refuse_standard_input(profile, command->fracture.mesh);
        for (const std::string& mesh : command->lists.meshes) refuse_standard_input(profile, mesh);
        command->lists.recipe = recipe_file(profile);
        run = [command] { return run_profile(*command); };
    });
}

} // namespace brittle::tools
