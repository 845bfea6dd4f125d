// Ctrl+C handling: a command ends between two steps, so that each output file is either complete or absent.
#pragma once

namespace brittle::tools {

// Installs the handlers: the first SIGINT or SIGTERM only sets a flag; a second one ends the program at once.
void catch_interrupts();

[[nodiscard]] bool is_interrupted();

// While one lives, an interrupted program that does not end by itself within 0.4 s ends at once with exit_interrupted,
// wherever it is: in a library, or waiting for a pipe. For work whose only results are files that are renamed as a whole.
class InterruptDeadline {
  public:
    InterruptDeadline();
    ~InterruptDeadline();
    InterruptDeadline(const InterruptDeadline&) = delete;
    InterruptDeadline& operator=(const InterruptDeadline&) = delete;
};

// Throws a Failure with exit_interrupted if is_interrupted().
void throw_if_interrupted();

} // namespace brittle::tools
