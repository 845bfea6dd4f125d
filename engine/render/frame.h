// One frame during its declaration and recording: the data that the renderer shares with its passes.
//
// A pass is a class that holds its pipelines and has a function declare(Frame&), which adds the pass to the graph. The
// handles in Frame are the newest versions: a pass that writes an image replaces its handle, and the next pass reads
// the new one.
#pragma once

#include <cstdint>
#include <optional>
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

class Materials;

// The descriptor layout of all graphics and culling shaders, with their samplers. Set 0 serves the whole frame; set 1
// and set 3 hold an image each that a pass reads; set 2 holds the materials of meshes (materials.h).
class FrameLayout {
  public:
    // All members of `quality` are set. Throws VulkanFailure.
    FrameLayout(const Device& device, const Quality& quality, uint32_t frame_sets, uint32_t image_sets);
    ~FrameLayout();
    FrameLayout(const FrameLayout&) = delete;
    FrameLayout& operator=(const FrameLayout&) = delete;

    [[nodiscard]] VkPipelineLayout pipeline_layout() const { return layout_; }
    [[nodiscard]] VkDescriptorSet allocate_frame() const;
    [[nodiscard]] VkDescriptorSet allocate_image() const;
    [[nodiscard]] VkDescriptorSet allocate_materials(VkDescriptorPool pool) const;

    struct Bindings {
        VkBuffer frame, poses, draws;
        VkBuffer commands, culled_for_camera, culled_for_light, visible_counts; // for the cull pass
        VkDeviceSize commands_size; // bytes; the cull pass derives the number of commands from it
        VkImageView shadow;
    };
    struct MaterialBindings {
        VkBuffer materials;
        VkImageView base_colours, normal_maps;
        VkSampler sampler;
    };
    // Write the descriptors of a set. No submitted frame may use the set.
    void update(VkDescriptorSet set, const Bindings& bindings) const;
    void update(VkDescriptorSet set, VkImageView image) const;
    void update(VkDescriptorSet set, const MaterialBindings& bindings) const;

  private:
    void create(const Quality& quality, uint32_t frame_sets, uint32_t image_sets);
    [[nodiscard]] VkDescriptorSet allocate(VkDescriptorPool pool, VkDescriptorSetLayout set_layout) const;
    void destroy();

    const Device& device_;
    VkSampler shadow_sampler_ = VK_NULL_HANDLE;
    VkSampler image_sampler_ = VK_NULL_HANDLE;
    VkDescriptorSetLayout frame_set_layout_ = VK_NULL_HANDLE;
    VkDescriptorSetLayout image_set_layout_ = VK_NULL_HANDLE;
    VkDescriptorSetLayout material_set_layout_ = VK_NULL_HANDLE;
    VkPipelineLayout layout_ = VK_NULL_HANDLE;
    VkDescriptorPool pool_ = VK_NULL_HANDLE;
};

// Returns the first surface of clear glass; 0 is the look of the scene. There is none without materials, nor where cuts
// have a texture.
[[nodiscard]] std::optional<uint32_t> glass_surface(const Scene& scene, const Materials* materials);

struct Frame {
    FrameGraph graph;
    External external;
    const Scene& scene;
    const PieceArena& pieces;
    uint32_t max_draws; // the device's limit of draws in one multi-draw
    const FrameLayout& layout;
    VkDescriptorSet set; // set 0, bound for the whole frame
    // For sets 1 and 3; a pass writes and binds one with bind_image().
    VkDescriptorSet depth_set, occlusion_set, depth_behind_set, behind_glass_set, glass_set, dust_set;
    const Materials* materials = nullptr; // in the view of materials; else null
    FrameStats stats;
    VkRect2D scissor{}; // the drawn pixels: Scene::region and, if the picture is upscaled, a margin

