// Who touches whom after a fracture: a bond for each pair of pieces that share a cap.
#pragma once

#include <span>

#include "fracture/exact/assemble.h"
#include "fracture/exact/islands.h"

namespace brittle::fracture::exact {

// Fills out.bonds, ordered by (a, b). Several caps between two pieces (a facet cut into separate regions)
// make one bond; caps without area make none.
void find_bonds(const Assembler::Input& input, const Assembler& assembler, const IslandSplitter& islands,
                Fragments& out);

} // namespace brittle::fracture::exact
