// What statics and mechanics say about the scenes of scenes.h.
//
// Pure functions, in double precision.
#pragma once

#include "tools/bench/scenes.h"

namespace brittle::tools {

// Returns the least thickness, in mean radii, at which a semicircular arch of `stones` equal wedges, an odd number, can
// stand: that of the thinnest arch whose line of thrust crosses every joint inside it (Heyman, "The stone skeleton",
// 1966). Stones do not slide, have no tensile strength between them, and do not crush. With many stones it is 0.1075
// (Milankovitch, 1907).
[[nodiscard]] double min_arch_thickness(int stones);

// Returns the speed, m/s, at which a wave runs along a row of dominoes far from its beginning (van Leeuwen, "The domino
// effect", American Journal of Physics 78, 2010): feet do not slip, collisions are inelastic, and every fallen domino
// leans on the next one and pushes it, with friction. 0 if the wave dies.
[[nodiscard]] double domino_wave_speed(const Dominoes& row);

} // namespace brittle::tools
