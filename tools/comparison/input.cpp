// Writes a mesh in the format of tools/compare, which every peer then gets:
//
//     compare_input MESH PART    MESH: a file, or shape:NAME; a mesh that is not sound is repaired first
//
// Prints the count of triangles and whether the mesh was repaired. Exit 1 where it cannot be read, repaired or written.
#include <iostream>
#include <string>

#include "fracture/doctor/repair.h"
#include "fracture/io/import.h"
#include "fracture/mesh/topology.h"
#include "fracture/shapes/shapes.h"
#include "tools/comparison/adapters/adapter.h"

namespace brittle::comparison {

namespace {

fracture::TriangleMesh mesh_named(const std::string& name) {
    if (name.starts_with("shape:")) {
        auto made = fracture::shape(name.substr(6));
        if (!made) throw std::runtime_error("there is no shape '" + name.substr(6) + "'");
        return std::move(*made);
    }
    auto read = fracture::import_mesh(name);
    if (!read) throw std::runtime_error(read.error().message);
    return std::move(*read);
}

} // namespace

} // namespace brittle::comparison

int main(int count, char** words) {
    using namespace brittle;
    using namespace brittle::comparison;
    if (count != 3) {
        std::cerr << "usage: compare_input MESH PART\n";
        return 2;
    }
    try {
        fracture::TriangleMesh mesh = mesh_named(words[1]);
        const bool sound = fracture::check_topology(mesh.positions.size(), mesh.triangles).manifold();
        if (!sound) {
            mesh = fracture::repair(mesh).mesh;
            if (!fracture::check_topology(mesh.positions.size(), mesh.triangles).manifold())
                throw std::runtime_error(std::string(words[1]) + ": not closed, and cannot be repaired; leave it out");
        }
        Part part;
        for (const glm::dvec3& p : mesh.positions) part.points.push_back({p.x, p.y, p.z});
        for (const fracture::Triangle& t : mesh.triangles) part.triangles.push_back({t.x, t.y, t.z});
        write_parts(words[2], {part});
        std::cout << part.triangles.size() << (sound ? " sound" : " repaired") << '\n';
    } catch (const std::exception& error) {
        std::cerr << "compare_input: " << error.what() << '\n';
        return 1;
    }
    return 0;
}
