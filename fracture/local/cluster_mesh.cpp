#include "fracture/local/cluster_mesh.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <limits>
#include <map>
#include <numeric>
#include <set>
#include <utility>

#include <glm/common.hpp>

#include "fracture/base/union_find.h"
#include "fracture/local/face_collector.h"
#include "fracture/local/number_table.h"

namespace brittle::fracture {

namespace {

constexpr uint32_t min_triangles_per_chunk = 8192;
constexpr uint32_t clusters_per_run = 64; // a run of triangles is divided into clusters by one thread

// Spreads the lower 21 bits of x to every third bit.
uint64_t spread(uint64_t x) {
    x &= 0x1fffff;
    x = (x | x << 32) & 0x1f00000000ffff;
    x = (x | x << 16) & 0x1f0000ff0000ff;
    x = (x | x << 8) & 0x100f00f00f00f00f;
    x = (x | x << 4) & 0x10c30c30c30c30c3;
    x = (x | x << 2) & 0x1249249249249249;
    return x;
}

struct Place {
    uint64_t code; // of the triangle's middle on a Z-order curve
    uint32_t triangle;

    friend bool operator<(const Place& a, const Place& b) {
        return a.code != b.code ? a.code < b.code : a.triangle < b.triangle;
    }
};

// The triangles along a Z-order curve, so that those of a run are neighbours (Morton 1966).
std::vector<Place> in_z_order(std::span<const glm::dvec3> positions, std::span<const Triangle> triangles,
                              Threads& threads) {
    const Box box = bounds(positions);
    const glm::dvec3 size = box.size();
    const double longest = std::max({size.x, size.y, size.z});
    const double scale = longest > 0.0 ? double{0x1fffff} / longest : 0.0;
    std::vector<Place> places(triangles.size());
    const auto count = static_cast<uint32_t>(triangles.size());
    const uint32_t parts = threads.chunks(count, min_triangles_per_chunk);
    std::vector<uint32_t> begins(parts + 1, count);
    threads.for_chunks(count, min_triangles_per_chunk, [&](uint32_t chunk, uint32_t begin, uint32_t end) {
        for (uint32_t t = begin; t < end; ++t) {
            const Triangle& c = triangles[t];
            const glm::dvec3 middle =
                (positions[c.x] - box.min + (positions[c.y] - box.min) + (positions[c.z] - box.min)) * (scale / 3.0);
            places[t] = {spread(static_cast<uint64_t>(middle.x)) | spread(static_cast<uint64_t>(middle.y)) << 1
                             | spread(static_cast<uint64_t>(middle.z)) << 2,
                         t};
        }
        std::sort(places.begin() + begin, places.begin() + end);
        begins[chunk] = begin;
    });
    for (uint32_t width = 1; width < parts; width *= 2) {
        const uint32_t pairs = (parts + 2 * width - 1) / (2 * width);
        threads.for_each(pairs, [&](uint32_t k) {
            const uint32_t first = 2 * k * width;
            const uint32_t middle = std::min(first + width, parts), last = std::min(first + 2 * width, parts);
            std::inplace_merge(places.begin() + begins[first], places.begin() + begins[middle],
                               places.begin() + begins[last]);
        });
    }
    return places;
}

// Divides triangles in their order into clusters.
class ClusterMaker {
  public:
    explicit ClusterMaker(const FaceList& faces) : faces_(faces) {}

    std::vector<ClusterPtr> run(std::span<const Place> places) {
        for (const Place& place : places) add(place.triangle);
        finish();
        return std::move(done_);
    }

  private:
    static constexpr uint32_t max_vertices = 256;

    void add(uint32_t triangle) {
        if (current_.triangles.size() == Cluster::max_triangles || current_.positions.size() + 3 > max_vertices)
            finish();
        std::array<uint8_t, 3> corners{};
        for (int k = 0; k < 3; ++k) {
            const uint32_t v = faces_.triangles[triangle][k];
            const uint32_t at = local_.add(v);
            if (at == current_.positions.size()) {
                current_.positions.push_back(faces_.positions[v]);
                current_.vertices.push_back(faces_.vertices.empty() ? v : faces_.vertices[v]);
            }
            corners[static_cast<size_t>(k)] = static_cast<uint8_t>(at);
        }
        current_.triangles.push_back(corners);
        current_.tags.push_back(faces_.tags[triangle]);
    }

    void finish() {
        if (current_.triangles.empty()) return;
        current_.box = bounds(current_.positions);
        done_.push_back(std::make_shared<const Cluster>(current_)); // a copy has no spare capacity
        current_ = {};
        local_.clear();
    }

