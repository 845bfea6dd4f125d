#include "tools/brittle/profile/compare.h"

#include <algorithm>
#include <cstdio>
#include <limits>

#include "tools/brittle/profile/series.h"
#include "tools/scenario/base/failure.h"
#include "tools/scenario/recipe/json_reader.h"

namespace brittle::tools {

namespace {

using Json = nlohmann::ordered_json;

constexpr int version = 1;
constexpr size_t max_profile_bytes = size_t{256} << 20;
constexpr uint64_t min_samples = 5; // minimum number of samples on either side for a verdict

// Throws a Failure if the rows are not {phase: {min, median, ..., samples}, ...}.
void check_rows(const std::filesystem::path& file, const Json& rows, const std::string& path) {
    JsonReader reader(file, rows, path);
    for (const auto& [phase, row] : rows.items()) {
        JsonReader inner(file, row, path + "/" + phase);
        for (const char* key : {"min", "median"}) {
            double value = -1.0;
            inner.number(key, value, 0.0, 1e15);
            if (value < 0.0) throw inner.failure(key, "is missing");
        }
        uint64_t samples = 0;
        inner.whole("samples", samples, 1, UINT32_MAX);
        if (samples == 0) throw inner.failure("samples", "is missing");
    }
}

void check_scenario(const std::filesystem::path& file, const Json& scenario, const std::string& path) {
    JsonReader reader(file, scenario, path);
    std::string name;
    reader.text("name", name);
    if (name.empty()) throw reader.failure("name", "is missing");
    const char* group = main_group(scenario);
    const Json* rows = reader.find(group);
    if (!rows) throw reader.failure(group, "is missing");
    check_rows(file, *rows, path + "/" + group);
    const Json* frames = reader.find("frames");
    if (!frames) return;
    JsonReader groups(file, *frames, path + "/frames");
    for (const auto& [name_of_frames, times] : frames->items())
        check_rows(file, times, path + "/frames/" + name_of_frames);
}

double ratio_of(const Json& before, const Json& after, const char* key) {
    const double a = before[key].get<double>(), b = after[key].get<double>();
    if (a > 0.0) return b / a;
    return b > 0.0 ? std::numeric_limits<double>::infinity() : 1.0;
}

Verdict verdict_of(const Json& before, const Json& after, double threshold) {
    if (std::min(before["samples"].get<uint64_t>(), after["samples"].get<uint64_t>()) < min_samples)
        return Verdict::few;
    const double median = ratio_of(before, after, "median"), least = ratio_of(before, after, "min");
    if (median > threshold) return least > threshold ? Verdict::slower : Verdict::noise;
    if (median < 1.0 / threshold) return least < 1.0 / threshold ? Verdict::faster : Verdict::noise;
    return Verdict::same;
}

void compare_rows(const std::string& scenario, const std::string& group, const Json& before, const Json& after,
                  Comparison& out) {
    for (const auto& [phase, row] : after.items()) {
        const auto old = before.find(phase);
        if (old == before.end()) continue;
        ComparedPhase p;
        p.scenario = scenario;
        p.group = group;
        p.phase = phase;
        p.before = (*old)["median"].get<double>();
        p.after = row["median"].get<double>();
        p.ratio = ratio_of(*old, row, "median");
        p.verdict = verdict_of(*old, row, out.threshold);
        const bool is_main = group == "fracture" || group == "start";
        const bool is_steady = group == "frames whole" || group == "frames falling" || group == "frames standing"
                               || group == "frames playing";
        p.decides = (is_main && phase == "total") || (is_steady && phase == "frame");
        out.slower = out.slower || (p.decides && p.verdict == Verdict::slower);
        out.phases.push_back(p);
    }
}

// Compares the keys on which comparability depends, and adds a note for each that differs.
void note_differences(const std::string& whose, const Json& before, const Json& after,
                      std::initializer_list<const char*> keys, std::vector<std::string>& notes) {
    const auto value = [](const Json& json, const char* key) {
        return json.is_object() && json.contains(key) ? json[key] : Json();
    };
    for (const char* key : keys) {
        const Json a = value(before, key), b = value(after, key);
        if (a != b) notes.push_back(whose + key + " was " + shown(a) + ", is " + shown(b));
    }
}

const Json* find_scenario(const Json& profile, const Json& name) {
    for (const Json& scenario : profile["scenarios"])
        if (scenario["name"] == name) return &scenario;
    return nullptr;
}

} // namespace

const char* to_string(Verdict verdict) {
    switch (verdict) {
    case Verdict::same:
        return "same";
    case Verdict::faster:
        return "faster";
    case Verdict::slower:
        return "slower";
    case Verdict::noise:
        return "noise";
    case Verdict::few:
        return "few";
    }
    return "";
}

Json read_profile(const std::filesystem::path& file) {
    Json json = read_json_file(file, "profile", max_profile_bytes);
    JsonReader reader(file, json, "");
    int written_for = 0;
    reader.whole("brittle_profile", written_for, 0, INT32_MAX);
    const Json* scenarios = reader.find("scenarios");
    if (written_for != version || !scenarios || !scenarios->is_array())
        throw reader.failure("", "this is not a profile; `brittle profile ... -o FILE.json` writes one");
    for (size_t i = 0; i < scenarios->size(); ++i)
        check_scenario(file, (*scenarios)[i], "/scenarios/" + std::to_string(i));
    return json;
}

Comparison compare_profiles(const Json& before, const Json& after, double threshold) {
    Comparison out;
    out.threshold = threshold;
    const auto part = [](const Json& json, const char* key) { return json.contains(key) ? json[key] : Json::object(); };
    note_differences("", part(before, "environment"), part(after, "environment"),
                     {"processor", "hardware_threads", "compiler", "build", "device", "driver"}, out.notes);
    note_differences("", part(before, "settings"), part(after, "settings"), {"size", "threads"}, out.notes);
    bool in_common = false;
    for (const Json& scenario : after["scenarios"]) {
        const auto name = scenario["name"].get<std::string>();
        const Json* old = find_scenario(before, scenario["name"]);
        if (!old) {
            out.notes.push_back(name + " is new");
            continue;
        }
        in_common = true;
        note_differences(name + ": ", *old, scenario, {"objects", "triangles", "sites", "pieces", "recipe"}, out.notes);
        const char* main = main_group(scenario);
        if (old->contains(main)) compare_rows(name, main, (*old)[main], scenario[main], out);
        const Json frames = part(scenario, "frames"), old_frames = part(*old, "frames");
        for (const auto& [group, rows] : frames.items())
            if (old_frames.contains(group)) compare_rows(name, "frames " + group, old_frames[group], rows, out);
    }
    for (const Json& scenario : before["scenarios"])
        if (!find_scenario(after, scenario["name"]))
            out.notes.push_back(scenario["name"].get<std::string>() + " was not measured again");
    if (!in_common)
        throw Failure(exit_input, "the two profiles have no scenario in common; measure the same meshes, counts and "
                                  "classify as in the old one");
    return out;
}

void print_comparison(const Comparison& comparison) {
    std::string group;
    for (const ComparedPhase& p : comparison.phases) {
        const std::string title = p.scenario + ", " + p.group;
        if (title != group) std::printf("\n%-36s %10s %10s %10s\n", title.c_str(), "before", "after", "ratio");
        group = title;
        const char* word = to_string(p.verdict);
        if (p.verdict == Verdict::same) word = "";
        if (p.verdict == Verdict::few) word = "too few samples";
        std::printf("%c %-34s %10.2f %10.2f %10.2f  %s\n", p.decides ? '*' : ' ', p.phase.c_str(), p.before, p.after,
                    p.ratio, word);
    }
    std::printf("\n");
    for (const std::string& note : comparison.notes) std::printf("note: %s\n", note.c_str());
    std::printf("%s by more than a factor of %.2f, in median and minimum (rows marked * decide)\n",
                comparison.slower ? "SLOWER" : "nothing is slower", comparison.threshold);
}

Json comparison_json(const Comparison& comparison) {
    Json phases = Json::array();
    for (const ComparedPhase& p : comparison.phases)
        phases.push_back({{"scenario", p.scenario},
                          {"group", p.group},
                          {"phase", p.phase},
                          {"before", p.before},
                          {"after", p.after},
                          {"ratio", p.ratio}, // null if infinite
                          {"verdict", to_string(p.verdict)},
                          {"decides", p.decides}});
    return {{"threshold", comparison.threshold},
            {"slower", comparison.slower},
            {"notes", comparison.notes},
            {"phases", phases}};
}

} // namespace brittle::tools
