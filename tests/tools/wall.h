// A wall of 30 concrete bricks that stands on the ground: bonded pieces for tests.
#pragma once

#include "tools/scenario/recipe/input.h"

namespace brittle::tools::test {

inline FractureOptions wall_options() {
    FractureOptions options;
    options.mesh = "shape:wall";
    use_material("concrete", options);
    options.pattern.kind = fracture::PatternKind::bricks;
    options.pattern.count = 30;
    options.world.anchored = true;
    return options;
}

} // namespace brittle::tools::test
