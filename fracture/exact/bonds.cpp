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

// Calls measure(a, b, triangle) for each cap triangle of piece a, once for both sides; b is the piece on the other side.
template<class Measure>
void BondFinder::visit_contacts(const Fragments& fragments, const Measure& measure) {
    for (uint32_t a = 0; a < fragments.pieces.size(); ++a) {
        const Piece& piece = fragments.pieces[a];
        for (uint32_t t = piece.triangles.begin + piece.exterior_triangles; t < piece.triangles.end; ++t) {
            const uint32_t other = fragments.triangle_source[t];
            if (other < piece.site) continue; // the other piece counts this cap
            const uint32_t corner = fragments.triangles[t].x;
            const uint32_t b = find_piece(other, fragments.vertex_point[piece.vertices.begin + corner]);
            if (b != no_index) measure(a, b, t);
        }
    }
}

void BondFinder::run(std::span<const glm::dvec3> sites, Fragments& out) {
    out.bonds.clear();
    index_pieces(sites.size(), out);
    std::array<uint32_t, 2> between{no_index, no_index}; // the sites of the normal
    glm::dvec3 normal(0.0);
    visit_contacts(out, [&](uint32_t a, uint32_t b, uint32_t t) {
        const Piece& piece = out.pieces[a];
        const uint32_t other = out.triangle_source[t];
        if (between != std::array{piece.site, other}) {
            between = {piece.site, other};
            normal = glm::normalize(sites[other] - sites[piece.site]);
        }
        const auto positions = out.positions_of(piece);
        const Triangle& corners = out.triangles[t];
        const glm::dvec3 &p = positions[corners.x], &q = positions[corners.y], &r = positions[corners.z];
        const double area = 0.5 * glm::dot(glm::cross(q - p, r - p), normal);
        add(out.bonds, a, b, area, area / 3.0 * (p + q + r), normal);
    });
    merge_equal(out.bonds);
    std::erase_if(out.bonds, [](const Bond& bond) { return !(bond.area > 0.0); });
    for (Bond& bond : out.bonds) bond.centroid /= bond.area;
}

void BondFinder::run_bent(size_t sites, Fragments& out) {
    out.bonds.clear();
    index_pieces(sites, out);
    visit_contacts(out, [&](uint32_t a, uint32_t b, uint32_t t) {
        const auto positions = out.positions_of(out.pieces[a]);
        const Triangle& corners = out.triangles[t];
        const glm::dvec3 &p = positions[corners.x], &q = positions[corners.y], &r = positions[corners.z];
        const glm::dvec3 half = 0.5 * glm::cross(q - p, r - p);
        const double area = glm::length(half);
        out.bonds.push_back({std::min(a, b), std::max(a, b), area, area / 3.0 * (p + q + r), a < b ? half : -half});
    });
    std::stable_sort(out.bonds.begin(), out.bonds.end(),
                     [](const Bond& x, const Bond& y) { return std::tie(x.a, x.b) < std::tie(y.a, y.b); });
    size_t kept = 0;
    for (const Bond& bond : out.bonds) {
        if (kept == 0 || out.bonds[kept - 1].a != bond.a || out.bonds[kept - 1].b != bond.b) {
            out.bonds[kept++] = bond;
            continue;
        }
        out.bonds[kept - 1].area += bond.area;
        out.bonds[kept - 1].centroid += bond.centroid;
        out.bonds[kept - 1].normal += bond.normal;
    }
    out.bonds.resize(kept);
    std::erase_if(out.bonds, [](const Bond& bond) { return !(bond.area > 0.0) || bond.normal == glm::dvec3(0.0); });
    for (Bond& bond : out.bonds) {
        bond.centroid /= bond.area;
        bond.normal = glm::normalize(bond.normal);
    }
}

} // namespace brittle::fracture::exact
