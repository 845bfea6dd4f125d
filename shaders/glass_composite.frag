#version 460
#extension GL_GOOGLE_include_directive : require
// The picture seen through glass: bent a little, tinted by the way through it, with reflections on top.
#include "frame.glsl"
#include "srgb.glsl"

layout(set = 1, binding = binding_image) uniform sampler2D picture; // behind the glass
layout(set = 3, binding = binding_image) uniform sampler2D sums;    // glass.glsl
layout(location = 0) out vec4 colour;

const float reference = 0.5; // m, the way of light to which the colour of glass refers
const float bend = 0.02;     // share of the picture's height by which a normal of length 1 moves what is behind it

// Bilinear, in linear light.
vec3 picture_at(vec2 at) {
    ivec2 last = textureSize(picture, 0) - 1;
    vec2 low = floor(at - 0.5), t = at - 0.5 - low;
    vec3 rows[2];
    for (int y = 0; y < 2; ++y) {
        vec3 left = linear_of(texelFetch(picture, clamp(ivec2(low) + ivec2(0, y), ivec2(0), last), 0).rgb);
        vec3 right = linear_of(texelFetch(picture, clamp(ivec2(low) + ivec2(1, y), ivec2(0), last), 0).rgb);
        rows[y] = mix(left, right, t.x);
    }
    return mix(rows[0], rows[1], t.y);
}

void main() {
    ivec2 pixel = ivec2(gl_FragCoord.xy);
    vec4 sum = texelFetch(sums, pixel, 0);
    if (sum == vec4(0.0)) {
        colour = texelFetch(picture, pixel, 0);
        return;
    }
    vec2 moved = clamp(sum.zw, -2.0, 2.0) * (bend / frame.eye.w);
    vec3 passed = pow(max(frame.glass.rgb, vec3(1e-3)), vec3(max(sum.x, 0.0) / reference));
    vec3 light = picture_at(gl_FragCoord.xy - moved) * passed * (1.0 - 0.6 * min(sum.y, 1.0)) + sum.y;
    colour = vec4(srgb_of(clamp(light, 0.0, 1.0)), 1.0);
}
