// Runs a check in a process of its own, so that a crash leaves the program alive.
#pragma once

#include <functional>
#include <string>

namespace brittle::stress {

// Runs the function in a child process with limits of CPU time and memory. Returns the function's result, or how the
// child ended: crashed, out of time, or out of memory.
[[nodiscard]] std::string isolated(const std::function<std::string()>& function, unsigned seconds, size_t memory_bytes);

} // namespace brittle::stress
