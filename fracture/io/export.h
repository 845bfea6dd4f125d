// Exports pieces as binary glTF (.glb), Wavefront OBJ with MTL, or binary PLY or STL, by the extension of the file.
//
//     must(export_pieces("pieces.glb", fragments, certificate, {.source = &model, .sites = sites}));
//
// docs/files.md describes the content of each format and the layout of GLB. In short: GLB and OBJ keep materials,
// texture coordinates, colours (GLB only) and normals of the source, interpolated at the corners of the cut; PLY keeps
// texture coordinates, images of base colours, and colours; STL keeps triangles. Where the source has no normals, pieces
// are flat shaded. Equal positions within a piece stay equal bit for bit in all formats: a reader that welds by position
// gets closed pieces from a file of one piece. A file of many pieces needs the groups of its format: GLB and OBJ have a
// name for each piece, PLY a number at each face, and STL nothing: choose `per_piece` there.
//
// GLB: one root node with one child per piece, NAME_000 ..., whose translation is the centre of mass, without rotation
// and scale; one primitive for each material of the exterior, then one for the cuts. `extras.brittle` of a child: site,
// volume, area, centre_of_mass, inertia (at density 1 about the centre of mass, row by row), exterior_triangles,
// interior_triangles, and bonds (each once, at the piece with the lower number): piece, area, centroid, normal.
// `extras.brittle` of the root: certificate and recipe. Positions are float(position - translation), with the
// translation first rounded to float.
//
// With poses, pieces are written at their poses. In GLB the nodes have translation and rotation, and the extras still
// describe the piece as it was cut: its point p has the coordinates p - centre_of_mass in the node. Other formats
// contain the transformed coordinates.
//
// Equal input gives equal bytes. Every file is written atomically (atomic_file.h); the file that refers to the others
// is written last.
#pragma once

#include <cstddef>
#include <filesystem>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include <glm/gtc/quaternion.hpp>
#include <glm/vec3.hpp>

#include "fracture/base/error.h"
#include "fracture/io/model.h"
#include "fracture/pieces/fragments.h"

namespace brittle::fracture {

// The names in a GLB file by which an engine makes bodies of the pieces.
enum class BodyNames {
    none,
    // The node NAME-rigid: Godot 3 and 4 make a rigid body of it, with convex shapes of the drawn mesh. If fixed,
    // NAME-col: a static body with the drawn mesh.
    godot,
    unreal // a child UCX_NAME_00 with the mesh of a hull; several hulls: UCX_NAME_00, UCX_NAME_01, ...
};

// The pose of a piece: its rotation about the centre of mass, and the position of its centre of mass.
struct PiecePose {
    glm::dvec3 position{0.0};
    glm::dquat orientation{1.0, 0.0, 0.0, 0.0}; // unit
};

struct ExportOptions {
    std::string name = "mesh"; // of the root node, and the start of each piece's name: NAME_000, ...
    std::string recipe = "{}"; // a JSON object, kept unchanged in the root's extras; GLB only
    // The model whose mesh was fractured. Null: pieces are flat shaded, in one material.
    const Model* source = nullptr;
    const std::vector<Image>* images = nullptr; // of `source`, in place of its own; GLB only
    std::span<const glm::dvec3> sites{}; // of the fracture, for texture coordinates in metres on the cuts; may be empty
    bool uv_by_plane = false;            // without sites: texture coordinates of each cut from its own plane
    // The cuts are rough: their normals are smooth, their texture coordinates lie along the mean plane of each cut, and a
    // GLB file gets a second set with the depth below the outside of `source` (u, in metres) for shading.
    bool rough = false;
    std::span<const PiecePose> poses{};    // one per piece; empty: all pieces lie where they were cut
    std::optional<Material> exterior{};    // for surfaces without a source material; default: a light stone
    std::optional<Material> interior{};    // of the cuts; default: a dark brown. Combined with interior_image
    std::optional<Image> interior_image{}; // base colour of the cuts, repeated every metre
    bool per_piece = false;                // one file per piece: NAME.glb becomes NAME_000.glb, NAME_001.glb, ...
    bool single_file = false;              // OBJ: without MTL and images; materials keep their names

