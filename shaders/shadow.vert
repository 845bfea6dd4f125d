#version 460
#extension GL_GOOGLE_include_directive : require
// Depth of the pieces seen from the light; without fragment shader.
#include "frame.glsl"

layout(location = 0) in vec3 position;

void main() {
    DrawData draw = draws[gl_InstanceIndex];
    vec3 world = transform_vertex(draw, position, vec3(0.0));
    gl_Position = is_clear(draw) ? nowhere : frame.shadow_clip_from_world * vec4(world, 1.0);
}
