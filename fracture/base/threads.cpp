#include "fracture/base/threads.h"

#include <algorithm>
#include <atomic>
#include <cassert>
#include <chrono>
#include <condition_variable>
#include <exception>
#include <functional>
#include <mutex>
#include <system_error>
#include <thread>
#include <vector>

// ThreadSanitizer cannot follow the synchronisation of Debian's uninstrumented TBB.
#if defined(BRITTLE_TBB) && !defined(__SANITIZE_THREAD__)
#define BRITTLE_USES_TBB
#include <tbb/parallel_for.h>
#include <tbb/task_arena.h>
#endif

namespace brittle::fracture {

namespace {
// Chunks per thread, on average. More chunks balance uneven work, fewer keep the tables per chunk small.
constexpr uint32_t chunks_per_thread = 4;
constexpr uint32_t max_threads = 256;

#if !defined(BRITTLE_USES_TBB)
// The workers of all loops, in place of TBB. A loop starts those that it lacks, and they stay: threads that were made for
// each loop would cost as much as a short loop, and in a browser a thread cannot start while its maker waits for it.
class Workers {
  public:
    // Never destroyed: the workers wait in it until the process ends.
    static Workers& shared() {
        static auto* const workers = new Workers;
        return *workers;
    }

    // Calls work(0) on this thread and meanwhile work(1) to work(helpers), each on a worker that is free; those for which no
    // worker is free in time are left out. Returns when all calls have. At least one helper; the work must not throw.
    void run(uint32_t helpers, const std::function<void(uint32_t)>& work) {
        assert(helpers >= 1 && helpers < max_threads);
        Job job{work, helpers};
        {
            const std::lock_guard lock(mutex_);
            start(helpers);
            jobs_.push_back(&job);
        }
        for (uint32_t k = 0; k < helpers; ++k) wake_.notify_one();
        work(0);
        std::unique_lock lock(mutex_);
        std::erase(jobs_, &job);
        done_.wait(lock, [&] { return job.running == 0; });
    }

  private:
    struct Job {
        const std::function<void(uint32_t)>& work;
        uint32_t helpers;     // how many workers may join
        uint32_t joined = 0;  // how many have
        uint32_t running = 0; // how many have not returned
    };

    void start(uint32_t count) {
        try {
            for (; free_ < count && !exhausted_; ++free_) std::thread(&Workers::serve, this).detach();
        } catch (const std::system_error&) {
            exhausted_ = true; // the system gives no more threads: loops run on those that there are
        }
    }

    void serve() {
        std::unique_lock lock(mutex_);
        for (;;) {
            wake_.wait(lock, [&] { return !jobs_.empty(); });
            Job& job = *jobs_.front();
            const uint32_t thread = ++job.joined;
            if (thread == job.helpers) jobs_.erase(jobs_.begin());
            ++job.running;
            --free_;
            lock.unlock();
            job.work(thread);
            lock.lock();
            ++free_;
            if (--job.running == 0) done_.notify_all();
        }
    }

    std::mutex mutex_;
    std::condition_variable wake_, done_;
    std::vector<Job*> jobs_; // those that more workers may join, the oldest first
    uint32_t free_ = 0;      // workers that run no job
    bool exhausted_ = false;
};

// Chunks are the same as with TBB, so results are.
template<class Body>
void parallel(uint32_t threads, uint32_t count, const Body& body) {
    std::atomic<uint32_t> next = 0;
    const auto work = [&](uint32_t thread) {
        for (uint32_t k = next++; k < count; k = next++) body(k, thread);
    };
    Workers::shared().run(threads - 1, std::ref(work));
}
#endif

// Carries the first exception of a loop from its thread to the caller. No exception goes through TBB, which may use
// another C++ library.
class Failure {
  public:
    // Calls the body, unless it failed before on any thread.
    template<class Body>
    void guard(const Body& body) noexcept {
        if (failed_) return;
        try {
            body();
        } catch (...) {
            const std::lock_guard lock(mutex_);
            if (!failed_.exchange(true)) exception_ = std::current_exception();
        }
    }
    void rethrow() {
        if (exception_) std::rethrow_exception(exception_);
    }

