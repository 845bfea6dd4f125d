// On what a profile was measured. No paths and no names of machines or people.
#pragma once

#include <nlohmann/json.hpp>

namespace brittle::tools {

// Keys: brittle (version), commit (as `git describe` had it when this was built, or "unknown"), compiler, build,
// system, processor, hardware_threads. The device's are added by who opens it.
[[nodiscard]] nlohmann::ordered_json environment();

} // namespace brittle::tools
