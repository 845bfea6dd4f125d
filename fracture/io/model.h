// What a mesh file holds: the mesh that is fractured, and what it looks like, so that the pieces can look the same.
//
//     Result<Model> model = import_model("vase.glb");
//     Result<Fragments> fragments = fracture(model->mesh, sites);
//     export_pieces("pieces.glb", *fragments, certificate, {.source = &*model, .sites = sites});
//
// The vertices of `mesh` are welded: they carry positions only. All else belongs to corners: corner k of triangle t is
// entry 3 * t + k. Lists of a kind that the file has nothing of are empty.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include <glm/vec2.hpp>
#include <glm/vec3.hpp>
#include <glm/vec4.hpp>

#include "fracture/mesh/mesh.h"

namespace brittle::fracture {

// An encoded picture, as it was in the file or beside it; never decoded.
struct Image {
    std::string name{};      // may be empty
    std::string mime_type{}; // image/png, image/jpeg, ...; empty where it could not be read
    std::vector<std::byte> bytes{};
};

// An image and how it is sampled; the numbers are those of glTF, 0 stands for none given.
struct Texture {
    std::optional<uint32_t> image{}; // into Model::images
    uint32_t wrap_s = 10497;         // 10497 repeat, 33071 clamp to edge, 33648 mirrored repeat
    uint32_t wrap_t = 10497;
    uint32_t min_filter = 0;
    uint32_t mag_filter = 0;
    // glTF extensions as a JSON object, or empty. Kept for GLB: indices in them are those of Model::images.
    std::string extensions{};
};

// Where a material uses a texture.
struct TextureUse {
    uint32_t texture = 0;     // into Model::textures
    uint32_t uv_set = 0;      // into Model::uv
    double strength = 1.0;    // of normal maps (scale) and occlusion
    std::string extensions{}; // as in Texture
};

enum class AlphaMode { opaque, mask, blend };

// The metallic-roughness model of glTF 2.0. Colours are linear.
struct Material {
    std::string name{};
    glm::dvec4 base_colour{1.0}; // and opacity
    double metallic = 0.0;
    double roughness = 1.0;
    glm::dvec3 emissive{0.0};
    std::optional<TextureUse> base_colour_texture{};
    std::optional<TextureUse> metallic_roughness_texture{};
    std::optional<TextureUse> normal_texture{};
    std::optional<TextureUse> occlusion_texture{};
    std::optional<TextureUse> emissive_texture{};
    AlphaMode alpha_mode = AlphaMode::opaque;
    double alpha_cutoff = 0.5; // of AlphaMode::mask
    bool double_sided = false;
    std::string extensions{}; // as in Texture; `index` in them is an index into Model::textures
};

constexpr uint32_t no_material = ~0u;

struct Model {
    TriangleMesh mesh;
    // Texture coordinates; (0, 0) is the upper left corner of the image, v points down. Set 0 before set 1.
    std::array<std::vector<glm::vec2>, 2> uv;
    std::vector<glm::vec3> normals;    // unit; zero where a corner has none: flat
    std::vector<glm::vec4> colours;    // linear, with opacity
    std::vector<uint32_t> material_of; // of each triangle, into materials; or no_material
    std::vector<Material> materials;
    std::vector<Texture> textures;
    std::vector<Image> images;
    // What was left behind, in sentences for people; at most a few dozen.
    std::vector<std::string> notes;
};

// What belongs to a corner. What it does not have becomes the value that is given here.
struct CornerLook {
    std::array<std::optional<glm::vec2>, 2> uv{}; // (0, 0)
    std::optional<glm::vec3> normal{};            // zero
    std::optional<glm::vec4> colour{};            // white
};

// Appends a triangle of vertices that the mesh has.
void append_triangle(Model& model, const Triangle& triangle, uint32_t material, std::span<const CornerLook, 3> corners);
// To be called after the last triangle: fills lists that later triangles had nothing for.
void complete_corners(Model& model);

// Gives the model another mesh with some of its triangles, corner by corner: those that `kept` names, in its order.
void keep_triangles(Model& model, TriangleMesh mesh, std::span<const uint32_t> kept);

// Gives the model any other mesh. For each of its triangles `source` names the one of the old mesh that it was, whose
// looks it keeps, corner by corner nearest to where they were, turned around if it is; no_source ones get nothing.
constexpr uint32_t no_source = ~0u;
void replace_mesh(Model& model, TriangleMesh mesh, std::span<const uint32_t> source);

} // namespace brittle::fracture
