#version 460
#extension GL_GOOGLE_include_directive : require
#include "fade.glsl"

layout(location = 0) flat in uint id;
layout(location = 1) flat in float opacity;
layout(location = 0) out uint colour;

void main() {
    discard_faded(opacity);
    colour = id;
}
