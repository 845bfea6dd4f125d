// What one frame in flight has to itself: the CPU writes its buffers while the device reads another slot's.
//
// In the order of a frame: wait for the slot's commands, write_slot(), then import_slot() into the frame that
// is declared. Buffers grow as the scene does, and are kept from frame to frame. All functions throw
// VulkanFailure.
#pragma once

#include <cstdint>
#include <memory>
#include <vector>

#include "engine/gpu/commands.h"
#include "engine/gpu/memory.h"
#include "engine/render/frame.h"

namespace brittle::engine {

struct FrameSlot {
    FrameSlot(const Device& device, const FrameLayout& layout);

    GraphExecutor executor;
    VkDescriptorSet set, depth_set, occlusion_set;
    DeviceBuffer uniforms;
    DeviceBuffer visible_counts; // written by both
    bool culled = false;         // the newest frame counts in `drawn`
    DeviceBuffer camera_commands, light_commands;
    DeviceBuffer draw_data, draw_commands; // one a draw range, of PieceArena::version()
    uint64_t pieces_version = 0;
    DeviceBuffer staging;                                     // of geometry that this frame uploads
    std::vector<std::shared_ptr<const DeviceBuffer>> retired; // that nothing needs after this frame
    DeviceBuffer poses;
    uint32_t posed_bodies = 0; // the first so many of poses hold what was written at the moment
    uint64_t poses_moment = 0; // 0: not known
    DeviceBuffer lines;
    DeviceBuffer spheres;
    CommandSlot commands; // last: its destructor waits before the others go
};

// What a slot's buffers are filled from, beside the scene.
struct SlotSource {
    const Device& device;
    const FrameLayout& layout;
    const PieceArena& pieces;
    const Quality& quality; // every member is set
    View view;
    VkImageView shadow; // of the map that the frame reads
};

// Fills the buffers, and points the slot's descriptors at them. The device must be done with the slot.
void write_slot(FrameSlot& slot, const SlotSource& from, const Scene& scene);

// Makes the slot's buffers and the pieces' arenas known to the frame's graph, with what the arenas are to
// upload.
void import_slot(Frame& frame, FrameSlot& slot, const Device& device);

} // namespace brittle::engine
