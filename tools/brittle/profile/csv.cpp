#include "tools/brittle/profile/csv.h"

#include "tools/brittle/profile/series.h"

namespace brittle::tools {

namespace {

using Json = nlohmann::ordered_json;

std::string cell(const Json& value) {
    if (!value.is_string()) return value.dump();
    const auto text = value.get<std::string>();
    if (text.find_first_of(",\"\r\n") == std::string::npos) return text;
    std::string quoted = "\"";
    for (const char c : text) {
        if (c == '"') quoted += '"';
        quoted += c;
    }
    return quoted + "\"";
}

void add_rows(std::string& csv, const std::string& scenario, const std::string& group, const Json& rows) {
    for (const auto& [phase, s] : rows.items()) {
        csv += scenario + cell(group) + "," + cell(phase);
        for (const char* key : {"min", "median", "p95", "p99", "max", "samples"}) csv += "," + cell(s[key]);
        csv += "\n";
    }
}

} // namespace

std::string profile_csv(const Json& profile) {
    std::string csv = "scenario,mesh,triangles,sites,pieces,classify,group,phase,"
                      "min_ms,median_ms,p95_ms,p99_ms,max_ms,samples\n";
    for (const Json& scenario : profile["scenarios"]) {
        std::string front;
        for (const char* key : {"name", "mesh", "triangles", "sites", "pieces", "classify"})
            front += cell(scenario.value(key, Json(""))) + ","; // a scene has no mesh, sites and classify
        add_rows(csv, front, main_group(scenario), scenario[main_group(scenario)]);
        if (!scenario.contains("frames")) continue;
        for (const auto& [name, rows] : scenario["frames"].items()) add_rows(csv, front, "frames " + name, rows);
    }
    return csv;
}

} // namespace brittle::tools
