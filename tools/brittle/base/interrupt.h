// Ctrl+C handling: a command ends between two steps, so that each output file is either complete or absent.
#pragma once

namespace brittle::tools {

// Installs the handlers: the first SIGINT or SIGTERM only sets a flag; a second one ends the program at once.
void catch_interrupts();

[[nodiscard]] bool is_interrupted();

// Throws a Failure with exit_interrupted if is_interrupted().
void throw_if_interrupted();

} // namespace brittle::tools
