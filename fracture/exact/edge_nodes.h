// Nodes along the Voronoi edges inside the solid, for caps that are bent after the cut (rough/rough.h).
//
// A node belongs to an edge, to the interval between two neighbouring stops on it (its ends and its pierce points), and
// to a sheet of the solid (winding.h). The caps on the three facets of the edge share it, so the pieces stay closed.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "fracture/exact/cut.h"
#include "fracture/exact/voronoi.h"
#include "fracture/exact/winding.h"

namespace brittle::fracture::exact {

class EdgeNodes {
  public:
    // Appends the nodes to cut.nodes: as few as leave no gap longer than `spacing` (scene units). 0 means none. Runs
    // after Winding::compute(). `groups` is one group a site, or empty: an edge within a group gets no nodes.
    void run(const VoronoiDiagram& diagram, const Winding& winding, double spacing, std::span<const uint32_t> groups,
             Cut& cut);

    // The intervals of edge e are numbered from this one on, along the edge: one more than its pierce points.
    [[nodiscard]] static uint32_t first_interval(const Winding& winding, uint32_t edge) {
        return winding.pierce_begin[edge] + edge;
    }
    // Nodes of one sheet in an interval. A node id is first() of the sheet and a number below count(), along the edge.
    [[nodiscard]] uint32_t count(uint32_t interval) const {
        return intervals_.empty() ? 0 : intervals_[interval].count;
    }
    [[nodiscard]] uint32_t first(uint32_t interval, int32_t sheet) const {
        const Interval& i = intervals_[interval];
        return i.first_node + i.count * static_cast<uint32_t>(sheet > 0 ? sheet - 1 : -sheet);
    }

  private:
    struct Interval {
        uint32_t first_node;
        uint32_t count;
    };
    std::vector<Interval> intervals_; // empty without nodes
};

} // namespace brittle::fracture::exact
