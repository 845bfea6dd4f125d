#include "fracture/exact/edge_nodes.h"

#include <cmath>
#include <cstdlib>

#include <glm/geometric.hpp>

namespace brittle::fracture::exact {

void EdgeNodes::run(const VoronoiDiagram& diagram, const Winding& winding, double spacing,
                    std::span<const uint32_t> groups, Cut& cut) {
    intervals_.clear();
    if (!(spacing > 0.0)) return;
    intervals_.resize(winding.pierces.size() + diagram.edges.size(), {0, 0});
    for (uint32_t e = 0; e < diagram.edges.size(); ++e) {
        const VoronoiDiagram::Edge& edge = diagram.edges[e];
        const bool is_inside_group = !groups.empty() && groups[edge.planes[0]] == groups[edge.planes[1]]
                                     && (edge.on_box() || groups[edge.planes[0]] == groups[edge.planes[2]]);
        const auto pierces = winding.pierces_of(e);
        int32_t w = winding.of_vertex[edge.start];
        glm::dvec3 from = diagram.vertices[edge.start].position;
        for (uint32_t k = 0; k <= pierces.size(); ++k) {
            const bool last = k == pierces.size();
            const glm::dvec3 to = last ? diagram.vertices[edge.end].position : cut.pierce_positions[pierces[k]];
            if (w != 0) {
                // The walk may meet pierce points in an order that rounding has reversed.
                const double gaps = is_inside_group ? 1.0 : std::ceil(glm::length(to - from) / spacing);
                Interval& interval = intervals_[first_interval(winding, e) + k];
                interval.first_node = static_cast<uint32_t>(cut.nodes.size());
                interval.count = gaps > 1.0 ? static_cast<uint32_t>(gaps) - 1 : 0;
                for (int32_t sheet = 0; sheet < std::abs(w); ++sheet) {
                    for (uint32_t n = 1; n <= interval.count; ++n) {
                        const glm::dvec3 at = from + (to - from) * (n / gaps);
                        cut.nodes.push_back({{edge.planes[0], edge.planes[1], edge.planes[2], no_index}, at, {}});
                    }
                }
            }
            if (!last) w += cut.pierce_points[pierces[k]].leaves ? -1 : 1;
            from = to;
        }
    }
}

} // namespace brittle::fracture::exact
