// The steps of a repair, in the order in which repair.cpp calls them. Each returns whether it changed anything, and a
// step without work changes no bit, so the steps can repeat until none has work.
#pragma once

#include "fracture/doctor/mending/work.h"

namespace brittle::fracture::mending {

// Merges vertices on rims (edges with an odd number of triangles) within `distance` of each other into the first of
// them, directly or along a chain. Positions do not change.
bool weld_rims(Work& work, double distance);

// Drops triangles that name a vertex twice. Their other two sides cancel, so no edge opens.
bool drop_degenerate(Work& work);

// Drops all but the first of triangles with equal corners and orientation. Of triangles with both orientations keeps
// one or none, whichever leaves fewer open edges around them.
bool drop_duplicates(Work& work);

bool drop_spare_patches(Work& work);

// Turns triangles so that neighbours agree.
bool orient_neighbours(Work& work);

// Fills rims. The mesh has no degenerate triangles.
bool close_holes(Work& work, const RepairSettings& settings);

// Turns closed parts outwards, cavities inwards.
bool turn_parts(Work& work, bool cavities);

// Drops parts that pass through no other and have solid on both sides, or on neither, by the winding number of the
// other parts around them: of two solids, one inside the other, the outer one remains.
bool drop_covered(Work& work);

// Separates parts that only touch, in edges with more than two triangles and in vertices with several fans.
bool separate(Work& work);

} // namespace brittle::fracture::mending
