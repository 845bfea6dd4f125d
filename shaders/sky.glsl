// The share of the sky that a surface sees, for fragment shaders; from the occlusion pass.
#ifndef BRITTLE_SKY_GLSL
#define BRITTLE_SKY_GLSL

#include "frame.glsl"

layout(constant_id = constant_ambient_occlusion) const bool ambient_occlusion = false;
layout(set = 1, binding = binding_image) uniform sampler2D occlusion_map;

// Returns the share of the sky that nearby geometry leaves visible: the mean of the occlusion pass over 4x4 pixels, the
// period of its sample rotation, weighted by their similarity in distance to this surface.
float sky_visibility(vec3 from_eye) {
    if (!ambient_occlusion) return 1.0;
    ivec2 last = textureSize(occlusion_map, 0) - 1, at = ivec2(gl_FragCoord.xy) - 2;
    float distance = length(from_eye), sum = 0.0, weights = 0.0;
    for (int y = 0; y < 4; ++y) {
        for (int x = 0; x < 4; ++x) {
            vec2 near = texelFetch(occlusion_map, clamp(at + ivec2(x, y), ivec2(0), last), 0).xy;
            float weight = max(1.0 - 30.0 * abs(near.y - distance) / distance, 1e-3);
            sum += weight * near.x;
            weights += weight;
        }
    }
    return sum / weights;
}

#endif
