#include "tools/brittle/pictures/marks.h"

#include <algorithm>

#include <glm/geometric.hpp>
#include <glm/gtc/color_space.hpp>

namespace brittle::tools {

namespace {

// As shares of the diagonal of the mesh's box.
constexpr double bar_radius = 0.0015;
constexpr double cross_size = 0.01;

using Segment = std::array<glm::dvec3, 2>;

void append_outline(const fracture::TriangleMesh& mesh, uint32_t triangle, std::vector<Segment>& segments) {
    const fracture::Triangle& t = mesh.triangles[triangle];
    for (int k = 0; k < 3; ++k) segments.push_back({mesh.positions[t[k]], mesh.positions[t[(k + 1) % 3]]});
}

// Appends a prism of three sides, closed at its ends.
void append_bar(fracture::TriangleMesh& mesh, const Segment& segment, double radius) {
    const glm::dvec3 along = segment[1] - segment[0];
    const double length = glm::length(along);
    const glm::dvec3 direction = length > 0.0 ? along / length : glm::dvec3(0.0, 1.0, 0.0);
    const glm::dvec3 other = std::abs(direction.y) < 0.9 ? glm::dvec3(0.0, 1.0, 0.0) : glm::dvec3(1.0, 0.0, 0.0);
    const glm::dvec3 u = glm::normalize(glm::cross(direction, other)), v = glm::cross(direction, u);
    const auto base = static_cast<uint32_t>(mesh.positions.size());
    for (size_t end = 0; end < 2; ++end)
        for (int k = 0; k < 3; ++k) {
            constexpr double cosines[] = {1.0, -0.5, -0.5}, sines[] = {0.0, 0.866, -0.866};
            mesh.positions.push_back(segment[end] + (end == 0 ? -radius : radius) * direction
                                     + radius * (cosines[k] * u + sines[k] * v));
        }
    mesh.triangles.emplace_back(base, base + 2, base + 1);
    mesh.triangles.emplace_back(base + 3, base + 4, base + 5);
    for (uint32_t k = 0; k < 3; ++k) {
        const uint32_t a = base + k, b = base + (k + 1) % 3;
        mesh.triangles.emplace_back(a, b, b + 3);
        mesh.triangles.emplace_back(a, b + 3, a + 3);
    }
}

double diagonal_of(const fracture::TriangleMesh& mesh) {
    return glm::length(fracture::bounds(mesh).size());
}

} // namespace

std::vector<Marks> marks_of(const fracture::TriangleMesh& mesh, const fracture::Inspection& inspection) {
    const fracture::Places& places = inspection.places;
    std::vector<Marks> all;
    const auto begin = [&](const char* kind, const char* colour_name,
                           const glm::uvec3& colour) -> std::vector<Segment>& {
        all.push_back({kind, colour, colour_name, {}});
        return all.back().segments;
    };
    const auto add_edges = [&](const std::vector<glm::uvec2>& edges, std::vector<Segment>& segments) {
        for (const glm::uvec2& edge : edges) segments.push_back({mesh.positions[edge.x], mesh.positions[edge.y]});
    };
    const auto add_triangles = [&](const std::vector<uint32_t>& triangles, std::vector<Segment>& segments) {
        for (const uint32_t t : triangles) append_outline(mesh, t, segments);
    };
    // Kinds in drawing order: a later kind covers an earlier one.
    add_triangles(places.thin_triangles, begin("thin places", "green", {90, 200, 90}));
    auto& crossings = begin("crossing triangles", "magenta", {225, 50, 200});
    for (const glm::uvec2& pair : places.crossings) {
        append_outline(mesh, pair.x, crossings);
        append_outline(mesh, pair.y, crossings);
    }
    add_triangles(places.duplicate_triangles, begin("duplicate triangles", "blue", {60, 110, 255}));
    add_triangles(places.flat_triangles, begin("flat triangles", "cyan", {40, 210, 230}));
    add_edges(places.misoriented_edges, begin("misoriented edges", "yellow", {250, 220, 40}));
    add_edges(places.non_manifold_edges, begin("non-manifold edges", "red", {230, 30, 30}));
    add_edges(places.open_edges, begin("open edges", "orange", {255, 140, 20}));
    auto& vertices = begin("non-manifold vertices", "red", {230, 30, 30});
    const double arm = cross_size * diagonal_of(mesh);
    for (const uint32_t v : places.non_manifold_vertices)
        for (int k = 0; k < 3; ++k) {
            glm::dvec3 offset(0.0);
            offset[k] = arm;
            vertices.push_back({mesh.positions[v] - offset, mesh.positions[v] + offset});
        }
    std::erase_if(all, [](const Marks& marks) { return marks.segments.empty(); });
    return all;
}

fracture::Model marked_model(const fracture::TriangleMesh& mesh, const std::vector<Marks>& marks) {
    fracture::Model model;
    model.mesh = mesh;
    model.material_of.assign(mesh.triangles.size(), 0);
    model.materials.push_back({.name = "surface",
                               .base_colour = {0.6, 0.6, 0.6, 0.45},
                               .alpha_mode = fracture::AlphaMode::blend,
                               .double_sided = true});
    const double radius = bar_radius * diagonal_of(mesh);
    for (const Marks& one : marks) {
        const glm::dvec3 colour = glm::convertSRGBToLinear(glm::dvec3(one.colour) / 255.0);
        model.materials.push_back({.name = one.kind, .base_colour = {colour, 1.0}, .emissive = colour});
        for (const Segment& segment : one.segments) append_bar(model.mesh, segment, radius);
        model.material_of.resize(model.mesh.triangles.size(), static_cast<uint32_t>(model.materials.size() - 1));
    }
    return model;
}

} // namespace brittle::tools
