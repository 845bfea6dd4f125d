// Benchmarks of destruction.h: what an impact costs the main thread, and what a thousand fresh bodies do to a frame.
#pragma once

namespace brittle::tools {

// impact/MESH, from contact to commit, damage radius a tenth of the mesh's size. Milliseconds, of the
//   main thread's own work: `commit` the longest update(); of the clock: `frame_before` and `frame_after` the median of step
//   and update, `wait` from the blow to the pieces, `prepare` an unbroken object's hulls and masses (once, on any thread).
// impact/1000_bodies: `before` is the median frame of a pile of 300 awake pieces, with 30 whole objects beside it; `longest` the
//   longest while those become 1,000 pieces, `share` the longest update() in it, `after` the median then.
// cycles/10000: breaking and clearing; `KB_growth` is heap of the last cycle less that of the thousandth.
void add_impact_benchmarks();

} // namespace brittle::tools
