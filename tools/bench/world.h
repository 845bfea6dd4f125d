// How long a step of the world takes while the bunny, a metre high, falls to pieces from 30 cm.
//
// world/meet/N             about N pieces, all of which meet
// world/alone/N            the same on one thread
// world/default/N          the same with the world's defaults: what is smaller than WorldSettings::debris_size is debris, and
//                          what comes when max_colliding do collide
// world/debris/N           the same as debris: pieces meet the ground only
// world/vacuum/1000        as meet, without air
// world/.../1000_of_3000   a thousand pieces fall beside two thousand that lie on the ground and sleep
// world/add/KIND/...       a thousand pieces come in one frame into a world of a thousand falling ones and two thousand that
//                          sleep. meet: all meet. default: the world's defaults, so most that come are debris as there is no
//                          room. onto: likewise, onto those that are there. small: no limit, but what comes is 15 cm in all,
//                          and most of it debris for its size. apart: likewise default, but what comes was bonded, and all
//                          bonds break before a step: a frame is the step and Structure::update
//
// The time is the median of the 180 steps of a second and a half: fall, impact, and the heap that is left. `low` and `high`
// are the lowest and the highest of that median over the runs; `fall`, `impact` and `heap` the medians of those parts
// (steps 2 to 30, 31 to 90, 91 to 180), `first` the step in which all pairs are new, `most` the worst of the others, in the median run.
// `forms` is what making the bodies takes ahead, `add` what is left then, `awake` how many still are in the end, `asleep` how many slept at the
// start.
//
// For world/add, in forty runs of the same steps, with newcomers and without: the time is the longest frame of the second after,
// adding the bodies included, mean of the runs. `before` is the median of the quarter of a second before, `first` the frame in which
// they come, `longest` and `after` the longest and the median of the second from there on, all by the least time of each step; `ratio`
// the longest over the median before, `ratio_of_medians` the same by the median of each step, `ratio_of_single_frames` the median of
// what each run by itself comes to, and ..._without the same of runs in which nobody comes. `colliding` counts who is awake and no
// debris then.
//
// Milliseconds on the clock, as a step works on all cores: on a machine by itself.
#pragma once

namespace brittle::tools {

void add_world_benchmarks();

} // namespace brittle::tools
