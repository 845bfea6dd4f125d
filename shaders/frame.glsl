// Descriptor set 0 and the functions that read it.
#ifndef BRITTLE_FRAME_GLSL
#define BRITTLE_FRAME_GLSL

#include "shared.h"

layout(set = 0, binding = binding_frame, std140) uniform FrameBlock {
    FrameData frame;
};
layout(set = 0, binding = binding_poses, std430) readonly buffer PoseBlock {
    Pose poses[];
};
layout(set = 0, binding = binding_draws, std430) readonly buffer DrawBlock {
    DrawData draws[];
};

// Rotates v by a unit quaternion.
vec3 rotate(vec4 rotation, vec3 v) {
    vec3 t = 2.0 * cross(rotation.xyz, v);
    return v + rotation.w * t + cross(rotation.xyz, t);
}

// Transforms a position in the body's frame to world space, relative to `origin`.
vec3 transform_point(Pose pose, vec3 position, vec3 origin) {
    return rotate(pose.rotation, position * pose.position_and_scale.w) + (pose.position_and_scale.xyz - origin);
}

// Transforms a vertex of a draw range to world space, relative to `origin`.
vec3 transform_vertex(DrawData draw, vec3 position, vec3 origin) {
    return transform_point(poses[draw.body], position + draw.offset.xyz, origin);
}

// Returns the albedo of a draw range in linear light; alpha is the piece's opacity.
vec4 albedo_of(DrawData draw) {
    vec4 material = frame.materials[draw.material];
    vec4 tint = unpackUnorm4x8(draw.tint);
    return vec4(material.rgb * mix(vec3(1.0), tint.rgb, material.w), tint.a);
}

// Whether a draw range is clear glass, which passes of their own draw (glass.glsl). A mesh with materials is not.
bool is_clear(DrawData draw) {
    return frame.glass.w != 0.0 && draw.object.w == 0.0
           && uint(frame.materials[draw.material | material_interior].w) == grain_glass;
}

const vec4 nowhere = vec4(2.0, 2.0, 2.0, 1.0); // the clip position of the vertices of what is not drawn

// Returns the clip position of a line's vertex, moved towards the eye so that a line on a surface passes the depth
// test.
vec4 line_position(vec3 from_eye) {
    const float nearer = 2e-4;
    vec4 clip = frame.clip_from_eye * vec4(from_eye, 1.0);
    clip.z -= nearer * clip.w;
    return clip;
}

#endif
