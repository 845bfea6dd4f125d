// Makes a failing case smaller while it keeps failing, for people to look at.
#pragma once

#include <functional>

#include "tools/stress/case.h"

namespace brittle::stress {

// Drops sites, then whole components of the mesh, then contracts edges (closed meshes stay closed), then rounds
// coordinates, as long as `fails` says yes; asks it at most `tries` times.
[[nodiscard]] Case shrink(Case c, const std::function<bool(const Case&)>& fails, unsigned tries);

} // namespace brittle::stress
