#include <cstdio>
#include <optional>
#include <span>
#include <string>

#include <nlohmann/json.hpp>

#include "fracture/io/atomic_file.h"
#include "tools/brittle/base/console.h"
#include "tools/brittle/base/interrupt.h"
#include "tools/brittle/commands/commands.h"
#include "tools/brittle/commands/report.h"
#include "tools/brittle/profile/compare.h"
#include "tools/brittle/profile/csv.h"
#include "tools/brittle/profile/measure.h"
#include "tools/brittle/profile/table.h"
#include "tools/brittle/profile/trace.h"
#include "tools/scenario/base/environment.h"
#include "tools/scenario/base/failure.h"
#include "tools/scenario/recipe/json_reader.h"

namespace brittle::tools {

namespace {

using Json = nlohmann::ordered_json;

void write(const std::string& file, const std::string& text) {
    if (!file.empty()) must(fracture::write_file_atomically(file, std::as_bytes(std::span(text))));
}

Json settings(const ProfileCommand& command) {
    return {{"warm_up", command.plan.warm_up},
            {"repeats", command.plan.repeats},
            {"frames", command.plan.frames},
            {"size", std::to_string(command.view.width) + "x" + std::to_string(command.view.height)},
            {"threads", command.fracture.threads}};
}

Json measure(const ProfileCommand& command, const std::vector<Scenario>& scenarios, Trace* trace) {
    Profiler profiler(command.plan, command.view, trace);
    Json measured = Json::array();
    for (const Scenario& scenario : scenarios) measured.push_back(profiler.measure(scenario));
    profiler.check();
    Json machine = environment();
    machine.update(profiler.device());
    return {{"brittle_profile", 1}, {"environment", machine}, {"settings", settings(command)}, {"scenarios", measured}};
}

// Returns the metadata of the trace: the environment, and the relation of the device's clock to the host's.
Json trace_metadata(const Json& profile) {
    Json metadata = profile["environment"];
    if (!metadata.contains("common_clock")) return metadata;
    metadata["device_clock"] =
        metadata["common_clock"].get<bool>()
            ? "calibrated against the host's monotonic clock (VK_EXT_ or VK_KHR_calibrated_timestamps)"
            : "not calibrated: the last pass of each submission is shown as ending when the host had waited for it and "
              "read its time";
    return metadata;
}

} // namespace

int run_profile(const ProfileCommand& command) {
    catch_interrupts();
    const std::vector<Scenario> scenarios = make_scenarios(command.plan, command.lists, command.fracture);
    if (is_scene(command.fracture)) print_idle_note(command.fracture);
    std::optional<Json> before;
    if (!command.compare.empty()) before = read_profile(command.compare);

    Trace trace;
    Json profile = measure(command, scenarios, command.trace.empty() ? nullptr : &trace);
    std::optional<Comparison> comparison;
    if (before) {
        comparison = compare_profiles(*before, profile, command.threshold);
        profile["comparison"] = comparison_json(*comparison);
    }

    // Printed before the files are written, so that a failure of writing does not lose the times.
    const std::string json = text_of(profile, 2) + "\n";
    if (command.json) {
        std::fputs(json.c_str(), stdout);
    } else if (!is_quiet()) {
        print_profile(profile);
        if (comparison) print_comparison(*comparison);
    }
    std::fflush(stdout);
    write(command.output, json);
    write(command.csv, profile_csv(profile));
    if (!command.trace.empty()) write(command.trace, text_of(trace.json(trace_metadata(profile))) + "\n");
    return comparison && comparison->slower ? exit_slower : exit_success;
}

} // namespace brittle::tools
