// The variant of classify_triangles.comp for devices with subgroup ballots: one atomic operation for each subgroup
// instead of one for each crossing triangle.
#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_KHR_shader_subgroup_ballot : require
#include "classify_triangles.glsl"

void list_crossing(uint t, bool crosses) {
    const uvec4 vote = subgroupBallot(crosses);
    uint first = 0;
    if (subgroupElect()) first = atomicAdd(count, subgroupBallotBitCount(vote));
    first = subgroupBroadcastFirst(first);
    if (crosses) crossing_list[first + subgroupBallotExclusiveBitCount(vote)] = t;
}
