// What `brittle profile` measures: meshes times counts of sites times the place of classification. The lists come from
// the command line or from a file that assets/profile.schema.json describes:
//
//     {"brittle_profile": 1, "repeats": 9, "scenarios": [
//         {"meshes": ["shape:torus", "bunny.obj"], "counts": [10, 100, 1000], "classify": ["cpu", "gpu"]},
//         {"name": "glass", "recipe": "glass.json"}]}
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "tools/brittle/recipe/input.h"
#include "tools/brittle/run/classify_choice.h"

namespace brittle::tools {

// Each of meshes x counts x classify. An empty list leaves what the recipe or the command line says.
struct ScenarioGroup {
    std::string name;   // goes before those of its scenarios; may be empty
    std::string recipe; // outdoes the command line; empty: none
    std::vector<std::string> meshes;
    std::vector<uint32_t> counts;      // of sites
    std::vector<std::string> classify; // "auto", "cpu", "gpu"
};

struct ProfilePlan {
    uint32_t warm_up = 2;  // fractures before those that count
    uint32_t repeats = 21; // fractures that count; 20 and more make the 95th percentile more than the maximum
    uint32_t frames = 60;  // before the fracture, and as many after it; 0: the fracture alone, without a device
    std::vector<ScenarioGroup> groups; // of the file; empty: the lists of the command line
};

struct Scenario {
    std::string name; // "bunny 100 cpu": how two profiles know the same scenario
    FractureOptions fracture;
    ClassifyPath classify = ClassifyPath::cpu;
};

// Takes over what the file says; what it does not mention stays. Relative paths in it count from its folder. Throws a
// Failure with exit_input that names the file, the JSON path and what was expected.
void read_profile_plan(const std::filesystem::path& file, ProfilePlan& plan);

// The scenarios in the order of the lists, with what the groups do not say from `lists` and `base`, the command line.
// Throws a Failure where a mesh is missing, a count meets sites that are not made by count, or two names are equal.
[[nodiscard]] std::vector<Scenario> make_scenarios(const ProfilePlan& plan, const ScenarioGroup& lists,
                                                   const FractureOptions& base);

} // namespace brittle::tools
