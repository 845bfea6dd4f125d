#include "engine/render/renderer_state.h"

#include <cstring>

#include "engine/core/window.h"
#include "engine/graph/access_vulkan.h"
#include "engine/render/upload_pass.h"
#include "engine/render/upscale_pass.h"

namespace brittle::engine {

namespace {

// Bytes of staging that a slot keeps from frame to frame, so that a slow stream of pieces allocates nothing. A larger
// buffer is freed after its frame.
constexpr uint64_t max_staging_kept = 4 << 20;

} // namespace

Passes& Renderer::State::passes_for(Format format) {
    const auto found = passes.find(format);
    if (found != passes.end()) return found->second;
    const VkPipelineLayout pipeline_layout = layout.pipeline_layout();
    const TargetFormat target{to_vulkan(format), *quality().samples};
    std::optional<OcclusionPass> occlusion;
    if (*quality().ambient_occlusion) occlusion.emplace(device, pipeline_layout);
    return passes
        .emplace(format, Passes{ShadowPass(device, pipeline_layout, sphere), std::move(occlusion),
                                ShadePass(device, pipeline_layout, target, quality()),
                                MarksPass(device, pipeline_layout, target, sphere), std::nullopt, std::nullopt})
        .first->second;
}

// Waits until the device has finished the oldest frame in flight, reads its results and returns its slot.
FrameSlot& Renderer::State::next_slot() {
    FrameSlot& slot = *slots[frame_number++ % frames_in_flight];
    slot.commands.wait();
    slot.retired.clear();
    if (slot.staging.size() > max_staging_kept) slot.staging = {};
    collect(slot);
    return slot;
}

// Reads the times and counts of the slot's frame, which the device must have finished.
void Renderer::State::collect(FrameSlot& slot) {
    if (std::vector<PassTime> times = slot.executor.collect_times(); !times.empty()) timings = std::move(times);
    if (slot.culled)
        stats.pieces_in_view = slot.visible_counts.mapped_as<uint32_t>(0, shared::view_count)[shared::view_camera];
}

ShadowMap& Renderer::State::shadow_map_for(const Target& target) {
    if (target.scale >= 1.0f) return shadow_map;
    if (!small_shadow_map) {
        const auto size = static_cast<uint32_t>(target.scale * static_cast<float>(shadow_map.size));
        small_shadow_map.emplace(device, std::max(size, min_shadow_size));
    }
    return *small_shadow_map;
}

// Returns the materials for a scene that is drawn with them, else null.
const Materials* Renderer::State::materials_for(const Scene& scene) {
    if (!scene.materials) return nullptr;
    pieces.need_corners();
    if (!materials) materials = std::make_unique<Materials>(device, layout, material_sets);
    return materials.get();
}

Frame Renderer::State::begin_frame(FrameSlot& slot, const Scene& scene, const Target& target) {
    const Materials* const drawn_with = materials_for(scene);
    const VkExtent2D render_extent = target.render_extent();
    const ShadowMap& map = shadow_map_for(target);
    const View view{{render_extent.width, render_extent.height},
                    static_cast<float>(target.extent.width) / static_cast<float>(target.extent.height),
                    map.size};
    write_slot(slot, {device, layout, pieces, quality(), view, map.image.view(), drawn_with}, scene);
    Frame frame{.scene = scene,
                .pieces = pieces,
                .max_draws = device.has_multi_draw() ? std::max(device.limits().maxDrawIndirectCount, 1u) : 1,
                .layout = layout,
                .set = slot.set,
                .depth_set = slot.depth_set,
                .occlusion_set = slot.occlusion_set,
                .depth_behind_set = slot.depth_behind_set,
                .behind_glass_set = slot.behind_glass_set,
                .glass_set = slot.glass_set,
                .dust_set = slot.dust_set,
                .materials = drawn_with};
    if (frame.draws_pieces())
        frame.stats = {.pieces = pieces.pieces(),
                       .pieces_in_view = cull ? stats.pieces_in_view : pieces.pieces(),
                       .draws = pieces.draws(),
                       .triangles = pieces.triangles()};
    frame.stats.scale = target.scale;
    frame.scissor = pixel_rect(scene.region, render_extent,
                               (target.scale < 1.0f ? upscale_margin : 0)
                                   + (frame.draws_glass() ? glass_margin(render_extent.height) : 0));
    import_slot(frame, slot, device);
    return frame;
}

void Renderer::State::declare_cull(Frame& frame, FrameSlot& slot, bool for_shadow) {
    slot.culled = cull && frame.draws_pieces();
    if (!slot.culled) return;
    const auto import = [&](const char* name, const DeviceBuffer& buffer) {
        return frame.graph.import_buffer(name, {buffer.size()},
                                         {.initial = {}, .final = {}, .external = frame.external.add(buffer.handle())});
    };
    frame.camera_commands = import("commands for the camera", slot.camera_commands);
    frame.light_commands = import("commands for the light", slot.light_commands);
    frame.visible_counts = frame.graph.import_buffer("pieces in view", {slot.visible_counts.size()},
                                                     {.initial = Access::host_write,
                                                      .final = Access::host_read,
                                                      .external = frame.external.add(slot.visible_counts.handle())});
    cull->declare(frame, for_shadow);
}

// Declares all passes that draw the scene: into frame.picture or, with a scale below 1, into a smaller image that is
// then upscaled into it.
void Renderer::State::declare_scene(Frame& frame, FrameSlot& slot, const Target& target) {
    const ShadowMap& map = shadow_map_for(target);
    frame.shadow =
        frame.graph.import_image("shadow map", {.width = map.size, .height = map.size, .format = Format::d32_float},
                                 {.initial = map.written ? AccessSet(Access::sampled_fragment) : AccessSet(),
                                  .final = Access::sampled_fragment,
                                  .external = frame.external.add(map.image.handle(), map.image.view())});
    const VkExtent2D render_extent = target.render_extent();
    frame.colour = frame.picture;
    if (target.scale < 1.0f)
        frame.colour = frame.graph.create_image(
            "small picture", {.width = render_extent.width, .height = render_extent.height, .format = target.format});
    ImageDesc desc{.width = render_extent.width,
                   .height = render_extent.height,
                   .format = Format::d32_float,
                   .samples = *quality().samples};
    frame.depth = frame.graph.create_image("depth", desc);
    desc.format = target.format;
    if (desc.samples > 1) frame.samples = frame.graph.create_image("colour samples", desc);

    Passes& p = passes_for(target.format);
    const Image result = frame.colour;
    if (frame.draws_glass()) {
        if (!p.glass)
            p.glass.emplace(device, layout.pipeline_layout(),
                            TargetFormat{to_vulkan(target.format), *quality().samples}, quality());
        frame.colour = frame.graph.create_image(
            "picture behind glass",
            {.width = render_extent.width, .height = render_extent.height, .format = target.format});
    }
    const bool shadow = frame.scene.moved || !map.valid;
    declare_cull(frame, slot, shadow);
    if (shadow) p.shadow.declare(frame);
    if (p.occlusion) p.occlusion->declare(frame, render_extent);
    p.shade.declare(frame);
    p.marks.declare(frame, render_extent);
    Image drawn = frame.draws_glass() ? p.glass->declare(frame, result, render_extent) : frame.colour;
    if (frame.dust.valid()) {
        if (!p.dust)
            p.dust.emplace(device, layout.pipeline_layout(),
                           TargetFormat{to_vulkan(target.format), *quality().samples});
        drawn = p.dust->declare(frame, drawn);
    }
    if (target.scale < 1.0f)
        declare_upscale(frame, drawn);
    else
        frame.picture = drawn;
}

void Renderer::State::record(Frame& frame, FrameSlot& slot) {
    CompileResult plan = std::move(frame.graph).compile(slot.executor.memory_needs());
    if (!plan) throw VulkanFailure{{Status::invalid_argument, "a bug in the frame graph: " + plan.error().message}};
    slot.commands.begin();
    vkCmdBindDescriptorSets(slot.commands.buffer(), VK_PIPELINE_BIND_POINT_GRAPHICS, layout.pipeline_layout(), 0, 1,
                            &frame.set, 0, nullptr);
    slot.executor.record(*plan, frame.external, slot.commands.buffer());
    stats = frame.stats;
    dot = to_dot(*plan);
}

// Declares the copy of an image, 4 bytes a pixel, to `readback`.
void Renderer::State::declare_read_back(Frame& frame, Image image, VkExtent2D extent) {
    const uint64_t bytes = uint64_t{4} * extent.width * extent.height;
    if (!readback.handle() || readback.size() < bytes)
        readback = DeviceBuffer(device, "readback", bytes, VK_BUFFER_USAGE_TRANSFER_DST_BIT, MemoryKind::readback);
    Buffer pixels = frame.graph.import_buffer(
        "readback", {readback.size()},
        {.initial = {}, .final = Access::host_read, .external = frame.external.add(readback.handle())});
    frame.graph.add_pass(
        "read back", PassKind::transfer,
        [&](PassBuilder& pass) {
            pass.read(image, Access::transfer_read);
            pixels = pass.write(pixels, Access::transfer_write);
        },
        [image, pixels, extent](PassContext& context) {
            const VkBufferImageCopy region{.imageSubresource = {VK_IMAGE_ASPECT_COLOR_BIT, 0, 0, 1},
                                           .imageExtent = {extent.width, extent.height, 1}};
            vkCmdCopyImageToBuffer(context.commands, context.image(image), VK_IMAGE_LAYOUT_TRANSFER_SRC_OPTIMAL,
                                   context.buffer(pixels), 1, &region);
        });
}

// Submits the recorded frame. Only then does the piece arena count its uploads as done.
void Renderer::State::submit(FrameSlot& slot, CommandSlot::Wait wait, VkSemaphore signal) {
    slot.commands.submit(wait, signal);
    pieces.uploaded(slot.retired);
}

// Updates the state of the shadow map after the submission of a frame that has drawn or read it.
void Renderer::State::shadow_map_submitted(const Target& target) {
    ShadowMap& map = shadow_map_for(target);
    map.written = true;
    map.valid = &map == &shadow_map;
    if (!map.valid) invalidate_shadow_map(); // the scene has moved since the full-size map was drawn
}

// Records and submits the frame, and waits for it.
void Renderer::State::finish(Frame& frame, FrameSlot& slot) {
    record(frame, slot);
    submit(slot, {}, VK_NULL_HANDLE);
    slot.commands.wait();
    collect(slot);
}

Bitmap Renderer::State::draw_off_screen(const Scene& scene, const Target& target) {
    FrameSlot& slot = next_slot();
    const VkExtent2D extent = target.extent;
    Frame frame = begin_frame(slot, scene, target);
    declare_upload(frame);
    frame.picture =
        frame.graph.create_image("colour", {.width = extent.width, .height = extent.height, .format = target.format});
    declare_scene(frame, slot, target);
    declare_read_back(frame, frame.picture, extent);
    finish(frame, slot);
    shadow_map_submitted(target);

    Bitmap bitmap{extent.width, extent.height, std::vector<uint8_t>(size_t{4} * extent.width * extent.height)};
    std::memcpy(bitmap.pixels.data(), readback.mapped(), bitmap.pixels.size());
    return bitmap;
}

IdImage Renderer::State::draw_ids(const Scene& scene, VkExtent2D extent) {
    if (!ids) ids.emplace(device, layout.pipeline_layout());
    FrameSlot& slot = next_slot();
    const Target target{Format::r32_uint, extent};
    Frame frame = begin_frame(slot, scene, target);
    declare_upload(frame);
    declare_cull(frame, slot, false);
    declare_read_back(frame, ids->declare(frame, extent), extent);
    finish(frame, slot);
    if (scene.moved) invalidate_shadow_map(); // this frame has moved the pieces, and drew no shadow map

    IdImage image{extent.width, extent.height, std::vector<uint32_t>(size_t{extent.width} * extent.height)};
    std::memcpy(image.ids.data(), readback.mapped(), image.ids.size() * sizeof(uint32_t));
    return image;
}

bool Renderer::State::draw_in_window(const Scene& scene, const std::function<void()>& draw_ui) {
    const glm::uvec2 size = window->framebuffer_size();
    if (size.x == 0 || size.y == 0) return false;
    const uint32_t slot_index = frame_number % frames_in_flight;
    FrameSlot& slot = next_slot();
    // At most two attempts; if the window changes again meanwhile, the frame is skipped.
    std::optional<uint32_t> image;
    for (int attempt = 0; attempt < 2 && !image; ++attempt) {
        if (swapchain->fit(size)) ui->fit(*swapchain);
        image = swapchain->acquire(slot_index);
    }
    if (!image) return false;

    const Target target{swapchain->format(), swapchain->extent(),
                        swapchain->supports_transfer() ? window_scale(scene) : 1.0f};
    ui->build(draw_ui);
    Frame frame = begin_frame(slot, scene, target);
    declare_upload(frame);
    frame.picture = frame.graph.import_image(
        "swapchain", {.width = target.extent.width, .height = target.extent.height, .format = target.format},
        {.initial = Access::acquired,
         .final = Access::present,
         .external = frame.external.add(swapchain->images()[*image], swapchain->views()[*image])});
    declare_scene(frame, slot, target);
    ui->declare(frame, *image);
    record(frame, slot);
    submit(slot, {swapchain->acquired(slot_index), to_vulkan(Access::acquired).stages}, swapchain->finished(*image));
    shadow_map_submitted(target);
    swapchain->present(*image);
    return true;
}

} // namespace brittle::engine
