#version 460
#extension GL_GOOGLE_include_directive : require
// Depth of pieces of glass seen from the light; others collapse. fade.frag discards most pixels, so that the shadow is
// faint.
#include "frame.glsl"

const float darkness = 0.3; // of the shadow

layout(location = 0) in vec3 position;
layout(location = 1) flat out vec4 albedo;

void main() {
    DrawData draw = draws[gl_InstanceIndex];
    albedo = vec4(0.0, 0.0, 0.0, darkness * unpackUnorm4x8(draw.tint).a);
    vec4 at = frame.shadow_clip_from_world * vec4(transform_vertex(draw, position, vec3(0.0)), 1.0);
    gl_Position = is_clear(draw) ? at : nowhere;
}