  private:
    std::atomic<bool> failed_ = false;
    std::mutex mutex_;
    std::exception_ptr exception_;
};

int64_t now() {
    return std::chrono::nanoseconds(std::chrono::steady_clock::now().time_since_epoch()).count();
}
} // namespace

void WorkLog::clear() {
    for (std::vector<Slice>& slices : slices_) slices.clear();
}

struct Threads::Arena {
#if defined(BRITTLE_USES_TBB)
    explicit Arena(uint32_t threads) : arena(static_cast<int>(threads)) {}
    tbb::task_arena arena;
#else
    explicit Arena(uint32_t) {} // loops share their workers
#endif
};

struct Threads::Question {
    explicit Question(const std::function<bool()>& q) : ask(q) {}
    const std::function<bool()>& ask;
    std::mutex asking;
    std::atomic<bool> answered_yes = false;
};

Threads::Threads(uint32_t count)
    : count_(std::clamp(count == 0 ? std::thread::hardware_concurrency() : count, 1u, max_threads)),
      arena_(count_ > 1 ? std::make_unique<Arena>(std::clamp(std::thread::hardware_concurrency(), 2u, count_))
                        : nullptr) {}

Threads::~Threads() = default;
Threads::Threads(Threads&&) noexcept = default;
Threads& Threads::operator=(Threads&&) noexcept = default;

uint32_t Threads::chunks(uint32_t n, uint32_t min_size) const {
    if (count_ == 1) return 1;
    return std::clamp(n / std::max(min_size, 1u), 1u, chunks_per_thread * count_);
}

void Threads::cancel_by(const std::function<bool()>& question) {
    question_ = question ? std::make_unique<Question>(question) : nullptr;
}

void Threads::poll() const {
    if (!question_) return;
    // A thread that finds another one asking goes on; its next poll sees the answer.
    if (const std::unique_lock lock(question_->asking, std::try_to_lock); lock && question_->ask())
        question_->answered_yes = true;
    if (question_->answered_yes) throw Cancelled{};
}

void Threads::log_to(WorkLog* log) {
    log_ = log;
    if (log && log->slices_.size() < count_) log->slices_.resize(count_);
}

template<class Body>
void Threads::each_chunk(uint32_t count, const Body& body) {
    if (count <= 1 || !arena_) {
        for (uint32_t k = 0; k < count; ++k) body(k, 0u);
        return;
    }
    Failure failure;
#if !defined(BRITTLE_USES_TBB)
    parallel(std::min(count_, count), count,
             [&](uint32_t k, uint32_t thread) { failure.guard([&] { body(k, thread); }); });
#else
    arena_->arena.execute([&] {
        const auto chunk = [&](uint32_t k) {
            const auto thread = static_cast<uint32_t>(tbb::this_task_arena::current_thread_index());
            failure.guard([&] { body(k, thread); });
        };
        tbb::parallel_for(uint32_t{0}, count, chunk, tbb::simple_partitioner{});
    });
#endif
    failure.rethrow();
}

void Threads::run(uint32_t n, uint32_t count, Call invoke, const void* body) {
    void* const callee = const_cast<void*>(body);
    const auto bound = [&](uint32_t k) { return static_cast<uint32_t>(static_cast<uint64_t>(n) * k / count); };
    if (!log_) {
        each_chunk(count, [&](uint32_t k, uint32_t) {
            poll();
            invoke(callee, k, bound(k), bound(k + 1));
        });
        return;
    }
    each_chunk(count, [&](uint32_t k, uint32_t thread) {
        poll();
        const int64_t from = now();
        invoke(callee, k, bound(k), bound(k + 1));
        assert(thread < log_->slices_.size());
        log_->slices_[thread].push_back({step_, bound(k), bound(k + 1), from, now()});
    });
}

} // namespace brittle::fracture
