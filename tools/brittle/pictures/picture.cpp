#include "tools/brittle/pictures/picture.h"

#include <algorithm>

#include <glm/geometric.hpp>
#include <glm/trigonometric.hpp>

#include "fracture/exact/voronoi.h"
#include "fracture/mesh/half_edge.h"
#include "fracture/sequential/bisectors.h"
#include "fracture/sequential/sequential.h"
#include "tools/brittle/pictures/view.h"
#include "tools/scenario/base/failure.h"
#include "tools/scenario/recipe/input.h"

namespace brittle::tools {

namespace {

constexpr double cell_margin = 0.08; // margin around the mesh, as a share of its box's diagonal
constexpr uint32_t cell_colour = engine::srgb8(38, 70, 140);

} // namespace

std::vector<engine::LineVertex> cell_lines(const Input& input) {
    return cell_lines(input.model.mesh, input.sites, input.weights);
}

std::vector<engine::LineVertex> cell_lines(const fracture::TriangleMesh& mesh, std::span<const glm::dvec3> sites,
                                           std::span<const double> weights) {
    fracture::Box box = fracture::bounds(mesh);
    const glm::dvec3 margin(cell_margin * glm::length(box.size()));
    box = {box.min - margin, box.max + margin};
    const fracture::VoronoiDiagram diagram = must(fracture::voronoi_diagram(sites, box, 0, weights));
    std::vector<engine::LineVertex> lines;
    for (const fracture::VoronoiDiagram::Edge& edge : diagram.edges) {
        lines.push_back({glm::vec3(diagram.vertices[edge.start].position), cell_colour});
        lines.push_back({glm::vec3(diagram.vertices[edge.end].position), cell_colour});
    }
    return lines;
}

fracture::Fragments partly_cut(const Input& input, uint32_t planes) {
    const fracture::TriangleMesh& mesh = input.model.mesh;
    const fracture::HalfEdgeMesh whole = must(fracture::build_half_edges(mesh.positions, mesh.triangles));
    std::vector<fracture::Bisector> bisectors =
        fracture::cell_bounds(input.sites, 0, fracture::bounds(mesh), input.weights).bisectors;
    bisectors.resize(std::min<size_t>(planes, bisectors.size()));
    const fracture::HalfEdgeMesh cut = fracture::cut_cell(whole, bisectors, 0);

    fracture::Fragments fragments;
    const std::vector<fracture::Triangle> triangles = fracture::triangle_list(cut);
    fragments.positions = cut.positions;
    fracture::Piece piece;
    for (const bool interior : {false, true}) {
        for (size_t t = 0; t < triangles.size(); ++t) {
            if (cut.sources[t].interior != interior) continue;
            fragments.triangles.push_back(triangles[t]);
            fragments.triangle_source.push_back(cut.sources[t].index);
        }
        if (!interior) piece.exterior_triangles = static_cast<uint32_t>(fragments.triangles.size());
    }
    if (fragments.triangles.empty())
        throw Failure(exit_mesh, "the cell of site 0 contains no part of the mesh; move the site or use another seed");
    piece.vertices.end = static_cast<uint32_t>(fragments.positions.size());
    piece.triangles.end = static_cast<uint32_t>(fragments.triangles.size());
    piece.mass = fracture::mass_properties(fragments.positions, fragments.triangles);
    fragments.pieces.push_back(piece);
    return fragments;
}

engine::Camera picture_camera(const PictureOptions& options, const engine::Bounds& mesh, float aspect) {
    return engine::look_at_bounds(stage_view(mesh), glm::radians(options.azimuth), glm::radians(options.elevation),
                                  aspect, 0.6f, 1.05f * options.distance);
}

} // namespace brittle::tools
