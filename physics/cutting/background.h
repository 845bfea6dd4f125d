// Jobs on worker threads, for one owner. Jobs start in the order given; each can be waited for or cancelled by itself.
//
//     Background<Pieces> background(2);
//     background.start(7, [=](const std::atomic<bool>& cancelled) { return cut(solid, cancelled); });
//     if (background.ready(7)) Pieces pieces = background.take(7);
//
// All calls come from the owner's thread. The destructor cancels all jobs and waits for those that run. What a job throws,
// take() throws. On Linux the workers have a low priority, so that they do not delay frames (yield_to_frames()).
#pragma once

#include <algorithm>
#include <atomic>
#include <cassert>
#include <condition_variable>
#include <cstdint>
#include <deque>
#include <exception>
#include <functional>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <thread>
#include <utility>
#include <vector>

namespace brittle::physics {

// Lowers the priority of this thread and of threads that it starts from now on. Does nothing outside Linux.
void yield_to_frames();

template<class Value>
class Background {
  public:
    using Work = std::function<Value(const std::atomic<bool>& cancelled)>;

    explicit Background(uint32_t threads = 1) {
        for (uint32_t i = 0; i < std::max(threads, 1u); ++i) threads_.emplace_back([this] { run(); });
    }
    ~Background() {
        {
            const std::scoped_lock lock(mutex_);
            ending_ = true;
            queue_.clear();
            for (const auto& [id, job] : jobs_) job->cancelled = true;
        }
        work_came_.notify_all();
        for (std::thread& thread : threads_) thread.join();
    }
    Background(const Background&) = delete;
    Background& operator=(const Background&) = delete;

    // An id names one job until the job is taken or cancelled.
    void start(uint32_t id, Work work) {
        const auto job = std::make_shared<Job>();
        job->work = std::move(work);
        {
            const std::scoped_lock lock(mutex_);
            assert(!jobs_.contains(id));
            jobs_.emplace(id, job);
            queue_.push_back(job);
        }
        work_came_.notify_one();
    }
    [[nodiscard]] bool ready(uint32_t id) { return jobs_.at(id)->done; }
    // Waits for the job if it is not ready.
    Value take(uint32_t id) {
        std::unique_lock lock(mutex_);
        const std::shared_ptr<Job> job = jobs_.at(id);
        work_done_.wait(lock, [&] { return job->done.load(); });
        jobs_.erase(id);
        if (job->failure) std::rethrow_exception(std::move(job->failure)); // no worker owns it any more
        return std::move(*job->value);
    }
    // Forgets a job. Its result, finished or not, is destroyed on a worker thread.
    void cancel(uint32_t id) {
        std::shared_ptr<Job> job;
        {
            const std::scoped_lock lock(mutex_);
            assert(jobs_.contains(id));
            job = std::move(jobs_.extract(id).mapped());
            job->cancelled = true;
            std::erase(queue_, job);
        }
        discard(std::move(job));
    }
    // Releases an object on a worker thread, before the next job there. Freeing large blocks of memory takes
    // milliseconds.
    void discard(std::shared_ptr<const void> last) {
        {
            const std::scoped_lock lock(mutex_);
            discarded_.push_back(std::move(last));
        }
        work_came_.notify_one();
    }

  private:
    struct Job {
        Work work;
        std::atomic<bool> cancelled = false;
        std::optional<Value> value; // written by the worker until done is set, as is failure; one of them is set then
        std::exception_ptr failure;
        std::atomic<bool> done = false;
    };

    void run() {
        yield_to_frames();
        for (;;) {
            std::vector<std::shared_ptr<const void>> discarded;
            std::shared_ptr<Job> job;
            {
                std::unique_lock lock(mutex_);
                work_came_.wait(lock, [this] { return ending_ || !queue_.empty() || !discarded_.empty(); });
                if (ending_) return;
                discarded.swap(discarded_);
                if (!queue_.empty()) {
                    job = queue_.front();
                    queue_.pop_front();
                }
            }
            discarded.clear();
            if (!job) continue;
            std::optional<Value> value;
            std::exception_ptr failure;
            try {
                value = job->work(job->cancelled);
            } catch (...) {
                failure = std::current_exception();
            }
            job->work = nullptr; // destroys the captures here, not on the owner's thread
            {
                const std::scoped_lock lock(mutex_);
                job->value = std::move(value);
                job->failure = std::move(failure);
                job->done = true;
            }
            work_done_.notify_all();
        }
    }

    std::mutex mutex_;
    std::condition_variable work_came_, work_done_;
    std::deque<std::shared_ptr<Job>> queue_;
    std::map<uint32_t, std::shared_ptr<Job>> jobs_;
    std::vector<std::shared_ptr<const void>> discarded_;
    bool ending_ = false;
    std::vector<std::thread> threads_;
};

} // namespace brittle::physics
