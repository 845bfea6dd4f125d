#include "tools/brittle/studio/worker.h"

#include <utility>

namespace brittle::tools {

Worker::Worker() : thread_([this] { work(); }) {}

Worker::~Worker() {
    {
        const std::scoped_lock lock(mutex_);
        ending_ = true;
        waiting_ = nullptr;
        cancelled_ = true;
    }
    wake_.notify_one();
    thread_.join();
}

void Worker::run(Task task) {
    {
        const std::scoped_lock lock(mutex_);
        waiting_ = std::move(task);
        busy_ = true;
    }
    wake_.notify_one();
}

void Worker::cancel() {
    const std::scoped_lock lock(mutex_);
    waiting_ = nullptr;
    cancelled_ = true;
    busy_ = running_;
}

void Worker::work() {
    std::unique_lock lock(mutex_);
    for (;;) {
        wake_.wait(lock, [this] { return ending_ || waiting_; });
        if (ending_) return;
        const Task task = std::exchange(waiting_, nullptr);
        cancelled_ = false;
        running_ = true;
        lock.unlock();
        task([this] { return cancelled_.load(); });
        lock.lock();
        running_ = false;
        busy_ = waiting_ != nullptr;
    }
}

} // namespace brittle::tools
