// Benchmarks of the cuts that blows make: how their cost grows with the mesh, with the damage, and from blow to blow.
#pragma once

namespace brittle::tools {

// blow/MESH              blows with a damage radius of a tenth of the size of an object, cut on one thread, without a
//                        world. Milliseconds: `first`, the median of ten blows to the whole object at ten places;
//                        `later`, the median of ten blows in a row, each to the largest piece that the one before has
//                        left; `first_max` and `later_max`, the longest; `whole`, the median of three blows that cut
//                        the whole mesh, up to 2 million triangles; `prepare`, the hulls, masses and clusters of
//                        the whole object (made once). ball_20972k takes 12 GB of memory
// blow/MESH/small, /large, /rough  a radius of 3 or of 20 hundredths of the size; rough cuts
// blow/MESH/as_many      a radius that holds as many triangles as that of ball_82k
void add_blow_benchmarks();

} // namespace brittle::tools
