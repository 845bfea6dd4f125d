// How long a step of the world takes while the bunny, a metre high, falls to pieces from 30 cm.
//
// world/bunny/N           about N pieces, all of which meet
// world/debris/N          the same as debris: pieces meet the ground only (WorldSettings::debris_size)
// world/.../1000_of_3000  a thousand pieces fall beside two thousand that sleep
//
// The time is the median of the 180 steps of a second and a half, `most` the worst but for the first, `first` that one, in
// which all pairs are new; `hulls` and `add` are what making the bodies takes, `awake` how many still are in the end, `asleep`
// how many slept at the start. Milliseconds.
#pragma once

namespace brittle::tools {

void add_world_benchmarks();

} // namespace brittle::tools
