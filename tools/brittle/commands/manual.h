// The manual page brittle.1, in the macros of man(7).
#pragma once

#include <string>

#include "tools/brittle/commands/option_table.h"

namespace brittle::tools {

[[nodiscard]] std::string manual_page(const ProgramEntry& program, const std::string& version);

} // namespace brittle::tools
