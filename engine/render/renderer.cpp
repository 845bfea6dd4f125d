#include "engine/render/renderer.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <map>

#include <imgui.h>

#include "engine/core/window.h"
#include "engine/gpu/check.h"
#include "engine/gpu/swapchain.h"
#include "engine/graph/access_vulkan.h"
#include "engine/render/cull_pass.h"
#include "engine/render/frame_slot.h"
#include "engine/render/id_pass.h"
#include "engine/render/marks_pass.h"
#include "engine/render/occlusion_pass.h"
#include "engine/render/shade_pass.h"
#include "engine/render/shadow_pass.h"
#include "engine/render/sphere_mesh.h"
#include "engine/render/staging_pool.h"
#include "engine/render/ui_pass.h"
#include "engine/render/upload_pass.h"
#include "engine/render/upscale_pass.h"

namespace brittle::engine {

namespace {

constexpr uint32_t frames_in_flight = 2;
constexpr uint32_t min_shadow_size = 64;
constexpr uint32_t max_shadow_size = 8192;
constexpr float min_scale = 0.25f; // of pixels a side; with fewer, pictures show little more than colours
// Bytes of staging that a slot keeps from frame to frame, so that pieces that trickle in allocate nothing;
// what a large mesh needed is given back.
constexpr uint64_t max_staging_kept = 4 << 20;
// Bytes of a batch from which it gets a buffer of its own: an allocation costs as much as copying fewer.
constexpr uint64_t min_staged_bytes = 64 << 10;

// Fills in what is unset, and checks the rest. The CPU's choices are what lavapipe draws at interactive
// rates: the frame of a bunny at 1280x720 takes 1.5 to 2 times as long with 4 samples, 1.5 times with 16
// taps, 4 to 6 times with occlusion.
Result<Quality> choose_quality(Quality quality, const Device& device) {
    const bool cpu = device.is_cpu();
    if (!quality.shadow_size) quality.shadow_size = cpu ? 1024 : 2048;
    if (!quality.soft_shadows) quality.soft_shadows = !cpu;
    if (!quality.samples) quality.samples = cpu ? 1 : 4;
    if (!quality.ambient_occlusion) quality.ambient_occlusion = !cpu;
    if (!quality.culling) quality.culling = device.has_multi_draw();
    if (!quality.front_to_back) quality.front_to_back = cpu;
    if (!quality.moving_scale) quality.moving_scale = cpu ? 0.5f : 1.0f;

    const uint32_t size = *quality.shadow_size;
    if (size < min_shadow_size || size > std::min(max_shadow_size, device.limits().maxImageDimension2D))
        return Error{Status::invalid_argument,
                     "a shadow map of " + std::to_string(size) + " texels a side is out of range, which is "
                         + std::to_string(min_shadow_size) + " to " + std::to_string(max_shadow_size)};
    // Other numbers are for some devices and formats only; these two are for all.
    if (*quality.samples != 1 && *quality.samples != 4)
        return Error{Status::invalid_argument,
                     std::to_string(*quality.samples) + " samples a pixel cannot be had: 1 or 4 can"};
    if (!(*quality.moving_scale >= min_scale && *quality.moving_scale <= 1.0f))
        return Error{Status::invalid_argument, "a scale of " + std::to_string(*quality.moving_scale)
                                                   + " while things move is out of range, which is 0.25 to 1"};
    return quality;
}

Result<void> check_size(const Device& device, glm::uvec2 size) {
    const uint32_t largest = device.limits().maxImageDimension2D;
    if (size.x == 0 || size.y == 0 || size.x > largest || size.y > largest)
        return Error{Status::invalid_argument, "cannot draw a picture of " + std::to_string(size.x) + " x "
                                                   + std::to_string(size.y) + " pixels: each side must be 1 to "
                                                   + std::to_string(largest)};
    return {};
}

struct Passes {
    ShadowPass shadow;
    std::optional<OcclusionPass> occlusion; // if the quality has it
    ShadePass shade;
    MarksPass marks;
};

// Depths seen from the sun. In a window there is a small one for frames of which fewer pixels are drawn:
// pieces cost it as much as the picture.
struct ShadowMap {
    ShadowMap(const Device& device, uint32_t size_)
        : size(size_), image(device, "shadow map", {size_, size_}, VK_FORMAT_D32_SFLOAT,
                             VK_IMAGE_USAGE_DEPTH_STENCIL_ATTACHMENT_BIT | VK_IMAGE_USAGE_SAMPLED_BIT) {}

    uint32_t size; // texels a side
    DeviceImage image;
    bool written = false; // a submitted frame drew it, and may still read it
    bool valid = false;   // it holds the shadows of the scene as it is
};

// Where a frame goes.
struct Target {
    Format format;
    VkExtent2D extent;
    float scale = 1.0f; // below 1, fewer pixels are drawn, and the picture is enlarged

