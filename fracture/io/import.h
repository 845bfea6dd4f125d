// Mesh files in: OBJ, STL and PLY (text and binary), OFF, glTF and GLB, and 3DS.
//
//     Result<TriangleMesh> mesh = import_mesh("bunny.obj");
//
// All meshes of a file are joined into one, with node transforms applied; polygons are split into triangles;
// vertices at bit-equal positions are welded (weld.h), because files split them at normal and texture seams.
// Nothing else is changed: units and axes stay as in the file (STL and 3DS are often Z up), materials and
// textures are not opened, and open or non-manifold meshes are returned as they are: check_topology()
// (topology.h) says what is wrong, and repair() (repair.h) mends it where it is asked to.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "fracture/error.h"
#include "fracture/mesh.h"

namespace brittle::fracture {

// The reader is chosen by the file's ending, in upper or lower case.
// Errors: file_not_found, unsupported_format, malformed_file (damaged, cut short, indices out of range,
// coordinates that are not finite), empty_mesh; the message names the file, where in it, and what to do.
// Never throws, and reads damaged files of any kind in time and memory bounded by their size. Triangles that
// name a vertex twice after welding are dropped; exporters that round coordinates leave them.
[[nodiscard]] Result<TriangleMesh> import_mesh(const std::filesystem::path& file);

// File endings that import_mesh reads, lower case with the dot, for help texts: ".obj", ".stl", ...
[[nodiscard]] const std::vector<std::string>& importable_extensions();

} // namespace brittle::fracture
