#version 460
#extension GL_GOOGLE_include_directive : require
// Spheres of a scene, one instance for each.
#include "frame.glsl"

layout(location = 0) in vec3 position; // on the unit sphere
layout(location = 1) in vec4 centre_and_radius;
layout(location = 0) out vec3 normal;

void main() {
    normal = position;
    vec3 from_eye = position * centre_and_radius.w + (centre_and_radius.xyz - frame.eye.xyz);
    gl_Position = frame.clip_from_eye * vec4(from_eye, 1.0);
}
