// The steps of a repair, in the order in which repair.cpp takes them. Each says whether it changed anything,
// and a step that has nothing to do changes no bit: so the steps can be repeated until none has.
#pragma once

#include "fracture/doctor/mending/work.h"

namespace brittle::fracture::mending {

// Vertices on rims (edges that an odd number of triangles use) that are no farther apart than `distance`
// become the first of them, directly or along a chain. Positions do not change.
bool weld_rims(Work& work, double distance);

// Triangles that name a vertex twice: their other two sides cancel, so nothing opens.
bool drop_degenerate(Work& work);

// Of triangles with the same corners and orientation all but the first. Of those with both orientations one
// or none, whichever leaves fewer edges open around them.
bool drop_duplicates(Work& work);

bool drop_spare_patches(Work& work);

// Turns triangles so that neighbours agree.
bool orient_neighbours(Work& work);

// Fills rims. Must see no degenerate triangles.
bool close_holes(Work& work, const RepairSettings& settings);

// Turns closed parts outwards, cavities inwards.
bool turn_parts(Work& work, bool cavities);

// Drops parts that pass through no other and have solid on both sides, or on neither, by the turns of the others around
// them: of two solids one inside the other the outer one is left.
bool drop_covered(Work& work);

// Separates what only touches.
bool separate(Work& work);

} // namespace brittle::fracture::mending
