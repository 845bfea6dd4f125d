// The menu of materials, of an object or of those that are selected: the materials chosen last, then all of them.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "tools/brittle/studio/recent.h"

namespace brittle::tools {

// Returns the materials of a list that exist, the newest first.
[[nodiscard]] std::vector<std::string> recent_materials(const Recent& recent);

// Draws the menu as the control of a line (widgets.h); `now` is the name of a preset, or empty for none. Returns the name
// that was clicked, and adds it to the list. Call from Dear ImGui's thread, between its new frame and render.
[[nodiscard]] std::optional<std::string> material_menu(const std::string& now, Recent& recent);

} // namespace brittle::tools
