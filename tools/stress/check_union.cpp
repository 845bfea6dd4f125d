#include "tools/stress/check_union.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <numbers>

#include <glm/geometric.hpp>

#include "fracture/base/random.h"
#include "fracture/mesh/topology.h"
#include "fracture/unite/unite.h"

namespace brittle::stress {

using namespace fracture;

namespace {

constexpr uint32_t sampled_points = 24;
constexpr double clear = 1e-4; // from an integer: a winding number that is further off is of a point at the surface

bool is_closed(const TriangleMesh& mesh) {
    for (const Triangle& t : mesh.triangles)
        if (std::max({t.x, t.y, t.z}) >= mesh.positions.size()) return false;
    for (const glm::dvec3& p : mesh.positions)
        for (int k = 0; k < 3; ++k)
            if (!std::isfinite(p[k])) return false;
    return check_topology(mesh.positions.size(), mesh.triangles).closed();
}

} // namespace

double winding_number(const TriangleMesh& mesh, const glm::dvec3& point) {
    double sum = 0.0;
    for (const Triangle& t : mesh.triangles) {
        const glm::dvec3 a = mesh.positions[t.x] - point, b = mesh.positions[t.y] - point,
                         c = mesh.positions[t.z] - point;
        const double la = glm::length(a), lb = glm::length(b), lc = glm::length(c);
        sum += std::atan2(glm::dot(a, glm::cross(b, c)),
                          la * lb * lc + glm::dot(a, b) * lc + glm::dot(b, c) * la + glm::dot(c, a) * lb);
    }
    return sum / (2.0 * std::numbers::pi);
}

std::string union_complaint(const Case& c) {
    if (!is_closed(c.mesh)) return {};
    const United united = unite(c.mesh, 1);
    if (!united.report.complete) return "the union is not complete";
    const TopologyReport topology = check_topology(united.mesh.positions.size(), united.mesh.triangles);
    if (!topology.manifold()) return "the union has " + describe(topology);
    const United again = unite(united.mesh, 1);
    if (again.mesh.positions != united.mesh.positions || again.mesh.triangles != united.mesh.triangles)
        return "a second union differs from the first";
    const United threaded = unite(c.mesh, 3);
    if (threaded.mesh.positions != united.mesh.positions || threaded.mesh.triangles != united.mesh.triangles)
        return "the union differs with 3 threads";
    Random random(c.mesh.triangles.size());
    for (uint32_t k = 0; k < sampled_points; ++k) {
        const glm::dvec3 p = random.uniform_in(bounds(c.mesh));
        const double before = winding_number(c.mesh, p), after = winding_number(united.mesh, p);
        if (std::abs(before - std::round(before)) > clear || std::abs(after - std::round(after)) > clear) continue;
        if (std::lround(after) == (std::lround(before) > 0 ? 1 : 0)) continue;
        char text[200];
        std::snprintf(text, sizeof text, "the union winds %ld times around (%.17g, %.17g, %.17g), the mesh %ld times",
                      std::lround(after), p.x, p.y, p.z, std::lround(before));
        return text;
    }
    return {};
}

} // namespace brittle::stress
