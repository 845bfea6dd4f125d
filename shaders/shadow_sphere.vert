#version 460
#extension GL_GOOGLE_include_directive : require
// Depth of spheres seen from the light, one instance for each sphere; without fragment shader.
#include "frame.glsl"

layout(location = 0) in vec3 position; // on the unit sphere
layout(location = 1) in vec4 centre_and_radius;

void main() {
    gl_Position = frame.shadow_clip_from_world * vec4(position * centre_and_radius.w + centre_and_radius.xyz, 1.0);
}
