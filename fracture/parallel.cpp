#include "fracture/parallel.h"

#include <algorithm>
#include <atomic>
#include <thread>
#include <vector>

#include <tbb/parallel_for.h>
#include <tbb/task_arena.h>

namespace brittle::fracture {

namespace {
// Chunks a thread takes on average: more even out unequal work, fewer keep the per-chunk tables small.
constexpr uint32_t kChunksPerThread = 4;
constexpr uint32_t kMostThreads = 256;

#if defined(__SANITIZE_THREAD__)
// ThreadSanitizer cannot see how Debian's TBB, which is built without it, synchronises: plain threads take its place.
template<class Body>
void parallel(uint32_t threads, uint32_t count, const Body& body) {
    std::atomic<uint32_t> next = 0;
    std::vector<std::jthread> workers;
    for (uint32_t t = 0; t < threads; ++t) {
        workers.emplace_back([&] {
            for (uint32_t k = next++; k < count; k = next++) body(k);
        });
    }
}
#endif
} // namespace

struct Threads::Arena {
    explicit Arena(uint32_t threads) : arena(static_cast<int>(threads)) {}
    tbb::task_arena arena;
};

Threads::Threads(uint32_t count)
    : count_(std::clamp(count == 0 ? std::thread::hardware_concurrency() : count, 1u, kMostThreads)),
      arena_(count_ > 1 ? std::make_unique<Arena>(std::clamp(std::thread::hardware_concurrency(), 2u, count_))
                        : nullptr) {}

Threads::~Threads() = default;
Threads::Threads(Threads&&) noexcept = default;
Threads& Threads::operator=(Threads&&) noexcept = default;

uint32_t Threads::chunks(uint32_t n, uint32_t least) const {
    if (count_ == 1) return 1;
    return std::clamp(n / std::max(least, 1u), 1u, kChunksPerThread * count_);
}

void Threads::run(uint32_t n, uint32_t count, Call invoke, const void* body) {
    void* const callee = const_cast<void*>(body);
    const auto bound = [&](uint32_t k) {
        return static_cast<uint32_t>(static_cast<uint64_t>(n) * k / count);
    };
    if (count == 1 || !arena_) {
        for (uint32_t k = 0; k < count; ++k) invoke(callee, k, bound(k), bound(k + 1));
        return;
    }
    const auto chunk = [&](uint32_t k) { invoke(callee, k, bound(k), bound(k + 1)); };
#if defined(__SANITIZE_THREAD__)
    parallel(count_, count, chunk);
#else
    arena_->arena.execute([&] { tbb::parallel_for(uint32_t{0}, count, chunk, tbb::simple_partitioner{}); });
#endif
}

} // namespace brittle::fracture
