// Shrinks a failing case to one that is small enough to read.
#pragma once

#include <functional>

#include "tools/stress/case.h"

namespace brittle::stress {

// Drops sites, then whole components of the mesh, then contracts edges (closed meshes stay closed), then rounds
// coordinates, and keeps each change for which `fails` returns true. Calls `fails` at most `tries` times.
[[nodiscard]] Case shrink(Case c, const std::function<bool(const Case&)>& fails, unsigned tries);

} // namespace brittle::stress
