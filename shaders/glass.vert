#version 460
#extension GL_GOOGLE_include_directive : require
// Pieces of glass; others collapse.
#include "frame.glsl"

layout(location = 0) in vec3 position;
layout(location = 1) in vec3 normal;
layout(location = 0) out vec3 from_eye;
layout(location = 1) flat out vec2 opacity_and_middle;
layout(location = 2) out vec3 smooth_normal;

void main() {
    DrawData draw = draws[gl_InstanceIndex];
    Pose pose = poses[draw.body];
    from_eye = transform_vertex(draw, position, frame.eye.xyz);
    vec3 middle = transform_point(pose, draw.sphere.xyz, frame.eye.xyz);
    opacity_and_middle = vec2(unpackUnorm4x8(draw.tint).a, length(middle));
    bool smooth_shaded = frame.cuts.y != 0.0 && draw.material % 2 == material_exterior;
    smooth_normal = smooth_shaded ? rotate(pose.rotation, normal) : vec3(0.0);
    gl_Position = is_clear(draw) ? frame.clip_from_eye * vec4(from_eye, 1.0) : nowhere;
}
