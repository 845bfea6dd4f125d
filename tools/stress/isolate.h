// Runs a check where it cannot take the program down with it.
#pragma once

#include <functional>
#include <string>

namespace brittle::stress {

// In a child process with limits on time and memory. What the function returns, or how the child ended: crashed, ran
// out of time (seconds of processor time), out of memory.
[[nodiscard]] std::string isolated(const std::function<std::string()>& function, unsigned seconds, size_t memory_bytes);

} // namespace brittle::stress
