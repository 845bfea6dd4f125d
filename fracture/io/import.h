// Mesh files in: OBJ, STL (text and binary), GLB/glTF, and 3DS.
//
// All meshes of a file are joined into one, with node transforms applied; polygons are split into triangles; vertices
// at bit-equal positions are welded, because files split them at normal and texture seams. Nothing else is changed:
// open or non-manifold meshes are returned as they are, and fracture() or `brittle fracture` says what is wrong.
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "fracture/error.h"
#include "fracture/mesh.h"

namespace brittle::fracture {

// Errors: file_not_found, unsupported_format, malformed_file, empty_mesh; the message names the file and what to do.
// Exporters that triangulate or weld badly leave triangles that name a vertex twice after welding: these are dropped.
[[nodiscard]] Result<TriangleMesh> import_mesh(const std::filesystem::path& file);

// File endings that import_mesh reads, lower case with the dot, for help texts: ".obj", ".stl", ...
[[nodiscard]] const std::vector<std::string>& importable_extensions();

} // namespace brittle::fracture
