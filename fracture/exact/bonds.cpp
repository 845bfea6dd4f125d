#include "fracture/exact/bonds.h"

#include <algorithm>
#include <tuple>

#include <glm/geometric.hpp>

namespace brittle::fracture::exact {

namespace {

// Until all are summed up, centroid holds the sum of area times centroid.
void add(std::vector<Bond>& bonds, uint32_t a, uint32_t b, double area, const glm::dvec3& moment,
         const glm::dvec3& normal) {
    if (!bonds.empty() && bonds.back().a == a && bonds.back().b == b) {
        bonds.back().area += area;
        bonds.back().centroid += moment;
        return;
    }
    bonds.push_back({a, b, area, moment, normal});
}

void merge_equal(std::vector<Bond>& bonds) {
    const auto before = [](const Bond& x, const Bond& y) { return std::tie(x.a, x.b) < std::tie(y.a, y.b); };
    if (!std::is_sorted(bonds.begin(), bonds.end(), before))
        std::stable_sort(bonds.begin(), bonds.end(), before);
    size_t kept = 0;
    for (const Bond& bond : bonds) {
        if (kept > 0 && bonds[kept - 1].a == bond.a && bonds[kept - 1].b == bond.b) {
            bonds[kept - 1].area += bond.area;
            bonds[kept - 1].centroid += bond.centroid;
        } else {
            bonds[kept++] = bond;
        }
    }
    bonds.resize(kept);
}

} // namespace

void find_bonds(const Assembler::Input& input, const Assembler& assembler, const IslandSplitter& islands,
                Fragments& out) {
    out.bonds.clear();
    const Cut& cut = input.cut;
    std::vector<glm::dvec3> corners;
    for (const CapChunk& chunk : input.caps) {
        for (const Cap& cap : chunk.caps) {
            const VoronoiDiagram::Facet& facet = input.diagram.facets[cap.facet];
            const bool split = islands.is_split(facet.i) || islands.is_split(facet.j);
            const glm::dvec3 normal = glm::normalize(input.scene.sites[facet.j] - input.scene.sites[facet.i]);
            corners.clear();
            for (uint32_t k = cap.corners_begin; k < cap.corners_end; ++k) {
                const VertexId id = chunk.corners[k];
                corners.push_back(cap_position(cut, id) * input.scene.to_input);
            }
            for (uint32_t t = cap.triangles_begin; t < cap.triangles_end; ++t) {
                const Triangle& k = chunk.triangles[t];
                const glm::dvec3 &p = corners[k.x], &q = corners[k.y], &r = corners[k.z];
                const double area = 0.5 * glm::dot(glm::cross(q - p, r - p), normal);
                uint32_t a = islands.first_piece(facet.i), b = islands.first_piece(facet.j);
                if (split) {
                    const VertexId id = chunk.corners[cap.corners_begin + k.x];
                    a = islands.piece_of(facet.i, assembler.local_index(input, id, facet.i));
                    b = islands.piece_of(facet.j, assembler.local_index(input, id, facet.j));
                }
                add(out.bonds, a, b, area, area / 3.0 * (p + q + r), normal);
            }
        }
    }
    merge_equal(out.bonds);
    std::erase_if(out.bonds, [](const Bond& bond) { return !(bond.area > 0.0); });
    for (Bond& bond : out.bonds) bond.centroid /= bond.area;
}

} // namespace brittle::fracture::exact
