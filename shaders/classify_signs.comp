// Computes the sign pattern of each crossing triangle: the signs of its corners against the bisectors of their cells,
// and whether any other cell is near enough to change the result (fracture/classifier.h). A bit that rounding could
// change is left unset.
#version 460
#extension GL_GOOGLE_include_directive : require
#include "classify.h"

layout(local_size_x = classify_group_size) in;
layout(push_constant) uniform Push { ClassifyGrid grid; };
layout(std430, binding = classify_binding_positions) readonly buffer Positions { float positions[]; };
layout(std430, binding = classify_binding_sites) readonly buffer Sites { vec4 sites[]; };
layout(std430, binding = classify_binding_bins) readonly buffer Bins { uint bin_begin[]; };
layout(std430, binding = classify_binding_vertex_answers) readonly buffer Vertices { uint site_of[]; };
layout(std430, binding = classify_binding_triangles) readonly buffer Triangles { uint triangles[]; };
layout(std430, binding = classify_binding_site_positions) readonly buffer SitePositions { vec4 site_position[]; };
layout(std430, binding = classify_binding_crossing) readonly buffer CrossingList { uint crossing_list[]; };
layout(std430, binding = classify_binding_crossing_count) readonly buffer Count { uint count; };
layout(std430, binding = classify_binding_triangle_answers) writeonly buffer Answers { uint answers[]; };

// State of the search around a point x: whether every site outside own_cells is farther from x than the site of
// own_cells.x, by more than the rounding errors, for every point within point_error of x. With o the site of
// own_cells.x, |x - s|^2 - |x - o|^2 is linear in x, with a gradient of 2 |s - o| <= 2 (|x - s| + |x - o|).
uvec3 own_cells;
float own_distance2, point_error;
bool refuted;

float squared_distance_error(float d2);

bool is_farther(float d2) {
    return d2 - own_distance2
           > squared_distance_error(d2) + squared_distance_error(own_distance2)
                 + 2.01 * point_error * (sqrt(d2) + sqrt(own_distance2));
}

void visit_site(uint site, float d2) {
    if (any(equal(own_cells, uvec3(site)))) return;
    // If is_farther() holds for a distance, it holds for all larger ones, because its left side grows faster than its
    // right side. Therefore can_stop() may apply it to a lower bound.
    if (!is_farther(d2)) refuted = true;
}

bool can_stop(float gap2) {
    return refuted || is_farther(gap2);
}

#include "classify_rings.glsl"

// Returns whether no cell other than `cells` contains a point within x_error of x. `site` is the site of cells.x.
bool is_alone(vec3 x, float x_error, uvec3 cells, vec3 site) {
    own_cells = cells;
    point_error = x_error;
    const vec3 d = x - site;
    own_distance2 = d.x * d.x + d.y * d.y + d.z * d.z;
    refuted = false;
    visit_sites(x);
    return !refuted;
}

// Returns |x - there|^2 - |x - here|^2, which is positive on the side of `here`. Raises `error` to the sum of the
// errors of both squares.
float bisector_value(vec3 x, vec3 here, vec3 there, inout float error) {
    const vec3 h = x - here, t = x - there;
    const float h2 = h.x * h.x + h.y * h.y + h.z * h.z, t2 = t.x * t.x + t.y * t.y + t.z * t.z;
    error = max(error, squared_distance_error(h2) + squared_distance_error(t2));
    return t2 - h2;
}

// Returns a bound of the rounding error of a point that is interpolated from rounded positions.
float rounding_of_point() {
    return 5.9604645e-8 * 12.0 * grid.low.w;
}

// Returns whether the edge crosses the bisector of its cells a and b at a point that no third cell contains.
bool is_edge_alone(vec3 from, vec3 to, uint a, uint b, vec3 site_a, vec3 site_b) {
    float error = 0.0;
    const float at_from = bisector_value(from, site_a, site_b, error);
    const float at_to = bisector_value(to, site_a, site_b, error);
    const float change = at_from - at_to;
    if (!(change > 8.0 * error)) return false;
    const float t = clamp(at_from / change, 0.0, 1.0);
    // The error of t is at most 4/3 error / change, plus its own rounding.
    const float t_error = 2.0 * error / change + 5e-7;
    return is_alone(from + t * (to - from), t_error * distance(from, to) + rounding_of_point(), uvec3(a, b, a), site_a);
}

// Returns whether the triangle meets the three cells' common edge at a point that no fourth cell contains. The
// barycentric weights of the point are the cofactors of det[f; g; 1], where f and g are the corners' values against two
// bisectors.
bool is_point_alone(mat3 corners, uvec3 cells, vec3 site[3]) {
    float error = 0.0;
    vec3 f, g;
    for (int k = 0; k < 3; ++k) {
        f[k] = bisector_value(corners[k], site[0], site[1], error);
        g[k] = bisector_value(corners[k], site[0], site[2], error);
    }
    const float largest = max(max(max(abs(f.x), abs(f.y)), abs(f.z)), max(max(abs(g.x), abs(g.y)), abs(g.z)));
    vec3 w = vec3(f.y * g.z - f.z * g.y, f.z * g.x - f.x * g.z, f.x * g.y - f.y * g.x);
    const float sum = w.x + w.y + w.z;
    // In multiples of `unit`, the error of a cofactor is at most 8, that of their sum at most 25, and hence that of a
    // weight in [0, 1] at most 45 / |sum|.
    const float unit = largest * error;
    if (!(abs(sum) > 128.0 * unit)) return false;
    w /= sum;
    if (any(lessThan(w, vec3(-0.01))) || any(greaterThan(w, vec3(1.01)))) return false; // outside the triangle
    const vec3 along = corners[1] - corners[0], across = corners[2] - corners[0];
    const float x_error = 64.0 * unit / abs(sum) * (length(along) + length(across)) + 2.0 * rounding_of_point();
    return is_alone(corners[0] + (w.y * along + w.z * across), x_error, cells, site[0]);
}

void main() {
    if (gl_GlobalInvocationID.x >= count) return;
    const uint t = crossing_list[gl_GlobalInvocationID.x];
    uvec3 vertices, cells;
    mat3 corners;
    vec3 site[3];
    for (int k = 0; k < 3; ++k) {
        vertices[k] = triangles[3 * t + k];
        cells[k] = site_of[vertices[k]];
        corners[k] = vec3(positions[3 * vertices[k]], positions[3 * vertices[k] + 1], positions[3 * vertices[k] + 2]);
        site[k] = site_position[cells[k] & ~classify_uncertain].xyz;
    }
    const bool certain = ((cells.x | cells.y | cells.z) & classify_uncertain) == 0;
    const bool three = certain && cells.x != cells.y && cells.y != cells.z && cells.z != cells.x;
    uint pattern = classify_crossing;
    for (int e = 0; e < 3; ++e) {
        const int to = e == 2 ? 0 : e + 1, third = e == 0 ? 2 : e - 1;
        const uint a = cells[e], b = cells[to];
        if (a == b || ((a | b) & classify_uncertain) != 0) continue;
        if (vertices[e] < vertices[to] && is_edge_alone(corners[e], corners[to], a, b, site[e], site[to]))
            pattern |= classify_edge_alone << e;
        float error = 0.0;
        const float value = bisector_value(corners[third], site[e], site[to], error);
        if (three && abs(value) > error)
            pattern |= (classify_sign_known << (2 * e)) | (value > 0.0 ? classify_sign_first << (2 * e) : 0);
    }
    if (three && is_point_alone(corners, cells, site)) pattern |= classify_point_alone;
    answers[t] = pattern;
}
