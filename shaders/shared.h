// Constants and struct layouts that C++ and GLSL share: both compile this file.
//
// Structs hold only vec4, mat4 and uint, in an order in which std140, std430 and C++ agree on every offset.
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
const uint binding_poses = 1;  // Pose, one a body
const uint binding_draws = 2;  // DrawData, one a draw range
const uint binding_shadow = 3; // the shadow map with its comparison sampler
// For the cull pass only.
const uint binding_commands = 4;          // DrawCommand, one a draw range: all of them
const uint binding_culled_for_camera = 5; // DrawCommand; those that are not in view have no instance
const uint binding_culled_for_light = 6;
const uint binding_visible_counts = 7; // uint, view_count: pieces in view
// Descriptor set 1: an image that an earlier pass made.
const uint binding_image = 0; // in the occlusion pass, depth; when shading, what that pass made of it

// Specialization constants.
const uint constant_soft_shadows = 0;      // bool: 16 taps instead of 1
const uint constant_ambient_occlusion = 1; // bool: binding_image says how much of the sky is seen
const uint constant_fading = 2;            // bool: pixels are left out by how far the piece has faded; see fade.glsl

const uint cull_group_size = 64;
const uint view_camera = 0;
const uint view_light = 1;
const uint view_count = 2;

const uint material_exterior = 0;
const uint material_interior = 1;
const uint material_count = 2;

// Positions called "from the eye" have the eye as origin and the world's axes: what is near keeps its precision however
// far the scene is from the world's origin.
struct FrameData {
    mat4 clip_from_eye;             // from a position from the eye to clip space
    mat4 eye_from_clip;             // and back
    mat4 shadow_from_eye;           // ... to shadow map coordinates: texture xy, depth
    mat4 shadow_clip_from_world;    // from a world position to the shadow map's clip space
    vec4 eye;                       // world position; w: 1 / height of the target in pixels
    vec4 to_light;                  // unit vector; w: how far a receiver is moved along its normal, metres
    vec4 sun;                       // rgb; w: the shadow map's depth bias
    vec4 sky;                       // rgb; w: the height over which the ground darkens what stands on it, metres
    vec4 bounce;                    // rgb; w: the shadow map's texel in texture coordinates
    vec4 materials[material_count]; // rgb by material; w: how much of the tint shows
    vec4 sphere;                    // rgb
    vec4 ground;                    // rgb; w: its height
    vec4 ground_disc;       // centre x and z in the world, the radius where it begins to fade, and where it ends
    vec4 background_top;    // rgb; w: exposure
    vec4 background_bottom; // rgb
    vec4 occlusion;         // radius around a point that is searched for what hides the sky, metres; pixels a metre at
                            // a distance of one; the sine of the height from which it counts; strength
};

struct Pose {
    vec4 rotation; // unit quaternion x y z w
    vec4 position_and_scale;
};

struct DrawData {
    uint body; // index of its Pose
    uint material;
    uint tint;   // linear, as packUnorm4x8; alpha: how much of the piece is left as it fades, 1 for all
    uint piece;  // its handle
    vec4 sphere; // around the piece, in the frame of its body: centre, radius
};

struct DrawCommand { // VkDrawIndexedIndirectCommand
    uint indices;
    uint instances;
    uint first_index;
    int first_vertex;
    uint first_instance;
};

#ifdef __cplusplus
static_assert(sizeof(FrameData) == 4 * 64 + 13 * 16);
static_assert(sizeof(Pose) == 32);
static_assert(sizeof(DrawData) == 32);
static_assert(sizeof(DrawCommand) == 20);
} // namespace brittle::engine::shared
#endif

#endif
