// Pieces out: binary glTF (.glb), Wavefront OBJ with MTL, PLY and STL (both binary), by the file's ending.
//
//     must(export_pieces("pieces.glb", fragments, certificate, {.source = &model, .sites = sites}));
//
// What each format holds, and the layout of GLB: docs/files.md. In short, GLB and OBJ keep materials, texture
// coordinates, colours (GLB) and normals of the source, interpolated at the corners of the cut; PLY keeps colours; STL
// keeps triangles. Where the source has no normals, pieces are flat shaded. Within a piece equal positions stay equal bit
// for bit in all of them: a reader that welds by position gets closed pieces back.
//
// GLB: one root node; a child for each piece, NAME_000 ..., with translation = centre of mass and no rotation or scale;
// one primitive for each material of the exterior, the cuts last. `extras.brittle` of a child: site, volume, area,
// centre_of_mass, inertia (at density 1 about the centre of mass, row by row), exterior_triangles, interior_triangles,
// and bonds (each once, at the piece with the lower number): piece, area, centroid, normal. Of the root: certificate and
// recipe. Positions are float(position - translation), with the translation first rounded to float.
//
// With poses, pieces are written as they lie: in GLB nodes have translation and rotation, and extras still tell of the piece
// as it was cut, so that a point p of them is at p - centre_of_mass in the node; other formats hold what is turned and moved.
//
// Equal input gives equal bytes. Every file is written atomically (atomic_file.h), the one that names the others last.
#pragma once

#include <filesystem>
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

// How collision hulls are named, so that an engine finds them.
enum class HullNames {
    godot, // NAME-convcolonly: a convex shape that is not drawn
    unreal // UCX_NAME_00
           // Of several hulls of a piece: NAME_00-convcolonly, NAME_01-convcolonly; UCX_NAME_00, UCX_NAME_01
};

// How a piece lies: turned about its centre of mass, which then comes to the position.
struct PiecePose {
    glm::dvec3 position{0.0};
    glm::dquat orientation{1.0, 0.0, 0.0, 0.0}; // unit
};

struct ExportOptions {
    std::string name = "mesh"; // of the root node and the start of each piece's name: NAME_000, ...
    std::string recipe = "{}"; // a JSON object, kept as it is in the root's extras; GLB only
    // The model whose mesh was fractured; null for none: flat shaded, in one material.
    const Model* source = nullptr;
    std::span<const glm::dvec3> sites{};   // of the fracture, for texture coordinates in metres on the cuts; or none
    bool uv_by_plane = false;              // without sites: such coordinates all the same, of each cut by its own plane
    std::span<const PiecePose> poses{};    // one a piece; or none: all lie where they were cut
    std::optional<Material> exterior{};    // of what has none in the source; or the default, a light stone
    std::optional<Material> interior{};    // of the cuts; or the default, a dark brown. Uses the texture below, if any
    std::optional<Image> interior_image{}; // base colour of the cuts, repeated every metre
    bool per_piece = false;                // a file for each piece: NAME.glb becomes NAME_000.glb, NAME_001.glb, ...

    // The rest is for GLB only.
    std::span<const std::vector<TriangleMesh>>
        hulls{}; // of each piece, in the coordinates of the pieces; or none at all
    HullNames hull_names = HullNames::godot;
    // Also says mass, inertia and hull by KHR_physics_rigid_bodies, a draft that may still change: as of 2024, Khronos
    // pull request 2424, where the geometry of a collider names a mesh by a node. Needs hulls for colliders.
    bool rigid_bodies = false;
    double density = 1000.0; // kg/m^3, of rigid_bodies; all else is at density 1
};

// The files written, the one to open first; with per_piece those of each piece in order.
// Errors: unsupported_format; write_failed, also for what the format cannot hold: coordinates beyond a 32-bit float (not
// OBJ), files of 4 GiB and more; invalid_setting for a recipe that is no JSON object, for hulls and poses that are not as many
// as pieces, and for a pose that is none.
// On failure an old file of the same name stays as it was; with several files, those written before it stay.
[[nodiscard]] Result<std::vector<std::filesystem::path>> export_pieces(const std::filesystem::path& file,
                                                                       const Fragments& fragments,
                                                                       const Certificate& certificate,
                                                                       const ExportOptions& options = {});

// A whole model, for repaired meshes: one piece, nothing interior.
[[nodiscard]] Result<std::vector<std::filesystem::path>>
export_model(const std::filesystem::path& file, const Model& model, const std::string& name = "mesh");

// File endings that can be exported, lower case with the dot.
[[nodiscard]] const std::vector<std::string>& exportable_extensions();

} // namespace brittle::fracture
