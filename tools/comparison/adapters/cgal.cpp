// CGAL's polygon mesh processing for tools/compare: each given cell meets a copy of the mesh, on several threads.
//
//     compare_cgal MESH SITES CELLS THREADS corefine   corefine_and_compute_intersection()
//     compare_cgal MESH SITES CELLS THREADS clip       clip() by the cell as a volume
#include <algorithm>
#include <atomic>
#include <thread>

#include <CGAL/Exact_predicates_inexact_constructions_kernel.h>
#include <CGAL/Polygon_mesh_processing/clip.h>
#include <CGAL/Polygon_mesh_processing/connected_components.h>
#include <CGAL/Polygon_mesh_processing/corefinement.h>
#include <CGAL/Polygon_mesh_processing/orientation.h>
#include <CGAL/Polygon_mesh_processing/polygon_soup_to_polygon_mesh.h>
#include <CGAL/Polygon_mesh_processing/triangulate_faces.h>
#include <CGAL/Surface_mesh.h>
#include <CGAL/version.h>

#include "tools/comparison/adapters/adapter.h"

namespace pmp = CGAL::Polygon_mesh_processing;
using Kernel = CGAL::Exact_predicates_inexact_constructions_kernel;
using Mesh = CGAL::Surface_mesh<Kernel::Point_3>;

namespace brittle::comparison {

namespace {

Mesh mesh_of(const Part& part) {
    std::vector<Kernel::Point_3> points;
    std::vector<std::vector<size_t>> faces;
    for (const Point& p : part.points) points.emplace_back(p[0], p[1], p[2]);
    for (const Corners& t : part.triangles) faces.push_back({t[0], t[1], t[2]});
    Mesh mesh;
    pmp::polygon_soup_to_polygon_mesh(points, faces, mesh);
    return mesh;
}

Part part_of(const Mesh& mesh) {
    Part part;
    std::vector<uint32_t> numbers(mesh.number_of_vertices() + mesh.number_of_removed_vertices());
    for (const auto v : mesh.vertices()) {
        numbers[v] = static_cast<uint32_t>(part.points.size());
        const auto& p = mesh.point(v);
        part.points.push_back({p.x(), p.y(), p.z()});
    }
    for (const auto face : mesh.faces()) {
        Corners& corners = part.triangles.emplace_back();
        size_t k = 0;
        for (const auto v : mesh.vertices_around_face(mesh.halfedge(face))) corners[k++] = numbers[v];
    }
    return part;
}

// Parts that bound volumes of their own, with their cavities.
void append_islands(Mesh& mesh, std::vector<Mesh>& out) {
    std::vector<Mesh> parts;
    pmp::split_connected_components(mesh, parts);
    const auto outward = [](const Mesh& part) { return pmp::is_outward_oriented(part); };
    if (std::ranges::all_of(parts, outward)) {
        std::ranges::move(parts, std::back_inserter(out));
    } else if (!mesh.is_empty()) { // with a cavity: stays one piece
        out.push_back(std::move(mesh));
    }
}

struct Job {
    explicit Job(const Task& task) : mesh(mesh_of(task.mesh)), threads(std::max(1u, task.threads)) {
        clips = !task.words.empty() && task.words[0] == "clip";
        for (const Part& cell : task.cells) cells.push_back(mesh_of(cell));
    }

    size_t run() {
        std::vector<std::vector<Mesh>> of_cell(cells.size());
        std::atomic<size_t> next = 0;
        std::atomic<bool> failed = false;
        const auto work = [&] {
            for (size_t k = next++; k < cells.size() && !failed; k = next++) {
                try {
                    Mesh solid = mesh, cell = cells[k], result;
                    if (clips) {
                        if (!pmp::clip(solid, cell, CGAL::parameters::clip_volume(true))) failed = true;
                        result = std::move(solid);
                    } else if (!pmp::corefine_and_compute_intersection(solid, cell, result)) {
                        failed = true;
                    }
                    result.collect_garbage();
                    append_islands(result, of_cell[k]);
                } catch (const std::exception&) {
                    failed = true;
                }
            }
        };
        std::vector<std::thread> others;
        for (unsigned k = 1; k < threads; ++k) others.emplace_back(work);
        work();
        for (std::thread& other : others) other.join();
        if (failed) throw std::runtime_error("CGAL refuses an intersection with a cell");
        made.clear();
        for (std::vector<Mesh>& all : of_cell) std::ranges::move(all, std::back_inserter(made));
        return made.size();
    }

    std::vector<Part> pieces() const {
        std::vector<Part> parts;
        for (const Mesh& piece : made) parts.push_back(part_of(piece));
        return parts;
    }

    Mesh mesh;
    unsigned threads;
    bool clips;
    std::vector<Mesh> cells, made;
};

} // namespace

} // namespace brittle::comparison

int main(int count, char** words) {
    return brittle::comparison::serve<brittle::comparison::Job>(count, words, "CGAL " CGAL_VERSION_STR);
}
