#version 460
#extension GL_GOOGLE_include_directive : require
#include "light.glsl"

layout(location = 0) out vec4 colour;

void main() {
    colour = display(background());
}
