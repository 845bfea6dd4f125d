#version 460
#extension GL_GOOGLE_include_directive : require
// Dust in front of a depth image with one sample a pixel.
#include "shared.h"

layout(set = 1, binding = binding_image) uniform sampler2D depth_map;

#define sample_count 1

float depth_at(ivec2 pixel, int k) {
    return texelFetch(depth_map, pixel, 0).r;
}

#include "dust.glsl"
