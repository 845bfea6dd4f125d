#include "fracture/doctor/inspect.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <map>
#include <numeric>
#include <tuple>

#include <glm/geometric.hpp>

#include "fracture/arithmetic/plane_predicates.h"
#include "fracture/base/union_find.h"
#include "fracture/mesh/inside.h"
#include "fracture/mesh/intersections.h"
#include "fracture/mesh/thickness.h"

namespace brittle::fracture {

namespace {

// The limits of fracture(): the range of coordinates in metres, and a volume above rounding.
constexpr double max_coordinate = 1e50;
constexpr double min_volume = 1e-15;

bool is_readable(const TriangleMesh& mesh) {
    if (mesh.triangles.empty()) return false;
    for (const glm::dvec3& p : mesh.positions)
        for (int k = 0; k < 3; ++k)
            if (!(std::abs(p[k]) <= max_coordinate)) return false;
    return std::all_of(mesh.triangles.begin(), mesh.triangles.end(), [&](const Triangle& t) {
        return std::max({t.x, t.y, t.z}) < mesh.positions.size();
    });
}

bool is_flat(const TriangleMesh& mesh, const Triangle& t) {
    const glm::dvec3 &a = mesh.positions[t.x], &b = mesh.positions[t.y], &c = mesh.positions[t.z];
    return orientation(glm::dvec2(a.x, a.y), {b.x, b.y}, {c.x, c.y}) == 0.0
           && orientation(glm::dvec2(a.y, a.z), {b.y, b.z}, {c.y, c.z}) == 0.0
           && orientation(glm::dvec2(a.z, a.x), {b.z, b.x}, {c.z, c.x}) == 0.0;
}

void find_duplicates(const TriangleMesh& mesh, size_t max_places, Inspection& out) {
    std::vector<std::array<uint32_t, 4>> sorted; // three vertices in ascending order, then the triangle
    for (uint32_t t = 0; t < mesh.triangles.size(); ++t) {
        std::array<uint32_t, 3> c = {mesh.triangles[t].x, mesh.triangles[t].y, mesh.triangles[t].z};
        std::sort(c.begin(), c.end());
        sorted.push_back({c[0], c[1], c[2], t});
    }
    std::sort(sorted.begin(), sorted.end());
    for (size_t k = 1, first = 0; k < sorted.size(); ++k) {
        if (!std::equal(sorted[k].begin(), sorted[k].begin() + 3, sorted[first].begin())) {
            first = k;
            continue;
        }
        ++out.duplicate_triangles;
        const glm::uvec2 pair(sorted[k][3], sorted[first][3]);
        if (!out.first_duplicate || pair.x < out.first_duplicate->x) out.first_duplicate = pair;
        out.places.duplicate_triangles.push_back(pair.x);
    }
    std::sort(out.places.duplicate_triangles.begin(), out.places.duplicate_triangles.end());
    if (out.places.duplicate_triangles.size() > max_places) out.places.duplicate_triangles.resize(max_places);
}

// Undirected edges with the number of uses in each direction.
struct Edge {
    uint32_t low, high;
    bool forward;
};

std::vector<Edge> sorted_edges(const TriangleMesh& mesh) {
    std::vector<Edge> edges;
    edges.reserve(3 * mesh.triangles.size());
    for (const Triangle& t : mesh.triangles)
        for (int k = 0; k < 3; ++k) {
            const uint32_t a = t[k], b = t[(k + 1) % 3];
            if (a != b) edges.push_back({std::min(a, b), std::max(a, b), a < b});
        }
    std::sort(edges.begin(), edges.end(), [](const Edge& x, const Edge& y) {
        return std::tie(x.low, x.high, x.forward) < std::tie(y.low, y.high, y.forward);
    });
    return edges;
}

void find_rims_and_components(const TriangleMesh& mesh, size_t max_places, Inspection& out) {
    const auto component = triangle_components(mesh.positions.size(), mesh.triangles);
    std::vector<uint32_t> of_vertex(mesh.positions.size(), 0);
    for (uint32_t t = 0; t < component.size(); ++t) {
        if (component[t] == out.components.size()) out.components.push_back({t, 0, 0.0, true, false, false});
        ++out.components[component[t]].triangles;
        const Triangle& c = mesh.triangles[t];
        const glm::dvec3 &o = mesh.positions[mesh.triangles[out.components[component[t]].first_triangle].x],
                         a = mesh.positions[c.x] - o, b = mesh.positions[c.y] - o, d = mesh.positions[c.z] - o;
        out.components[component[t]].volume += glm::dot(a, glm::cross(b, d)) / 6.0;
        for (int k = 0; k < 3; ++k) of_vertex[c[k]] = component[t];
    }

    const std::vector<Edge> edges = sorted_edges(mesh);
    std::vector<uint32_t> parent(mesh.positions.size());
    std::iota(parent.begin(), parent.end(), 0u);
    std::vector<Edge> open;
    for (size_t begin = 0, end = 0; begin < edges.size(); begin = end) {
        size_t forward = 0;
        for (; end < edges.size() && edges[end].low == edges[begin].low && edges[end].high == edges[begin].high; ++end)
            forward += edges[end].forward ? 1 : 0;
        const auto list = [&](std::vector<glm::uvec2>& places) {
            if (places.size() < max_places) places.emplace_back(edges[begin].low, edges[begin].high);
        };
        if (end - begin == 1) list(out.places.open_edges);
        if (end - begin == 2 && forward != 1) list(out.places.misoriented_edges);
        if (end - begin > 2) list(out.places.non_manifold_edges);
        if (end - begin != 2 || forward != 1) out.components[of_vertex[edges[begin].low]].closed = false;
        if (end - begin != 1) continue;
        open.push_back(edges[begin]);
        unite(parent, edges[begin].low, edges[begin].high);
    }
    std::map<uint32_t, Inspection::Rim> rims;
    for (const Edge& edge : open) {
        Inspection::Rim& rim = rims[root_of(parent, edge.low)];
        rim.vertex = root_of(parent, edge.low);
        ++rim.edges;
        rim.length += glm::distance(mesh.positions[edge.low], mesh.positions[edge.high]);
    }
    for (const auto& [root, rim] : rims) out.rims.push_back(rim);
    std::stable_sort(out.rims.begin(), out.rims.end(),
                     [](const auto& x, const auto& y) { return x.length > y.length; });

    for (uint32_t k = 0; k < out.components.size(); ++k) {
        Inspection::Component& own = out.components[k];
        if (!own.closed || !(own.volume < 0.0)) continue;
        // Is it inside the solid that the outward shells enclose?
        TriangleMesh others{mesh.positions, {}};
        for (uint32_t t = 0; t < component.size(); ++t)
            if (out.components[component[t]].closed && out.components[component[t]].volume > 0.0)
                others.triangles.push_back(mesh.triangles[t]);
        own.is_cavity =
            !others.triangles.empty() && InsideTest(others)(mesh.positions[mesh.triangles[own.first_triangle].x]);
        own.is_inside_out = !own.is_cavity;
        if (k > 1000) break; // crumbs: each test examines the whole mesh
    }
}

void measure_thickness(const TriangleMesh& mesh, const InspectSettings& settings, Inspection& out) {
    const Thickness thickness(mesh);
    const double limit = Inspection::thin_limit * glm::length(out.box.size());
    const auto count = static_cast<uint64_t>(mesh.triangles.size());
    const auto middle = [&](uint32_t t) {
        const Triangle& c = mesh.triangles[t];
        return (mesh.positions[c.x] + mesh.positions[c.y] + mesh.positions[c.z]) / 3.0;
    };
    // The first thousand tell how much work a measurement is.
    constexpr uint64_t probes = 1000;
    uint64_t measured = std::min<uint64_t>(count, settings.max_measured);
    if (measured > probes) {
        uint64_t visits = 0;
        for (uint64_t k = 0; k < probes; ++k) {
            const auto t = static_cast<uint32_t>(k * count / probes);
            static_cast<void>(thickness.at(t, middle(t), &visits));
        }
        measured = std::clamp(settings.max_visits * probes / std::max<uint64_t>(visits, 1), probes, measured);
    }
    double area = 0.0, thin = 0.0;
    for (uint64_t k = 0; k < measured; ++k) {
        const auto t = static_cast<uint32_t>(k * count / measured);
        const Triangle& c = mesh.triangles[t];
        const glm::dvec3 &p = mesh.positions[c.x], &q = mesh.positions[c.y], &r = mesh.positions[c.z];
        const std::optional<double> through = thickness.at(t, middle(t));
        if (!through) continue;
        const double own = glm::length(glm::cross(q - p, r - p));
        area += own;
        if (!out.min_thickness || *through < *out.min_thickness) {
            out.min_thickness = through;
            out.thinnest_triangle = t;
        }
        if (!(*through < limit)) continue;
        thin += own;
        if (out.places.thin_triangles.size() < settings.max_places) out.places.thin_triangles.push_back(t);
    }
    if (area > 0.0) out.thin_share = thin / area;
}

std::string grouped(uint64_t number) {
    std::string text = std::to_string(number);
    for (size_t at = text.size(); at > 3;) text.insert(at -= 3, ",");
    return text;
}

std::string count(uint64_t number, const char* one, const char* many) {
    return grouped(number) + " " + (number == 1 ? one : many);
}

template<class... Values>
std::string format(const char* text, Values... values) {
    char buffer[300];
    std::snprintf(buffer, sizeof buffer, text, values...);
    return buffer;
}

// Most mesh formats do not define their unit of length.
std::string guess_units(double longest) {
    if (longest > 1000.0) return "; if these are millimetres, scale by 0.001";
    if (longest > 50.0) return "; if these are centimetres, scale by 0.01";
    return "";
}

// Each property for itself, however many faults there are.
std::string properties(const TopologyReport& t) {
    return std::string(t.open_edges == 0 ? "closed" : "open") + (t.misoriented_edges == 0 ? ", " : ", not ")
           + "oriented" + (t.non_manifold_edges == 0 && t.non_manifold_vertices == 0 ? ", " : ", not ") + "manifold";
}

std::string verdict(const Inspection& i) {
    if (i.refusal) {
        switch (*i.refusal) {
        case Status::empty_mesh:
            return "refuses it: there are no triangles.";
        case Status::invalid_mesh:
            return "refuses it: an index or a coordinate is out of range, or a triangle names a vertex twice.";
        case Status::not_closed:
            return "refuses it: the surface has holes. brittle repair closes them.";
        case Status::non_manifold:
            return "refuses it: more than two triangles share an edge. brittle repair drops duplicates and separates "
                   "parts "
                   "that touch.";
        case Status::not_oriented:
            return "refuses it: neighbouring triangles face opposite ways. brittle repair turns them.";
        case Status::inside_out:
            return "refuses it: it faces inwards. brittle repair turns it.";
        case Status::inverted_part:
            return "refuses it: a part faces inwards outside all others. brittle repair turns it.";
        case Status::no_volume:
            return "refuses it: it encloses nothing.";
        default:
            return std::string("refuses it: ") + to_string(*i.refusal) + ".";
        }
    }
    if (i.intersections > 0)
        return "takes it, unless a piece would be inside out. Where it passes through itself, pieces overlap too: "
               "space counts as often as the surface winds around it.";
    return "takes it as it is.";
}

} // namespace

Inspection inspect(const TriangleMesh& mesh, const InspectSettings& settings) {
    Inspection out;
    out.topology.triangles = mesh.triangles.size();
    if (!is_readable(mesh)) {
        out.refusal = mesh.triangles.empty() ? Status::empty_mesh : Status::invalid_mesh;
        return out;
    }
    out.topology = check_topology(mesh.positions.size(), mesh.triangles);
    const MassProperties mass = mass_properties(mesh.positions, mesh.triangles);
    out.area = mass.area;
    out.volume = mass.volume;
    out.unused_vertices = mesh.positions.size() - out.topology.vertices;
    TriangleMesh used; // the bounding box excludes unused vertices
    for (const Triangle& t : mesh.triangles)
        for (int k = 0; k < 3; ++k) used.positions.push_back(mesh.positions[t[k]]);
    out.box = bounds(used);
    for (uint32_t t = 0; t < mesh.triangles.size(); ++t) {
        if (!is_flat(mesh, mesh.triangles[t])) continue;
        ++out.flat_triangles;
        if (!out.first_flat_triangle) out.first_flat_triangle = t;
        if (out.places.flat_triangles.size() < settings.max_places) out.places.flat_triangles.push_back(t);
    }
    find_duplicates(mesh, settings.max_places, out);
    find_rims_and_components(mesh, settings.max_places, out);
    measure_thickness(mesh, settings, out);
    out.places.non_manifold_vertices = out.topology.some_non_manifold_vertices;
    if (out.places.non_manifold_vertices.size() > settings.max_places)
        out.places.non_manifold_vertices.resize(settings.max_places);
    Intersections crossing = find_intersections(mesh, settings.max_pairs, settings.max_places);
    out.places.crossings = std::move(crossing.listed);
    out.intersections = crossing.pairs;
    out.first_intersection = crossing.first;
    out.all_pairs_seen = crossing.complete;

    const double diagonal = glm::length(out.box.size());
    if (!out.topology.closed())
        out.refusal = status_of(out.topology);
    else if (std::abs(out.volume) <= min_volume * out.area * diagonal)
        out.refusal = Status::no_volume;
    else if (out.volume < 0.0)
        out.refusal = Status::inside_out;
    else if (out.intersections == 0 && out.all_pairs_seen
             && std::any_of(out.components.begin(), out.components.end(),
                            [](const auto& c) { return c.is_inside_out; }))
        out.refusal = Status::inverted_part;
    return out;
}

std::string describe(const Inspection& i) {
    std::string text = "  triangles  " + count(i.topology.triangles, "triangle", "triangles");
    if (i.refusal == Status::empty_mesh || (i.refusal == Status::invalid_mesh && i.topology.vertices == 0))
        return text + "\n  fracture   " + verdict(i) + "\n";
    const glm::dvec3 size = i.box.size();
    text += ", " + count(i.topology.vertices, "vertex", "vertices") + ", "
            + count(i.components.size(), "component", "components") + "\n";
    text += format("  size       %.6g x %.6g x %.6g", size.x, size.y, size.z)
            + guess_units(std::max({size.x, size.y, size.z})) + "\n";
    if (i.topology.closed()) text += format("  volume     %.6g, surface %.6g\n", i.volume, i.area);
    const auto line = [&text](const char* name, const std::string& what) {
        text += "  " + std::string(name) + std::string(11 - std::string(name).size(), ' ') + what + "\n";
    };
    line("surface", properties(i.topology));
    if (!i.topology.manifold()) line("faults", describe(i.topology));
    if (!i.rims.empty())
        line("holes", count(i.rims.size(), "rim", "rims") + ", the longest of "
                          + count(i.rims[0].edges, "edge", "edges")
                          + format(", %.4g long, at vertex ", i.rims[0].length) + std::to_string(i.rims[0].vertex));
    const auto number = [&](auto member) {
        return static_cast<uint64_t>(
            std::count_if(i.components.begin(), i.components.end(), [&](const auto& c) { return c.*member; }));
    };
    if (const uint64_t n = number(&Inspection::Component::is_cavity)) line("cavities", grouped(n));
    if (const uint64_t n = number(&Inspection::Component::is_inside_out))
        line("inside out", count(n, "component faces", "components face") + " inwards");
    if (i.flat_triangles > 0)
        line("flat", count(i.flat_triangles, "triangle has", "triangles have") + " no area, the first is "
                         + std::to_string(*i.first_flat_triangle));
    if (i.duplicate_triangles > 0)
        line("duplicates", count(i.duplicate_triangles, "triangle repeats another", "triangles repeat others")
                               + ", the first " + std::to_string(i.first_duplicate->x) + ", which repeats "
                               + std::to_string(i.first_duplicate->y));
    if (i.unused_vertices > 0) line("unused", count(i.unused_vertices, "vertex", "vertices"));
    if (i.intersections > 0)
        line("crossings", count(i.intersections, "pair of triangles meets", "pairs of triangles meet")
                              + " beyond common edges and vertices, the first "
                              + std::to_string(i.first_intersection->x) + " and "
                              + std::to_string(i.first_intersection->y));
    if (i.thin_share > 0.0)
        line("thin", format("%.3g %% of the surface is thinner than %.3g, the thinnest %.3g at triangle ",
                            100.0 * i.thin_share, Inspection::thin_limit * glm::length(size), *i.min_thickness)
                         + std::to_string(i.thinnest_triangle));
    if (!i.all_pairs_seen)
        line("", "not all pairs of triangles were tested for crossings: too many are close together");
    line("fracture", verdict(i));
    return text;
}

} // namespace brittle::fracture
