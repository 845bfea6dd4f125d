// Adds up what the faces of glass do to the light of a pixel; glass_composite.frag applies it. Sums do not depend on
// the order of the faces, so nothing is sorted. Pieces are closed: each ray that enters one leaves it, and the way
// through glass is the sum of the distances of its back faces less that of its front faces.
//
// Includers declare a depth_map of the opaque scene, and depth_at().
#include "fade.glsl"
#include "light.glsl"

layout(location = 0) in vec3 from_eye;
layout(location = 1) flat in vec2 opacity_and_middle; // of the piece; distance of its middle from the eye, metres
layout(location = 2) in vec3 smooth_normal;           // zero on cuts
// The way through glass, metres; the reflected light; the bend of the ray: x and y, on the screen, of the normals.
layout(location = 0) out vec4 sums;

float luminance(vec3 light) {
    return dot(light, vec3(0.2126, 0.7152, 0.0722));
}

void main() {
    vec3 across = cross(dFdy(from_eye), dFdx(from_eye));
    discard_faded(opacity_and_middle.x);
    float distance = length(from_eye);
    float behind = depth_at(ivec2(gl_FragCoord.xy));
    // The opaque surface of the pixel, on the ray of this fragment.
    vec4 here = frame.clip_from_eye * vec4(from_eye, 1.0);
    vec4 opaque = frame.eye_from_clip * vec4(here.xy / here.w, behind, 1.0);
    float end = length(opaque.xyz / opaque.w);
    float reached = min(distance, end) - opacity_and_middle.y;
    sums = vec4(gl_FrontFacing ? -reached : reached, 0.0, 0.0, 0.0);
    if (distance > end) return;

    // Outward normals: towards the eye on front faces, away from it on back faces.
    vec3 view = -from_eye / distance;
    float side = gl_FrontFacing ? 1.0 : -1.0;
    float squared = dot(across, across);
    vec3 facet = squared > 0.0 ? across * inversesqrt(squared) : side * view;
    if (side * dot(facet, view) < 0.0) facet = -facet;
    vec3 normal = dot(smooth_normal, facet) > 0.0 ? normalize(smooth_normal) : facet;
    if (side * dot(normal, view) < 0.0) normal = facet;
    // A prism bends a ray by the sum of its normals; two parallel faces do not.
    mat4 rows = transpose(frame.clip_from_eye);
    sums.zw = vec2(dot(normalize(rows[0].xyz), normal), dot(normalize(rows[1].xyz), normal));
    if (gl_FrontFacing)
        sums.y =
            fresnel(dot(normal, view)) * luminance(light_from(reflect(-view, normal), sun_visibility(from_eye, facet)));
}
