// A profile as a table for people, on standard output.
#pragma once

#include <nlohmann/json.hpp>

namespace brittle::tools {

// Each scenario's rows, and where there are several a line for each with its medians.
void print_profile(const nlohmann::ordered_json& profile);

} // namespace brittle::tools
