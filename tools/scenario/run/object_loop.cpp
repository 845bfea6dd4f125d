#include "tools/scenario/run/object_loop.h"

#include <optional>
#include <string>
#include <vector>

#include "tools/scenario/base/failure.h"

namespace brittle::tools {

namespace {

// Triangles to work on; a site takes about as long as fifty.
size_t cost_of(const LoadedObject& loaded) {
    constexpr size_t triangles_per_site = 50;
    return loaded.input->model.mesh.triangles.size() + triangles_per_site * loaded.input->sites.size();
}

} // namespace

void ObjectLoop::share_among(std::span<const size_t> objects) {
    cost_ = 0;
    for (const size_t k : objects) cost_ += cost_of(scene_.objects[k]);
}

uint32_t ObjectLoop::threads_for(size_t object) const {
    return cost_of(scene_.objects[object]) > cost_ / threads_.count() ? threads_.count() : 1;
}

void ObjectLoop::run(std::span<const size_t> objects, const std::function<void(size_t object)>& body) {
    std::vector<std::optional<Failure>> failures(objects.size());
    threads_.for_each(static_cast<uint32_t>(objects.size()), [&](uint32_t n) {
        throw_if_cancelled(host_);
        try {
            body(objects[n]);
        } catch (const Failure& failure) {
            failures[n] = failure;
        }
        const std::lock_guard lock(reporting_);
        if (progress_) progress_(static_cast<double>(++done_) / static_cast<double>(total_));
    });
    for (size_t n = 0; n < objects.size(); ++n)
        if (failures[n]) throw failures[n]->at("object " + scene_.objects[objects[n]].object.name);
}

} // namespace brittle::tools