    const FaceList& faces_;
    Cluster current_;
    NumberTable local_{max_vertices};
    std::vector<ClusterPtr> done_;
};

std::vector<ClusterPtr> clusters_of(const FaceList& faces, Threads& threads) {
    const std::vector<Place> places = in_z_order(faces.positions, faces.triangles, threads);
    constexpr uint32_t run = clusters_per_run * Cluster::max_triangles;
    const auto count = static_cast<uint32_t>(places.size());
    std::vector<std::vector<ClusterPtr>> runs((count + run - 1) / run);
    threads.for_each(static_cast<uint32_t>(runs.size()), [&](uint32_t k) {
        const auto part = std::span(places).subspan(size_t{k} * run, std::min(run, count - k * run));
        runs[k] = ClusterMaker(faces).run(part);
    });
    std::vector<ClusterPtr> clusters;
    for (std::vector<ClusterPtr>& part : runs)
        clusters.insert(clusters.end(), std::make_move_iterator(part.begin()), std::make_move_iterator(part.end()));
    return clusters;
}

} // namespace

ClusterMesh::NodePtr ClusterMesh::leaf(ClusterPtr cluster) {
    Node node;
    node.box = cluster->box;
    node.triangles = static_cast<uint32_t>(cluster->triangles.size());
    node.clusters = 1;
    node.cluster = std::move(cluster);
    return std::make_shared<const Node>(std::move(node));
}

ClusterMesh::NodePtr ClusterMesh::above(NodePtr low, NodePtr high) {
    if (!low) return high;
    if (!high) return low;
    Node node;
    node.box = {glm::min(low->box.min, high->box.min), glm::max(low->box.max, high->box.max)};
    node.triangles = low->triangles + high->triangles;
    node.clusters = low->clusters + high->clusters;
    node.low = std::move(low);
    node.high = std::move(high);
    return std::make_shared<const Node>(std::move(node));
}

ClusterMesh::NodePtr ClusterMesh::tree_of(std::span<const ClusterPtr> clusters) {
    if (clusters.empty()) return nullptr;
    if (clusters.size() == 1) return leaf(clusters[0]);
    const size_t half = clusters.size() / 2;
    return above(tree_of(clusters.first(half)), tree_of(clusters.subspan(half)));
}

// `box` holds all of the clusters, so that other branches are not searched.
ClusterMesh::NodePtr ClusterMesh::without(const NodePtr& node, const ClusterSet& clusters, const Box& box) {
    if (!overlap(node->box, box)) return node;
    if (node->cluster) return clusters.contains(node->cluster.get()) ? nullptr : node;
    NodePtr low = without(node->low, clusters, box), high = without(node->high, clusters, box);
    return low == node->low && high == node->high ? node : above(std::move(low), std::move(high));
}

// Puts a tree beside the deepest node whose box would not grow by it.
ClusterMesh::NodePtr ClusterMesh::inserted(const NodePtr& node, const NodePtr& other) {
    const auto holds = [&](const Node& parent) {
        for (int k = 0; k < 3; ++k)
            if (!(parent.box.min[k] <= other->box.min[k]) || !(parent.box.max[k] >= other->box.max[k])) return false;
        return true;
    };
    if (!node) return other;
    if (!node->cluster && holds(*node->low)) return above(inserted(node->low, other), node->high);
    if (!node->cluster && holds(*node->high)) return above(node->low, inserted(node->high, other));
    return above(node, other);
}

ClusterMesh::ClusterMesh(const TriangleMesh& mesh, std::span<const uint32_t> tags, Threads& threads)
    : vertex_limit_(static_cast<uint32_t>(mesh.positions.size())) {
    assert(tags.size() == mesh.triangles.size());
    const FaceList faces{mesh.triangles, mesh.positions, {}, {tags.begin(), tags.end()}};
    root_ = tree_of(clusters_of(faces, threads));
}

void ClusterMesh::add_branches(const NodePtr& node, uint32_t max_triangles, std::vector<ClusterBranch>& branches) {
    if (node->triangles <= max_triangles || node->cluster) {
        branches.push_back(ClusterBranch(node));
        return;
    }
    add_branches(node->low, max_triangles, branches);
    add_branches(node->high, max_triangles, branches);
}

std::vector<ClusterBranch> ClusterMesh::branches(uint32_t max_triangles) const {
    std::vector<ClusterBranch> branches;
    if (root_) add_branches(root_, max_triangles, branches);
    return branches;
}

ClusterMesh ClusterMesh::with(const ClusterSet& without_these, const FaceList& faces) const {
    constexpr double infinity = std::numeric_limits<double>::infinity();
    ClusterMesh changed = *this;
    Box box{glm::dvec3(infinity), glm::dvec3(-infinity)};
    for (const Cluster* cluster : without_these)
        box = {glm::min(box.min, cluster->box.min), glm::max(box.max, cluster->box.max)};
    if (root_ && !without_these.empty()) changed.root_ = without(root_, without_these, box);
    Threads one(1);
    if (const NodePtr added = tree_of(clusters_of(faces, one))) changed.root_ = inserted(changed.root_, added);
    for (const uint32_t v : faces.vertices) changed.vertex_limit_ = std::max(changed.vertex_limit_, v + 1);
    return changed;
}

// By vertex number: the lowest number of its component.
std::vector<uint32_t> ClusterMesh::components() const {
    std::vector<uint32_t> parent(vertex_limit_);
    std::iota(parent.begin(), parent.end(), 0u);
    for_each([&](const ClusterPtr& cluster) {
        for (const auto& [a, b, c] : cluster->triangles) {
            unite(parent, cluster->vertices[a], cluster->vertices[b]);
            unite(parent, cluster->vertices[a], cluster->vertices[c]);
        }
    });
    for (uint32_t v = 0; v < parent.size(); ++v) parent[v] = root_of(parent, v);
    return parent;
}

bool ClusterMesh::is_connected() const {
    const std::vector<uint32_t> component = components();
    uint32_t some = no_index;
    bool connected = true;
    for_each([&](const ClusterPtr& cluster) {
        if (some == no_index) some = component[cluster->vertices[0]];
        for (const uint32_t v : cluster->vertices) connected = connected && component[v] == some;
    });
    return connected;
}

std::vector<ClusterMesh> ClusterMesh::parts() const {
    const std::vector<uint32_t> component = components();
    std::map<uint32_t, uint32_t> sizes; // triangles by component
    for_each([&](const ClusterPtr& cluster) {
        for (const auto& corners : cluster->triangles) ++sizes[component[cluster->vertices[corners[0]]]];
    });
    if (sizes.size() < 2) return {*this};
    const uint32_t largest = std::ranges::max_element(sizes, {}, [](const auto& entry) { return entry.second; })->first;
    // The triangles of all but the largest part, and those of it that share a cluster with one of them.
    struct Part {
        FaceList faces;
        NumberTable numbers;
        FaceCollector collector{faces, numbers};
    };
    std::map<uint32_t, Part> others;
    ClusterSet opened;
    for_each([&](const ClusterPtr& cluster) {
        const auto of = [&](size_t k) { return component[cluster->vertices[cluster->triangles[k][0]]]; };
        bool is_largest = true;
        for (size_t k = 0; k < cluster->triangles.size(); ++k) is_largest = is_largest && of(k) == largest;
        if (is_largest) return;
        opened.insert(cluster.get());
        std::set<uint32_t> begun;
        for (size_t k = 0; k < cluster->triangles.size(); ++k) {
            FaceCollector& collector = others[of(k)].collector;
            if (begun.insert(of(k)).second) collector.open(*cluster);
            collector.add(k);
        }
    });
    std::vector<ClusterMesh> parts{with(opened, others[largest].faces)};
    for (const auto& [number, triangles] : sizes) {
        if (number == largest) continue;
        parts.push_back(ClusterMesh().with({}, others[number].faces));
        parts.back().vertex_limit_ = vertex_limit_;
    }
    return parts;
}

TriangleMesh ClusterMesh::flatten(std::vector<uint32_t>* tags) const {
    TriangleMesh mesh;
    mesh.triangles.reserve(triangle_count());
    if (tags) {
        tags->clear();
        tags->reserve(triangle_count());
    }
    std::vector<uint32_t> index(vertex_limit_, no_index);
    for_each([&](const ClusterPtr& cluster) {
        for (size_t v = 0; v < cluster->positions.size(); ++v) {
            uint32_t& at = index[cluster->vertices[v]];
            if (at != no_index) continue;
            at = static_cast<uint32_t>(mesh.positions.size());
            mesh.positions.push_back(cluster->positions[v]);
        }
        const auto number = [&](uint8_t corner) { return index[cluster->vertices[corner]]; };
        for (const auto& [a, b, c] : cluster->triangles) mesh.triangles.emplace_back(number(a), number(b), number(c));
        if (tags) tags->insert(tags->end(), cluster->tags.begin(), cluster->tags.end());
    });
    return mesh;
}

} // namespace brittle::fracture
