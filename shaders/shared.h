// Constants and struct layouts of rendering, shared by C++ and GLSL: both compile this file.
//
// The members of structs are vec4, mat4, uint and int, in an order in which std140, std430 and C++ agree on all
// offsets.
#ifndef BRITTLE_SHADERS_SHARED_H
#define BRITTLE_SHADERS_SHARED_H

#ifdef __cplusplus
#include <cstdint>

#include <glm/mat4x4.hpp>
#include <glm/vec4.hpp>

namespace brittle::engine::shared {
using uint = uint32_t;
using glm::mat4;
using glm::vec4;
#endif

// Descriptor set 0.
const uint binding_frame = 0;  // FrameData, uniform
const uint binding_poses = 1;  // Pose, one for each body
const uint binding_draws = 2;  // DrawData, one for each draw range
const uint binding_shadow = 3; // the shadow map with its comparison sampler
// For the cull pass only.
const uint binding_commands = 4;          // DrawCommand, one for each draw range
const uint binding_culled_for_camera = 5; // DrawCommand, with zero instances for ranges outside the view
const uint binding_culled_for_light = 6;
const uint binding_visible_counts = 7; // uint, view_count: pieces in view
// Descriptor set 2: the materials of meshes, for pieces drawn with them.
const uint binding_mesh_materials = 0; // MeshMaterial
const uint binding_base_colours = 1;   // layers of base colour textures
const uint binding_normal_maps = 2;    // layers of normal maps
// Descriptor sets 1 and 3: an image from an earlier pass each.
const uint binding_image = 0; // in the occlusion and glass passes, depth; in the shade pass, the result of occlusion

// Specialization constants.
const uint constant_soft_shadows = 0;      // bool: 16 shadow taps instead of 1
const uint constant_ambient_occlusion = 1; // bool: binding_image holds the visible share of the sky
const uint constant_fading = 2;            // bool: pixels of fading pieces are discarded; fade.glsl
const uint constant_cut_out = 3;           // bool: pixels that a material cuts out are discarded; mesh_material.glsl

const uint splinter_vertices = 24; // of the mesh of a splinter (splinter.glsl)
const uint puff_vertices = 6;      // of the square of a puff of dust (dust.vert)

const uint cull_group_size = 64;
const uint view_camera = 0;
const uint view_light = 1;
const uint view_count = 2;

// The material of a draw range is 2 * surface + side.
const uint material_exterior = 0;
const uint material_interior = 1;
const uint max_surfaces = 16; // of a scene
const uint material_count = 2 * max_surfaces;

// The grain of fracture surfaces (grain.glsl), in place of the weight of the tint where pieces have their materials.
const uint grain_plain = 0;
const uint grain_glass = 1;
const uint grain_stone = 2;
const uint grain_concrete = 3;
const uint grain_wood = 4;
const uint grain_ceramic = 5;
const uint grain_brick = 6;

// Bits of MeshMaterial::flags.
const uint wrap_clamp = 1;   // of u; shifted by wrap_bits, of v
const uint wrap_mirror = 2;  // of u; neither: repeat
const uint wrap_bits = 2;    // a coordinate
const uint alpha_mask = 16;  // pixels below the cutoff are cut out
const uint alpha_blend = 32; // a share of pixels is cut out by the pattern of fade.glsl

// "Eye space" here has the eye as its origin and the axes of world space, so that near geometry keeps its precision far
// from the world's origin.
struct FrameData {
    mat4 clip_from_eye;             // eye space to clip space
    mat4 eye_from_clip;             // clip space to eye space
    mat4 shadow_from_eye;           // eye space to shadow map coordinates: texture xy, depth
    mat4 shadow_clip_from_world;    // world space to the shadow map's clip space
    vec4 eye;                       // world position; w: 1 / height of the target in pixels
    vec4 to_light;                  // unit vector; w: offset of a shadow receiver along its normal, metres
    vec4 sun;                       // rgb; w: the shadow map's depth bias
    vec4 sky;                       // rgb; w: height of the zone that the ground darkens, metres
    vec4 bounce;                    // rgb; w: side of a shadow map texel in texture coordinates
    vec4 materials[material_count]; // rgb by material; w: weight of the tint
    vec4 sphere;                    // rgb
    vec4 ground;                    // rgb; w: y of the ground, metres
    vec4 ground_disc;       // centre x and z in the world; radii at which the ground begins and ends to fade, metres
    vec4 background_top;    // rgb; w: exposure
    vec4 background_bottom; // rgb
    vec4 cuts; // 1 + layer of the texture of fracture surfaces, or 0; 1 for smooth shading, of pieces with materials
    vec4 occlusion; // search radius, metres; pixels per metre at a distance of one metre; sine of the elevation
                    // from which a sample occludes; strength
    vec4 glass;     // the share of light that passes a depth of glass (glass_composite.frag); w: 1 if glass is clear
};

struct Pose {
    vec4 rotation; // unit quaternion x y z w
    vec4 position_and_scale;
};

struct DrawData {
    uint body; // index of its Pose
    uint material;
    uint tint;   // linear, packed by packUnorm4x8; alpha: opacity, below 1 for a fading piece
    uint id;     // what a picture of ids shows
    vec4 sphere; // bounding sphere of the piece in its body's frame: centre, radius
    vec4 offset; // xyz: from the body's centre of mass to the origin of the positions, in the body's frame
    vec4 object; // xyz: centre of mass in the object; w: 1 + first material of the object's mesh, or 0
};

// A material of a mesh. Layers are those of the bindings of set 2.
struct MeshMaterial {
    vec4 colour;       // linear, with opacity; factor of texture and vertex colour
    uint base_layer;   // 1 + layer of the base colour texture, or 0
    uint normal_layer; // 1 + layer of the normal map, or 0
    uint base_flags;   // bits of wrap_* and alpha_*
    uint normal_flags; // bits of wrap_*
    vec4 numbers;      // alpha cutoff; scale of the normal map
    vec4 base_uv;      // matrix of the texture coordinates, column by column
    vec4 normal_uv;
    vec4 uv_offset; // added to the products: xy of the base colours, zw of the normal map
};

struct DrawCommand { // VkDrawIndexedIndirectCommand
    uint indices;
    uint instances;
    uint first_index;
    int first_vertex;
    uint first_instance;
};

#ifdef __cplusplus
static_assert(sizeof(FrameData) == 4 * 64 + (13 + material_count) * 16);
static_assert(sizeof(Pose) == 32);
static_assert(sizeof(DrawData) == 64);
static_assert(sizeof(MeshMaterial) == 96);
static_assert(sizeof(DrawCommand) == 20);
} // namespace brittle::engine::shared
#endif

#endif
