// CGAL's polygon mesh processing as a program, for tools/zoo, which compiles it: what CGAL makes of a file, and whether a
// file is sound.
//
//     zoo_cgal judge FILE        one line: the faults, or "sound", then the size of the bounding box
//     zoo_cgal repair FILE PLY   CGAL's repair of polygon soups, holes and crossings
//     zoo_cgal stl FILE STL      the triangles of a file as they come
//
// Exit 1 where a file cannot be read or written.
#include <array>
#include <cmath>
#include <cstddef>
#include <fstream>
#include <iostream>
#include <iterator>
#include <string>
#include <vector>

#include <CGAL/Bbox_3.h>
#include <CGAL/Exact_predicates_inexact_constructions_kernel.h>
#include <CGAL/IO/polygon_soup_io.h>
#include <CGAL/Polygon_mesh_processing/border.h>
#include <CGAL/Polygon_mesh_processing/orient_polygon_soup.h>
#include <CGAL/Polygon_mesh_processing/orientation.h>
#include <CGAL/Polygon_mesh_processing/polygon_soup_to_polygon_mesh.h>
#include <CGAL/Polygon_mesh_processing/repair_polygon_soup.h>
#include <CGAL/Polygon_mesh_processing/repair_self_intersections.h>
#include <CGAL/Polygon_mesh_processing/self_intersections.h>
#include <CGAL/Polygon_mesh_processing/stitch_borders.h>
#include <CGAL/Polygon_mesh_processing/triangulate_faces.h>
#include <CGAL/Polygon_mesh_processing/triangulate_hole.h>
#include <CGAL/Surface_mesh.h>

namespace pmp = CGAL::Polygon_mesh_processing;
using Kernel = CGAL::Exact_predicates_inexact_constructions_kernel;
using Point = Kernel::Point_3;
using Mesh = CGAL::Surface_mesh<Point>;

namespace {

struct Soup {
    std::vector<Point> points;
    std::vector<std::vector<size_t>> polygons;
};

// Returns the faults of a soup whose vertices are joined only where the file joins them.
std::string faults(const Soup& soup) {
    if (soup.polygons.empty()) return "empty";
    if (!pmp::is_polygon_soup_a_polygon_mesh(soup.polygons)) return "not manifold or not oriented";
    Mesh mesh;
    pmp::polygon_soup_to_polygon_mesh(soup.points, soup.polygons, mesh);
    if (!CGAL::is_closed(mesh)) return "open";
    if (!CGAL::is_triangle_mesh(mesh) && !pmp::triangulate_faces(mesh)) return "not triangulated";
    if (pmp::does_self_intersect(mesh)) return "crosses itself";
    return pmp::does_bound_a_volume(mesh) ? "sound" : "not outward";
}

void judge(Soup soup) {
    pmp::remove_isolated_points_in_polygon_soup(soup.points, soup.polygons);
    std::string found = faults(soup);
    if (found != "sound") { // files that store each corner of a triangle, or each colour of a vertex, by itself
        Soup joined = soup;
        pmp::merge_duplicate_points_in_polygon_soup(joined.points, joined.polygons);
        if (faults(joined) == "sound") found = "sound";
    }
    CGAL::Bbox_3 box;
    for (const auto& polygon : soup.polygons)
        for (const size_t v : polygon) box += soup.points[v].bbox();
    std::cout << found;
    for (int k = 0; k < 3; ++k) std::cout << ' ' << (soup.polygons.empty() ? 0.0 : box.max(k) - box.min(k));
    std::cout << '\n';
}

Mesh repaired(Soup soup) {
    pmp::repair_polygon_soup(soup.points, soup.polygons);
    pmp::orient_polygon_soup(soup.points, soup.polygons);
    Mesh mesh;
    pmp::polygon_soup_to_polygon_mesh(soup.points, soup.polygons, mesh);
    pmp::triangulate_faces(mesh);
    pmp::stitch_borders(mesh);
    std::vector<Mesh::Halfedge_index> rims;
    pmp::extract_boundary_cycles(mesh, std::back_inserter(rims));
    for (const Mesh::Halfedge_index rim : rims) {
        std::vector<Mesh::Face_index> faces;
        pmp::triangulate_hole(mesh, rim, std::back_inserter(faces));
    }
    if (pmp::does_self_intersect(mesh)) pmp::experimental::remove_self_intersections(mesh);
    if (CGAL::is_closed(mesh) && !pmp::does_self_intersect(mesh)) pmp::orient_to_bound_a_volume(mesh);
    mesh.collect_garbage();
    return mesh;
}

bool write_stl(const Soup& soup, const std::string& name) {
    std::ofstream out(name, std::ios::binary);
    out << std::string(80, ' ');
    std::vector<std::array<size_t, 3>> triangles;
    for (const auto& polygon : soup.polygons)
        for (size_t k = 2; k < polygon.size(); ++k) triangles.push_back({polygon[0], polygon[k - 1], polygon[k]});
    const auto put = [&](const auto& value) { out.write(reinterpret_cast<const char*>(&value), sizeof value); };
    put(static_cast<uint32_t>(triangles.size()));
    for (const auto& triangle : triangles) {
        for (int k = 0; k < 3; ++k) put(0.0f); // the normal, which admesh computes
        for (const size_t v : triangle)
            for (int k = 0; k < 3; ++k) put(static_cast<float>(soup.points[v][k]));
        put(uint16_t{0});
    }
    return out.good();
}

} // namespace

int main(int count, char** words) {
    const std::string task = count > 2 ? words[1] : "";
    Soup soup;
    if ((count > 3) != (task == "repair" || task == "stl") || task.empty()
        || !CGAL::IO::read_polygon_soup(words[2], soup.points, soup.polygons))
        return 1;
    if (task == "judge") judge(soup);
    if (task == "stl") return write_stl(soup, words[3]) ? 0 : 1;
    if (task == "repair") return CGAL::IO::write_PLY(words[3], repaired(soup)) ? 0 : 1;
    return 0;
}
