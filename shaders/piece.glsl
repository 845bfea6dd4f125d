// Common functions of the pieces' fragment shaders.
#ifndef BRITTLE_PIECE_GLSL
#define BRITTLE_PIECE_GLSL

#include "fade.glsl"
#include "light.glsl"
#include "sky.glsl"

layout(location = 0) in vec3 from_eye;
layout(location = 1) flat in vec4 albedo;
layout(location = 0) out vec4 colour;

// Returns the triangle's normal from screen-space derivatives, so that vertices can be shared. The order of the cross
// product is for Vulkan's Y axis, which points down. Back faces are culled, so a normal that points away from the eye
// is a rounding error on a triangle seen edge-on, and is negated. A triangle too thin for derivatives faces the eye.
vec3 flat_normal() {
    vec3 n = cross(dFdy(from_eye), dFdx(from_eye));
    float squared = dot(n, n);
    if (!(squared > 0.0)) return -normalize(from_eye);
    n *= inversesqrt(squared);
    return dot(n, from_eye) > 0.0 ? -n : n;
}

// Writes the shaded colour. `facet` is the triangle's normal, which offsets the shadow test; `normal` is the shading
// normal. `gloss`: the share of the reflection of a smooth coat.
void light_piece(vec3 reflected, vec3 facet, vec3 normal, float gloss) {
    float height = from_eye.y + frame.eye.y - frame.ground.w;
    float lit = sun_visibility(from_eye, facet), visible = sky_visibility(from_eye);
    vec3 light = shade(reflected, normal, lit, height, visible);
    if (gloss > 0.0) {
        vec3 view = -normalize(from_eye);
        light += gloss * visible * fresnel(dot(normal, view)) * light_from(reflect(-view, normal), lit);
    }
    colour = display(light);
}

#endif
