#version 460
#extension GL_GOOGLE_include_directive : require
// Faces of glass in front of a depth image with several samples a pixel, of which the first counts.
#include "shared.h"

layout(set = 1, binding = binding_image) uniform sampler2DMS depth_map;

float depth_at(ivec2 pixel) {
    return texelFetch(depth_map, pixel, 0).r;
}

#include "glass.glsl"
