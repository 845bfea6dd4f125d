// A profile as a table for people, on standard output.
#pragma once

#include <nlohmann/json.hpp>

namespace brittle::tools {

// Prints the rows of each scenario and, if there are several scenarios, one line with the medians of each.
void print_profile(const nlohmann::ordered_json& profile);

} // namespace brittle::tools
