// The readers behind import_mesh, one a format. Internal: include io/import.h instead.
//
// All take bytes that others damaged and promise: no read outside them, memory and time bounded by their
// size, and indices in range in what comes out. Positions are as in the file, not yet welded. Messages do not
// name the file (import_mesh puts it in front) but the line, byte or index.
//
// They are our own and not assimp's: its glTF reader crashed on deeply nested JSON and on long chains of nodes (both are
// tests here), it stores positions in single precision, and these name the line, byte or index at fault.
#pragma once

#include <cstddef>
#include <filesystem>
#include <span>
#include <string_view>

#include "fracture/error.h"
#include "fracture/mesh.h"

namespace brittle::fracture {

// Wavefront OBJ: `v` and `f` (with negative indices, continued lines and polygons, also concave ones);
// everything else is skipped, materials are never opened.
[[nodiscard]] Result<TriangleMesh> read_obj(std::string_view text);

// Stereolithography, text or binary, told apart by content: many binary files start with "solid" too.
[[nodiscard]] Result<TriangleMesh> read_stl(std::span<const std::byte> bytes);

// Stanford PLY, text or binary of either byte order: `vertex` with x, y, z of any type, `face` with its list of indices;
// other elements and properties are skipped. Triangle strips are not read.
[[nodiscard]] Result<TriangleMesh> read_ply(std::span<const std::byte> bytes);

// Geomview OFF, also with normals and colours, which are skipped; text only.
[[nodiscard]] Result<TriangleMesh> read_off(std::string_view text);

// 3D Studio: the triangle meshes. Their vertices are stored in world coordinates, so the mesh matrix (4160)
// and the keyframer's nodes are not applied.
[[nodiscard]] Result<TriangleMesh> read_3ds(std::span<const std::byte> bytes);

// glTF 2.0, as .gltf or .glb: triangles, strips and fans of the default scene under their node transforms.
// Points, lines, skins, morph targets and animations are skipped; sparse and compressed accessors are
// refused. Buffers may lie in the file, in data: URIs, or in files below the folder.
[[nodiscard]] Result<TriangleMesh> read_gltf(std::span<const std::byte> bytes,
                                             const std::filesystem::path& folder);

} // namespace brittle::fracture
