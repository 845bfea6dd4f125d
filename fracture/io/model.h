// The content of a mesh file: the mesh to fracture, and its materials and corner attributes, which the pieces inherit.
//
//     Result<Model> model = import_model("vase.glb");
//     Result<Fragments> fragments = fracture(model->mesh, sites);
//     export_pieces("pieces.glb", *fragments, certificate, {.source = &*model, .sites = sites});
//
// The vertices of `mesh` are welded and carry positions only. All other attributes belong to corners: corner k of
// triangle t is entry 3 * t + k. The list of an attribute that the file does not have is empty.
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

// An encoded image, byte for byte from the file or beside it; never decoded.
struct Image {
    std::string name{};      // may be empty
    std::string mime_type{}; // image/png, image/jpeg, ...; empty where the image could not be read
    std::vector<std::byte> bytes{};
};

// An image with its sampler. The numbers are those of glTF; 0 means unspecified.
struct Texture {
    std::optional<uint32_t> image{}; // into Model::images
    uint32_t wrap_s = 10497;         // 10497 repeat, 33071 clamp to edge, 33648 mirrored repeat
    uint32_t wrap_t = 10497;
    uint32_t min_filter = 0;
    uint32_t mag_filter = 0;
    // glTF extensions as a JSON object, or empty. Kept for GLB; image indices in it are those of Model::images.
    std::string extensions{};
};

// The use of a texture by a material.
struct TextureUse {
    uint32_t texture = 0;     // into Model::textures
    uint32_t uv_set = 0;      // into Model::uv
    double strength = 1.0;    // glTF scale of a normal map, strength of occlusion
    std::string extensions{}; // as in Texture
};

enum class AlphaMode { opaque, mask, blend };

// The metallic-roughness model of glTF 2.0. Colours are linear.
struct Material {
    std::string name{};
    glm::dvec4 base_colour{1.0}; // with opacity
    double metallic = 0.0;
    double roughness = 1.0;
    glm::dvec3 emissive{0.0};
    std::optional<TextureUse> base_colour_texture{};
    std::optional<TextureUse> metallic_roughness_texture{};
    std::optional<TextureUse> normal_texture{};
    std::optional<TextureUse> occlusion_texture{};
    std::optional<TextureUse> emissive_texture{};
    AlphaMode alpha_mode = AlphaMode::opaque;
    double alpha_cutoff = 0.5; // for AlphaMode::mask
    bool double_sided = false;
    std::string extensions{}; // as in Texture; an `index` in it refers to Model::textures
};

constexpr uint32_t no_material = ~0u;

struct Model {
    TriangleMesh mesh;
    // From the readers to import only: a number per vertex, or empty. Vertices of equal position and different numbers
    // are different points, of parts that touch there (weld.h).
    std::vector<uint32_t> points;
    // Texture coordinates: (0, 0) is the upper left corner of the image, v points down. Set 0 is used before set 1.
    std::array<std::vector<glm::vec2>, 2> uv;
    std::vector<glm::vec3> normals;    // unit; zero where a corner has none, for flat shading
    std::vector<glm::vec4> colours;    // linear, with opacity
    std::vector<uint32_t> material_of; // per triangle: into materials, or no_material
    std::vector<Material> materials;
    std::vector<Texture> textures;
    std::vector<Image> images;
    // Sentences for a reader about content that was not imported; at most a few dozen.
    std::vector<std::string> notes;
};

// The attributes of a corner. The comments give the value of a missing one.
struct CornerAttributes {
    std::array<std::optional<glm::vec2>, 2> uv{}; // (0, 0)
    std::optional<glm::vec3> normal{};            // zero
    std::optional<glm::vec4> colour{};            // white
};

// Appends a triangle of existing vertices.
void append_triangle(Model& model, const Triangle& triangle, uint32_t material,
                     std::span<const CornerAttributes, 3> corners);
// Completes the attribute lists. Call it after the last append_triangle().
void complete_corners(Model& model);

// Replaces the mesh by one with some of its triangles, corner by corner: `kept` lists them in order.
void keep_triangles(Model& model, TriangleMesh mesh, std::span<const uint32_t> kept);

// Replaces the mesh by any other. `source` names the old triangle of each new one, whose attributes it keeps: each
// corner takes those of the nearest old corner, also where the triangle was turned over. no_source: no attributes.
constexpr uint32_t no_source = ~0u;
void replace_mesh(Model& model, TriangleMesh mesh, std::span<const uint32_t> source);

// Replaces the mesh by one whose triangles are parts of the old ones, which `source` names. Corners take interpolated
// attributes; a corner of the old triangle keeps its own, bit for bit.
void divide_mesh(Model& model, TriangleMesh mesh, std::span<const uint32_t> source);

} // namespace brittle::fracture
