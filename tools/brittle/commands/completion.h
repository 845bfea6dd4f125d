// Completion scripts for shells: commands, options, their words, files and built-in shapes.
//
//     source <(brittle complete bash)
#pragma once

#include <string>
#include <vector>

#include "tools/brittle/commands/option_table.h"

namespace brittle::tools {

// Each returns the script. `shapes`: the words after "shape:".
[[nodiscard]] std::string bash_completion(const ProgramEntry& program, const std::vector<std::string>& shapes);
[[nodiscard]] std::string zsh_completion(const ProgramEntry& program, const std::vector<std::string>& shapes);
[[nodiscard]] std::string fish_completion(const ProgramEntry& program, const std::vector<std::string>& shapes);

} // namespace brittle::tools
