// Benchmarks of destruction.h: what an impact costs the main thread, and what a thousand fresh bodies do to a frame.
#pragma once

namespace brittle::tools {

// impact/MESH: a thing of 2 m that stands beside 1,000 awake pieces and 2,000 that sleep is hit by a ball, damage radius a tenth
//   of its size. Milliseconds, of the main thread's own work: `commit` the longest update() from the ball's flight to the
//   pieces; of the clock: `frame_before` and `frame_after` the median of step and update, `wait` from the contact to the pieces,
//   `prepare` an unbroken object's hulls and masses (once, on any thread). `reach`, m: of what came off, from the point.
// impact/1000_bodies: `before` is the median frame of a pile of 300 awake pieces, with 30 whole balls on the ground beside it;
//   `longest` the longest while those are struck and become 1,000 pieces, `share` the longest update() in it, `after` the median
//   then. Medians of three runs.
// impact/1000_in_crowd: the same beside 1,000 awake pieces and 2,000 that sleep.
// cycles/10000: breaking and clearing; `KB_growth` is heap of the last cycle less that of the thousandth.
void add_impact_benchmarks();

} // namespace brittle::tools
