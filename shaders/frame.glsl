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

// A vertex of the body to its place in the world, less `origin`.
vec3 place(Pose pose, vec3 position, vec3 origin) {
    vec3 p = position * pose.position_and_scale.w;
    vec3 t = 2.0 * cross(pose.rotation.xyz, p);
    return p + pose.rotation.w * t + cross(pose.rotation.xyz, t) + (pose.position_and_scale.xyz - origin);
}

#endif