    // The remaining options are for GLB only.
    BodyNames body_names = BodyNames::none;
    bool fixed = false; // the bodies of the pieces never move, and collide with the drawn mesh: hulls are not written
    // Convex hulls of each piece, in piece coordinates, for unreal and rigid_bodies; may be empty.
    std::span<const std::vector<TriangleMesh>> hulls{};
    // Also writes mass, inertia and hulls with the extension KHR_physics_rigid_bodies. The extension is a draft and may
    // change: this is its state of June 2026, Khronos pull request 2424, where the geometry of a collider refers to a
    // mesh. Colliders need hulls; their meshes are not drawn.
    bool rigid_bodies = false;
    double density = 1000.0; // kg/m^3, for rigid_bodies; all other values are at density 1
};

// Exports the pieces. Returns the files written, the one to open first; with per_piece, those of each piece in order.
//
// Errors: unsupported_format; write_failed, also for content that the format cannot hold (coordinates beyond a 32-bit
// float, except in OBJ; files of 4 GiB and more); invalid_setting for a recipe that is not a JSON object, for a number
// of hulls or poses that differs from the number of pieces, and for an invalid pose. After a failure an old file of the
// same name is unchanged; of several files, those written before it stay.
[[nodiscard]] Result<std::vector<std::filesystem::path>> export_pieces(const std::filesystem::path& file,
                                                                       const Fragments& fragments,
                                                                       const Certificate& certificate,
                                                                       const ExportOptions& options = {});

// A file in memory.
struct ExportedFile {
    std::string name;
    std::vector<std::byte> bytes;
};

// Returns the files that export_pieces() would write, without folder; `name` has the extension. The file to open is the
// first one, with per_piece the first of each piece. Errors as above.
[[nodiscard]] Result<std::vector<ExportedFile>> export_pieces_to_memory(const std::string& name,
                                                                        const Fragments& fragments,
                                                                        const Certificate& certificate,
                                                                        const ExportOptions& options = {});

// Several objects in one GLB file: each a root node with the pieces as children, as export_pieces() writes them, without
// a certificate. `extras.brittle` of a root: object, its name, and recipe. Equal materials, textures and images are
// written once, and of all objects but the first only those that are used.
//
//     ObjectExport scene;
//     for (const Object& object : objects) must(scene.add(object.pieces, {.name = object.name, .poses = object.poses}));
//     must(scene.write("rubble.glb"));
class ObjectExport {
  public:
    ObjectExport();
    ~ObjectExport();
    ObjectExport(const ObjectExport&) = delete;
    ObjectExport& operator=(const ObjectExport&) = delete;

    // Names should differ; per_piece has no effect. The images of the source must outlive write() or bytes(). Errors as
    // export_pieces().
    [[nodiscard]] Result<void> add(const Fragments& fragments, const ExportOptions& options);
    // Once, after the last object. Errors: invalid_setting without objects; write_failed.
    [[nodiscard]] Result<void> write(const std::filesystem::path& file);
    [[nodiscard]] Result<std::vector<std::byte>> bytes(); // in place of write()

  private:
    struct Writer;
    std::unique_ptr<Writer> writer_;
    bool has_objects_ = false;
};

// Exports a whole model, after a repair for example: one piece without interior.
[[nodiscard]] Result<std::vector<std::filesystem::path>>
export_model(const std::filesystem::path& file, const Model& model, const std::string& name = "mesh");

// Returns the files of a model, as export_pieces_to_memory() does. `single_file`: as ExportOptions.
[[nodiscard]] Result<std::vector<ExportedFile>> export_model_to_memory(const std::string& file, const Model& model,
                                                                       const std::string& name = "mesh",
                                                                       bool single_file = false);

// The extensions that can be exported, in lower case with the dot.
[[nodiscard]] const std::vector<std::string>& exportable_extensions();

} // namespace brittle::fracture
