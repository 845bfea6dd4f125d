#version 460
#extension GL_GOOGLE_include_directive : require
// Puffs of dust, one instance for each: a square that faces the eye and covers the ball of the puff.
#include "frame.glsl"

layout(location = 0) in vec4 centre_and_radius;
layout(location = 1) in vec4 colour_and_opacity;
layout(location = 2) in uint number;
layout(location = 0) out vec3 from_eye;
layout(location = 1) flat out vec4 ball; // centre from the eye; radius, metres
layout(location = 2) flat out vec4 dust; // colour; opacity of the middle
layout(location = 3) flat out uint pattern;

// Distances from the eye, in radii, between which a puff appears: the eye is never inside one.
const float nearest = 1.2, visible = 2.5;

void main() {
    ball = vec4(centre_and_radius.xyz - frame.eye.xyz, centre_and_radius.w);
    pattern = number;
    float distance = length(ball.xyz), radii = distance / max(ball.w, 1e-6);
    dust = vec4(colour_and_opacity.rgb, colour_and_opacity.a * smoothstep(nearest, visible, radii));
    if (radii <= nearest) {
        from_eye = vec3(0.0);
        gl_Position = nowhere;
        return;
    }
    vec3 forward = ball.xyz / distance;
    vec3 right = normalize(cross(forward, abs(forward.y) < 0.9 ? vec3(0.0, 1.0, 0.0) : vec3(1.0, 0.0, 0.0)));
    vec3 above = cross(right, forward);
    const vec2 corners[6] =
        vec2[](vec2(-1.0, -1.0), vec2(1.0, -1.0), vec2(1.0, 1.0), vec2(-1.0, -1.0), vec2(1.0, 1.0), vec2(-1.0, 1.0));
    // The cone of rays that touch the ball, cut at the distance of its centre.
    float reach = ball.w * radii * inversesqrt(radii * radii - 1.0);
    vec2 corner = reach * corners[gl_VertexIndex];
    from_eye = ball.xyz + corner.x * right + corner.y * above;
    gl_Position = frame.clip_from_eye * vec4(from_eye, 1.0);
}
