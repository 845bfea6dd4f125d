// The readers behind import_model, one a format. Internal: include io/import.h instead.
//
// All take bytes that others damaged and promise: no read outside them, memory and time bounded by their
// size, and indices in range in what comes out. Positions are as in the file, not yet welded. Messages do not
// name the file (import_model puts it in front) but the line, byte or index. What is wrong with looks is a note.
//
// They are our own and not assimp's: its glTF reader crashed on deeply nested JSON and on long chains of nodes (both are
// tests here), it stores positions in single precision, and these name the line, byte or index at fault.
#pragma once

#include <cstddef>
#include <span>
#include <string_view>

#include "fracture/base/error.h"
#include "fracture/io/companions.h"
#include "fracture/io/model.h"

namespace brittle::fracture {

// By the file's ending in lower case, one of importable_extensions().
[[nodiscard]] Result<Model> read_model(std::string_view extension, std::span<const std::byte> bytes,
                                       Companions& companions);

// Wavefront OBJ: `v`, `vt`, `vn` and `f` (with negative indices, continued lines and polygons, also concave ones), colours
// behind `v`, `mtllib` and `usemtl`; everything else is skipped.
[[nodiscard]] Result<Model> read_obj(std::string_view text, Companions& companions);

// Appends the materials of a Wavefront MTL library, with base colour, emissive and normal textures (PNG or JPEG).
void read_mtl(std::string_view text, Companions& companions, Model& model);

// Stereolithography, text or binary, told apart by content: many binary files start with "solid" too.
[[nodiscard]] Result<TriangleMesh> read_stl(std::span<const std::byte> bytes);

// Stanford PLY, text or binary of either byte order: `vertex` with x, y, z of any type, its normals, colours and texture
// coordinates, `face` with its list of indices and MeshLab's texture coordinates; other elements and properties are
// skipped. Triangle strips are not read.
[[nodiscard]] Result<Model> read_ply(std::span<const std::byte> bytes, Companions& companions);

// Geomview OFF with normals and colours of vertices; text only. Colours of faces are skipped.
[[nodiscard]] Result<Model> read_off(std::string_view text);

// 3D Studio: the triangle meshes. Their vertices are stored in world coordinates, so the mesh matrix (4160)
// and the keyframer's nodes are not applied. Materials are skipped.
[[nodiscard]] Result<TriangleMesh> read_3ds(std::span<const std::byte> bytes);

// glTF 2.0, as .gltf or .glb: triangles, strips and fans of the default scene under their node transforms, with
// materials, images, two sets of texture coordinates, normals and colours. Points, lines, skins, morph targets and
// animations are skipped; compressed accessors are refused. Buffers may lie in the file, in data: URIs, or in files
// below the folder.
[[nodiscard]] Result<Model> read_gltf(std::span<const std::byte> bytes, Companions& companions);

} // namespace brittle::fracture
