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
// A nice increment of 10 is about a tenth of the weight, so jobs progress on a machine whose cores are all busy. The
// time slice, ns, is a tenth of a millisecond: a step on all cores waits at the end of a parallel loop for the thread
// that a job displaced. Linux before 6.12 ignores the slice.
constexpr int nice_increment = 10;
constexpr uint64_t slice_ns = 100'000;
constexpr int max_nice = 19;

// struct sched_attr of sched_setattr(2). Declared here because the kernel's header conflicts with glibc's.
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
    (void)syscall(SYS_sched_setattr, 0, &attributes, 0); // 0: this thread; without permission its priority stays
#endif
}

} // namespace brittle::physics