    [[nodiscard]] VkExtent2D render_extent() const {
        const auto scaled = [this](uint32_t pixels) {
            return std::max(static_cast<uint32_t>(std::lround(static_cast<float>(pixels) * scale)), 1u);
        };
        return {scaled(extent.width), scaled(extent.height)};
    }
};

} // namespace

struct Renderer::State {
    State(Device& device_, const RendererSettings& settings_)
        : device(device_), settings(settings_), layout(device_, frames_in_flight, 2 * frames_in_flight),
          sphere(device_), shadow_map(device_, *quality().shadow_size), pieces(device_), staging(device_) {
        if (*quality().culling) cull.emplace(device_, layout.pipeline_layout());
        for (auto& slot : slots) slot = std::make_unique<FrameSlot>(device_, layout);
    }
    ~State() { device.wait_idle(); }

    [[nodiscard]] const Quality& quality() const { return settings.quality; }
    [[nodiscard]] float window_scale(const Scene& scene) const { return scene.moved ? *quality().moving_scale : 1.0f; }
    ShadowMap& shadow_map_for(const Target& target);
    void invalidate_shadow_map() { shadow_map.valid = false; }
    Passes& passes_for(Format format);
    FrameSlot& next_slot();
    void collect(FrameSlot& slot);
    Frame begin_frame(FrameSlot& slot, const Scene& scene, const Target& target);
    void submit(FrameSlot& slot, CommandSlot::Wait wait, VkSemaphore signal);
    // Calls the function as guarded() does, and remembers a lost device.
    template<class Function>
    auto run(Function&& function) {
        auto result = lost ? decltype(guarded(function))(*lost) : guarded(function);
        if (!result && result.error().status == Status::device_lost) lost = result.error();
        return result;
    }
    void declare_cull(Frame& frame, FrameSlot& slot, bool for_shadow);
    void declare_read_back(Frame& frame, Image image, VkExtent2D extent);
    void declare_scene(Frame& frame, FrameSlot& slot, const Target& target);
    void shadow_map_submitted(const Target& target); // the frame was submitted
    void record(Frame& frame, FrameSlot& slot);
    void finish(Frame& frame, FrameSlot& slot); // records, submits and waits
    Bitmap draw_off_screen(const Scene& scene, const Target& target);
    IdImage draw_ids(const Scene& scene, VkExtent2D extent);
    bool draw_in_window(const Scene& scene, const std::function<void()>& ui);

    Device& device;
    RendererSettings settings; // every member of the quality is set
    FrameLayout layout;
    std::optional<CullPass> cull; // if the quality has it
    std::optional<IdPass> ids;    // once it was asked for
    SphereMesh sphere;
    ShadowMap shadow_map;
    std::optional<ShadowMap> small_shadow_map; // once a frame wants it; never kept
    PieceArena pieces;
    StagingPool staging;
    std::map<Format, Passes> passes; // the window's format may differ from the pictures'
    std::array<std::unique_ptr<FrameSlot>, frames_in_flight> slots;
    uint32_t frame_number = 0;
    DeviceBuffer readback;
    Window* window = nullptr;
    std::unique_ptr<Swapchain> swapchain;
    std::unique_ptr<UiPass> ui;

    std::vector<PassTime> timings;
    FrameStats stats;
    std::string dot;
    std::optional<Error> lost; // once the device was: changes of pieces do not ask it
};

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
                                MarksPass(device, pipeline_layout, target, sphere)})
        .first->second;
}

// Waits until the device is done with the oldest frame, and takes its times.
FrameSlot& Renderer::State::next_slot() {
    FrameSlot& slot = *slots[frame_number++ % frames_in_flight];
    slot.commands.wait();
    slot.retired.clear();
    if (slot.staging.size() > max_staging_kept) slot.staging = {};
    collect(slot);
    return slot;
}

// What the device says of the slot's frame, which it is done with.
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

