// Pieces into files, as the options of `brittle fracture` say.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "tools/brittle/commands.h"

namespace brittle::tools {

// The files written, the one to open first. Throws a Failure.
std::vector<std::filesystem::path> write_pieces(const FractureCommand& command, const Input& input, const Broken& broken,
                                                const std::string& recipe);

} // namespace brittle::tools
