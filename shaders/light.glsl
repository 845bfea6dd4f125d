// Lighting, shadows, background and tone mapping, for fragment shaders.
#ifndef BRITTLE_LIGHT_GLSL
#define BRITTLE_LIGHT_GLSL

#include "frame.glsl"
#include "srgb.glsl"

layout(constant_id = constant_soft_shadows) const bool soft_shadows = false;
layout(set = 0, binding = binding_shadow) uniform sampler2DShadow shadow_map;

// Returns the share of sunlight that reaches a surface: 0 in shadow, 1 lit. Surfaces outside the shadow map are lit:
// the map encloses all casters, and its border has the far depth.
float sun_visibility(vec3 from_eye, vec3 normal) {
    vec3 receiver = from_eye + normal * frame.to_light.w;
    vec3 s = (frame.shadow_from_eye * vec4(receiver, 1.0)).xyz;
    s.z = min(s.z - frame.sun.w, 1.0);
    // The shadow of glass has a pattern (glass_shadow.vert), which only the mean of 4x4 texels hides.
    if (!soft_shadows && frame.glass.w == 0.0) return texture(shadow_map, s);
    float texel = frame.bounce.w;
    float lit = 0.0;
    for (int y = 0; y < 4; ++y)
        for (int x = 0; x < 4; ++x) lit += texture(shadow_map, vec3(s.xy + (vec2(x, y) - 1.5) * texel, s.z));
    return lit / 16.0;
}

// Lambertian reflection of a sun and of a two-coloured sky whose share `visible` reaches the surface. `height` is the
// height above the ground, which darkens surfaces near it.
vec3 shade(vec3 albedo, vec3 normal, float lit, float height, float visible) {
    float open = 0.45 + 0.55 * clamp(height / frame.sky.w + 0.5 * max(normal.y, 0.0), 0.0, 1.0);
    vec3 ambient = mix(frame.bounce.rgb, frame.sky.rgb, 0.5 + 0.5 * normal.y) * (open * visible);
    return albedo * (ambient + frame.sun.rgb * (lit * max(dot(normal, frame.to_light.xyz), 0.0)));
}

// The share of light that glass, glaze or varnish reflects at an angle (Schlick 1994, for an index of refraction of
// 1.5).
float fresnel(float cosine) {
    return 0.04 + 0.96 * pow(1.0 - clamp(cosine, 0.0, 1.0), 5.0);
}

// The light that comes from a direction: sky above, ground below, and a soft glow around the sun, which is seen where
// `lit` is 1.
vec3 light_from(vec3 direction, float lit) {
    float sun = max(dot(direction, frame.to_light.xyz), 0.0);
    vec3 sky = mix(frame.bounce.rgb, 1.6 * frame.sky.rgb, smoothstep(-0.15, 0.35, direction.y));
    return sky + frame.sun.rgb * (0.5 * pow(sun, 10.0) + lit * 24.0 * pow(sun, 600.0));
}

// Returns the background of a pixel: a vertical gradient in the picture, not in the world, so that the ground fades
// into it at every camera angle.
vec3 background() {
    float y = gl_FragCoord.y * frame.eye.w;
    return mix(frame.background_top.rgb, frame.background_bottom.rgb, smoothstep(0.0, 1.0, y));
}

// Converts linear light to the target's colour: exposure, a filmic curve (Narkowicz 2015, a fit of ACES), and the sRGB
// curve, because the targets are UNORM.
vec4 display(vec3 light) {
    light *= frame.background_top.w;
    vec3 c = clamp(light * (2.51 * light + 0.03) / (light * (2.43 * light + 0.59) + 0.14), 0.0, 1.0);
    return vec4(srgb_of(c), 1.0);
}

#endif
