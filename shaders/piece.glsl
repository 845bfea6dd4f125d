// What the pieces' fragment shaders share.
#ifndef BRITTLE_PIECE_GLSL
#define BRITTLE_PIECE_GLSL

#include "fade.glsl"
#include "light.glsl"

layout(location = 0) in vec3 from_eye;
layout(location = 1) flat in vec4 albedo;
layout(location = 0) out vec4 colour;

// The triangle's normal from screen derivatives, so that vertices are shared. The order of the product is Vulkan's, with
// Y down. Back faces are culled, so a normal that points away from the eye is rounding on a triangle seen edge-on: it
// is turned round. A triangle too thin for any derivative faces the eye.
vec3 flat_normal() {
    vec3 n = cross(dFdy(from_eye), dFdx(from_eye));
    float squared = dot(n, n);
    if (!(squared > 0.0)) return -normalize(from_eye);
    n *= inversesqrt(squared);
    return dot(n, from_eye) > 0.0 ? -n : n;
}

// `facet` is the triangle's normal, by which it leaves its own shadow; `normal` what light falls on.
void light_piece(vec3 facet, vec3 normal) {
    float height = from_eye.y + frame.eye.y - frame.ground.w;
    colour = display(
        shade(albedo.rgb, normal, sun_visibility(from_eye, facet), height, sky_visibility(from_eye)));
}

#endif
