// Divides triangles along the portions that they hold.
#include <algorithm>
#include <map>
#include <numeric>
#include <unordered_map>

#include "fracture/unite/arrangement.h"
#include "fracture/unite/planar_mesh.h"

namespace brittle::fracture::arrangement {
namespace {

class Cutter {
  public:
    explicit Cutter(const Arrangement& arrangement) : all_(arrangement), planar_(arrangement.points) {}

    void run(const Cut& cut, std::vector<Part>& parts) {
        const Triangle& corners = all_.mesh.triangles[cut.triangle];
        planar_.start({corners.x, corners.y, corners.z}, all_.axis[cut.triangle]);
        index_of_.clear();
        for (uint32_t k = 0; k < 3; ++k) index_of_[planar_.point(k)] = k;
        for (uint32_t k = 0; k < 3; ++k) {
            if (cut.edges[k] == no_index) continue;
            const uint32_t end = (k + 1) % 3;
            uint32_t last = k;
            for (const uint32_t point : points_along({cut.edges[k], planar_.point(k), planar_.point(end)}))
                last = index_of_[point] = planar_.divide_boundary(last, end, point);
        }
        std::vector<std::pair<uint32_t, uint32_t>> pieces; // of portions: indices
        for (const Portion& portion : cut.portions) {
            uint32_t last = index(portion.from);
            for (const uint32_t point : points_along(portion)) {
                const uint32_t here = index(point);
                pieces.emplace_back(last, here);
                last = here;
            }
            pieces.emplace_back(last, index(portion.to));
        }
        for (const auto& [from, to] : pieces) planar_.constrain(from, to);
        if (cut.is_covered)
            emit_regions(cut.triangle, parts);
        else
            for (const PlanarMesh::Face& face : planar_.faces()) parts.push_back({points_of(face), cut.triangle});
    }

  private:
    // The points of a carrier that lie on a portion of it, in order, without its ends.
    std::vector<uint32_t> points_along(const Portion& portion) {
        const Carrier& carrier = all_.carriers[portion.carrier];
        if (carrier.points.empty() && (carrier.from == portion.from || carrier.from == portion.to)
            && (carrier.to == portion.from || carrier.to == portion.to))
            return {};
        const Points& points = all_.points;
        const int axis = points.axis_between(portion.from, portion.to);
        const int ends = points.compare(portion.from, portion.to, axis);
        std::vector<uint32_t> along;
        const auto take = [&](uint32_t p) {
            if (p != portion.from && p != portion.to && points.compare(portion.from, p, axis) == ends
                && points.compare(p, portion.to, axis) == ends)
                along.push_back(p);
        };
        for (const uint32_t point : carrier.points) take(point);
        take(carrier.from);
        take(carrier.to);
        std::sort(along.begin(), along.end(),
                  [&](uint32_t a, uint32_t b) { return points.compare(a, b, axis) == ends; });
        return along;
    }

    uint32_t index(uint32_t point) {
        const auto [entry, is_new] = index_of_.try_emplace(point, 0u);
        if (is_new) entry->second = planar_.insert(point);
        return entry->second;
    }

    [[nodiscard]] Triangle points_of(const PlanarMesh::Face& face) const {
        return {planar_.point(face.corner[0]), planar_.point(face.corner[1]), planar_.point(face.corner[2])};
    }

    // Regions are bounded by constrained edges. Where triangles lie on each other their regions have equal borders; all
    // take the triangulation of the first.
    void emit_regions(uint32_t triangle, std::vector<Part>& parts) {
        const std::vector<PlanarMesh::Face>& faces = planar_.faces();
        std::vector<uint8_t> seen(faces.size(), 0);
        for (uint32_t start = 0; start < faces.size(); ++start) {
            if (seen[start]) continue;
            seen[start] = 1;
            std::vector<uint32_t> region{start};
            std::vector<uint64_t> border;
            std::vector<std::pair<uint32_t, uint32_t>> directed;
            for (size_t n = 0; n < region.size(); ++n) {
                const PlanarMesh::Face& face = faces[region[n]];
                for (size_t k = 0; k < 3; ++k) {
                    const uint32_t beside = face.beside[k];
                    if (face.constrained[k] || beside == no_index) {
                        const uint32_t a = planar_.point(face.corner[k]), b = planar_.point(face.corner[(k + 1) % 3]);
                        border.push_back(Arrangement::edge_key(a, b));
                        directed.emplace_back(a, b);
                    } else if (!seen[beside]) {
                        seen[beside] = 1;
                        region.push_back(beside);
                    }
                }
            }
            std::vector<Triangle> own;
            for (const uint32_t face : region) own.push_back(points_of(faces[face]));
            std::sort(border.begin(), border.end());
            const auto [first, is_new] = regions_.try_emplace(border, own);
            const bool turned = !is_new && !has_edge_of(first->second, border, directed);
            for (const Triangle& t : first->second) parts.push_back({turned ? Triangle(t.x, t.z, t.y) : t, triangle});
        }
    }

    // Whether triangles run along a border in the direction of a region. Edges that the region has on both sides do not
    // tell.
    static bool has_edge_of(const std::vector<Triangle>& triangles, const std::vector<uint64_t>& border,
                            const std::vector<std::pair<uint32_t, uint32_t>>& directed) {
        for (const auto& [a, b] : directed) {
            const auto range = std::equal_range(border.begin(), border.end(), Arrangement::edge_key(a, b));
            if (range.second - range.first != 1) continue;
            for (const Triangle& t : triangles)
                for (int k = 0; k < 3; ++k)
                    if (t[k] == a && t[(k + 1) % 3] == b) return true;
            return false;
        }
        return true;
    }

    const Arrangement& all_;
    PlanarMesh planar_;
    std::unordered_map<uint32_t, uint32_t> index_of_;                // point: index in planar_
    std::map<std::vector<uint64_t>, std::vector<Triangle>> regions_; // by border
};

} // namespace

std::vector<Part> divide_triangles(const Arrangement& arrangement, Threads& threads) {
    const auto count = static_cast<uint32_t>(arrangement.cuts.size());
    std::vector<uint32_t> order(count);
    std::iota(order.begin(), order.end(), 0u);
    std::sort(order.begin(), order.end(),
              [&](uint32_t a, uint32_t b) { return arrangement.cuts[a].triangle < arrangement.cuts[b].triangle; });
    std::vector<std::vector<Part>> parts(count);
    threads.for_chunks(count, 64, [&](uint32_t, uint32_t begin, uint32_t end) {
        Cutter cutter(arrangement);
        for (uint32_t k = begin; k < end; ++k)
            if (const Cut& cut = arrangement.cuts[order[k]]; !cut.is_covered) cutter.run(cut, parts[k]);
    });
    Cutter cutter(arrangement); // of all that lie in one plane, because it knows their regions
    for (uint32_t k = 0; k < count; ++k)
        if (const Cut& cut = arrangement.cuts[order[k]]; cut.is_covered) cutter.run(cut, parts[k]);
    std::vector<Part> all;
    for (const std::vector<Part>& part : parts) all.insert(all.end(), part.begin(), part.end());
    return all;
}

} // namespace brittle::fracture::arrangement
