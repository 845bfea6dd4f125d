#version 460
#extension GL_GOOGLE_include_directive : require
// Screen-space ambient occlusion: the share of the sky visible from each pixel's surface. Samples lie on a spiral in
// the depth image; each is weighted by the sine of its elevation above the surface's plane and by its proximity. The
// spiral and the choice of normal are those of McGuire's scalable ambient obscurance (2012).
//
// The spiral is rotated from pixel to pixel in a 4x4 pattern, which sky_visibility() in sky.glsl averages out.
#include "frame.glsl"

layout(set = 1, binding = binding_image) uniform sampler2D depth_map;
layout(location = 0) out vec2 visible_and_distance; // visible share of the sky, distance from the eye in metres

const int samples = 16;
const float turns = 7.0; // coprime with the number of samples
const float tau = 6.283185307;

vec3 position_at(ivec2 pixel) {
    ivec2 size = textureSize(depth_map, 0);
    pixel = clamp(pixel, ivec2(0), size - 1);
    vec2 clip = (vec2(pixel) + 0.5) / vec2(size) * 2.0 - 1.0;
    vec4 eye = frame.eye_from_clip * vec4(clip, texelFetch(depth_map, pixel, 0).r, 1.0);
    return eye.xyz / eye.w;
}

// Returns the surface's tangent towards the next pixel, from the side with the smaller difference: the other side may
// lie across an edge.
vec3 slope(vec3 position, ivec2 pixel, ivec2 to_next) {
    vec3 ahead = position_at(pixel + to_next) - position, back = position - position_at(pixel - to_next);
    bool none_ahead = dot(ahead, ahead) == 0.0; // at the image's border, where position_at() clamps
    bool none_back = dot(back, back) == 0.0;
    return none_back || (!none_ahead && dot(ahead, ahead) < dot(back, back)) ? ahead : back;
}

void main() {
    ivec2 pixel = ivec2(gl_FragCoord.xy);
    vec3 position = position_at(pixel);
    float distance = length(position);
    visible_and_distance = vec2(1.0, min(distance, 60000.0)); // within the range of 16-bit floats
    if (texelFetch(depth_map, pixel, 0).r >= 1.0) return;

    vec3 normal = cross(slope(position, pixel, ivec2(0, 1)), slope(position, pixel, ivec2(1, 0)));
    float squared = dot(normal, normal);
    if (!(squared > 0.0)) return;
    normal *= inversesqrt(squared);

    float radius = frame.occlusion.x;
    float pixels = clamp(radius * frame.occlusion.y / distance, 2.0, 0.25 / frame.eye.w);
    float turned = float((pixel.x & 3) + 4 * (pixel.y & 3)) * (tau / 16.0);
    float hidden = 0.0;
    for (int i = 0; i < samples; ++i) {
        float out_to = (float(i) + 0.5) / float(samples);
        float angle = out_to * turns * tau + turned;
        vec3 v = position_at(pixel + ivec2(round(out_to * pixels * vec2(cos(angle), sin(angle))))) - position;
        float vv = max(dot(v, v), 1e-12 * radius * radius);
        float sine = dot(v, normal) * inversesqrt(vv);
        hidden += max(sine - frame.occlusion.z, 0.0) * max(1.0 - vv / (radius * radius), 0.0);
    }
    visible_and_distance.x = 1.0 / (1.0 + frame.occlusion.w * hidden / float(samples)); // never 0
}
