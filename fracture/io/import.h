// Imports mesh files: OBJ with MTL, STL and PLY (text and binary), OFF, glTF and GLB, and 3DS.
//
//     Result<TriangleMesh> mesh = import_mesh("bunny.obj");
//     Result<Model> model = import_model("vase.glb"); // with materials, images and texture coordinates
//     Result<MeshScene> scene = import_scene("level.glb"); // node by node
//
// import_mesh() and import_model() join all meshes of a file into one, with node transforms applied. Polygons are split into triangles. Vertices
// at bit-equal positions are welded (weld.h), because files split them at seams of normals and texture coordinates.
// Nothing else changes: units and axes are those of the file (STL and 3DS are often Z up), and open or non-manifold
// meshes are returned unchanged; inspect() (inspect.h) reports their flaws and repair() (repair.h) mends them.
// docs/files.md lists the attributes that a model keeps of each format. Colours of OBJ, PLY and OFF are sRGB.
#pragma once

#include <cstddef>
#include <filesystem>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "fracture/base/error.h"
#include "fracture/io/mesh_scene.h"
#include "fracture/io/model.h"
#include "fracture/mesh/mesh.h"

namespace brittle::fracture {

// Imports the mesh. The extension of the file, in upper or lower case, chooses the reader.
//
// Errors: file_not_found, unsupported_format, malformed_file (damaged, cut short, indices out of range, coordinates
// that are not finite), empty_mesh. The message names the file, the place in it, and the remedy. Never throws. Damaged
// files of any kind take time and memory bounded by their size. Triangles that name a vertex twice after welding are
// dropped; exporters that round coordinates produce them.
[[nodiscard]] Result<TriangleMesh> import_mesh(const std::filesystem::path& file);

// Imports the mesh with its materials, images and corner attributes. A fault in these gives a note, not an error. Other
// files (materials, images, buffers) are opened only in the folder of the file and below.
[[nodiscard]] Result<Model> import_model(const std::filesystem::path& file);

// Imports the bytes of a mesh file. `extension` names the format, for example ".glb". No other file is opened: materials,
// images and buffers that lie beside the file give notes, or malformed_file where the geometry is in them. Errors as
// above; messages begin with `name`.
[[nodiscard]] Result<Model> import_model(std::span<const std::byte> bytes, std::string_view extension,
                                         std::string_view name = "mesh in memory");

// Imports the nodes of a .glb or .gltf file that show meshes, and each of these meshes once: geometry only, or with
// materials, images and corner attributes (`with_looks`), a fault in which gives a note. Cameras, lights and empty nodes
// give transforms to their children alone. Errors as above: unsupported_format for other formats, empty_mesh where no
// node shows a triangle.
[[nodiscard]] Result<MeshScene> import_scene(const std::filesystem::path& file, bool with_looks = false);

// Reads an image for a material: PNG, JPEG, WebP or KTX2, recognised by its first bytes. Errors as above.
[[nodiscard]] Result<Image> read_image(const std::filesystem::path& file);

// Returns the extension of the format that the bytes of a mesh file are in, told by how they begin (for binary STL, by
// their number): ".glb". Empty where no reader knows such a file.
[[nodiscard]] std::string_view extension_of(std::span<const std::byte> bytes);

// The extensions that can be imported, in lower case with the dot, for help texts: ".obj", ".stl", ...
[[nodiscard]] const std::vector<std::string>& importable_extensions();

} // namespace brittle::fracture
