// Work on the objects of a scene, side by side. A failure is kept until all objects are done, so that the first one in
// the scene's order reports its own, whatever the number of threads.
//
//     ObjectLoop loop(scene, host, progress, scene.objects.size());
//     loop.run(all, [&](size_t object) { made[object] = make(scene.objects[object], loop.threads_for(object)); });
#pragma once

#include <cstdint>
#include <functional>
#include <mutex>
#include <span>

#include "fracture/base/threads.h"
#include "tools/scenario/recipe/host.h"
#include "tools/scenario/run/scene.h"

namespace brittle::tools {

class ObjectLoop {
  public:
    // `progress` is called by one thread at a time, with rising shares up to 1 once `total` objects are done.
    ObjectLoop(const LoadedScene& scene, const Host& host, const std::function<void(double)>& progress, size_t total)
        : scene_(scene), host_(host), progress_(progress), total_(total), threads_(scene.threads) {}

    // Sets the objects among which threads_for() divides the threads; none at first.
    void share_among(std::span<const size_t> objects);
    // All threads help with an object that is more than a thread's share of the work; others get one.
    [[nodiscard]] uint32_t threads_for(size_t object) const;

    // Calls body(object), on any thread, for each of the objects. Throws the Failure of the first one that has one, and
    // names it; also a Failure if the host has cancelled.
    void run(std::span<const size_t> objects, const std::function<void(size_t object)>& body);

  private:
    const LoadedScene& scene_;
    const Host& host_;
    const std::function<void(double)>& progress_;
    size_t total_, done_ = 0, cost_ = 0;
    fracture::Threads threads_;
    std::mutex reporting_;
};

} // namespace brittle::tools
