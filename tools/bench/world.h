// Benchmarks of a step of the world while the bunny, a metre high and in pieces, falls from 30 cm.
//
// world/meet/N             about N pieces, all of which collide
// world/alone/N            as meet, on one thread
// world/default/N          as meet, with the world's defaults: a piece below WorldSettings::debris_size is debris, and
//                          so is a piece that is added while max_colliding pieces collide
// world/debris/N           as meet, with all pieces as debris
// world/vacuum/1000        as meet, without air
// world/.../1000_of_3000   a thousand pieces fall beside two thousand that sleep on the ground
// world/add/KIND/...       a thousand pieces are added in one frame to a world of a thousand falling and two thousand
//                          sleeping pieces. meet: all collide. default: the world's defaults, so that most new pieces
//                          are debris for lack of room. onto: as default, on top of the others. small: without a limit,
//                          but the new pieces are those of a bunny of 15 cm, so that most are debris by size. apart: as
//                          default, but the new pieces were bonded, and all bonds break before a step; a frame is the
//                          step and Structure::update()
//
// The time is the median of the 180 steps of a second and a half: fall, impact, and the heap that is left. `low` and
// `high` are the lowest and the highest of that median over the runs. In the median run: `fall`, `impact` and `heap`,
// the medians of those parts (steps 2 to 30, 31 to 90, 91 to 180); `first`, the step in which all pairs are new;
// `most`, the longest of the others. `forms` is the time for making the body forms ahead, `add` the time for adding
// them, `awake` the number of awake pieces at the end, `asleep` the number of sleeping pieces at the start.
//
// world/add has forty runs of the same steps, with the new pieces and without. The time is the longest frame of the
// second after, adding the bodies included, as the mean of the runs. By the least time of each step over the runs:
// `before`, the median of the quarter of a second before; `first`, the frame in which the pieces are added; `longest`
// and `after`, the longest and the median of the second from there on; `ratio`, longest by before. `ratio_of_medians`
// is that ratio by the median time of each step, `ratio_of_single_frames` the median of the ratio of each run, and
// ..._without are those of the runs without new pieces. `colliding` is the number of awake pieces afterwards that are
// no debris.
//
// Milliseconds of wall time, as a step works on all cores: run it on an idle machine.
#pragma once

namespace brittle::tools {

void add_world_benchmarks();

} // namespace brittle::tools
