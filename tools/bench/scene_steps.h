// Benchmarks of a step of scenes.h, all of whose bodies collide, without sleep.
//
// scene/pyramid     1,275 cubes, standing
// scene/dominoes    200 dominoes, three seconds of the wave
// scene/cards       a house of four levels
// scene/convex_pile, scene/junkyard, scene/pyramids   as Box3D's, rebuilt from their descriptions
//
// The time is the median, over the steps, of the median time of each step over the runs: a disturbed frame of one run
// does not count. `p95` is the 95th percentile of those, `longest` the longest. `bodies` is their number and `contacts`
// the number of touching points at the end. Milliseconds of wall time.
#pragma once

namespace brittle::tools {

void add_scene_benchmarks();

} // namespace brittle::tools
