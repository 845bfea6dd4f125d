// The readers behind import_model(), one per format. Internal: include io/import.h instead.
//
// The input is untrusted. All readers promise: no read outside the bytes, memory and time bounded by their number, and
// valid indices in the result. Positions are those of the file, not yet welded. Messages name the line, byte or index;
// import_model() puts the name of the file in front. A fault in materials or attributes gives a note.
//
// The rejected alternative is assimp: its glTF reader crashed on deeply nested JSON and on long chains of nodes (both
// are tests here), it stores positions in single precision, and its messages do not name the line, byte or index at
// fault.
#pragma once

#include <cstddef>
#include <span>
#include <string_view>
#include <vector>

#include "fracture/base/error.h"
#include "fracture/io/companions.h"
#include "fracture/io/mesh_scene.h"
#include "fracture/io/model.h"

namespace brittle::fracture {

// Reads a file by its extension in lower case, one of importable_extensions().
[[nodiscard]] Result<Model> read_model(std::string_view extension, std::span<const std::byte> bytes,
                                       Companions& companions);

// Wavefront OBJ: `v` with colours, `vt`, `vn` and `f` (with negative indices, continued lines, and polygons, concave
// ones included), `mtllib` and `usemtl`. Other statements are skipped.
[[nodiscard]] Result<Model> read_obj(std::string_view text, Companions& companions);

// Appends the materials of a Wavefront MTL library, with base colour, emissive and normal textures (PNG or JPEG).
void read_mtl(std::string_view text, Companions& companions, Model& model);

// STL, text or binary, distinguished by content: many binary files start with "solid" too.
[[nodiscard]] Result<Model> read_stl(std::span<const std::byte> bytes);

// Stanford PLY, text or binary of either byte order: element `vertex` with x, y, z of any type, normals, colours and
// texture coordinates; element `face` with its list of indices and MeshLab's texture coordinates. Other elements and
// properties are skipped, triangle strips included.
[[nodiscard]] Result<Model> read_ply(std::span<const std::byte> bytes, Companions& companions);

// Geomview OFF with normals and colours of vertices, text only. Colours of faces are skipped.
[[nodiscard]] Result<Model> read_off(std::string_view text);

// 3D Studio: the triangle meshes. Vertices are stored in world coordinates, so the mesh matrix (4160) and the nodes of
// the keyframer are not applied. Materials are skipped.
[[nodiscard]] Result<TriangleMesh> read_3ds(std::span<const std::byte> bytes);

// glTF 2.0, .gltf or .glb: triangles, strips and fans of the default scene under their node transforms, with materials,
// images, two sets of texture coordinates, normals and colours. Points, lines, skins, morph targets and animations are
// skipped; compressed accessors are refused. Buffers may be in the file, in data: URIs, or in files of the folder and
// below.
[[nodiscard]] Result<Model> read_gltf(std::span<const std::byte> bytes, Companions& companions);

// The same file node by node, as MeshScene describes it, except that meshes are not yet welded, may be empty, and stand
// with their points.
struct RawScene {
    std::vector<SceneNode> nodes{};
    std::vector<SceneMesh> meshes{};
    std::vector<std::vector<uint32_t>> points{}; // Model::points of each mesh
    Model looks{};                               // MeshScene::looks
};
[[nodiscard]] Result<RawScene> read_gltf_scene(std::span<const std::byte> bytes, Companions& companions);

} // namespace brittle::fracture
