// The common part of the two variants of triangle classification, which differ in list_crossing().
#include "classify.h"

layout(local_size_x = classify_group_size) in;
layout(push_constant) uniform Push { ClassifyGrid grid; };
layout(std430, binding = classify_binding_vertex_answers) readonly buffer Vertices { uint site_of[]; };
layout(std430, binding = classify_binding_triangles) readonly buffer Triangles { uint triangles[]; };
layout(std430, binding = classify_binding_triangle_answers) writeonly buffer Answers { uint answers[]; };
layout(std430, binding = classify_binding_crossing) writeonly buffer CrossingList { uint crossing_list[]; };
layout(std430, binding = classify_binding_crossing_count) buffer Count { uint count; };

// Appends triangle t to the list if it crosses; called by all invocations.
void list_crossing(uint t, bool crosses);

void main() {
    const uint t = gl_GlobalInvocationID.x;
    bool crosses = false;
    if (t < grid.counts.x) {
        const uint a = site_of[triangles[3 * t]], b = site_of[triangles[3 * t + 1]], c = site_of[triangles[3 * t + 2]];
        const bool whole = a == b && b == c && (a & classify_uncertain) == 0;
        answers[t] = whole ? a : classify_crossing;
        crosses = !whole;
    }
    list_crossing(t, crosses);
}
