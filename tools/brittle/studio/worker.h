// A thread for work that must not block the window. One task runs at a time and one more may wait; a newer task
// replaces the waiting one, as previews need only the last request.
//
//     worker.run([=](const Worker::Cancelled& cancelled) { result = slow(cancelled); });
//
// A task passes on its result by its own means (under a mutex) and must not throw. The destructor cancels and waits.
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
    void cancel();                                    // asks the running task to end and drops the waiting one
    [[nodiscard]] bool busy() const { return busy_; } // whether a task runs or waits

  private:
    void work();

    mutable std::mutex mutex_;
    std::condition_variable wake_;
    Task waiting_;
    std::atomic<bool> busy_ = false;
    std::atomic<bool> cancelled_ = false;
    bool running_ = false;
    bool ending_ = false;
    std::thread thread_; // last: starts when all other members exist
};

} // namespace brittle::tools
