#version 460
#extension GL_GOOGLE_include_directive : require
// Depth of fading pieces seen from the light; fade.frag discards pixels.
#include "frame.glsl"

layout(location = 0) in vec3 position;
layout(location = 1) flat out vec4 albedo;

void main() {
    DrawData draw = draws[gl_InstanceIndex];
    albedo = albedo_of(draw);
    vec4 at = frame.shadow_clip_from_world * vec4(transform_vertex(draw, position, vec3(0.0)), 1.0);
    gl_Position = is_clear(draw) ? nowhere : at;
}
