// Culls the draw ranges of pieces outside the view, for the camera (global invocation y = 0) and for the light (y = 1).
// A culled command keeps its place, with zero instances. Compaction would change the draw order from run to run, and
// with it the picture where surfaces coincide.
#version 460
#extension GL_GOOGLE_include_directive : require
#include "frame.glsl"
#include "frustum.h"

layout(local_size_x = cull_group_size) in;
layout(set = 0, binding = binding_commands, std430) readonly buffer All { DrawCommand all[]; };
layout(set = 0, binding = binding_culled_for_camera, std430) writeonly buffer Camera { DrawCommand for_camera[]; };
layout(set = 0, binding = binding_culled_for_light, std430) writeonly buffer Light { DrawCommand for_light[]; };
layout(set = 0, binding = binding_visible_counts, std430) buffer VisibleCounts { uint visible_counts[view_count]; };

// Whether a range is the second one of the piece before it: its indices follow those of that one. Copies of a piece have
// the same vertices, but begin with the same indices.
bool continues(uint i) {
    DrawCommand before = all[i - 1], own = all[i];
    return own.first_vertex == before.first_vertex && own.first_index == before.first_index + before.indices;
}

void main() {
    uint i = gl_GlobalInvocationID.x, view = gl_GlobalInvocationID.y;
    if (i >= all.length()) return;
    DrawData draw = draws[i];
    Pose pose = poses[draw.body];
    vec3 origin = view == view_camera ? frame.eye.xyz : vec3(0.0);
    mat4 clip = view == view_camera ? frame.clip_from_eye : frame.shadow_clip_from_world;
    float scale = abs(pose.position_and_scale.w);
    vec3 centre = transform_point(pose, draw.sphere.xyz, origin);
    bool visible = scale != 0.0 && intersects_frustum(clip, centre, centre, draw.sphere.w * scale);

    DrawCommand command = all[i];
    bool first_of_piece = i == 0 || !continues(i);
    if (!visible) command.instances = 0;
    if (view == view_camera) {
        for_camera[i] = command;
    } else {
        // A shadow has no material, so the piece's two consecutive ranges are merged into one draw.
        if (!first_of_piece) command.instances = 0;
        else if (i + 1 < all.length() && continues(i + 1)) command.indices += all[i + 1].indices;
        for_light[i] = command;
    }
    if (visible && first_of_piece) atomicAdd(visible_counts[view], 1);
}
