#version 460
#extension GL_GOOGLE_include_directive : require
#include "light.glsl"
#include "sky.glsl"

layout(location = 0) in vec3 from_eye;
layout(location = 0) out vec4 colour;

void main() {
    vec2 from_centre = from_eye.xz + frame.eye.xz - frame.ground_disc.xy;
    float fade = smoothstep(frame.ground_disc.z, frame.ground_disc.w, length(from_centre));
    const vec3 up = vec3(0.0, 1.0, 0.0);
    vec3 light = shade(frame.ground.rgb, up, sun_visibility(from_eye, up), frame.sky.w,
                       sky_visibility(from_eye));
    colour = display(mix(light, background(), fade));
}
