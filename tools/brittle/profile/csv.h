// A profile as comma-separated values, for spreadsheets and scripts (RFC 4180, with plain line ends).
#pragma once

#include <string>

#include <nlohmann/json.hpp>

namespace brittle::tools {

// Returns a line of column names and one line per phase:
// scenario,mesh,triangles,sites,pieces,classify,group,phase,min_ms, median_ms,p95_ms,p99_ms,max_ms,samples. `group` is
// "fracture", "frames whole" and so on.
[[nodiscard]] std::string profile_csv(const nlohmann::ordered_json& profile);

} // namespace brittle::tools
