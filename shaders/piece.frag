#version 460
#extension GL_GOOGLE_include_directive : require
#include "piece.glsl"

void main() {
    vec3 normal = flat_normal(); // derivatives are undefined after a discard
    discard_faded(albedo.a);
    light_piece(albedo.rgb, normal, normal, 0.0);
}
