#include "fracture/exact/surface.h"

#include <algorithm>
#include <atomic>
#include <cstring>
#include <string>

#include "fracture/mesh/topology.h"

namespace brittle::fracture::exact {

namespace {

constexpr uint32_t min_triangles_per_chunk = 8192;
constexpr uint32_t min_vertices_per_chunk = 8192;

Error unsound(const TriangleMesh& mesh) {
    for (size_t i = 0; i < mesh.triangles.size(); ++i) {
        const Triangle& t = mesh.triangles[i];
        const uint32_t highest = std::max({t.x, t.y, t.z});
        if (highest < mesh.positions.size()) continue;
        return {Status::invalid_mesh, "triangle " + std::to_string(i) + " names vertex " + std::to_string(highest)
                                          + ", but the mesh has only " + std::to_string(mesh.positions.size())};
    }
    const TopologyReport report = check_topology(mesh.positions.size(), mesh.triangles);
    return {status_of(report), "the mesh does not bound a solid: " + describe(report)};
}

uint32_t root_of(std::vector<uint32_t>& parent, uint32_t v) {
    for (;;) {
        const uint32_t p = std::atomic_ref(parent[v]).load(std::memory_order_relaxed);
        if (p == v) return v;
        const uint32_t above = std::atomic_ref(parent[p]).load(std::memory_order_relaxed);
        if (above == p) return p;
        std::atomic_ref(parent[v]).store(above,
                                         std::memory_order_relaxed); // an ancestor, whatever other threads write
        v = above;
    }
}

// Links roots only, and to lower indices only: for any order of threads, the root of a finished set is its lowest
// vertex.
void unite(std::vector<uint32_t>& parent, uint32_t a, uint32_t b) {
    for (;;) {
        a = root_of(parent, a);
        b = root_of(parent, b);
        if (a == b) return;
        if (a < b) std::swap(a, b);
        uint32_t expected = a;
        if (std::atomic_ref(parent[a]).compare_exchange_weak(expected, b, std::memory_order_relaxed)) return;
    }
}

} // namespace

Result<void> Surface::inspect(const TriangleMesh& mesh, Threads& threads) {
    if (!is_known(mesh, threads)) {
        is_complete_ = false;
        if (!check_.run(mesh.positions.size(), mesh.triangles, threads)) return unsound(mesh);
        find_components(mesh, threads);
        known_.resize(mesh.triangles.size());
        threads.for_chunks(
            static_cast<uint32_t>(known_.size()), min_triangles_per_chunk, [&](uint32_t, uint32_t begin, uint32_t end) {
                std::copy(mesh.triangles.begin() + begin, mesh.triangles.begin() + end, known_.begin() + begin);
            });
        is_complete_ = true;
    }
    return {};
}

bool Surface::is_known(const TriangleMesh& mesh, Threads& threads) const {
    if (!is_complete_ || known_.size() != mesh.triangles.size() || component_.size() != mesh.positions.size())
        return false;
    std::atomic<bool> equal = true;
    threads.for_chunks(static_cast<uint32_t>(known_.size()), min_triangles_per_chunk,
                       [&](uint32_t, uint32_t begin, uint32_t end) {
                           const size_t bytes = (end - begin) * sizeof(Triangle);
                           if (std::memcmp(&known_[begin], &mesh.triangles[begin], bytes) != 0) equal = false;
                       });
    return equal;
}

void Surface::find_components(const TriangleMesh& mesh, Threads& threads) {
    const auto vertices = static_cast<uint32_t>(mesh.positions.size());
    component_.resize(vertices);
    threads.for_chunks(vertices, min_vertices_per_chunk, [&](uint32_t, uint32_t begin, uint32_t end) {
        for (uint32_t v = begin; v < end; ++v) component_[v] = v;
    });
    threads.for_chunks(static_cast<uint32_t>(mesh.triangles.size()), min_triangles_per_chunk,
                       [&](uint32_t, uint32_t begin, uint32_t end) {
                           for (uint32_t t = begin; t < end; ++t) {
                               const Triangle& corners = mesh.triangles[t];
                               unite(component_, corners.x, corners.y);
                               unite(component_, corners.x, corners.z);
                           }
                       });
    std::atomic<uint32_t> count = 0;
    std::atomic<bool> leaves_out = false;
    threads.for_chunks(vertices, min_vertices_per_chunk, [&](uint32_t, uint32_t begin, uint32_t end) {
        uint32_t roots = 0;
        for (uint32_t v = begin; v < end; ++v) {
            const uint32_t degree = check_.degree(v);
            const uint32_t root = root_of(component_, v);
            // Two triangles at a vertex are back to back. As all edges pair up, they are a whole component.
            if (degree == 2) leaves_out = true;
            if (degree > 2) roots += root == v ? 1 : 0;
            std::atomic_ref(component_[v]).store(root, std::memory_order_relaxed);
        }
        count += roots;
    });
    component_count_ = count;
    leaves_triangles_out_ = leaves_out;
    threads.for_chunks(vertices, min_vertices_per_chunk, [&](uint32_t, uint32_t begin, uint32_t end) {
        for (uint32_t v = begin; v < end; ++v) {
            if (check_.degree(v) <= 2) component_[v] = no_index;
        }
    });
}

} // namespace brittle::fracture::exact
