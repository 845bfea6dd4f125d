#version 460
#extension GL_GOOGLE_include_directive : require
// Dust in front of a depth image with several samples a pixel.
#include "shared.h"

layout(set = 1, binding = binding_image) uniform sampler2DMS depth_map;

#define sample_count textureSamples(depth_map)

float depth_at(ivec2 pixel, int k) {
    return texelFetch(depth_map, pixel, k).r;
}

#include "dust.glsl"
