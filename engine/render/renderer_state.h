// The state of a Renderer, and the steps of a frame. Internal to the renderer: renderer.cpp is its public face.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "engine/gpu/check.h"
#include "engine/gpu/swapchain.h"
#include "engine/render/cull_pass.h"
#include "engine/render/dust_pass.h"
#include "engine/render/frame_slot.h"
#include "engine/render/glass_pass.h"
#include "engine/render/id_pass.h"
#include "engine/render/marks_pass.h"
#include "engine/render/materials.h"
#include "engine/render/occlusion_pass.h"
#include "engine/render/renderer.h"
#include "engine/render/shade_pass.h"
#include "engine/render/shadow_pass.h"
#include "engine/render/sphere_mesh.h"
#include "engine/render/staging_pool.h"
#include "engine/render/ui_pass.h"

namespace brittle::engine {

inline constexpr uint32_t frames_in_flight = 2;

// The passes that draw into targets of one format.
struct Passes {
    ShadowPass shadow;
    std::optional<OcclusionPass> occlusion; // with Quality::ambient_occlusion
    ShadePass shade;
    MarksPass marks;
    std::optional<GlassPass> glass; // made by the first frame with glass
    std::optional<DustPass> dust;   // made by the first frame with dust
};

// The depth seen from the sun. A window has a smaller second map for frames that are drawn with fewer pixels, because
// drawing the pieces into the map costs as much as drawing them into the picture.
struct ShadowMap {
    ShadowMap(const Device& device, uint32_t size_)
        : size(size_), image(device, "shadow map", {.extent = {size_, size_}}, VK_FORMAT_D32_SFLOAT,
                             VK_IMAGE_USAGE_DEPTH_STENCIL_ATTACHMENT_BIT | VK_IMAGE_USAGE_SAMPLED_BIT) {}

    uint32_t size; // texels a side
    DeviceImage image;
    bool written = false; // a submitted frame drew the map, and may still read it
    bool valid = false;   // the map holds the shadows of the present scene
};

// The target of a frame.
struct Target {
    Format format;
    VkExtent2D extent;
    float scale = 1.0f; // share of the sides that is drawn; below 1, the picture is upscaled

    [[nodiscard]] VkExtent2D render_extent() const {
        const auto scaled = [this](uint32_t pixels) {
            return std::max(static_cast<uint32_t>(std::lround(static_cast<float>(pixels) * scale)), 1u);
        };
        return {scaled(extent.width), scaled(extent.height)};
    }
};

struct Renderer::State {
    State(Device& device_, const RendererSettings& settings_)
        : device(device_), settings(settings_),
          layout(device_, settings_.quality, frames_in_flight, 6 * frames_in_flight), sphere(device_),
          shadow_map(device_, *quality().shadow_size), pieces(device_), staging(device_) {
        if (*quality().culling) cull.emplace(device_, layout.pipeline_layout());
        for (auto& slot : slots) slot = std::make_unique<FrameSlot>(device_, layout);
    }
    ~State() { device.wait_idle(); }

    [[nodiscard]] const Quality& quality() const { return settings.quality; }
    [[nodiscard]] float window_scale(const Scene& scene) const { return scene.moved ? *quality().moving_scale : 1.0f; }
    void invalidate_shadow_map() { shadow_map.valid = false; }

    // Calls a function that returns a Result, like guarded(). After a lost device, returns its Error without the call.
    template<class Function>
    auto run(Function&& function) {
        auto result = lost ? decltype(guarded(function))(*lost) : guarded(function);
        if (!result && result.error().status == Status::device_lost) lost = result.error();
        return result;
    }

    // Each draws one whole frame. draw_in_window() returns false when there was no image to draw into.
    Bitmap draw_off_screen(const Scene& scene, const Target& target);
    IdImage draw_ids(const Scene& scene, VkExtent2D extent);
    bool draw_in_window(const Scene& scene, const std::function<void()>& ui);

    // The steps of a frame, in their order.
    FrameSlot& next_slot();
    const Materials* materials_for(const Scene& scene);
    Frame begin_frame(FrameSlot& slot, const Scene& scene, const Target& target);
    void declare_scene(Frame& frame, FrameSlot& slot, const Target& target);
    void declare_cull(Frame& frame, FrameSlot& slot, bool for_shadow);
    void declare_read_back(Frame& frame, Image image, VkExtent2D extent);
    void record(Frame& frame, FrameSlot& slot);
    void submit(FrameSlot& slot, CommandSlot::Wait wait, VkSemaphore signal);
    void shadow_map_submitted(const Target& target);
    void finish(Frame& frame, FrameSlot& slot);
    void collect(FrameSlot& slot);

    ShadowMap& shadow_map_for(const Target& target);
    Passes& passes_for(Format format);

    Device& device;
    RendererSettings settings; // every member of its quality is set
    FrameLayout layout;
    std::optional<CullPass> cull; // with Quality::culling
    std::optional<IdPass> ids;    // created by the first draw_ids()
    SphereMesh sphere;
    ShadowMap shadow_map;
    std::optional<ShadowMap> small_shadow_map; // created by the first frame with a scale below 1; never valid
    PieceArena pieces;
    std::vector<std::shared_ptr<const MaterialSet>> material_sets;
    std::unique_ptr<Materials> materials; // of these sets; made by the first frame that needs them
    StagingPool staging;
    std::map<Format, Passes> passes; // the window's format may differ from that of render()
    std::array<std::unique_ptr<FrameSlot>, frames_in_flight> slots;
    uint32_t frame_number = 0;
    DeviceBuffer readback;
    Window* window = nullptr;
    std::unique_ptr<Swapchain> swapchain;
    std::unique_ptr<UiPass> ui;

    std::vector<PassTime> timings;
    FrameStats stats;
    std::string dot;
    std::optional<Error> lost; // the error of a lost device; run() returns it also from functions without Vulkan calls
};

} // namespace brittle::engine
