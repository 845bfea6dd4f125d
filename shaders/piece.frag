#version 460
#extension GL_GOOGLE_include_directive : require
#include "piece.glsl"

void main() {
    leave_out(albedo.a);
    vec3 normal = flat_normal();
    light_piece(normal, normal);
}
