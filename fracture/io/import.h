// Mesh files in: OBJ with MTL, STL and PLY (text and binary), OFF, glTF and GLB, and 3DS.
//
//     Result<TriangleMesh> mesh = import_mesh("bunny.obj");
//     Result<Model> model = import_model("vase.glb"); // with what it looks like
//
// All meshes of a file are joined into one, with node transforms applied; polygons are split into triangles;
// vertices at bit-equal positions are welded (weld.h), because files split them at normal and texture seams.
// Nothing else is changed: units and axes stay as in the file (STL and 3DS are often Z up), and open or
// non-manifold meshes are returned as they are: inspect() (inspect.h) says what is wrong, repair() (repair.h)
// mends it. What a model keeps of each format: docs/files.md. Colours of OBJ, PLY and OFF are sRGB.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "fracture/base/error.h"
#include "fracture/io/model.h"
#include "fracture/mesh/mesh.h"

namespace brittle::fracture {

// The reader is chosen by the file's ending, in upper or lower case.
// Errors: file_not_found, unsupported_format, malformed_file (damaged, cut short, indices out of range,
// coordinates that are not finite), empty_mesh; the message names the file, where in it, and what to do.
// Never throws, and reads damaged files of any kind in time and memory bounded by their size. Triangles that
// name a vertex twice after welding are dropped; exporters that round coordinates leave them.
[[nodiscard]] Result<TriangleMesh> import_mesh(const std::filesystem::path& file);

// The same mesh, with materials, images and what belongs to its corners. What is wrong with these is no error but a
// note. Other files (materials, images, buffers) are opened only in the file's own folder and below.
[[nodiscard]] Result<Model> import_model(const std::filesystem::path& file);

// A picture for a material; PNG, JPEG, WebP or KTX2, told by its first bytes. Errors as above.
[[nodiscard]] Result<Image> read_image(const std::filesystem::path& file);

// File endings that both read, lower case with the dot, for help texts: ".obj", ".stl", ...
[[nodiscard]] const std::vector<std::string>& importable_extensions();

} // namespace brittle::fracture
