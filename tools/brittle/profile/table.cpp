#include "tools/brittle/profile/table.h"

#include <algorithm>
#include <cstdio>
#include <string>
#include <vector>

#include "tools/brittle/profile/series.h"

namespace brittle::tools {

namespace {

using Json = nlohmann::ordered_json;

std::string text_of(const Json& json, const char* key) {
    return json[key].get<std::string>();
}

void print_rows(const std::string& title, const Json& rows) {
    std::printf("\n%-36s %10s %10s %10s %10s\n", title.c_str(), "median", "p95", "p99", "max");
    for (const auto& [name, s] : rows.items()) {
        std::printf("  %-34s %10.2f %10.2f %10.2f %10.2f\n", name.c_str(), s["median"].get<double>(),
                    s["p95"].get<double>(), s["p99"].get<double>(), s["max"].get<double>());
    }
}

void print_head_of_mesh(const Json& scenario) {
    std::printf("\n%s: %zu triangles, %zu sites, %u pieces, %s; the first fracture took %.2f\n",
                text_of(scenario, "name").c_str(), scenario["triangles"].get<size_t>(), scenario["sites"].get<size_t>(),
                scenario["pieces"].get<unsigned>(), scenario["closed"].get<bool>() ? "all closed" : "NOT ALL CLOSED",
                scenario["first"].get<double>());
    std::printf("classification on the %s\n", text_of(scenario, "classify_why").c_str());
}

void print_head_of_scene(const Json& scenario) {
    std::printf("\n%s: %zu objects, %zu triangles, %u pieces; the first start took %.2f\n",
                text_of(scenario, "name").c_str(), scenario["objects"].get<size_t>(),
                scenario["triangles"].get<size_t>(), scenario["pieces"].get<unsigned>(),
                scenario["first"].get<double>());
    if (!scenario.contains("played")) return;
    const Json& played = scenario["played"];
    const auto cuts = played["cuts"].get<unsigned>();
    std::printf("played: %u %s, %zu pieces at the end\n", cuts, cuts == 1 ? "cut" : "cuts",
                played["pieces"].get<size_t>());
}

void print_scenario(const Json& scenario) {
    const std::string group = main_group(scenario);
    scenario.contains("objects") ? print_head_of_scene(scenario) : print_head_of_mesh(scenario);
    print_rows(group, scenario[group]);
    if (!scenario.contains("frames")) return;
    for (const auto& [name, rows] : scenario["frames"].items()) print_rows("frames, " + name, rows);
}

// Prints one line per scenario and one column per phase: the phases of all scenarios in order of appearance, the total
// last.
void print_summary(const Json& scenarios) {
    std::vector<std::string> phases;
    size_t width = 0;
    for (const Json& scenario : scenarios) {
        width = std::max(width, text_of(scenario, "name").size());
        for (const auto& [phase, s] : scenario[main_group(scenario)].items()) {
            const bool known = std::find(phases.begin(), phases.end(), phase) != phases.end();
            if (!known && phase != "total" && !phase.starts_with("pass ")) phases.push_back(phase);
        }
    }
    phases.push_back("total");
    const auto column = static_cast<int>(width);
    std::printf("\n%-*s %7s", column, "medians", "pieces");
    for (const std::string& phase : phases) std::printf(" %9s", phase.c_str());
    std::printf(" %9s\n", "p95");
    for (const Json& scenario : scenarios) {
        const Json& rows = scenario[main_group(scenario)];
        std::printf("%-*s %7u", column, text_of(scenario, "name").c_str(), scenario["pieces"].get<unsigned>());
        for (const std::string& phase : phases) {
            if (rows.contains(phase)) {
                std::printf(" %9.2f", rows[phase]["median"].get<double>());
            } else {
                std::printf(" %9s", "");
            }
        }
        std::printf(" %9.2f\n", rows["total"]["p95"].get<double>());
    }
}

} // namespace

void print_profile(const Json& profile) {
    const Json& environment = profile["environment"];
    std::printf("brittle %s (%s), %s, %s\n", text_of(environment, "brittle").c_str(),
                text_of(environment, "commit").c_str(), text_of(environment, "compiler").c_str(),
                text_of(environment, "build").c_str());
    std::printf("%s, %u hardware threads", text_of(environment, "processor").c_str(),
                environment["hardware_threads"].get<unsigned>());
    if (environment.contains("device"))
        std::printf("; %s, %s, pictures of %s", text_of(environment, "device").c_str(),
                    text_of(environment, "driver").c_str(), text_of(profile["settings"], "size").c_str());
    std::printf("; milliseconds\n");
    for (const Json& scenario : profile["scenarios"]) print_scenario(scenario);
    if (profile["scenarios"].size() > 1) print_summary(profile["scenarios"]);
}

} // namespace brittle::tools
