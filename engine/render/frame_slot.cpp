#include "engine/render/frame_slot.h"

#include <algorithm>
#include <cstring>
#include <utility>

#include <glm/geometric.hpp>

#include "engine/render/marks_pass.h"

namespace brittle::engine {

namespace {

// Smallest buffer, bytes: enough for a thousand pieces, since a GPU's driver takes up to a millisecond to allocate memory
// and as long to free it.
constexpr uint64_t min_reserved = 256 << 10;

// Grows the buffer to 1.5 times `size` if it is too small, so that a growing scene does not allocate each frame.
void reserve(const Device& device, DeviceBuffer& buffer, const char* name, uint64_t size, VkBufferUsageFlags usage,
             MemoryKind kind = MemoryKind::upload) {
    if (buffer.handle() && buffer.size() >= size) return;
    buffer = DeviceBuffer(device, name, std::max(size + size / 2, min_reserved), usage, kind);
}

void write_poses(FrameSlot& slot, const SlotSource& from, const Scene& scene) {
    const uint32_t bodies = from.pieces.bodies();
    if (slot.poses.size() < bodies * sizeof(BodyPose)) slot.poses_moment = 0;
    reserve(from.device, slot.poses, "poses", std::max(bodies, 1u) * sizeof(BodyPose),
            VK_BUFFER_USAGE_STORAGE_BUFFER_BIT);
    const std::span<BodyPose> poses = slot.poses.mapped_as<BodyPose>(0, bodies);
    const bool known = scene.write_poses && bodies <= slot.posed_bodies && slot.poses_moment <= scene.moment;
    const uint64_t since = known ? slot.poses_moment : 0;
    // The callback may set positions only; the other members then have their defaults.
    if (since == 0) std::ranges::fill(poses, BodyPose{});
    slot.poses_moment = 0; // remains if the callback throws
    if (!scene.write_poses) return;
    scene.write_poses(poses, since);
    slot.poses_moment = scene.moment;
    slot.posed_bodies = bodies;
}

void write_pieces(FrameSlot& slot, const SlotSource& from, const Scene& scene) {
    const PieceArena& pieces = from.pieces;
    const Device& device = from.device;
    const uint32_t draws = pieces.draws(), room = std::max(draws, 1u);
    constexpr VkBufferUsageFlags storage = VK_BUFFER_USAGE_STORAGE_BUFFER_BIT;
    constexpr VkBufferUsageFlags commands = VK_BUFFER_USAGE_INDIRECT_BUFFER_BIT | storage;
    const uint64_t commands_size = room * sizeof(shared::DrawCommand);
    const auto lists = [&] {
        return PieceArena::DrawLists{slot.draw_data.mapped_as<shared::DrawData>(0, draws),
                                     slot.draw_commands.mapped_as<VkDrawIndexedIndirectCommand>(0, draws)};
    };
    if (slot.pieces_version != pieces.version()) {
        slot.pieces_version = 0; // remains if an allocation throws
        reserve(device, slot.draw_data, "draw data", room * sizeof(shared::DrawData), storage);
        reserve(device, slot.draw_commands, "draw commands", commands_size, commands);
        pieces.write_draws(lists());
        slot.pieces_version = pieces.version();
    }
    // Reads the mapped poses; on a CPU device, the default for front_to_back, mapped memory is fast to read.
    if (*from.quality.front_to_back)
        pieces.write_draws(lists(), slot.poses.mapped_as<BodyPose>(0, pieces.bodies()), scene.camera.eye);
    const uint64_t culled_size = *from.quality.culling ? commands_size : 0;
    reserve(device, slot.camera_commands, "commands for the camera", culled_size, commands, MemoryKind::device);
    reserve(device, slot.light_commands, "commands for the light", culled_size, commands, MemoryKind::device);
    std::ranges::fill(slot.visible_counts.mapped_as<uint32_t>(0, shared::view_count), 0u);
}

void write_marks(FrameSlot& slot, const Device& device, const Scene& scene) {
    if (!scene.lines.empty()) {
        reserve(device, slot.lines, "lines", scene.lines.size_bytes(), VK_BUFFER_USAGE_VERTEX_BUFFER_BIT);
        std::memcpy(slot.lines.mapped(), scene.lines.data(), scene.lines.size_bytes());
    }
    if (!scene.spheres.empty()) {
        reserve(device, slot.spheres, "spheres", std::max(scene.spheres.size_bytes(), MarksPass::min_spheres_size),
                VK_BUFFER_USAGE_VERTEX_BUFFER_BIT);
        std::memcpy(slot.spheres.mapped(), scene.spheres.data(), scene.spheres.size_bytes());
    }
}

// Sorts the dust from back to front, since each puff is drawn over what is behind it.
void write_particles(FrameSlot& slot, const Device& device, const Scene& scene) {
    if (!scene.splinters.empty()) {
        reserve(device, slot.splinters, "splinters", scene.splinters.size_bytes(), VK_BUFFER_USAGE_VERTEX_BUFFER_BIT);
        std::memcpy(slot.splinters.mapped(), scene.splinters.data(), scene.splinters.size_bytes());
    }
    if (!scene.dust.empty()) {
        reserve(device, slot.dust, "dust", scene.dust.size_bytes(), VK_BUFFER_USAGE_VERTEX_BUFFER_BIT);
        std::vector<std::pair<float, uint32_t>> order; // by puff: negative square of its distance, index
        for (const DustPuff& puff : scene.dust) {
            const glm::vec3 from_eye = puff.centre - scene.camera.eye;
            order.emplace_back(-glm::dot(from_eye, from_eye), static_cast<uint32_t>(order.size()));
        }
        std::ranges::sort(order);
        const std::span<DustPuff> out = slot.dust.mapped_as<DustPuff>(0, order.size());
        for (size_t k = 0; k < order.size(); ++k) out[k] = scene.dust[order[k].second];
    }
}

void import_written(Frame& frame, const FrameSlot& slot) {
    const auto import = [&](const char* name, const DeviceBuffer& buffer) {
        return frame.graph.import_buffer(name, {buffer.size()},
                                         {.initial = Access::host_write,
                                          .final = {},
                                          .read_only = true,
                                          .external = frame.external.add(buffer.handle())});
    };
    frame.uniforms = import("frame data", slot.uniforms);
    frame.poses = import("poses", slot.poses);
    if (!frame.scene.lines.empty()) frame.lines = import("lines", slot.lines);
    if (!frame.scene.spheres.empty()) frame.spheres = import("spheres", slot.spheres);
    if (!frame.scene.splinters.empty()) frame.splinters = import("splinters", slot.splinters);
    if (!frame.scene.dust.empty()) frame.dust = import("dust", slot.dust);
}

void import_pieces(Frame& frame, FrameSlot& slot, const Device& device) {
    const PieceArena& pieces = frame.pieces;
    const auto import = [&](const char* name, const DeviceBuffer& buffer, Access access) {
        return frame.graph.import_buffer(
            name, {buffer.size()}, {.initial = access, .final = {}, .external = frame.external.add(buffer.handle())});
    };
    frame.upload = pieces.next_upload();
    if (frame.draws_pieces() || !frame.upload.empty()) {
        // Passes of earlier frames read the arenas; an upload waits for those reads.
        frame.vertices = import("piece vertices", pieces.vertices(), Access::vertex_read);
        frame.normals = import("piece normals", pieces.normals(), Access::vertex_read);
        frame.indices = import("piece indices", pieces.indices(), Access::index_read);
        if (pieces.corners().handle()) frame.corners = import("piece corners", pieces.corners(), Access::vertex_read);
    }
    if (frame.upload.staging_size > 0) {
        reserve(device, slot.staging, "staging", frame.upload.staging_size, VK_BUFFER_USAGE_TRANSFER_SRC_BIT);
        pieces.write_staging(slot.staging.mapped());
        frame.staging = import("staging", slot.staging, Access::host_write);
    }
    for (const PieceUpload::Staged& staged : frame.upload.staged)
        frame.staged.push_back(import("staged pieces", *staged.buffer, Access::host_write));
    if (!frame.draws_pieces()) return;
    frame.draw_data = import("draw data", slot.draw_data, Access::host_write);
    frame.commands = import("draw commands", slot.draw_commands, Access::host_write);
    frame.camera_commands = frame.light_commands = frame.commands;
}

} // namespace

FrameSlot::FrameSlot(const Device& device, const FrameLayout& layout)
    : executor(device), set(layout.allocate_frame()), depth_set(layout.allocate_image()),
      occlusion_set(layout.allocate_image()), depth_behind_set(layout.allocate_image()),
      behind_glass_set(layout.allocate_image()), glass_set(layout.allocate_image()), dust_set(layout.allocate_image()),
      uniforms(device, "frame data", sizeof(shared::FrameData), VK_BUFFER_USAGE_UNIFORM_BUFFER_BIT, MemoryKind::upload),
      visible_counts(device, "pieces in view", shared::view_count * sizeof(uint32_t),
                     VK_BUFFER_USAGE_STORAGE_BUFFER_BIT, MemoryKind::readback),
      commands(device) {}

void write_slot(FrameSlot& slot, const SlotSource& from, const Scene& scene) {
    const shared::FrameData data = frame_data(scene, from.view, from.materials);
    std::memcpy(slot.uniforms.mapped(), &data, sizeof data);

    write_poses(slot, from, scene);
    write_pieces(slot, from, scene);
    write_marks(slot, from.device, scene);
    write_particles(slot, from.device, scene);
    from.layout.update(slot.set, {.frame = slot.uniforms.handle(),
                                  .poses = slot.poses.handle(),
                                  .draws = slot.draw_data.handle(),
                                  .commands = slot.draw_commands.handle(),
                                  .culled_for_camera = slot.camera_commands.handle(),
                                  .culled_for_light = slot.light_commands.handle(),
                                  .visible_counts = slot.visible_counts.handle(),
                                  .commands_size = std::max(from.pieces.draws(), 1u) * sizeof(shared::DrawCommand),
                                  .shadow = from.shadow});
}

void import_slot(Frame& frame, FrameSlot& slot, const Device& device) {
    import_written(frame, slot);
    import_pieces(frame, slot, device);
}

} // namespace brittle::engine
