#include "fracture/exact/triangle_sorter.h"

#include <algorithm>
#include <array>

namespace brittle::fracture::exact {

namespace {

// Triangles are examined in blocks of this size, without branches: in many meshes it is as good as random whether the
// next triangle is whole.
constexpr uint32_t block_size = 512;

} // namespace

void TriangleSorter::run(const Input& input, bool guessed, Threads& threads, std::vector<SiteId>& cell_of_triangle,
                         Cut& cut) {
    const auto count = static_cast<uint32_t>(input.triangles.size());
    cell_of_triangle.resize(count);
    const uint32_t parts = threads.chunks(count, min_triangles_per_chunk);
    if (crossing_.size() < parts) crossing_.resize(parts);
    whole_.reset(parts, input.cells);
    const std::span<const uint32_t> components = input.surface.components();
    const bool leaves_out = input.surface.leaves_triangles_out();
    threads.for_chunks(count, min_triangles_per_chunk, [&](uint32_t chunk, uint32_t begin, uint32_t end) {
        uint32_t* const whole_in = whole_.row(chunk);
        std::vector<Crossing>& crossing = crossing_[chunk];
        crossing.clear();
        std::array<Crossing, block_size> found;
        for (uint32_t first = begin; first < end; first += block_size) {
            size_t found_count = 0;
            for (uint32_t t = first; t < std::min(first + block_size, end); ++t) {
                const Triangle& corners = input.triangles[t];
                const uint32_t guess = guessed ? cell_of_triangle[t] : Classifier::crossing;
                const bool is_guess = (guess & Classifier::crossing) == 0;
                const SiteId a = input.cell_of[corners.x], b = input.cell_of[corners.y], c = input.cell_of[corners.z];
                const bool is_used = !leaves_out || components[corners.x] != no_index;
                const bool is_whole = is_used && (is_guess || (a == b && b == c));
                cell_of_triangle[t] = is_whole ? (is_guess ? guess : a) : no_index;
                whole_in[is_guess ? guess : a] += is_whole ? 1 : 0;
                found[found_count] = {t, guess & ~Classifier::crossing};
                found_count += is_used && !is_whole ? 1 : 0;
            }
            crossing.insert(crossing.end(), found.begin(), found.begin() + found_count);
        }
    });
    std::vector<size_t> crossing_begin(parts + 1, 0);
    for (uint32_t k = 0; k < parts; ++k) crossing_begin[k + 1] = crossing_begin[k] + crossing_[k].size();
    cut.crossing.resize(crossing_begin[parts]);
    threads.for_chunks(parts, 1, [&](uint32_t, uint32_t begin, uint32_t end) {
        for (uint32_t k = begin; k < end; ++k)
            std::transform(crossing_[k].begin(), crossing_[k].end(), cut.crossing.begin() + crossing_begin[k],
                           [](const Crossing& c) {
                               return CrossingTriangle{c.triangle, c.known, {}, {}};
                           });
    });
}

} // namespace brittle::fracture::exact
