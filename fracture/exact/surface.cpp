#include "fracture/exact/surface.h"

#include <bit>
#include <string>

#include "fracture/topology.h"

namespace brittle::fracture::exact {

namespace {

uint64_t mix(uint64_t x) {
    x *= 0x9e3779b97f4a7c15ull;
    x ^= x >> 32;
    x *= 0xd6e8feb86659fd93ull;
    return x ^ (x >> 29);
}

// Two independent chains hide the latency of the multiplications.
uint64_t hash_of(const TriangleMesh& mesh) {
    uint64_t a = mesh.positions.size(), b = mesh.triangles.size();
    for (const Triangle& t : mesh.triangles) {
        a = std::rotl(a, 23) ^ (t.x * 0x9e3779b97f4a7c15ull + t.y);
        a *= 0xff51afd7ed558ccdull;
        b = std::rotl(b, 29) + (t.z ^ (uint64_t{t.x} << 32));
        b *= 0xc4ceb9fe1a85ec53ull;
    }
    return mix(a) ^ mix(b + 1);
}

// Half of a directed edge's term: equal and opposite for the two directions, so that paired edges cancel.
uint64_t edge_term(uint32_t from, uint32_t to) {
    return from < to ? mix(uint64_t{from} << 32 | to) : uint64_t{0} - mix(uint64_t{to} << 32 | from);
}

Error unsound(const TriangleMesh& mesh) {
    const TopologyReport report = check_topology(mesh.positions.size(), mesh.triangles);
    std::string what = describe(report);
    if (what.empty()) what = "its edges do not pair up";
    return {Status::invalid_mesh, "the mesh does not bound a solid: " + what + "; close or repair it first"};
}

} // namespace

Result<void> Surface::inspect(const TriangleMesh& mesh) {
    const uint64_t hash = hash_of(mesh);
    if (known_ && hash == hash_ && component_.size() == mesh.positions.size()) return {};
    known_ = false;
    uint64_t sum = 0;
    const auto vertices = static_cast<uint32_t>(mesh.positions.size());
    for (size_t i = 0; i < mesh.triangles.size(); ++i) {
        const Triangle& t = mesh.triangles[i];
        if (t.x >= vertices || t.y >= vertices || t.z >= vertices) {
            return Error{Status::invalid_mesh, "triangle " + std::to_string(i)
                                                   + " names a vertex that the mesh of "
                                                   + std::to_string(vertices) + " vertices does not have"};
        }
        if (t.x == t.y || t.y == t.z || t.z == t.x) return unsound(mesh);
        sum += edge_term(t.x, t.y) + edge_term(t.y, t.z) + edge_term(t.z, t.x);
    }
    if (sum != 0) return unsound(mesh);
    find_components(mesh);
    hash_ = hash;
    known_ = true;
    return {};
}

void Surface::find_components(const TriangleMesh& mesh) {
    // Union-find that links to the smaller index, with path halving.
    component_.assign(mesh.positions.size(), kNone);
    const auto root = [&](uint32_t v) {
        if (component_[v] == kNone) component_[v] = v;
        while (component_[v] != v) {
            component_[v] = component_[component_[v]];
            v = component_[v];
        }
        return v;
    };
    for (const Triangle& t : mesh.triangles) {
        uint32_t a = root(t.x);
        for (const uint32_t v : {t.y, t.z}) {
            const uint32_t b = root(v);
            if (a < b)
                component_[b] = a;
            else {
                component_[a] = b;
                a = b;
            }
        }
    }
    component_count_ = 0;
    leaves_triangles_out_ = false;
    std::vector<uint8_t> size(component_.size(), 0); // of the component that each root names, up to 4
    for (uint32_t v = 0; v < component_.size(); ++v) {
        if (component_[v] == kNone) continue;
        component_[v] = component_[component_[v]]; // parents have smaller indices, so theirs are final
        component_count_ += component_[v] == v ? 1 : 0;
        uint8_t& n = size[component_[v]];
        n = n < 4 ? static_cast<uint8_t>(n + 1) : n;
    }
    for (uint32_t v = static_cast<uint32_t>(component_.size()); v-- > 0;) { // roots come last
        if (component_[v] == kNone || size[component_[v]] != 3) continue;
        component_count_ -= component_[v] == v ? 1 : 0;
        component_[v] = kNone;
        leaves_triangles_out_ = true;
    }
}

} // namespace brittle::fracture::exact
