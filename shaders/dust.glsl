// A puff of dust: a ball of haze, so that it has no edge where it meets a surface (Umenhoffer, Szirmay-Kalos and
// Szijarto, "Spherical billboards and their application to rendering explosions", 2006).
//
// Includers declare a depth_map of the opaque scene, and sample_count and depth_at().
#include "light.glsl"
#include "noise.glsl"

layout(location = 0) in vec3 from_eye;
layout(location = 1) flat in vec4 ball; // centre from the eye; radius, metres
layout(location = 2) flat in vec4 dust; // colour; opacity of the middle
layout(location = 3) flat in uint pattern;
layout(location = 0) out vec4 colour;

// The distance of the opaque surface of a sample, on the ray of this fragment.
float distance_of(float depth) {
    vec4 here = frame.clip_from_eye * vec4(from_eye, 1.0);
    vec4 opaque = frame.eye_from_clip * vec4(here.xy / here.w, depth, 1.0);
    return length(opaque.xyz / opaque.w);
}

void main() {
    vec3 ray = normalize(from_eye);
    float middle = dot(ray, ball.xyz), inverse = 1.0 / ball.w;
    vec3 aside = (middle * ray - ball.xyz) * inverse; // from the centre to the nearest point of the ray, in radii
    float squared = 1.0 - dot(aside, aside);
    if (squared <= 0.0) discard;
    float half_chord = sqrt(squared);
    // The share of the ball's diameter that the ray passes before it meets a surface; the mean of the samples.
    float passed = 0.0;
    for (int k = 0; k < sample_count; ++k) {
        float end = (distance_of(depth_at(ivec2(gl_FragCoord.xy), k)) - middle) * inverse;
        passed += clamp(0.5 * (min(end, half_chord) + half_chord), 0.0, 1.0);
    }
    passed /= float(sample_count);
    if (passed <= 0.0) discard;
    // Billows: noise on the side of the ball that faces the eye. Between them the haze is thinner, without holes.
    uvec3 hash = hashes(ivec3(pattern, pattern >> 16, 0));
    float billows = noise(2.2 * (aside - half_chord * ray) + 97.0 * vec3(unit(hash.x), unit(hash.y), unit(hash.z)));
    float opacity = dust.a * passed * passed * mix(0.4, 1.0, smoothstep(0.2, 0.8, billows));
    // Dust scatters light to all sides, most of it forward.
    float lit = sun_visibility(middle * ray, vec3(0.0));
    float towards_sun = max(dot(ray, frame.to_light.xyz), 0.0);
    vec3 light = mix(frame.bounce.rgb, frame.sky.rgb, 0.5 + 0.25 * billows)
                 + frame.sun.rgb * lit * (0.35 + 0.2 * billows + 0.3 * pow(towards_sun, 8.0));
    colour = vec4(display(dust.rgb * light).rgb, opacity);
}
