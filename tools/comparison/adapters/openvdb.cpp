// OpenVDB's fracturer for tools/compare: level sets of the mesh and of the given cells, 128 voxels along the longest side
// of the mesh, one cell after the other cut from what is left, each result meshed again. A further argument is another
// count of voxels.
#include <algorithm>

#include <openvdb/openvdb.h>
#include <openvdb/tools/LevelSetFracture.h>
#include <openvdb/tools/MeshToVolume.h>
#include <openvdb/tools/VolumeToMesh.h>
#include <tbb/global_control.h>

#include "tools/comparison/adapters/adapter.h"

namespace brittle::comparison {

namespace {

using Grid = openvdb::FloatGrid;

struct Mesh {
    std::vector<openvdb::Vec3s> points;
    std::vector<openvdb::Vec3I> triangles;
    std::vector<openvdb::Vec4I> quads;
};

Mesh mesh_of(const Part& part) {
    Mesh mesh;
    for (const Point& p : part.points)
        mesh.points.emplace_back(static_cast<float>(p[0]), static_cast<float>(p[1]), static_cast<float>(p[2]));
    for (const Corners& t : part.triangles) mesh.triangles.emplace_back(t[0], t[1], t[2]);
    return mesh;
}

struct Job {
    explicit Job(const Task& task)
        : mesh(mesh_of(task.mesh)), limit(tbb::global_control::max_allowed_parallelism, std::max(1u, task.threads)) {
        openvdb::initialize();
        const double voxels = task.words.empty() ? 128.0 : std::stod(task.words[0]);
        openvdb::Vec3s low = mesh.points.at(0), high = low;
        for (const openvdb::Vec3s& p : mesh.points) {
            low = openvdb::math::minComponent(low, p);
            high = openvdb::math::maxComponent(high, p);
        }
        const float longest = std::max({high[0] - low[0], high[1] - low[1], high[2] - low[2]});
        transform = openvdb::math::Transform::createLinearTransform(longest / std::max(8.0, voxels));
        for (const Part& cell : task.cells)
            if (!cell.triangles.empty()) cells.push_back(mesh_of(cell));
    }

    size_t run() {
        const auto level_set = [&](const Mesh& shape) {
            return openvdb::tools::meshToLevelSet<Grid>(*transform, shape.points, shape.triangles);
        };
        std::list<Grid::Ptr> rest{level_set(mesh)};
        openvdb::tools::LevelSetFracture<Grid> fracturer;
        for (const Mesh& cell : cells) fracturer.fracture(rest, *level_set(cell), true);
        made.clear();
        for (const auto* grids : {&fracturer.fragments(), &rest})
            for (const Grid::Ptr& grid : *grids) {
                Mesh& piece = made.emplace_back();
                openvdb::tools::volumeToMesh(*grid, piece.points, piece.triangles, piece.quads);
                if (piece.points.empty()) made.pop_back();
            }
        return made.size();
    }

    // Its triangles are clockwise seen from outside.
    std::vector<Part> pieces() const {
        std::vector<Part> parts;
        for (const Mesh& piece : made) {
            Part& part = parts.emplace_back();
            for (const openvdb::Vec3s& p : piece.points) part.points.push_back({p[0], p[1], p[2]});
            for (const openvdb::Vec3I& t : piece.triangles) part.triangles.push_back({t[0], t[2], t[1]});
            for (const openvdb::Vec4I& q : piece.quads) {
                part.triangles.push_back({q[0], q[2], q[1]});
                part.triangles.push_back({q[0], q[3], q[2]});
            }
        }
        return parts;
    }

    Mesh mesh;
    tbb::global_control limit;
    openvdb::math::Transform::Ptr transform;
    std::vector<Mesh> cells, made;
};

} // namespace

} // namespace brittle::comparison

int main(int count, char** words) {
    return brittle::comparison::serve<brittle::comparison::Job>(
        count, words, std::string("OpenVDB ") + openvdb::getLibraryVersionString());
}
