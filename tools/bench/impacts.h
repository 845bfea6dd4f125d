// Benchmarks of destruction.h: the cost of an impact for the main thread, and of a thousand new bodies for a frame.
#pragma once

namespace brittle::tools {

// impact/MESH            a ball hits an object of 2 m beside 1,000 awake and 2,000 sleeping pieces, with a damage
//                        radius of a tenth of the object's size. Milliseconds. CPU time of the main thread: `commit`,
//                        the longest update() between the ball's flight and the commit. Wall time: `frame_before` and
//                        `frame_after`, the median of step and update; `wait`, from the contact to the commit;
//                        `prepare`, the hulls and masses of the unbroken object (made once, on any thread). `reach`, m:
//                        largest distance from the contact to a piece that came off
// impact/1000_bodies     30 whole balls on the ground beside a pile of 300 awake pieces are struck and become 1,000
//                        pieces. `before`, the median frame until then; `longest`, the longest frame during the breaks;
//                        `share`, the longest update() in it; `after`, the median frame afterwards. Medians of three
//                        runs
// impact/1000_in_crowd   as impact/1000_bodies, beside 1,000 awake and 2,000 sleeping pieces
// cycles/10000           breaking and clearing; `KB_growth` is the heap after the last cycle less the heap after the
//                        thousandth
void add_impact_benchmarks();

} // namespace brittle::tools
