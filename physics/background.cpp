#include "physics/background.h"

#if defined(__linux__)
#include <linux/sched/types.h>
#include <sched.h>
#include <sys/resource.h>
#include <sys/syscall.h>
#include <unistd.h>

#include <algorithm>
#endif

namespace brittle::physics {

namespace {

#if defined(__linux__)
// A tenth of the weight: on a machine where all cores work, a job still gets done. It has the core for a tenth of a millisecond
// at a time (ns; Linux 6.12, before it is not looked at): a step that works on all cores waits at the end of a loop
// for the thread that was put aside.
constexpr int lower = 10;
constexpr uint64_t at_a_time = 100'000;
constexpr int lowest = 19;
#endif

} // namespace

void yield_to_frames() {
#if defined(__linux__)
    sched_attr attributes{};
    attributes.size = sizeof(attributes);
    attributes.sched_policy = SCHED_OTHER;
    attributes.sched_nice = std::min(getpriority(PRIO_PROCESS, 0) + lower, lowest);
    attributes.sched_runtime = at_a_time;
    (void)syscall(SYS_sched_setattr, 0, &attributes, 0); // 0: this thread; who may not stays as he is
#endif
}

} // namespace brittle::physics
