#version 460

layout(location = 0) flat in vec4 srgb;
layout(location = 0) out vec4 colour;

void main() {
    colour = srgb; // the caller's colour, without lighting or tone mapping
}
