// The machine and build that a measurement was made with. Holds no paths and no names of machines or people.
#pragma once

#include <nlohmann/json.hpp>

namespace brittle::tools {

// Keys: brittle (version), commit (`git describe` at build time, or "unknown"), compiler, build, system, processor,
// hardware_threads. The code that opens a Vulkan device adds the device's keys.
[[nodiscard]] nlohmann::ordered_json environment();

} // namespace brittle::tools
