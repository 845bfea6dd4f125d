#version 460
#extension GL_GOOGLE_include_directive : require
#include "piece.glsl"

void main() {
    discard_faded(albedo.a);
    vec3 normal = flat_normal();
    light_piece(albedo.rgb, normal, normal);
}
