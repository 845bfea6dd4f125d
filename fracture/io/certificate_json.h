// A certificate as JSON, for reports and for the extras of exported files.
#pragma once

#include <string>

#include "fracture/pieces/fragments.h"

namespace brittle::fracture {

// A JSON object with the members of Certificate under their names, the hash as 16 hexadecimal digits.
[[nodiscard]] std::string certificate_json(const Certificate& certificate);

} // namespace brittle::fracture
