#include "tools/brittle/profile/scenario.h"

#include <algorithm>
#include <cstdio>
#include <string_view>

#include "fracture/io/text_cursor.h"
#include "tools/scenario/base/failure.h"
#include "tools/scenario/recipe/json_reader.h"
#include "tools/scenario/recipe/recipe.h"

namespace brittle::tools {

namespace {

using Json = nlohmann::ordered_json;

constexpr int version = 1;
constexpr std::string_view shape_prefix = "shape:";
constexpr size_t max_plan_bytes = size_t{1} << 20;

// Returns the elements of a non-empty list; none if the key is missing.
std::vector<Json> list_of(JsonReader& reader, const std::string& key) {
    const Json* value = reader.find(key);
    if (!value) return {};
    if (!value->is_array() || value->empty()) reader.fail(key, "a list [ ] that is not empty", *value);
    return {value->begin(), value->end()};
}

ScenarioGroup read_group(JsonReader& reader, const std::filesystem::path& folder) {
    const auto from_here = [&](const std::string& path) {
        return path.starts_with(shape_prefix) ? path : (folder / path).lexically_normal().string();
    };
    ScenarioGroup group;
    reader.text("name", group.name);
    reader.text("recipe", group.recipe);
    if (!group.recipe.empty()) group.recipe = from_here(group.recipe);
    for (const Json& mesh : list_of(reader, "meshes")) {
        if (!mesh.is_string()) reader.fail("meshes", "text in quotes", mesh);
        group.meshes.push_back(from_here(mesh.get<std::string>()));
    }
    for (const Json& count : list_of(reader, "counts"))
        group.counts.push_back(static_cast<uint32_t>(reader.whole_of("counts", count, 1, 1'000'000)));
    for (const Json& where : list_of(reader, "classify")) {
        if (where != "auto" && where != "cpu" && where != "gpu")
            reader.fail("classify", "\"auto\", \"cpu\" or \"gpu\"", where);
        group.classify.push_back(where.get<std::string>());
    }
    reader.refuse_unknown_keys();
    return group;
}

std::string stem(const std::string& file) {
    if (file.starts_with(shape_prefix)) return file.substr(shape_prefix.size());
    return std::filesystem::path(file).stem().string();
}

std::string sites_name(const FractureOptions& options) {
    if (!options.sites_file.empty()) return stem(options.sites_file);
    if (options.pattern.piece_size <= 0.0) return std::to_string(options.pattern.count);
    char text[32];
    std::snprintf(text, sizeof text, "%gm", options.pattern.piece_size);
    return text;
}

std::string scene_name(const ScenarioGroup& group) {
    const std::string file = group.recipe.empty() ? "scene" : stem(group.recipe);
    return group.name.empty() ? file : group.name + " " + file;
}

Scenario make_scenario(const ScenarioGroup& group, FractureOptions options, const std::string& classify) {
    if (options.mesh.empty())
        throw Failure(exit_usage, "no mesh to profile: give MESH, --meshes A,B or a recipe that names one");
    const std::string name =
        (group.name.empty() ? "" : group.name + " ") + stem(options.mesh) + " " + sites_name(options) + " " + classify;
    return {name, std::move(options), classify_path(classify)};
}

} // namespace

void read_profile_plan(const std::filesystem::path& file, ProfilePlan& plan) {
    const Json json = read_json_file(file, "profile's plan", max_plan_bytes);
    JsonReader reader(file, json, "");
    std::string schema; // for editors
    reader.text("$schema", schema);
    int written_for = 0;
    reader.whole("brittle_profile", written_for, 0, INT32_MAX);
    if (written_for != version)
        throw reader.failure("brittle_profile", "expected the plan's version, which is " + std::to_string(version));
    reader.whole("warm_up", plan.warm_up, 0, 10'000);
    reader.whole("repeats", plan.repeats, 1, 10'000);
    reader.whole("frames", plan.frames, 0, 100'000);
    const std::vector<Json> groups = list_of(reader, "scenarios");
    if (groups.empty()) throw reader.failure("scenarios", "expected a list [ ] of scenarios, found none");
    plan.groups.clear();
    for (size_t i = 0; i < groups.size(); ++i) {
        JsonReader inner(file, groups[i], "/scenarios/" + std::to_string(i));
        plan.groups.push_back(read_group(inner, file.parent_path()));
    }
    reader.refuse_unknown_keys();
}

std::vector<Scenario> make_scenarios(const ProfilePlan& plan, const ScenarioGroup& lists, const FractureOptions& base) {
    std::vector<Scenario> scenarios;
    const std::vector<ScenarioGroup> groups = plan.groups.empty() ? std::vector{lists} : plan.groups;
    for (const ScenarioGroup& group : groups) {
        FractureOptions options = base;
        if (!plan.groups.empty() && !group.recipe.empty()) read_recipe(group.recipe, options);
        std::vector<std::string> meshes = group.meshes.empty() ? lists.meshes : group.meshes;
        std::vector<uint32_t> counts = group.counts.empty() ? lists.counts : group.counts;
        std::vector<std::string> classify = group.classify.empty() ? lists.classify : group.classify;
        if (is_scene(options)) {
            if (!meshes.empty() || !counts.empty() || !classify.empty())
                throw Failure(exit_usage, "a scene is measured as it is: leave out --meshes, --counts and --classify, "
                                          "or the meshes, counts and classify of its group");
            scenarios.push_back({.name = scene_name(group), .fracture = options});
            continue;
        }
        if (meshes.empty()) meshes = {options.mesh};
        if (classify.empty()) classify = {"cpu"};
        if (!counts.empty() && !options.sites_file.empty())
            throw Failure(exit_usage, "counts need a pattern, but the sites come from the file "
                                          + fracture::quoted(options.sites_file) + "; leave out one of the two");
        if (counts.empty()) {
            counts = {options.pattern.count};
        } else {
            options.pattern.piece_size = 0.0; // replaced by the counts
        }
        for (const std::string& mesh : meshes) {
            options.mesh = mesh;
            for (const uint32_t count : counts) {
                options.pattern.count = count;
                for (const std::string& where : classify) scenarios.push_back(make_scenario(group, options, where));
            }
        }
    }
    for (auto at = scenarios.begin(); at != scenarios.end(); ++at) {
        const auto same = [&](const Scenario& other) { return other.name == at->name; };
        if (std::any_of(scenarios.begin(), at, same))
            throw Failure(exit_usage, "two scenarios are named '" + at->name
                                          + "'; leave out one, or write them into a "
                                            "file for --scenarios, where \"name\" can distinguish them");
    }
    if (scenarios.size() > 1 && !base.save_recipe.empty())
        throw Failure(exit_usage, "--save-recipe needs a single scenario; the number of scenarios is "
                                      + std::to_string(scenarios.size()));
    return scenarios;
}

} // namespace brittle::tools