Frame Renderer::State::begin_frame(FrameSlot& slot, const Scene& scene, const Target& target) {
    const VkExtent2D render_extent = target.render_extent();
    const ShadowMap& map = shadow_map_for(target);
    const View view{{render_extent.width, render_extent.height},
                    static_cast<float>(target.extent.width) / static_cast<float>(target.extent.height),
                    map.size};
    write_slot(slot, {device, layout, pieces, quality(), view, map.image.view()}, scene);
    Frame frame{.scene = scene,
                .pieces = pieces,
                .max_draws = device.has_multi_draw() ? std::max(device.limits().maxDrawIndirectCount, 1u) : 1,
                .layout = layout,
                .set = slot.set,
                .depth_set = slot.depth_set,
                .occlusion_set = slot.occlusion_set};
    if (frame.draws_pieces())
        frame.stats = {.pieces = pieces.pieces(),
                       .pieces_in_view = cull ? stats.pieces_in_view : pieces.pieces(),
                       .draws = pieces.draws(),
                       .triangles = pieces.triangles()};
    frame.stats.scale = target.scale;
    frame.scissor = pixel_rect(scene.region, render_extent, target.scale < 1.0f ? upscale_margin : 0);
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

// Draws into frame.picture, or where there are fewer pixels, into an image that is then enlarged into it.
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

    const Passes& p = passes_for(target.format);
    const bool shadow = frame.scene.moved || !map.valid;
    declare_cull(frame, slot, shadow);
    if (shadow) p.shadow.declare(frame);
    if (p.occlusion) p.occlusion->declare(frame, render_extent);
    p.shade.declare(frame);
    p.marks.declare(frame);
    if (target.scale < 1.0f)
        declare_upscale(frame);
    else
        frame.picture = frame.colour;
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

// Leaves the image's pixels, of 4 bytes, in `readback`.
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

void Renderer::State::submit(FrameSlot& slot, CommandSlot::Wait wait, VkSemaphore signal) {
    slot.commands.submit(wait, signal);
    pieces.uploaded(slot.retired);
}

void Renderer::State::shadow_map_submitted(const Target& target) {
    ShadowMap& map = shadow_map_for(target);
    map.written = true;
    map.valid = &map == &shadow_map;
    if (!map.valid) invalidate_shadow_map(); // things moved since it was drawn
}

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
    if (scene.moved) invalidate_shadow_map(); // the map holds where pieces were before

    IdImage image{extent.width, extent.height, std::vector<uint32_t>(size_t{extent.width} * extent.height)};
    std::memcpy(image.ids.data(), readback.mapped(), image.ids.size() * sizeof(uint32_t));
    return image;
}

