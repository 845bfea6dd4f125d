#version 460

layout(location = 0) flat in vec4 srgb;
layout(location = 0) out vec4 colour;

void main() {
    colour = srgb; // as the caller chose it: no light, no tone curve
}
