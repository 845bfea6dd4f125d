// One frame while it is declared and recorded: what the renderer hands to its passes.
//
// A pass is a class with its pipelines, and one function, declare(Frame&), that adds it to the graph. Frame's
// handles are always the newest versions: a pass that writes an image replaces the handle here, and the next
// pass goes on from there.
#pragma once

#include <cstdint>
#include <vector>

#include <glm/vec2.hpp>
#include <vulkan/vulkan.h>

#include "engine/gpu/pipeline.h"
#include "engine/graph/execute.h"
#include "engine/render/piece_arena.h"
#include "engine/render/renderer.h"
#include "engine/render/scene.h"
#include "shaders/shared.h"

namespace brittle::engine {

// The layout of descriptors that all shaders use, and their samplers. Set 0 is for the whole frame; set 1
// holds one image that a pass reads.
class FrameLayout {
  public:
    FrameLayout(const Device& device, uint32_t frame_sets, uint32_t image_sets); // throws VulkanFailure
    ~FrameLayout();
    FrameLayout(const FrameLayout&) = delete;
    FrameLayout& operator=(const FrameLayout&) = delete;

    [[nodiscard]] VkPipelineLayout pipeline_layout() const { return layout_; }
    [[nodiscard]] VkDescriptorSet allocate_frame() const;
    [[nodiscard]] VkDescriptorSet allocate_image() const;

    struct Bindings {
        VkBuffer frame, poses, draws;
        VkBuffer commands, culled_for_camera, culled_for_light, visible_counts; // for the cull pass
        VkDeviceSize commands_size; // bytes: the cull pass takes the number of commands from it
        VkImageView shadow;
    };
    // Point a set, which no submitted frame may be using, at these.
    void update(VkDescriptorSet set, const Bindings& bindings) const;
    void update(VkDescriptorSet set, VkImageView image) const;

  private:
    void create(uint32_t frame_sets, uint32_t image_sets);
    [[nodiscard]] VkDescriptorSet allocate(VkDescriptorSetLayout set_layout) const;
    void destroy();

    const Device& device_;
    VkSampler shadow_sampler_ = VK_NULL_HANDLE;
    VkSampler image_sampler_ = VK_NULL_HANDLE;
    VkDescriptorSetLayout frame_set_layout_ = VK_NULL_HANDLE;
    VkDescriptorSetLayout image_set_layout_ = VK_NULL_HANDLE;
    VkPipelineLayout layout_ = VK_NULL_HANDLE;
    VkDescriptorPool pool_ = VK_NULL_HANDLE;
};

struct Frame {
    FrameGraph graph;
    External external;
    const Scene& scene;
    const PieceArena& pieces;
    uint32_t max_draws; // in one multi-draw, by the device's limit
    const FrameLayout& layout;
    VkDescriptorSet set;                      // set 0
    VkDescriptorSet depth_set, occlusion_set; // for set 1, unused so far
    FrameStats stats;
    VkRect2D scissor{}; // of the pixels that are drawn: Scene::region, and a rim for what enlarges it

    // Imports. Those of the arena are valid only if it holds a draw.
    Buffer uniforms, poses, vertices, normals, indices, draw_data, commands;
    // What each view draws: the cull pass's work or, without one, all commands.
    Buffer camera_commands, light_commands;
    Buffer visible_counts; // counts of pieces, by view; valid if there is a cull pass
    Buffer lines, spheres; // valid if the scene has any
    Image shadow;
    // Targets. Without multisampling `samples` names nothing, and `colour` is drawn into itself.
    Image colour, depth, samples;
    Image occlusion; // valid if the quality has it
    Image picture;   // what is shown: `colour`, or another one into which that is enlarged

    PieceUpload upload;         // of geometry, before anything is drawn
    Buffer staging;             // what is to be uploaded; valid if upload.staging_size is not 0
    std::vector<Buffer> staged; // upload.staged

    // For the passes that draw into the target: the last of them resolves the samples.
    void write_colour(PassBuilder& pass, Access access, bool last);
    [[nodiscard]] Rendering colour_rendering(const PassContext& context, VkAttachmentLoadOp load, bool last) const;

    // Within a pass that reads the image: points a set at it and binds that as set 1.
    void bind_image(const PassContext& context, VkDescriptorSet to, Image image) const;

    [[nodiscard]] bool draws_marks() const { return lines.valid() || spheres.valid(); }
    [[nodiscard]] bool draws_pieces() const { return scene.pieces_visible && pieces.draws() != 0; }
};

// What pipelines that draw into the target must know of it.
struct TargetFormat {
    VkFormat colour;
    uint32_t samples;
};

// What the shaders are told about a scene.
struct View {
    glm::uvec2 size;      // pixels that are drawn
    float aspect;         // width / height of the picture that they make: the size may be rounded
    uint32_t shadow_size; // texels a side
};
// The pixels of a region in a picture of that size, with so many around them; those that it has.
[[nodiscard]] VkRect2D pixel_rect(const Region& region, VkExtent2D size, int32_t margin);

[[nodiscard]] shared::FrameData frame_data(const Scene& scene, const View& view);

// For the passes that draw pieces: their reads, and the multi-draws by the commands of one view, one with each pipeline
// that has pieces to draw. Without a pipeline for them, pieces that fade are left out.
void read_pieces(const Frame& frame, PassBuilder& pass, Buffer commands);
struct PiecePipelines {
    const Pipeline& solid;
    const Pipeline* fading = nullptr; // its fragment shader leaves pixels out
};
void draw_pieces(Frame& frame, const PassContext& context, Buffer commands, const PiecePipelines& pipelines);

// Where pieces touch, the cut of one and the exterior of another may be equally deep in a pixel of the seam. The first
// drawn stays: from front to back that is the exterior, and the seam has no specks of the interior's colour.
inline constexpr VkCompareOp piece_depth_test = VK_COMPARE_OP_LESS;

// The specialization that fading pipelines share, beside what else the shader has.
struct FadingConstant {
    VkBool32 fading = VK_TRUE;
    VkSpecializationMapEntry entry{shared::constant_fading, 0, sizeof(VkBool32)};
    VkSpecializationInfo info{1, &entry, sizeof(VkBool32), &fading};

    FadingConstant() = default;
    FadingConstant(const FadingConstant&) = delete; // it points into itself
    FadingConstant& operator=(const FadingConstant&) = delete;
};

} // namespace brittle::engine
