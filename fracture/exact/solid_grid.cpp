#include "fracture/exact/solid_grid.h"

#include <algorithm>
#include <atomic>
#include <cassert>
#include <cmath>

#include <glm/common.hpp>

namespace brittle::fracture::exact {

namespace {

constexpr uint32_t min_vertices_per_chunk = 8192;
constexpr uint32_t min_triangles_per_chunk = 8192;

// So many times as there are bins and triangles, a bin may be touched. Large triangles that lie across the axes need
// more; the grid takes all bins for covered then.
constexpr size_t max_touches = 8;

// A place in ten bits an axis.
uint32_t pack(const glm::ivec3& place) {
    return static_cast<uint32_t>(place.x << 20 | place.y << 10 | place.z);
}

glm::ivec3 unpack(uint32_t packed) {
    return {packed >> 20, packed >> 10 & 1023u, packed & 1023u};
}

double largest(const glm::dvec3& v) {
    return std::max({v.x, v.y, v.z});
}

} // namespace

void SolidGrid::build(std::span<const glm::dvec3> positions, std::span<const Triangle> triangles, const Box& box,
                      uint32_t bins, Threads& threads) {
    assert(bins >= 1 && bins <= max_bins);
    low_ = box.min;
    size_ = largest(box.size()) / bins;
    per_length_ = 1.0 / size_;
    margin_ = 0x1.0p-20 * size_ + 0x1.0p-50 * std::max(largest(glm::abs(box.min)), largest(glm::abs(box.max)));
    count_ = glm::ivec3(glm::ceil(box.size() / size_));
    count_ = glm::clamp(count_, 1, static_cast<int>(bins));
    state_.assign(static_cast<size_t>(count_.x) * static_cast<size_t>(count_.y) * static_cast<size_t>(count_.z),
                  unknown);
    touch(positions, triangles, threads);
    find_outside();
    find_groups();
}

glm::ivec3 SolidGrid::place_of(const glm::dvec3& point) const {
    const glm::dvec3 place = glm::clamp((point - low_) * per_length_, glm::dvec3(0.0), glm::dvec3(count_ - 1));
    return {static_cast<int>(place.x), static_cast<int>(place.y), static_cast<int>(place.z)};
}

uint32_t SolidGrid::index_of(const glm::ivec3& place) const {
    return static_cast<uint32_t>((place.x * count_.y + place.y) * count_.z + place.z);
}

// Touches all bins in the box of each triangle. Rounding may put a vertex into the bin beside its own, but into the same
// one for all of its triangles; so the touched bins hold a closed surface that equals the mesh up to rounding.
void SolidGrid::touch(std::span<const glm::dvec3> positions, std::span<const Triangle> triangles, Threads& threads) {
    const auto touch_bin = [&](const glm::ivec3& place) {
        std::atomic_ref(state_[index_of(place)]).store(touched, std::memory_order_relaxed);
    };
    place_of_vertex_.resize(positions.size());
    const auto vertices = static_cast<uint32_t>(positions.size());
    threads.for_chunks(vertices, min_vertices_per_chunk, [&](uint32_t, uint32_t begin, uint32_t end) {
        for (uint32_t v = begin; v < end; ++v) {
            const glm::ivec3 place = place_of(positions[v]);
            place_of_vertex_[v] = pack(place);
            touch_bin(place);
        }
    });
    const auto count = static_cast<uint32_t>(triangles.size());
    std::atomic<bool> gave_up = false;
    threads.for_chunks(count, min_triangles_per_chunk, [&](uint32_t, uint32_t begin, uint32_t end) {
        auto left = static_cast<int64_t>(max_touches * (state_.size() + (end - begin)));
        for (const Triangle& t : triangles.subspan(begin, end - begin)) {
            const uint32_t a = place_of_vertex_[t.x], b = place_of_vertex_[t.y], c = place_of_vertex_[t.z];
            if (a == b && b == c) continue;
            const glm::ivec3 low = glm::min(unpack(a), glm::min(unpack(b), unpack(c)));
            const glm::ivec3 high = glm::max(unpack(a), glm::max(unpack(b), unpack(c)));
            const glm::ivec3 size = high - low + 1;
            left -= int64_t{size.x} * size.y * size.z;
            if (left < 0) {
                gave_up = true;
                return;
            }
            for (int x = low.x; x <= high.x; ++x)
                for (int y = low.y; y <= high.y; ++y)
                    for (int z = low.z; z <= high.z; ++z) touch_bin({x, y, z});
        }
    });
    if (gave_up) std::fill(state_.begin(), state_.end(), static_cast<uint8_t>(touched));
}

template<class Visit>
void SolidGrid::visit_beside(uint32_t bin, const Visit& visit) const {
    const auto y_count = static_cast<uint32_t>(count_.y), z_count = static_cast<uint32_t>(count_.z);
    const uint32_t x = bin / (y_count * z_count), y = bin / z_count % y_count, z = bin % z_count;
    if (x > 0) visit(bin - y_count * z_count);
    if (x + 1 < static_cast<uint32_t>(count_.x)) visit(bin + y_count * z_count);
    if (y > 0) visit(bin - z_count);
    if (y + 1 < y_count) visit(bin + z_count);
    if (z > 0) visit(bin - 1);
    if (z + 1 < z_count) visit(bin + 1);
}

void SolidGrid::find_outside() {
    stack_.clear();
    const auto reach = [&](uint32_t bin) {
        if (state_[bin] != unknown) return;
        state_[bin] = outside;
        stack_.push_back(bin);
    };
    for (int x = 0; x < count_.x; ++x)
        for (int y = 0; y < count_.y; ++y)
            for (int z = 0; z < count_.z; ++z) {
                const bool on_box =
                    x == 0 || y == 0 || z == 0 || x + 1 == count_.x || y + 1 == count_.y || z + 1 == count_.z;
                if (on_box) reach(index_of({x, y, z}));
            }
    while (!stack_.empty()) {
        const uint32_t bin = stack_.back();
        stack_.pop_back();
        visit_beside(bin, reach);
    }
}

void SolidGrid::find_groups() {
    group_points_.clear();
    const auto reach = [&](uint32_t bin) {
        if (state_[bin] == outside || state_[bin] == covered) return;
        state_[bin] = covered;
        stack_.push_back(bin);
    };
    for (int x = 0; x < count_.x; ++x)
        for (int y = 0; y < count_.y; ++y)
            for (int z = 0; z < count_.z; ++z) {
                reach(index_of({x, y, z}));
                if (stack_.empty()) continue;
                group_points_.push_back(low_ + (glm::dvec3(x, y, z) + 0.5) * size_);
                while (!stack_.empty()) {
                    const uint32_t bin = stack_.back();
                    stack_.pop_back();
                    visit_beside(bin, reach);
                }
            }
}

bool SolidGrid::covers(const glm::dvec3& point) const {
    const glm::dvec3 place = (point - low_) * per_length_;
    for (int k = 0; k < 3; ++k)
        if (!(place[k] >= 0.0 && place[k] < count_[k])) return false;
    return state_[index_of(glm::ivec3(place))] == covered;
}

bool SolidGrid::meets(const Box& box) const {
    const glm::ivec3 low = place_of(box.min - margin_), high = place_of(box.max + margin_);
    for (int x = low.x; x <= high.x; ++x)
        for (int y = low.y; y <= high.y; ++y)
            for (int z = low.z; z <= high.z; ++z)
                if (state_[index_of({x, y, z})] == covered) return true;
    return false;
}

} // namespace brittle::fracture::exact
