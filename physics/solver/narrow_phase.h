// The narrow phase: contacts of all pairs whose bounds overlap, on several threads.
//
// The update of a pair writes to that pair only, so results do not depend on the number of threads.
#pragma once

#include "fracture/base/threads.h"
#include "physics/solver/pair_contacts.h"
#include "physics/solver/sweep_broadphase.h"

namespace brittle::physics {

// Updates the contacts of the pairs with an awake body whose bounds were set when pairs were last found.
void find_contacts(SweptPairs& pairs, const ContactStep& step, fracture::Threads& threads);

} // namespace brittle::physics
