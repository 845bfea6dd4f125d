#include "physics/cutting/piece_payload.h"

#include "fracture/base/threads.h"

namespace brittle::physics {

std::vector<PayloadPtr> payloads_of(std::span<const SolidPtr> solids, const PayloadMaker& maker, uint32_t threads) {
    std::vector<PayloadPtr> payloads(solids.size());
    if (!maker) return payloads;
    fracture::Threads pool(threads);
    pool.for_chunks(static_cast<uint32_t>(solids.size()), 4, [&](uint32_t, uint32_t begin, uint32_t end) {
        for (uint32_t i = begin; i < end; ++i) payloads[i] = maker(*solids[i], nullptr);
    });
    return payloads;
}

} // namespace brittle::physics
