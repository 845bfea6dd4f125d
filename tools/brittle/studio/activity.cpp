#include "tools/brittle/studio/activity.h"

#include <new>
#include <utility>

namespace brittle::tools {

void Activity::start(const std::string& what, Worker::Task task) {
    name_ = what;
    share_ = -1.0;
    worker_.run([this, task = std::move(task)](const Worker::Cancelled& cancelled) {
        try {
            task(cancelled);
        } catch (const Failure& failure) {
            post([this, failure] { failed_(failure); });
        } catch (const std::bad_alloc&) {
            post([this] { say({"out of memory: use a smaller mesh or fewer sites", true}); });
        }
    });
}

void Activity::post(std::function<void()> completion) {
    const std::scoped_lock lock(mutex_);
    completions_.push_back(std::move(completion));
    if (wake_) wake_();
}

void Activity::wake_by(std::function<void()> wake) {
    const std::scoped_lock lock(mutex_);
    wake_ = std::move(wake);
}

void Activity::deliver() {
    std::vector<std::function<void()>> completions;
    {
        const std::scoped_lock lock(mutex_);
        completions.swap(completions_);
    }
    for (const auto& completion : completions) completion();
}

std::optional<Activity::Work> Activity::work() const {
    if (!worker_.busy()) return std::nullopt;
    return Work{name_, share_};
}

bool Activity::idle() const {
    return !worker_.busy() && !has_results();
}

bool Activity::has_results() const {
    const std::scoped_lock lock(mutex_);
    return !completions_.empty();
}

} // namespace brittle::tools
