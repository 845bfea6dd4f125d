// voro++ for tools/compare: the Voronoi cells in the bounding box of the mesh, with their vertices and faces.
#include <algorithm>
#include <cmath>

#include <voro++/voro++.hh>

#include "tools/comparison/adapters/adapter.h"

namespace brittle::comparison {

namespace {

struct Job {
    explicit Job(const Task& task) : sites(task.sites), low(task.mesh.points.at(0)), high(low) {
        for (const Point& p : task.mesh.points)
            for (int k = 0; k < 3; ++k) {
                low[k] = std::min(low[k], p[k]);
                high[k] = std::max(high[k], p[k]);
            }
        const double volume = (high[0] - low[0]) * (high[1] - low[1]) * (high[2] - low[2]);
        const double block = std::cbrt(5.0 * volume / static_cast<double>(sites.size())); // its manual's 5 a block
        for (int k = 0; k < 3; ++k) blocks[k] = std::max(1, static_cast<int>((high[k] - low[k]) / block + 1.0));
    }

    size_t run() {
        voro::container box(low[0], high[0], low[1], high[1], low[2], high[2], blocks[0], blocks[1], blocks[2], false,
                            false, false, 8);
        for (size_t k = 0; k < sites.size(); ++k) box.put(static_cast<int>(k), sites[k][0], sites[k][1], sites[k][2]);
        cells.clear();
        voro::c_loop_all loop(box);
        voro::voronoicell cell;
        if (loop.start()) do {
                if (!box.compute_cell(cell, loop)) continue;
                double x = 0.0, y = 0.0, z = 0.0;
                loop.pos(x, y, z);
                Cell& made = cells.emplace_back();
                cell.vertices(x, y, z, made.vertices);
                cell.face_vertices(made.faces);
            } while (loop.inc());
        return cells.size();
    }

    std::vector<Part> pieces() const {
        std::vector<Part> parts;
        for (const Cell& cell : cells) {
            Part& part = parts.emplace_back();
            for (size_t k = 0; k < cell.vertices.size(); k += 3)
                part.points.push_back({cell.vertices[k], cell.vertices[k + 1], cell.vertices[k + 2]});
            for (size_t at = 0; at < cell.faces.size(); at += static_cast<size_t>(cell.faces[at]) + 1) {
                const auto corner = [&](int k) {
                    return static_cast<uint32_t>(cell.faces[at + 1 + static_cast<size_t>(k)]);
                };
                for (int k = 2; k < cell.faces[at]; ++k)
                    part.triangles.push_back({corner(0), corner(k), corner(k - 1)});
            }
        }
        return parts;
    }

    struct Cell {
        std::vector<double> vertices;
        std::vector<int> faces; // a count, then as many vertices, clockwise seen from outside
    };
    std::vector<Point> sites;
    Point low, high;
    std::array<int, 3> blocks{};
    std::vector<Cell> cells;
};

} // namespace

} // namespace brittle::comparison

int main(int count, char** words) {
    return brittle::comparison::serve<brittle::comparison::Job>(count, words, "voro++ 0.4.6");
}
