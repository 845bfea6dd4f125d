// The narrow phase: contacts of all pairs whose bounds overlap, on several threads.
//
// A pair's contacts change nothing but themselves, so pairs are updated side by side and nothing depends on the
// number of threads.
#pragma once

#include "fracture/base/threads.h"
#include "physics/solver/pair_contacts.h"
#include "physics/solver/sweep_broadphase.h"

namespace brittle::physics {

// For the pairs of which bounds were set when pairs were last found and of which a body is awake.
void find_contacts(SweptPairs& pairs, const ContactStep& step, fracture::Threads& threads);

} // namespace brittle::physics
