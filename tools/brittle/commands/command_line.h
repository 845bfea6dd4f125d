// The command line of the `brittle` program: one function for each command. It adds the command to the parser with its
// options and help. When the parser meets the command, `run` becomes the call of its function in commands.h.
#pragma once

#include <functional>

#include <CLI/CLI.hpp>

namespace brittle::tools {

using Run = std::function<int()>;

void add_fracture(CLI::App& app, Run& run);
void add_inspect(CLI::App& app, Run& run);
void add_repair(CLI::App& app, Run& run);
void add_render(CLI::App& app, Run& run);
void add_replay(CLI::App& app, Run& run);
void add_demo(CLI::App& app, Run& run);
void add_profile(CLI::App& app, Run& run);
// Prints completion scripts. Hidden; after all other commands.
void add_complete(CLI::App& app, Run& run);

} // namespace brittle::tools
