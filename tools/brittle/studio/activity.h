// The session's long work and its messages: tasks run on a worker, their results and failures arrive in the window's
// thread.
//
//     activity.start("reading bunny.obj", [&](const Worker::Cancelled& cancelled) {
//         auto mesh = read(cancelled);                       // on the worker; may throw a Failure
//         activity.post([&, mesh] { use(mesh); });           // runs in deliver()
//     });
//     each frame: activity.deliver();
//
// post() and set_share() may be called from the task, all other functions from the window's thread only.
#pragma once

#include <atomic>
#include <functional>
#include <mutex>
#include <optional>
#include <string>
#include <vector>

#include "tools/brittle/studio/worker.h"
#include "tools/scenario/base/failure.h"

namespace brittle::tools {

struct Message {
    std::string text{};
    bool fault = false;
    std::string mend{}; // path of a mesh that repair would make closed; or empty
};

class Activity {
  public:
    struct Work {
        std::string what;
        double share = 0.0; // share that is done; negative: unknown
    };

    // `failed` receives the failures of tasks, in deliver().
    explicit Activity(std::function<void(const Failure&)> failed) : failed_(std::move(failed)) {}

    // Starts a task. `what` names it for people.
    void start(const std::string& what, Worker::Task task);
    // Queues a function for the next deliver().
    void post(std::function<void()> completion);
    void set_share(double share) { share_ = share; }
    // Sets what post() calls, on any thread, so that a window which waits for events looks for the result.
    void wake_by(std::function<void()> wake);
    // Runs the functions queued by post(). Called once per frame.
    void deliver();
    void cancel() { worker_.cancel(); }

    [[nodiscard]] std::optional<Work> work() const;
    [[nodiscard]] bool busy() const { return worker_.busy(); }
    // Whether no task runs or waits and no function is queued.
    [[nodiscard]] bool idle() const;
    [[nodiscard]] bool has_results() const; // whether a function is queued

    [[nodiscard]] const Message& message() const { return message_; }
    void say(Message message) { message_ = std::move(message); }

  private:
    std::function<void(const Failure&)> failed_;
    Message message_;
    mutable std::mutex mutex_;
    std::vector<std::function<void()>> completions_;
    std::function<void()> wake_;
    std::string name_;
    std::atomic<double> share_ = 0.0;
    Worker worker_; // last: its destructor waits for tasks, which use the other members
};

} // namespace brittle::tools