bool Renderer::State::draw_in_window(const Scene& scene, const std::function<void()>& draw_ui) {
    const glm::uvec2 size = window->framebuffer_size();
    if (size.x == 0 || size.y == 0) return false;
    const uint32_t slot_index = frame_number % frames_in_flight;
    FrameSlot& slot = next_slot();
    // Twice at most: a window that changes faster than that gets its frame next time.
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

Renderer::Renderer(std::unique_ptr<State> state) : state_(std::move(state)) {}

Renderer::~Renderer() = default;

Result<std::unique_ptr<Renderer>> Renderer::create(Device& device, const RendererSettings& settings) {
    return guarded([&]() -> Result<std::unique_ptr<Renderer>> {
        Result<Quality> quality = choose_quality(settings.quality, device);
        if (!quality) return quality.error();
        return std::unique_ptr<Renderer>(
            new Renderer(std::make_unique<State>(device, RendererSettings{*quality, settings.vsync})));
    });
}

const Quality& Renderer::quality() const {
    return state_->quality();
}

Result<std::vector<PieceHandle>> Renderer::set_pieces(std::span<const PieceMesh> pieces) {
    return state_->run([&]() -> Result<std::vector<PieceHandle>> {
        Result<PieceBatch> batch = PieceBatch::create(pieces);
        if (!batch) return batch.error();
        Result<std::vector<PieceHandle>> handles = state_->pieces.replace_all(*std::move(batch));
        if (!handles) return handles;
        state_->invalidate_shadow_map();
        // A body's number means another body now.
        for (const auto& slot : state_->slots) slot->poses_moment = 0;
        return handles;
    });
}

Result<std::vector<PieceHandle>> Renderer::add_pieces(std::span<const PieceMesh> pieces) {
    Result<PieceBatch> batch = state_->run([&] { return PieceBatch::create(pieces); });
    if (!batch) return batch.error();
    return add_pieces(*std::move(batch));
}

Result<std::vector<PieceHandle>> Renderer::add_pieces(PieceBatch batch) {
    std::vector<PieceBatch> one;
    one.push_back(std::move(batch));
    return add_pieces(std::move(one));
}

Result<std::vector<PieceHandle>> Renderer::add_pieces(std::vector<PieceBatch> batches) {
    return state_->run([&]() -> Result<std::vector<PieceHandle>> {
        Result<std::vector<PieceHandle>> handles = state_->pieces.add(std::move(batches));
        if (handles) state_->invalidate_shadow_map();
        return handles;
    });
}

void Renderer::stage(PieceBatch& batch) const {
    if (batch.staged() || batch.bytes() < min_staged_bytes) return;
    (void)guarded([&]() -> Result<void> {
        batch.move_to(state_->staging.take(batch.bytes()));
        return {};
    });
}

Result<void> Renderer::remove_pieces(std::span<const PieceHandle> handles) {
    return state_->run([&]() -> Result<void> {
        Result<void> removed = state_->pieces.remove(handles);
        if (removed) state_->invalidate_shadow_map();
        return removed;
    });
}

Result<void> Renderer::fade_pieces(std::span<const PieceHandle> handles, float fade) {
    return state_->run([&]() -> Result<void> {
        Result<void> faded = state_->pieces.fade(handles, fade);
        if (faded) state_->invalidate_shadow_map();
        return faded;
    });
}

uint32_t Renderer::body_count() const {
    return state_->pieces.bodies();
}

Result<Bitmap> Renderer::render(const Scene& scene, glm::uvec2 size) {
    return state_->run([&]() -> Result<Bitmap> {
        if (Result<void> valid = check_size(state_->device, size); !valid) return valid.error();
        return state_->draw_off_screen(scene, {Format::rgba8_unorm, {size.x, size.y}});
    });
}

Result<Bitmap> Renderer::render_as_presented(const Scene& scene, glm::uvec2 size) {
    return state_->run([&]() -> Result<Bitmap> {
        if (Result<void> valid = check_size(state_->device, size); !valid) return valid.error();
        return state_->draw_off_screen(scene, {Format::rgba8_unorm, {size.x, size.y}, state_->window_scale(scene)});
    });
}

Result<IdImage> Renderer::render_ids(const Scene& scene, glm::uvec2 size) {
    return state_->run([&]() -> Result<IdImage> {
        if (Result<void> valid = check_size(state_->device, size); !valid) return valid.error();
        return state_->draw_ids(scene, {size.x, size.y});
    });
}

Result<void> Renderer::attach(Window& window, const std::function<void()>& prepare_ui) {
    return state_->run([&]() -> Result<void> {
        if (state_->window) return Error{Status::invalid_argument, "the renderer already draws into a window"};
        auto swapchain = std::make_unique<Swapchain>(state_->device, window, state_->settings.vsync, frames_in_flight);
        state_->ui = std::make_unique<UiPass>(state_->device, window, *swapchain, prepare_ui);
        state_->swapchain = std::move(swapchain);
        state_->window = &window;
        return {};
    });
}

Result<bool> Renderer::present(const Scene& scene, const std::function<void()>& ui) {
    return state_->run([&]() -> Result<bool> {
        if (!state_->window) return Error{Status::invalid_argument, "present() needs attach() first"};
        return state_->draw_in_window(scene, ui);
    });
}

bool Renderer::ui_wants_mouse() const {
    return state_->ui && ImGui::GetIO().WantCaptureMouse;
}

bool Renderer::ui_wants_keyboard() const {
    return state_->ui && ImGui::GetIO().WantCaptureKeyboard;
}

Result<void> Renderer::warm_up() {
    return state_->run([&]() -> Result<void> {
        // Triangles of their own, one of which fades: there may be no piece that makes the driver compile
        // their shaders.
        const glm::vec3 corners[] = {{0.0f, 0.0f, 0.0f}, {1.0f, 0.0f, 0.0f}, {0.0f, 1.0f, 0.0f}};
        const glm::uvec3 triangle(0, 1, 2);
        const PieceMesh piece{.positions = corners, .triangles = {&triangle, 1}, .exterior_triangles = 1};
        const PieceMesh two[] = {piece, piece};
        const Result<std::vector<PieceHandle>> stand_ins = add_pieces(two);
        if (!stand_ins) return stand_ins.error();

        const LineVertex line[] = {{{0.0f, 0.0f, 0.0f}}, {{1.0f, 0.0f, 0.0f}}};
        const Sphere sphere{};
        const Scene scene{.lines = line, .spheres = {&sphere, 1}, .spheres_cast_shadows = true};
        const Format format = state_->swapchain ? state_->swapchain->format() : Format::rgba8_unorm;
        const Result<void> drawn = guarded([&]() -> Result<void> {
            if (Result<void> faded = state_->pieces.fade({&stand_ins->back(), 1}, 0.5f); !faded) return faded;
            (void)state_->draw_off_screen(scene, {format, {16, 16}, state_->window_scale(scene)});
            return {};
        });
        state_->invalidate_shadow_map();
        const Result<void> removed = state_->pieces.remove(*stand_ins);
        return drawn ? removed : drawn;
    });
}

const std::vector<PassTime>& Renderer::timings() const {
    return state_->timings;
}

const FrameStats& Renderer::stats() const {
    return state_->stats;
}

const std::string& Renderer::graph_dot() const {
    return state_->dot;
}

} // namespace brittle::engine
