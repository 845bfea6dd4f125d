#include "engine/render/frame.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <limits>

#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <glm/gtc/matrix_transform.hpp>

#include "engine/gpu/check.h"
#include "engine/render/materials.h"

namespace brittle::engine {

FrameLayout::FrameLayout(const Device& device, const Quality& quality, uint32_t frame_sets, uint32_t image_sets)
    : device_(device) {
    try {
        create(quality, frame_sets, image_sets);
    } catch (...) {
        destroy();
        throw;
    }
}

FrameLayout::~FrameLayout() {
    destroy();
}

void FrameLayout::create(const Quality& quality, uint32_t frame_sets, uint32_t image_sets) {
    // Linear filtering of a depth comparison is 2x2 percentage-closer filtering, which softens shadows further and
    // costs nothing on a GPU. A CPU device pays for each tap. Hard shadows look alike on all devices.
    const VkFilter filter = *quality.soft_shadows && !device_.is_cpu() ? VK_FILTER_LINEAR : VK_FILTER_NEAREST;
    const VkSamplerCreateInfo sampler{.sType = VK_STRUCTURE_TYPE_SAMPLER_CREATE_INFO,
                                      .magFilter = filter,
                                      .minFilter = filter,
                                      .mipmapMode = VK_SAMPLER_MIPMAP_MODE_NEAREST,
                                      .addressModeU = VK_SAMPLER_ADDRESS_MODE_CLAMP_TO_BORDER,
                                      .addressModeV = VK_SAMPLER_ADDRESS_MODE_CLAMP_TO_BORDER,
                                      .addressModeW = VK_SAMPLER_ADDRESS_MODE_CLAMP_TO_BORDER,
                                      .compareEnable = VK_TRUE,
                                      .compareOp = VK_COMPARE_OP_LESS_OR_EQUAL,
                                      .borderColor = VK_BORDER_COLOR_FLOAT_OPAQUE_WHITE};
    check(vkCreateSampler(device_.handle(), &sampler, nullptr, &shadow_sampler_), "create a sampler");
    // A sampler for texelFetch(), which ignores it.
    const VkSamplerCreateInfo plain{.sType = VK_STRUCTURE_TYPE_SAMPLER_CREATE_INFO};
    check(vkCreateSampler(device_.handle(), &plain, nullptr, &image_sampler_), "create a sampler");

    constexpr VkShaderStageFlags compute = VK_SHADER_STAGE_COMPUTE_BIT;
    constexpr VkShaderStageFlags vertex = VK_SHADER_STAGE_VERTEX_BIT | compute;
    constexpr VkShaderStageFlags all = VK_SHADER_STAGE_FRAGMENT_BIT | vertex;
    constexpr VkDescriptorType storage = VK_DESCRIPTOR_TYPE_STORAGE_BUFFER;
    const VkDescriptorSetLayoutBinding bindings[] = {
        {shared::binding_frame, VK_DESCRIPTOR_TYPE_UNIFORM_BUFFER, 1, all, nullptr},
        {shared::binding_poses, storage, 1, vertex, nullptr},
        {shared::binding_draws, storage, 1, vertex, nullptr},
        {shared::binding_commands, storage, 1, compute, nullptr},
        {shared::binding_culled_for_camera, storage, 1, compute, nullptr},
        {shared::binding_culled_for_light, storage, 1, compute, nullptr},
        {shared::binding_visible_counts, storage, 1, compute, nullptr},
        {shared::binding_shadow, VK_DESCRIPTOR_TYPE_COMBINED_IMAGE_SAMPLER, 1, VK_SHADER_STAGE_FRAGMENT_BIT,
         &shadow_sampler_}};
    const VkDescriptorSetLayoutCreateInfo set_layout{.sType = VK_STRUCTURE_TYPE_DESCRIPTOR_SET_LAYOUT_CREATE_INFO,
                                                     .bindingCount = static_cast<uint32_t>(std::size(bindings)),
                                                     .pBindings = bindings};
    check(vkCreateDescriptorSetLayout(device_.handle(), &set_layout, nullptr, &frame_set_layout_),
          "create a descriptor set layout");
    const VkDescriptorSetLayoutBinding image{shared::binding_image, VK_DESCRIPTOR_TYPE_COMBINED_IMAGE_SAMPLER, 1,
                                             VK_SHADER_STAGE_FRAGMENT_BIT, &image_sampler_};
    const VkDescriptorSetLayoutCreateInfo image_layout{
        .sType = VK_STRUCTURE_TYPE_DESCRIPTOR_SET_LAYOUT_CREATE_INFO, .bindingCount = 1, .pBindings = &image};
    check(vkCreateDescriptorSetLayout(device_.handle(), &image_layout, nullptr, &image_set_layout_),
          "create a descriptor set layout");
    constexpr VkDescriptorType sampled = VK_DESCRIPTOR_TYPE_COMBINED_IMAGE_SAMPLER;
    const VkDescriptorSetLayoutBinding of_materials[] = {
        {shared::binding_mesh_materials, storage, 1, VK_SHADER_STAGE_FRAGMENT_BIT, nullptr},
        {shared::binding_base_colours, sampled, 1, VK_SHADER_STAGE_FRAGMENT_BIT, nullptr},
        {shared::binding_normal_maps, sampled, 1, VK_SHADER_STAGE_FRAGMENT_BIT, nullptr}};
    const VkDescriptorSetLayoutCreateInfo material_layout{.sType = VK_STRUCTURE_TYPE_DESCRIPTOR_SET_LAYOUT_CREATE_INFO,
                                                          .bindingCount =
                                                              static_cast<uint32_t>(std::size(of_materials)),
                                                          .pBindings = of_materials};
    check(vkCreateDescriptorSetLayout(device_.handle(), &material_layout, nullptr, &material_set_layout_),
          "create a descriptor set layout");
    const VkDescriptorSetLayout set_layouts[] = {frame_set_layout_, image_set_layout_, material_set_layout_,
                                                 image_set_layout_};
    const VkPipelineLayoutCreateInfo layout{.sType = VK_STRUCTURE_TYPE_PIPELINE_LAYOUT_CREATE_INFO,
                                            .setLayoutCount = static_cast<uint32_t>(std::size(set_layouts)),
                                            .pSetLayouts = set_layouts};
    check(vkCreatePipelineLayout(device_.handle(), &layout, nullptr, &layout_), "create a pipeline layout");

    const VkDescriptorPoolSize sizes[] = {{VK_DESCRIPTOR_TYPE_UNIFORM_BUFFER, frame_sets},
                                          {VK_DESCRIPTOR_TYPE_STORAGE_BUFFER, 6 * frame_sets},
                                          {VK_DESCRIPTOR_TYPE_COMBINED_IMAGE_SAMPLER, frame_sets + image_sets}};
    const VkDescriptorPoolCreateInfo pool{.sType = VK_STRUCTURE_TYPE_DESCRIPTOR_POOL_CREATE_INFO,
                                          .maxSets = frame_sets + image_sets,
                                          .poolSizeCount = static_cast<uint32_t>(std::size(sizes)),
                                          .pPoolSizes = sizes};
    check(vkCreateDescriptorPool(device_.handle(), &pool, nullptr, &pool_), "create a descriptor pool");
}

void FrameLayout::destroy() {
    vkDestroyDescriptorPool(device_.handle(), pool_, nullptr);
    vkDestroyPipelineLayout(device_.handle(), layout_, nullptr);
    vkDestroyDescriptorSetLayout(device_.handle(), frame_set_layout_, nullptr);
    vkDestroyDescriptorSetLayout(device_.handle(), image_set_layout_, nullptr);
    vkDestroyDescriptorSetLayout(device_.handle(), material_set_layout_, nullptr);
    vkDestroySampler(device_.handle(), image_sampler_, nullptr);
    vkDestroySampler(device_.handle(), shadow_sampler_, nullptr);
}

VkDescriptorSet FrameLayout::allocate_frame() const {
    return allocate(pool_, frame_set_layout_);
}

VkDescriptorSet FrameLayout::allocate_image() const {
    return allocate(pool_, image_set_layout_);
}

VkDescriptorSet FrameLayout::allocate_materials(VkDescriptorPool pool) const {
    return allocate(pool, material_set_layout_);
}

VkDescriptorSet FrameLayout::allocate(VkDescriptorPool pool, VkDescriptorSetLayout set_layout) const {
    const VkDescriptorSetAllocateInfo info{.sType = VK_STRUCTURE_TYPE_DESCRIPTOR_SET_ALLOCATE_INFO,
                                           .descriptorPool = pool,
                                           .descriptorSetCount = 1,
                                           .pSetLayouts = &set_layout};
    VkDescriptorSet set = VK_NULL_HANDLE;
    check(vkAllocateDescriptorSets(device_.handle(), &info, &set), "allocate a descriptor set");
    return set;
}

void FrameLayout::update(VkDescriptorSet set, const Bindings& bindings) const {
    const VkDescriptorBufferInfo frame{bindings.frame, 0, VK_WHOLE_SIZE};
    const VkDescriptorBufferInfo poses{bindings.poses, 0, VK_WHOLE_SIZE};
    const VkDescriptorBufferInfo draws{bindings.draws, 0, VK_WHOLE_SIZE};
    const VkDescriptorBufferInfo commands{bindings.commands, 0, bindings.commands_size};
    const VkDescriptorBufferInfo for_camera{bindings.culled_for_camera, 0, VK_WHOLE_SIZE};
    const VkDescriptorBufferInfo for_light{bindings.culled_for_light, 0, VK_WHOLE_SIZE};
    const VkDescriptorBufferInfo visible_counts{bindings.visible_counts, 0, VK_WHOLE_SIZE};
    const VkDescriptorImageInfo shadow{VK_NULL_HANDLE, bindings.shadow, VK_IMAGE_LAYOUT_READ_ONLY_OPTIMAL};
    const auto write = [set](uint32_t binding, VkDescriptorType type, const VkDescriptorBufferInfo* buffer,
                             const VkDescriptorImageInfo* image) {
        return VkWriteDescriptorSet{.sType = VK_STRUCTURE_TYPE_WRITE_DESCRIPTOR_SET,
                                    .dstSet = set,
                                    .dstBinding = binding,
                                    .descriptorCount = 1,
                                    .descriptorType = type,
                                    .pImageInfo = image,
                                    .pBufferInfo = buffer};
    };
    const VkWriteDescriptorSet writes[] = {
        write(shared::binding_frame, VK_DESCRIPTOR_TYPE_UNIFORM_BUFFER, &frame, nullptr),
        write(shared::binding_poses, VK_DESCRIPTOR_TYPE_STORAGE_BUFFER, &poses, nullptr),
        write(shared::binding_draws, VK_DESCRIPTOR_TYPE_STORAGE_BUFFER, &draws, nullptr),
        write(shared::binding_commands, VK_DESCRIPTOR_TYPE_STORAGE_BUFFER, &commands, nullptr),
        write(shared::binding_culled_for_camera, VK_DESCRIPTOR_TYPE_STORAGE_BUFFER, &for_camera, nullptr),
        write(shared::binding_culled_for_light, VK_DESCRIPTOR_TYPE_STORAGE_BUFFER, &for_light, nullptr),
        write(shared::binding_visible_counts, VK_DESCRIPTOR_TYPE_STORAGE_BUFFER, &visible_counts, nullptr),
        write(shared::binding_shadow, VK_DESCRIPTOR_TYPE_COMBINED_IMAGE_SAMPLER, nullptr, &shadow)};
    vkUpdateDescriptorSets(device_.handle(), static_cast<uint32_t>(std::size(writes)), writes, 0, nullptr);
}

void FrameLayout::update(VkDescriptorSet set, VkImageView image) const {
    const VkDescriptorImageInfo info{VK_NULL_HANDLE, image, VK_IMAGE_LAYOUT_READ_ONLY_OPTIMAL};
    const VkWriteDescriptorSet write{.sType = VK_STRUCTURE_TYPE_WRITE_DESCRIPTOR_SET,
                                     .dstSet = set,
                                     .dstBinding = shared::binding_image,
                                     .descriptorCount = 1,
                                     .descriptorType = VK_DESCRIPTOR_TYPE_COMBINED_IMAGE_SAMPLER,
                                     .pImageInfo = &info};
    vkUpdateDescriptorSets(device_.handle(), 1, &write, 0, nullptr);
}

void FrameLayout::update(VkDescriptorSet set, const MaterialBindings& bindings) const {
    const VkDescriptorBufferInfo materials{bindings.materials, 0, VK_WHOLE_SIZE};
    const VkDescriptorImageInfo images[] = {
        {bindings.sampler, bindings.base_colours, VK_IMAGE_LAYOUT_READ_ONLY_OPTIMAL},
        {bindings.sampler, bindings.normal_maps, VK_IMAGE_LAYOUT_READ_ONLY_OPTIMAL}};
    const VkWriteDescriptorSet writes[] = {{.sType = VK_STRUCTURE_TYPE_WRITE_DESCRIPTOR_SET,
                                            .dstSet = set,
                                            .dstBinding = shared::binding_mesh_materials,
                                            .descriptorCount = 1,
                                            .descriptorType = VK_DESCRIPTOR_TYPE_STORAGE_BUFFER,
                                            .pBufferInfo = &materials},
                                           {.sType = VK_STRUCTURE_TYPE_WRITE_DESCRIPTOR_SET,
                                            .dstSet = set,
                                            .dstBinding = shared::binding_base_colours,
                                            .descriptorCount = 1,
                                            .descriptorType = VK_DESCRIPTOR_TYPE_COMBINED_IMAGE_SAMPLER,
                                            .pImageInfo = &images[0]},
                                           {.sType = VK_STRUCTURE_TYPE_WRITE_DESCRIPTOR_SET,
                                            .dstSet = set,
                                            .dstBinding = shared::binding_normal_maps,
                                            .descriptorCount = 1,
                                            .descriptorType = VK_DESCRIPTOR_TYPE_COMBINED_IMAGE_SAMPLER,
                                            .pImageInfo = &images[1]}};
    vkUpdateDescriptorSets(device_.handle(), static_cast<uint32_t>(std::size(writes)), writes, 0, nullptr);
}

namespace {

struct ShadowFit {
    glm::mat4 clip_from_world;
    float texel; // side of a texel, metres
    float depth; // distance from the near to the far plane, metres
};

// Returns the tightest box around the casters in the light's frame. Receivers need not be inside: a receiver behind a
// caster has the caster's texture coordinates, and a depth beyond the far plane is clamped to it.
ShadowFit fit_shadow(const Bounds& bounds, glm::vec3 to_light, uint32_t size) {
    const glm::vec3 up = std::abs(to_light.y) < 0.99f ? glm::vec3(0.0f, 1.0f, 0.0f) : glm::vec3(0.0f, 0.0f, 1.0f);
    const glm::vec3 centre = bounds.centre();
    const glm::mat4 view = glm::lookAt(centre + to_light, centre, up);
    glm::vec3 low(std::numeric_limits<float>::max()), high(-low);
    for (int corner = 0; corner < 8; ++corner) {
        const glm::vec3 p(corner & 1 ? bounds.max.x : bounds.min.x, corner & 2 ? bounds.max.y : bounds.min.y,
                          corner & 4 ? bounds.max.z : bounds.min.z);
        const glm::vec3 q(view * glm::vec4(p, 1.0f));
        low = glm::min(low, q);
        high = glm::max(high, q);
    }
    // A margin of a few texels, which filters read beyond the last caster, and a minimum size for flat or empty bounds.
    const float extent = std::max({high.x - low.x, high.y - low.y, high.z - low.z, 1e-5f});
    const float margin = extent * 4.0f / static_cast<float>(size);
    low -= margin;
    high += margin;
    const float width = std::max(high.x - low.x, high.y - low.y);
    return {glm::orthoRH_ZO(low.x, high.x, low.y, high.y, -high.z, -low.z) * view, width / static_cast<float>(size),
            high.z - low.z};
}

} // namespace

VkRect2D pixel_rect(const Region& region, VkExtent2D size, int32_t margin) {
    assert(std::isfinite(region.min.x + region.min.y + region.max.x + region.max.y));
    const glm::vec2 pixels(size.width, size.height);
    const auto within = [&](glm::vec2 p) { return glm::ivec2(glm::clamp(p, glm::vec2(0.0f), pixels)); };
    const auto apart = static_cast<float>(margin);
    const glm::ivec2 low = within(glm::floor(region.min * pixels) - apart);
    const glm::ivec2 high = glm::max(within(glm::ceil(region.max * pixels) + apart), low);
    return {{low.x, low.y}, {static_cast<uint32_t>(high.x - low.x), static_cast<uint32_t>(high.y - low.y)}};
}

std::optional<uint32_t> glass_surface(const Scene& scene, const Materials* materials) {
    if (!materials || materials->cut_layer() != 0) return std::nullopt;
    if (scene.look.grain == Grain::glass) return 0;
    for (uint32_t surface = 1; surface <= scene.surfaces.size(); ++surface)
        if (scene.surfaces[surface - 1].grain == Grain::glass) return surface;
    return std::nullopt;
}

shared::FrameData frame_data(const Scene& scene, const View& view, const Materials* materials) {
    const CameraMatrices camera = matrices(scene.camera, view.aspect, scene.bounds);
    const glm::vec3 eye(glm::inverse(camera.view)[3]);
    const glm::mat4 eye_to_world = glm::translate(glm::mat4(1.0f), eye);

    const Look& look = scene.look;
    const float length = glm::length(look.to_light);
    const glm::vec3 to_light = length > 0.0f ? look.to_light / length : glm::vec3(0.0f, 1.0f, 0.0f);
    const ShadowFit shadow = fit_shadow(scene.bounds, to_light, view.shadow_size);
    const glm::mat4 texture_from_clip = glm::translate(glm::mat4(1.0f), glm::vec3(0.5f, 0.5f, 0.0f))
                                        * glm::scale(glm::mat4(1.0f), glm::vec3(0.5f, 0.5f, 1.0f));

    // Against shadow acne: an offset along the normal for sloped surfaces, and a depth bias for rounding. Both are in
    // texels, because the error is proportional to the texel's size.
    constexpr float normal_offset_texels = 1.6f;
    constexpr float bias_texels = 0.6f;
    // The ground fades out between these multiples of the distance to the target, so that it looks alike at any zoom.
    constexpr float fade_begin = 0.9f;
    constexpr float fade_end = 3.5f;
    // The height of the zone that the ground darkens, as a share of the scene's height; shade() in light.glsl.
    constexpr float ground_darkens = 0.35f;
    // Ambient occlusion (occlusion.frag), chosen by eye. The reach is a share of the scene's height, because pieces
    // that roll away do not change it; the bias is a sine.
    constexpr float occlusion_reach = 0.25f;
    constexpr float occlusion_bias = 0.12f;
    constexpr float occlusion_strength = 14.0f;

    const float reach = glm::length(scene.camera.target - eye);
    const float height = std::max(scene.bounds.size().y, 1e-5f);
    const float pixels_a_metre = 0.5f * static_cast<float>(view.size.y) * std::abs(camera.projection[1][1]);
    const glm::mat4 clip_from_eye = camera.projection * glm::mat4(glm::mat3(camera.view));
    shared::FrameData data{
        .clip_from_eye = clip_from_eye,
        .eye_from_clip = glm::inverse(clip_from_eye),
        .shadow_from_eye = texture_from_clip * shadow.clip_from_world * eye_to_world,
        .shadow_clip_from_world = shadow.clip_from_world,
        .eye = {eye, 1.0f / static_cast<float>(view.size.y)},
        .to_light = {to_light, normal_offset_texels * shadow.texel},
        .sun = {look.sun, bias_texels * shadow.texel / shadow.depth},
        .sky = {look.sky, ground_darkens * height},
        .bounce = {look.bounce, 1.0f / static_cast<float>(view.shadow_size)},
        .materials = {},
        .sphere = {look.sphere, 0.0f},
        .ground = {look.ground, scene.ground_height},
        .ground_disc = {scene.camera.target.x, scene.camera.target.z, fade_begin * reach, fade_end * reach},
        .background_top = {look.background_top, look.exposure},
        .background_bottom = {look.background_bottom, 0.0f},
        .cuts = {materials ? static_cast<float>(materials->cut_layer()) : 0.0f, scene.smooth ? 1.0f : 0.0f, 0.0f, 0.0f},
        .occlusion = {occlusion_reach * height, pixels_a_metre, occlusion_bias, occlusion_strength},
        .glass = {}};
    if (const std::optional<uint32_t> glass = glass_surface(scene, materials))
        data.glass = {*glass == 0 ? look.exterior : scene.surfaces[*glass - 1].exterior, 1.0f};
    for (uint32_t surface = 0; surface < shared::max_surfaces; ++surface) {
        const bool own = surface > 0 && surface <= scene.surfaces.size();
        const SurfaceLook from =
            own ? scene.surfaces[surface - 1] : SurfaceLook{look.exterior, look.interior, look.tint, look.grain};
        const auto grain = static_cast<float>(from.grain);
        data.materials[2 * surface + shared::material_exterior] = {from.exterior, materials ? 0.0f : from.tint};
        data.materials[2 * surface + shared::material_interior] = {from.interior,
                                                                   materials ? grain : 0.45f * from.tint};
    }
    return data;
}

void Frame::write_colour(PassBuilder& pass, Access access, bool last) {
    Image& target = samples.valid() ? samples : colour;
    target = pass.write(target, access);
    if (samples.valid() && last) colour = pass.write(colour, Access::resolve_attachment);
}

Rendering Frame::colour_rendering(const PassContext& context, VkAttachmentLoadOp load, bool last) const {
    return {.extent = context.extent(colour),
            .colour = context.view(samples.valid() ? samples : colour),
            .colour_load = load,
            .resolve = samples.valid() && last ? context.view(colour) : VK_NULL_HANDLE,
            .depth = context.view(depth),
            .scissor = scissor};
}

void Frame::bind_image(const PassContext& context, VkDescriptorSet to, Image image, uint32_t as) const {
    layout.update(to, context.view(image));
    vkCmdBindDescriptorSets(context.commands, VK_PIPELINE_BIND_POINT_GRAPHICS, layout.pipeline_layout(), as, 1, &to, 0,
                            nullptr);
}

void read_pieces(const Frame& frame, PassBuilder& pass, Buffer commands) {
    pass.read(frame.poses, Access::storage_read_vertex);
    pass.read(frame.draw_data, Access::storage_read_vertex);
    pass.read(frame.vertices, Access::vertex_read);
    pass.read(frame.indices, Access::index_read);
    pass.read(commands, Access::indirect_read);
}

void read_materials(const Frame& frame, PassBuilder& pass) {
    pass.read(frame.normals, Access::vertex_read);
    pass.read(frame.corners, Access::vertex_read);
}

void bind_materials(const Frame& frame, const PassContext& context) {
    const VkBuffer buffers[] = {context.buffer(frame.normals), context.buffer(frame.corners)};
    const VkDeviceSize starts[] = {0, 0};
    vkCmdBindVertexBuffers(context.commands, 1, 2, buffers, starts);
    const VkDescriptorSet set = frame.materials->set();
    vkCmdBindDescriptorSets(context.commands, VK_PIPELINE_BIND_POINT_GRAPHICS, frame.layout.pipeline_layout(), 2, 1,
                            &set, 0, nullptr);
}

void draw_pieces(Frame& frame, const PassContext& context, Buffer commands, const PiecePipelines& pipelines) {
    const VkBuffer vertices = context.buffer(frame.vertices);
    const VkDeviceSize start = 0;
    vkCmdBindVertexBuffers(context.commands, 0, 1, &vertices, &start);
    vkCmdBindIndexBuffer(context.commands, context.buffer(frame.indices), 0, VK_INDEX_TYPE_UINT32);
    constexpr uint32_t stride = sizeof(VkDrawIndexedIndirectCommand);
    const auto draw = [&](const Pipeline& pipeline, uint32_t begin, uint32_t end) {
        if (begin == end) return;
        vkCmdBindPipeline(context.commands, VK_PIPELINE_BIND_POINT_GRAPHICS, pipeline.handle());
        for (uint32_t first = begin; first < end; first += frame.max_draws) {
            const uint32_t count = std::min(frame.max_draws, end - first);
            vkCmdDrawIndexedIndirect(context.commands, context.buffer(commands), uint64_t{first} * stride, count,
                                     stride);
            ++frame.stats.indirect_calls;
        }
    };
    draw(pipelines.solid, 0, frame.pieces.solid_draws());
    if (pipelines.fading) draw(*pipelines.fading, frame.pieces.solid_draws(), frame.pieces.draws());
}

} // namespace brittle::engine
