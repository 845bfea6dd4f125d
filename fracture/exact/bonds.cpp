#include "fracture/exact/bonds.h"

#include <algorithm>
#include <array>
#include <tuple>
#include <vector>

#include <glm/geometric.hpp>

#include "fracture/exact/scene.h"

namespace brittle::fracture::exact {

namespace {

// Until merge_equal() has run, centroid holds the sum of area times centroid.
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
    if (!std::is_sorted(bonds.begin(), bonds.end(), before)) std::stable_sort(bonds.begin(), bonds.end(), before);
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

// Indexes the corners of cuts only: points that a cut created, and mesh vertices that replaced one of them (slivers.h).
void BondFinder::index_pieces(size_t sites, const Fragments& fragments) {
    constexpr uint32_t first_cut_point = 1u << 30; // as in Fragments::vertex_point
    first_piece_.assign(sites + 1, 0);
    for (const Piece& piece : fragments.pieces) ++first_piece_[piece.site + 1];
    for (size_t site = 0; site < sites; ++site) first_piece_[site + 1] += first_piece_[site];
    islands_.clear();
    for (uint32_t p = 0; p < fragments.pieces.size(); ++p) {
        const Piece& piece = fragments.pieces[p];
        if (pieces_of(piece.site) < 2) continue;
        const auto points = std::span(fragments.vertex_point).subspan(piece.vertices.begin, piece.vertices.size());
        for (const uint32_t point : points)
            if (point >= first_cut_point) islands_.push_back({piece.site, point, p});
        for (const Triangle& t : fragments.triangles_of(piece).subspan(piece.exterior_triangles))
            for (const uint32_t v : {t.x, t.y, t.z})
                if (points[v] < first_cut_point) islands_.push_back({piece.site, points[v], p});
    }
    std::sort(islands_.begin(), islands_.end());
}

uint32_t BondFinder::find_piece(uint32_t site, uint32_t point) const {
    if (pieces_of(site) == 0) return no_index;
    if (pieces_of(site) == 1) return first_piece_[site];
    const auto at = std::lower_bound(islands_.begin(), islands_.end(), Entry{site, point, 0});
    if (at == islands_.end() || (*at)[0] != site || (*at)[1] != point) return no_index;
    return (*at)[2];
}

void BondFinder::run(std::span<const glm::dvec3> sites, Fragments& out) {
    out.bonds.clear();
    index_pieces(sites.size(), out);
    for (uint32_t a = 0; a < out.pieces.size(); ++a) {
        const Piece& piece = out.pieces[a];
        const auto positions = out.positions_of(piece);
        uint32_t other = no_index;
        glm::dvec3 normal(0.0);
        for (uint32_t t = piece.triangles.begin + piece.exterior_triangles; t < piece.triangles.end; ++t) {
            if (out.triangle_source[t] < piece.site) continue; // the other piece counts this cap
            if (out.triangle_source[t] != other) {
                other = out.triangle_source[t];
                normal = glm::normalize(sites[other] - sites[piece.site]);
            }
            const Triangle& corners = out.triangles[t];
            const uint32_t b = find_piece(other, out.vertex_point[piece.vertices.begin + corners.x]);
            if (b == no_index) continue;
            const glm::dvec3 &p = positions[corners.x], &q = positions[corners.y], &r = positions[corners.z];
            const double area = 0.5 * glm::dot(glm::cross(q - p, r - p), normal);
            add(out.bonds, a, b, area, area / 3.0 * (p + q + r), normal);
        }
    }
    merge_equal(out.bonds);
    std::erase_if(out.bonds, [](const Bond& bond) { return !(bond.area > 0.0); });
    for (Bond& bond : out.bonds) bond.centroid /= bond.area;
}

} // namespace brittle::fracture::exact
