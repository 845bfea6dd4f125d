#version 460
#extension GL_GOOGLE_include_directive : require
// A square of two triangles around the disc in which the ground fades out; without vertex buffer.
#include "frame.glsl"

layout(location = 0) out vec3 from_eye;

void main() {
    const vec2 corners[6] = vec2[](vec2(-1, -1), vec2(-1, 1), vec2(1, 1), vec2(-1, -1), vec2(1, 1), vec2(1, -1));
    vec2 xz = frame.ground_disc.xy + corners[gl_VertexIndex] * frame.ground_disc.w;
    from_eye = vec3(xz.x, frame.ground.w, xz.y) - frame.eye.xyz;
    gl_Position = frame.clip_from_eye * vec4(from_eye, 1.0);
}