    // Imports. Those of the pieces are valid only if there is a draw range or an upload.
    Buffer uniforms, poses, vertices, normals, indices, draw_data, commands;
    Buffer corners; // valid if the arena has any: in the view of materials, and with pieces that have some
    // The draw commands of each view: the output of the cull pass or, without it, all commands.
    Buffer camera_commands, light_commands;
    Buffer visible_counts;                  // number of visible pieces of each view; valid if there is a cull pass
    Buffer lines, spheres, splinters, dust; // valid if the scene has any
    Image shadow;
    // Targets. With multisampling, passes draw into `samples` and the last one resolves it into `colour`; otherwise
    // `samples` is invalid and passes draw into `colour`.
    Image colour, depth, samples;
    Image occlusion; // valid with Quality::ambient_occlusion
    Image picture;   // the picture to show: `colour`, or the image into which glass is drawn or `colour` is upscaled

    PieceUpload upload;         // the geometry to copy before anything is drawn
    Buffer staging;             // the source of the copies; valid if upload.staging_size is not 0
    std::vector<Buffer> staged; // parallel to upload.staged

    // For the passes that draw into the target; `last` marks the last of them, which resolves the samples.
    void write_colour(PassBuilder& pass, Access access, bool last);
    [[nodiscard]] Rendering colour_rendering(const PassContext& context, VkAttachmentLoadOp load, bool last) const;

    // Writes the image into a descriptor set and binds it as set 1 or 3, in a pass that reads the image.
    void bind_image(const PassContext& context, VkDescriptorSet to, Image image, uint32_t as = 1) const;

    [[nodiscard]] bool draws_marks() const { return lines.valid() || spheres.valid(); }
    // Whether pieces may be clear glass, which the glass pass draws.
    [[nodiscard]] bool draws_glass() const { return draws_pieces() && glass_surface(scene, materials).has_value(); }
    [[nodiscard]] bool draws_pieces() const { return scene.pieces_visible && pieces.draws() != 0; }
};

// The properties of the target that pipelines need.
struct TargetFormat {
    VkFormat colour;
    uint32_t samples;
};

// The sizes that frame_data() needs beside the scene.
struct View {
    glm::uvec2 size;      // drawn pixels
    float aspect;         // width / height of the target; that of `size` may differ by rounding
    uint32_t shadow_size; // shadow map texels a side
};
// Returns the pixels that a region covers in a picture of `size`, with `margin` pixels around them, clamped to the
// picture.
[[nodiscard]] VkRect2D pixel_rect(const Region& region, VkExtent2D size, int32_t margin);

// Returns the uniform data of a frame. `materials` is null unless the scene is drawn with them.
[[nodiscard]] shared::FrameData frame_data(const Scene& scene, const View& view, const Materials* materials = nullptr);

// For the passes that draw pieces: read_pieces() declares their reads, and draw_pieces() records the multi-draws of one
// view's commands, first the solid pieces, then the fading ones. Without a pipeline for fading pieces, they are
// skipped.
void read_pieces(const Frame& frame, PassBuilder& pass, Buffer commands);
struct PiecePipelines {
    const Pipeline& solid;
    const Pipeline* fading = nullptr; // its fragment shader discards pixels
};
// In the view of materials: bind set 2, normals and corner attributes for the pipelines of material_input.h.
void read_materials(const Frame& frame, PassBuilder& pass);
void bind_materials(const Frame& frame, const PassContext& context);
void draw_pieces(Frame& frame, const PassContext& context, Buffer commands, const PiecePipelines& pipelines);

// Where pieces touch, the interior face of one and the exterior face of another may have equal depth in a pixel of the
// seam. LESS keeps the face drawn first, which is the exterior when pieces are drawn from front to back, so the seam
// has no specks of the interior's colour.
inline constexpr VkCompareOp piece_depth_test = VK_COMPARE_OP_LESS;

// The specialization constant of pipelines for fading pieces.
struct FadingConstant {
    VkBool32 fading = VK_TRUE;
    VkSpecializationMapEntry entry{shared::constant_fading, 0, sizeof(VkBool32)};
    VkSpecializationInfo info{1, &entry, sizeof(VkBool32), &fading};

    FadingConstant() = default;
    FadingConstant(const FadingConstant&) = delete; // `info` points to the other members
    FadingConstant& operator=(const FadingConstant&) = delete;
};

} // namespace brittle::engine
