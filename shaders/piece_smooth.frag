#version 460
#extension GL_GOOGLE_include_directive : require
#include "piece.glsl"

layout(location = 2) in vec3 smooth_normal;

void main() {
    vec3 facet = flat_normal(); // derivatives are undefined after a discard
    discard_faded(albedo.a);
    bool bent = dot(smooth_normal, facet) > 0.0; // false without a smooth normal, which is 0 then
    light_piece(albedo.rgb, facet, bent ? normalize(smooth_normal) : facet, 0.0);
}
