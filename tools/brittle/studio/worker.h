// A thread for work that the window must not wait for. One task runs at a time; one more may wait, and the newest takes
// its place: for previews, of which only the last counts.
//
//     worker.run([=](const Worker::Cancelled& cancelled) { result = slow(cancelled); });
//
// A task hands its result over by its own means (under a mutex) and must not throw. The destructor cancels and waits.
#pragma once

#include <atomic>
#include <condition_variable>
#include <functional>
#include <mutex>
#include <thread>

namespace brittle::tools {

class Worker {
  public:
    using Cancelled = std::function<bool()>;
    using Task = std::function<void(const Cancelled&)>;

    Worker();
    ~Worker();
    Worker(const Worker&) = delete;
    Worker& operator=(const Worker&) = delete;

    void run(Task task);
    void cancel();                                    // what runs is asked to end, what waits is dropped
    [[nodiscard]] bool busy() const { return busy_; } // something runs or waits

  private:
    void work();

    mutable std::mutex mutex_;
    std::condition_variable wake_;
    Task waiting_;
    std::atomic<bool> busy_ = false;
    std::atomic<bool> cancelled_ = false;
    bool running_ = false;
    bool ending_ = false;
    std::thread thread_; // last: starts when all else is there
};

} // namespace brittle::tools
