#version 460
#extension GL_GOOGLE_include_directive : require
#include "light.glsl"

layout(location = 0) in vec3 normal;
layout(location = 0) out vec4 colour;

// Spheres are markers: they are fully lit, even inside a mesh.
void main() {
    colour = display(shade(frame.sphere.rgb, normalize(normal), 1.0, frame.sky.w, 1.0));
}
