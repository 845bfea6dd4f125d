// Loops over bodies and contacts, on several threads and with prefetches.
#pragma once

#include <span>
#include <vector>

#include "fracture/base/threads.h"
#include "physics/solver/body.h"
#include "physics/solver/manifold.h"
#include "physics/solver/prefetch.h"

namespace brittle::physics {

// Calls visit(body) for each body, in parallel.
void for_each_body(std::span<Body* const> bodies, fracture::Threads& threads, const auto& visit) {
    constexpr uint32_t min_bodies = 64; // fewer are not worth waking another thread for
    threads.for_chunks(static_cast<uint32_t>(bodies.size()), min_bodies, [&](uint32_t, uint32_t begin, uint32_t end) {
        for (uint32_t i = begin; i < end; ++i) {
            if (i + prefetch_distance < end) prefetch(bodies[i + prefetch_distance]);
            visit(*bodies[i]);
        }
    });
}

// Calls visit(manifold) for each manifold with contacts, in parallel: two calls may concern one body.
void for_each_contact(const std::vector<AnyManifold>& all, fracture::Threads& threads, const auto& visit) {
    constexpr uint32_t min_manifolds = 128; // fewer are not worth waking another thread for
    threads.for_chunks(static_cast<uint32_t>(all.size()), min_manifolds, [&](uint32_t, uint32_t begin, uint32_t end) {
        for (uint32_t i = begin; i < end; ++i) {
            if (i + prefetch_distance + 1 < end) all[i + prefetch_distance + 1].prefetch_contacts();
            if (i + prefetch_distance < end) all[i + prefetch_distance].prefetch_body();
            if (all[i].count > 0) visit(all[i]);
        }
    });
}

} // namespace brittle::physics
