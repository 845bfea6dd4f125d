// The descriptor set, for every shader that reads it.
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

vec3 rotate(vec4 rotation, vec3 v) {
    vec3 t = 2.0 * cross(rotation.xyz, v);
    return v + rotation.w * t + cross(rotation.xyz, t);
}

// A vertex of the body to its place in the world, less `origin`.
vec3 transform_point(Pose pose, vec3 position, vec3 origin) {
    return rotate(pose.rotation, position * pose.position_and_scale.w) + (pose.position_and_scale.xyz - origin);
}

// Of a draw range, in linear light; alpha: how much of it is left as it fades.
vec4 albedo_of(DrawData draw) {
    vec4 material = frame.materials[draw.material];
    vec4 tint = unpackUnorm4x8(draw.tint);
    return vec4(material.rgb * mix(vec3(1.0), tint.rgb, material.w), tint.a);
}

// Lines on a surface must win against it: they come nearer by a fraction of their depth.
vec4 line_position(vec3 from_eye) {
    const float nearer = 2e-4;
    vec4 clip = frame.clip_from_eye * vec4(from_eye, 1.0);
    clip.z -= nearer * clip.w;
    return clip;
}

#endif
