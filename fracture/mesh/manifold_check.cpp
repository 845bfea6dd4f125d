#include "fracture/mesh/manifold_check.h"

#include <algorithm>
#include <cstring>
#include <limits>

#include "fracture/base/simd.h"

namespace brittle::fracture {

namespace {

constexpr uint8_t overflowing = 9; // the degree that stands for more corners than slots

// Triangles per run. A thread that fills a range of vertices skips the runs that refer to none of them.
constexpr uint32_t run_length = 512;
constexpr uint32_t min_runs = 16;    // per chunk
constexpr uint32_t min_blocks = 256; // per range of vertices

// A block holds the corners of eight consecutive vertices: `next` of corner s of vertex k is at s * lanes + k, `prev`
// is at the same place after all nexts.
constexpr uint32_t lanes = 8;
constexpr uint32_t slots = 8;
constexpr uint32_t prevs = slots * lanes;
constexpr uint32_t block_size = 2 * prevs;

// Eight numbers in one or two vector registers; GCC and Clang support the extension.
using Eight = uint32_t __attribute__((vector_size(4 * lanes)));

} // namespace

namespace simd {

// Walks around eight vertices at once, without branches. A step goes to the corner whose next is the prev of the
// current corner. Finding none or several is an error, as is returning to the start before the last corner. Without an
// error, n corners in the walk are n different corners: a walk that enters a cycle elsewhere never returns to its
// start.
BRITTLE_SIMD bool are_rings(const uint32_t* corners, const uint8_t* degrees, size_t blocks) {
    Eight bad{};
    for (size_t b = 0; b < blocks; ++b, corners += block_size, degrees += lanes) {
        Eight degree{};
        uint32_t most = 0;
        for (uint32_t k = 0; k < lanes; ++k) {
            const uint32_t n = degrees[k] == overflowing ? 0 : degrees[k];
            degree[k] = n;
            most = n > most ? n : most;
        }
        Eight next[slots], prev[slots];
        for (uint32_t s = 0; s < slots; ++s) {
            std::memcpy(&next[s], corners + s * lanes, sizeof next[s]);
            std::memcpy(&prev[s], corners + prevs + s * lanes, sizeof prev[s]);
            next[s] |= ~reinterpret_cast<Eight>(degree > s); // no vertex index has all bits set
        }
        const Eight first = next[0];
        Eight at = prev[0];
        for (uint32_t step = 1; step < most; ++step) {
            const Eight walks = reinterpret_cast<Eight>(degree > step);
            Eight found{}, hits{};
            for (uint32_t s = 0; s < slots; ++s) {
                const Eight here = reinterpret_cast<Eight>(next[s] == at);
                hits -= here;
                found |= here & prev[s];
            }
            bad |= walks & (reinterpret_cast<Eight>(at == first) | reinterpret_cast<Eight>(hits != 1u));
            at = (found & walks) | (at & ~walks);
        }
        bad |= reinterpret_cast<Eight>(at != first) & reinterpret_cast<Eight>(degree != 0u);
    }
    uint32_t any = 0;
    for (uint32_t k = 0; k < lanes; ++k) any |= bad[k];
    return any == 0;
}

} // namespace simd

// Returns whether all indices are in range and no triangle names a vertex twice. Fills index_ranges_.
bool ManifoldCheck::check_indices(size_t vertex_count, std::span<const Triangle> triangles, Threads& threads) {
    const auto runs = static_cast<uint32_t>((triangles.size() + run_length - 1) / run_length);
    index_ranges_.resize(runs);
    threads.for_chunks(runs, min_runs, [&](uint32_t, uint32_t begin, uint32_t end) {
        for (uint32_t r = begin; r < end; ++r) {
            const size_t first = size_t{r} * run_length;
            IndexRange indices{std::numeric_limits<uint32_t>::max(), 0};
            bool degenerate = false;
            for (const Triangle& t : triangles.subspan(first, std::min<size_t>(run_length, triangles.size() - first))) {
                indices.lowest = std::min({indices.lowest, t.x, t.y, t.z});
                indices.highest = std::max({indices.highest, t.x, t.y, t.z});
                degenerate |= t.x == t.y || t.y == t.z || t.z == t.x;
            }
            // Rejected like an index out of range.
            if (degenerate) indices.highest = std::numeric_limits<uint32_t>::max();
            index_ranges_[r] = indices;
        }
    });
    return std::all_of(index_ranges_.begin(), index_ranges_.end(),
                       [&](const IndexRange& r) { return r.highest < vertex_count; });
}

void ManifoldCheck::fill(uint32_t first, uint32_t last, std::span<const Triangle> triangles, Range& range) {
    const auto place = [&](uint32_t v, uint32_t next, uint32_t prev) {
        if (v - first >= last - first) return; // an index below `first` wraps around
        const uint32_t n = degree_[v];
        if (n < slots) {
            uint32_t* const corner = corners_.data() + size_t{v / lanes} * block_size + n * lanes + v % lanes;
            corner[0] = next;
            corner[prevs] = prev;
            degree_[v] = static_cast<uint8_t>(n + 1);
        } else {
            range.overflow.push_back({v, next, prev});
            degree_[v] = overflowing;
        }
    };
    for (size_t r = 0; r < index_ranges_.size(); ++r) {
        if (index_ranges_[r].lowest >= last || index_ranges_[r].highest < first) continue;
        const size_t begin = r * run_length;
        for (const Triangle& t : triangles.subspan(begin, std::min<size_t>(run_length, triangles.size() - begin))) {
            place(t.x, t.y, t.z);
            place(t.y, t.z, t.x);
            place(t.z, t.x, t.y);
        }
    }
}

// Walks around vertices of any degree, one at a time.
bool ManifoldCheck::overflow_forms_rings(std::vector<Corner>& overflow) const {
    const auto vertex_of = [](const Corner& c) { return c.vertex; };
    std::ranges::sort(overflow, {}, vertex_of);
    for (size_t k = 0, late = overflow.size(); k < late; ++k) { // append the corners in the slots, once per vertex
        const uint32_t v = overflow[k].vertex;
        if (k > 0 && overflow[k - 1].vertex == v) continue;
        const uint32_t* const corner = corners_.data() + size_t{v / lanes} * block_size + v % lanes;
        for (uint32_t s = 0; s < slots; ++s) overflow.push_back({v, corner[s * lanes], corner[prevs + s * lanes]});
    }
    std::ranges::sort(overflow, {}, [](const Corner& c) { return uint64_t{c.vertex} << 32 | c.next; });
    for (size_t begin = 0, end = 0; begin < overflow.size(); begin = end) {
        while (end < overflow.size() && overflow[end].vertex == overflow[begin].vertex) ++end;
        const std::span<const Corner> fan(overflow.data() + begin, end - begin);
        uint32_t at = fan[0].prev;
        for (size_t step = 1; step < fan.size(); ++step) {
            // std::ranges::lower_bound does not compile here with Clang 14 and the library of GCC 12.
            const auto here = std::lower_bound(fan.begin(), fan.end(), at,
                                               [](const Corner& c, uint32_t next) { return c.next < next; });
            const bool found = here != fan.end() && here->next == at;
            if (at == fan[0].next || !found || (here + 1 != fan.end() && (here + 1)->next == at)) return false;
            at = here->prev;
        }
        if (at != fan[0].next) return false;
    }
    return true;
}

bool ManifoldCheck::run(size_t vertex_count, std::span<const Triangle> triangles, Threads& threads) {
    if (!check_indices(vertex_count, triangles, threads)) return false;
    const auto blocks = static_cast<uint32_t>((vertex_count + lanes - 1) / lanes);
    corners_.resize(size_t{blocks} * block_size);
    degree_.resize(size_t{blocks} * lanes);
    // One range per thread: each range scans all triangles except skipped runs, so more ranges would cost more.
    const uint32_t ranges = std::clamp(blocks / min_blocks, 1u, threads.count());
    if (ranges_.size() < ranges) ranges_.resize(ranges);
    threads.for_each(ranges, [&](uint32_t r) {
        Range& range = ranges_[r];
        const auto first = static_cast<uint32_t>(uint64_t{blocks} * r / ranges);
        const auto last = static_cast<uint32_t>(uint64_t{blocks} * (r + 1) / ranges);
        range.overflow.clear();
        std::fill(degree_.begin() + first * lanes, degree_.begin() + last * lanes, uint8_t{0});
        fill(first * lanes, last * lanes, triangles, range);
        range.manifold =
            simd::are_rings(corners_.data() + size_t{first} * block_size, degree_.data() + first * lanes, last - first)
            && overflow_forms_rings(range.overflow);
    });
    return std::all_of(ranges_.begin(), ranges_.begin() + ranges, [](const Range& r) { return r.manifold; });
}

} // namespace brittle::fracture
