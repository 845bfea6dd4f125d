// Ctrl+C ends a command between two steps, so that files are whole or not there.
#pragma once

namespace brittle::tools {

// From here on the first SIGINT or SIGTERM is only remembered; a second one ends the program at once.
void catch_interrupts();

[[nodiscard]] bool is_interrupted();

// Throws a Failure with exit_interrupted where is_interrupted().
void throw_if_interrupted();

} // namespace brittle::tools
