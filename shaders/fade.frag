#version 460
#extension GL_GOOGLE_include_directive : require
// Depth of fading pieces.
#include "fade.glsl"

layout(location = 1) flat in vec4 albedo;

void main() {
    discard_faded(albedo.a);
}
