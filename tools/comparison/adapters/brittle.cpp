// Brittle for tools/compare.
//
//     compare_brittle MESH SITES CELLS THREADS          fracture() with a workspace that is kept
//     compare_brittle MESH SITES CELLS THREADS cells    only the Voronoi cells in the bounding box of the mesh
#include <algorithm>
#include <cmath>
#include <map>

#include <glm/geometric.hpp>

#include "fracture/exact/voronoi.h"
#include "fracture/fracture.h"
#include "tools/comparison/adapters/adapter.h"

namespace brittle::comparison {

namespace {

glm::dvec3 vector_of(const Point& p) {
    return {p[0], p[1], p[2]};
}

struct Job {
    explicit Job(const Task& task)
        : only_cells(!task.words.empty() && task.words[0] == "cells"), settings{.threads = task.threads} {
        for (const Point& p : task.mesh.points) mesh.positions.push_back(vector_of(p));
        for (const Corners& t : task.mesh.triangles) mesh.triangles.emplace_back(t[0], t[1], t[2]);
        for (const Point& p : task.sites) sites.push_back(vector_of(p));
    }

    size_t run() {
        if (only_cells) {
            auto made = fracture::voronoi_diagram(sites, bounds(mesh), settings.threads);
            if (!made) throw std::runtime_error(made.error().message);
            diagram = std::move(*made);
            return sites.size();
        }
        const auto done = fracture::fracture(mesh, sites, settings, workspace, fragments);
        if (!done) throw std::runtime_error(done.error().message);
        return fragments.pieces.size();
    }

    std::vector<Part> pieces() const {
        std::vector<Part> parts;
        if (only_cells) {
            for (uint32_t site = 0; site < sites.size(); ++site)
                if (diagram.cell_is_empty[site] == 0) parts.push_back(cell(site));
            return parts;
        }
        for (const fracture::Piece& piece : fragments.pieces) {
            Part& part = parts.emplace_back();
            for (const glm::dvec3& p : fragments.positions_of(piece)) part.points.push_back({p.x, p.y, p.z});
            for (const fracture::Triangle& t : fragments.triangles_of(piece)) part.triangles.push_back({t.x, t.y, t.z});
        }
        return parts;
    }

    Part cell(uint32_t site) const;

    bool only_cells;
    fracture::Settings settings;
    fracture::TriangleMesh mesh;
    std::vector<glm::dvec3> sites;
    fracture::VoronoiDiagram diagram;
    fracture::Workspace workspace;
    fracture::Fragments fragments;
};

// The facets of a cell, as fans. The diagram has none on the box: on each side of it, the vertices of the cell and the
// corners of the box that it owns form a convex polygon.
Part Job::cell(uint32_t site) const {
    using fracture::VoronoiDiagram;
    const fracture::Box box = bounds(mesh);
    Part part;
    std::map<std::array<double, 3>, uint32_t> numbers;
    const auto number_of = [&](const glm::dvec3& p) {
        const auto [at, is_new] = numbers.try_emplace({p.x, p.y, p.z}, static_cast<uint32_t>(part.points.size()));
        if (is_new) part.points.push_back({p.x, p.y, p.z});
        return at->second;
    };
    const auto add_fan = [&](const std::vector<uint32_t>& ring) {
        for (size_t k = 2; k < ring.size(); ++k) {
            const Corners t{ring[0], ring[k - 1], ring[k]};
            if (t[0] != t[1] && t[1] != t[2] && t[2] != t[0]) part.triangles.push_back(t);
        }
    };
    std::array<std::vector<glm::dvec3>, 6> on_side;
    for (const auto& neighbour : diagram.neighbours_of(site)) {
        std::vector<uint32_t> ring;
        for (const auto& corner : diagram.ring_of(diagram.facets[neighbour.facet])) {
            const VoronoiDiagram::Vertex& vertex = diagram.vertices[corner.vertex];
            ring.push_back(number_of(vertex.position));
            for (const uint32_t plane : vertex.planes)
                if (plane >= VoronoiDiagram::first_box_plane)
                    on_side[plane - VoronoiDiagram::first_box_plane].push_back(vertex.position);
        }
        if (neighbour.site < site) std::ranges::reverse(ring);
        add_fan(ring);
    }
    for (int k = 0; k < 8; ++k) {
        const glm::dvec3 corner((k & 1 ? box.max : box.min).x, (k & 2 ? box.max : box.min).y,
                                (k & 4 ? box.max : box.min).z);
        const auto distance = [&](const glm::dvec3& s) { return glm::dot(s - corner, s - corner); };
        if (std::ranges::min_element(sites, {}, distance) - sites.begin() != site) continue;
        for (int axis = 0; axis < 3; ++axis) on_side[2 * axis + (k >> axis & 1)].push_back(corner);
    }
    for (int side = 0; side < 6; ++side) {
        std::vector<glm::dvec3>& points = on_side[side];
        glm::dvec3 middle(0.0);
        for (const glm::dvec3& p : points) middle += p / static_cast<double>(points.size());
        const int u = (side / 2 + 1) % 3, v = (side / 2 + 2) % 3; // counter-clockwise seen from the positive axis
        const double sense = side % 2 == 1 ? 1.0 : -1.0;
        std::ranges::sort(points, {},
                          [&](const glm::dvec3& p) { return sense * std::atan2(p[v] - middle[v], p[u] - middle[u]); });
        std::vector<uint32_t> ring;
        for (const glm::dvec3& p : points) ring.push_back(number_of(p));
        add_fan(ring);
    }
    return part;
}

} // namespace

} // namespace brittle::comparison

int main(int count, char** words) {
    return brittle::comparison::serve<brittle::comparison::Job>(count, words, "Brittle " BRITTLE_VERSION);
}
