// The resources of one frame in flight: the CPU writes the buffers of one slot while the device reads those of another.
//
// Each frame waits for the slot's commands, calls write_slot(), and imports the slot into its graph with import_slot().
// Buffers grow with the scene and are kept from frame to frame. All functions throw VulkanFailure.
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
    VkDescriptorSet set, depth_set, occlusion_set, depth_behind_set, behind_glass_set, glass_set, dust_set;
    DeviceBuffer uniforms;
    DeviceBuffer visible_counts; // zeroed by the CPU, counted up by the cull pass
    bool culled = false;         // whether the newest frame has a cull pass, and `visible_counts` its result
    DeviceBuffer camera_commands, light_commands;
    DeviceBuffer draw_data, draw_commands;                    // one element for each draw range
    uint64_t pieces_version = 0;                              // PieceArena::version() of the two
    DeviceBuffer staging;                                     // geometry that this frame uploads
    std::vector<std::shared_ptr<const DeviceBuffer>> retired; // freed when the device has finished this frame
    DeviceBuffer poses;
    uint32_t posed_bodies = 0; // number of poses that were written at poses_moment
    uint64_t poses_moment = 0; // Scene::moment of the poses; 0: unknown
    DeviceBuffer lines;
    DeviceBuffer spheres;
    DeviceBuffer splinters;
    DeviceBuffer dust;    // from back to front
    CommandSlot commands; // last, because its destructor waits for the device before the buffers are destroyed
};

// The data that fills a slot's buffers, beside the scene.
struct SlotSource {
    const Device& device;
    const FrameLayout& layout;
    const PieceArena& pieces;
    const Quality& quality; // every member is set
    View view;
    VkImageView shadow;                   // the shadow map that the frame reads
    const Materials* materials = nullptr; // in the view of materials
};

// Fills the slot's buffers and writes its descriptors. The device must have finished the slot's last frame.
void write_slot(FrameSlot& slot, const SlotSource& from, const Scene& scene);

// Imports the slot's buffers and the piece arenas into the frame's graph, and plans the upload of the arenas.
void import_slot(Frame& frame, FrameSlot& slot, const Device& device);

} // namespace brittle::engine
