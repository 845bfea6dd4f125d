#include "physics/cutting/background.h"

#if defined(__linux__)
#include <sched.h>
#include <sys/resource.h>
#include <sys/syscall.h>
#include <unistd.h>

#include <algorithm>
#include <cstdint>
#endif

namespace brittle::physics {

namespace {

#if defined(__linux__)
// A tenth of the weight: on a machine where all cores work, a job still gets done. It has the core for a tenth of a millisecond
// at a time (ns; Linux 6.12, before it is not looked at): a step that works on all cores waits at the end of a loop
// for the thread that was put aside.
constexpr int nice_increment = 10;
constexpr uint64_t slice_ns = 100'000;
constexpr int max_nice = 19;

// As sched_setattr(2) has it: the kernel's header and glibc's cannot both be included.
struct SchedAttributes {
    uint32_t size = sizeof(SchedAttributes);
    uint32_t policy = SCHED_OTHER;
    uint64_t flags = 0;
    int32_t nice = 0;
    uint32_t priority = 0;
    uint64_t runtime = 0, deadline = 0, period = 0; // ns
};
#endif

} // namespace

void yield_to_frames() {
#if defined(__linux__)
    SchedAttributes attributes;
    attributes.nice = std::min(getpriority(PRIO_PROCESS, 0) + nice_increment, max_nice);
    attributes.runtime = slice_ns;
    (void)syscall(SYS_sched_setattr, 0, &attributes, 0); // 0: this thread; who may not stays as he is
#endif
}

} // namespace brittle::physics
