#include "physics/background.h"

#if defined(__linux__)
#include <sched.h>
#endif

namespace brittle::physics {

// At the usual priority, or a lower one that still gets its turn, a step that works on all cores waits several milliseconds at the
// end of a loop for the thread that was put aside.
void yield_to_frames() {
#if defined(__linux__)
    const sched_param idle{};
    (void)sched_setscheduler(0, SCHED_IDLE, &idle); // 0: this thread; who may not stays as he is
#endif
}

} // namespace brittle::physics
