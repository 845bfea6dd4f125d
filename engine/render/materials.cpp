#include "engine/render/materials.h"

#include <algorithm>
#include <array>
#include <cstring>
#include <string>

#include "engine/gpu/check.h"
#include "engine/gpu/commands.h"
#include "engine/gpu/device.h"
#include "engine/render/frame.h"
#include "shaders/shared.h"

namespace brittle::engine {

namespace {

constexpr float max_anisotropy = 8.0f;

uint32_t flags_of(Wrap u, Wrap v) {
    const auto bits = [](Wrap wrap) {
        return wrap == Wrap::repeat ? 0u : (wrap == Wrap::clamp ? shared::wrap_clamp : shared::wrap_mirror);
    };
    return bits(u) | bits(v) << shared::wrap_bits;
}

glm::vec4 columns(const glm::mat2& turn) {
    return {turn[0], turn[1]};
}

// `base` and `normals`: the layers before those of the material's set.
shared::MeshMaterial packed(const MeshMaterial& material, uint32_t base, uint32_t normals) {
    shared::MeshMaterial made{.colour = material.colour,
                              .numbers = {material.cutoff, material.normal_scale, 0.0f, 0.0f},
                              .base_uv = {1.0f, 0.0f, 0.0f, 1.0f},
                              .normal_uv = {1.0f, 0.0f, 0.0f, 1.0f}};
    if (material.opacity == Opacity::mask) made.base_flags |= shared::alpha_mask;
    if (material.opacity == Opacity::blend) made.base_flags |= shared::alpha_blend;
    if (const std::optional<MaterialTexture>& texture = material.base_colour) {
        made.base_layer = 1 + base + texture->layer;
        made.base_flags |= flags_of(texture->wrap_u, texture->wrap_v);
        made.base_uv = columns(texture->turn);
        made.uv_offset.x = texture->offset.x;
        made.uv_offset.y = texture->offset.y;
    }
    if (const std::optional<MaterialTexture>& texture = material.normal_map) {
        made.normal_layer = 1 + normals + texture->layer;
        made.normal_flags = flags_of(texture->wrap_u, texture->wrap_v);
        made.normal_uv = columns(texture->turn);
        made.uv_offset.z = texture->offset.x;
        made.uv_offset.w = texture->offset.y;
    }
    return made;
}

// A stack of one white texel, for a binding that no material reads.
TextureStack or_blank(TextureStack stack) {
    if (stack.layers() > 0) return stack;
    const Bitmap white{1, 1, {255, 255, 255, 255}};
    return TextureStack::of({&white, 1});
}

DeviceImage image_for(const Device& device, const char* name, const TextureStack& stack, VkFormat format) {
    if (stack.layers() > device.limits().maxImageArrayLayers)
        throw VulkanFailure{{Status::invalid_argument, "the meshes have " + std::to_string(stack.layers())
                                                           + " textures; the device takes "
                                                           + std::to_string(device.limits().maxImageArrayLayers)}};
    return {device,
            name,
            {{stack.width(), stack.height()}, stack.levels(), stack.layers()},
            format,
            VK_IMAGE_USAGE_SAMPLED_BIT | VK_IMAGE_USAGE_TRANSFER_DST_BIT};
}

void barrier(VkCommandBuffer commands, VkImage image, bool is_written) {
    const VkImageMemoryBarrier2 change{
        .sType = VK_STRUCTURE_TYPE_IMAGE_MEMORY_BARRIER_2,
        .srcStageMask = is_written ? VK_PIPELINE_STAGE_2_COPY_BIT : VK_PIPELINE_STAGE_2_NONE,
        .srcAccessMask = is_written ? VK_ACCESS_2_TRANSFER_WRITE_BIT : VK_ACCESS_2_NONE,
        .dstStageMask = is_written ? VK_PIPELINE_STAGE_2_FRAGMENT_SHADER_BIT : VK_PIPELINE_STAGE_2_COPY_BIT,
        .dstAccessMask = is_written ? VK_ACCESS_2_SHADER_SAMPLED_READ_BIT : VK_ACCESS_2_TRANSFER_WRITE_BIT,
        .oldLayout = is_written ? VK_IMAGE_LAYOUT_TRANSFER_DST_OPTIMAL : VK_IMAGE_LAYOUT_UNDEFINED,
        .newLayout = is_written ? VK_IMAGE_LAYOUT_READ_ONLY_OPTIMAL : VK_IMAGE_LAYOUT_TRANSFER_DST_OPTIMAL,
        .srcQueueFamilyIndex = VK_QUEUE_FAMILY_IGNORED,
        .dstQueueFamilyIndex = VK_QUEUE_FAMILY_IGNORED,
        .image = image,
        .subresourceRange = {VK_IMAGE_ASPECT_COLOR_BIT, 0, VK_REMAINING_MIP_LEVELS, 0, VK_REMAINING_ARRAY_LAYERS}};
    const VkDependencyInfo dependency{
        .sType = VK_STRUCTURE_TYPE_DEPENDENCY_INFO, .imageMemoryBarrierCount = 1, .pImageMemoryBarriers = &change};
    vkCmdPipelineBarrier2(commands, &dependency);
}

uint64_t bytes_of(const TextureStack& stack) {
    uint64_t bytes = 0;
    for (uint32_t k = 0; k < stack.levels(); ++k) bytes += stack.level(k).size();
    return bytes;
}

// Textures do not change from frame to frame, so they are copied outside of the frame graph.
void copy_textures(const Device& device, std::span<const std::pair<VkImage, const TextureStack*>> images) {
    uint64_t size = 0;
    for (const auto& [image, stack] : images) size += bytes_of(*stack);
    const DeviceBuffer staging(device, "staged textures", size, VK_BUFFER_USAGE_TRANSFER_SRC_BIT, MemoryKind::upload);
    CommandSlot commands(device);
    commands.begin();
    uint64_t offset = 0;
    for (const auto& [image, stack] : images) {
        barrier(commands.buffer(), image, false);
        uint32_t width = stack->width(), height = stack->height();
        for (uint32_t k = 0; k < stack->levels(); ++k) {
            const std::span<const uint8_t> pixels = stack->level(k);
            std::memcpy(staging.mapped() + offset, pixels.data(), pixels.size());
            const VkBufferImageCopy region{.bufferOffset = offset,
                                           .imageSubresource = {VK_IMAGE_ASPECT_COLOR_BIT, k, 0, stack->layers()},
                                           .imageExtent = {width, height, 1}};
            vkCmdCopyBufferToImage(commands.buffer(), staging.handle(), image, VK_IMAGE_LAYOUT_TRANSFER_DST_OPTIMAL, 1,
                                   &region);
            offset += pixels.size();
            width = std::max(width / 2, 1u);
            height = std::max(height / 2, 1u);
        }
        barrier(commands.buffer(), image, true);
    }
    commands.submit({}, VK_NULL_HANDLE);
    commands.wait();
}

} // namespace

Materials::Materials(const Device& device, const FrameLayout& layout,
                     const std::vector<std::shared_ptr<const MaterialSet>>& sets)
    : device_(device) {
    std::vector<shared::MeshMaterial> materials;
    std::vector<const TextureStack*> base, normals;
    uint32_t base_layers = 0, normal_layers = 0;
    for (const auto& set : sets) {
        for (const MeshMaterial& material : set->materials) {
            materials.push_back(packed(material, base_layers, normal_layers));
            has_cut_outs_ = has_cut_outs_ || material.opacity != Opacity::opaque;
        }
        if (set->cuts && cut_layer_ == 0) cut_layer_ = 1 + base_layers + *set->cuts;
        base_layers += set->base_colours.layers();
        normal_layers += set->normal_maps.layers();
        base.push_back(&set->base_colours);
        normals.push_back(&set->normal_maps);
    }
    if (materials.empty()) materials.emplace_back();
    const TextureStack base_stack = or_blank(TextureStack::joined(base));
    const TextureStack normal_stack = or_blank(TextureStack::joined(normals, {.srgb = false}));
    const uint64_t size = materials.size() * sizeof(shared::MeshMaterial);
    materials_ = DeviceBuffer(device, "mesh materials", size, VK_BUFFER_USAGE_STORAGE_BUFFER_BIT, MemoryKind::upload);
    std::memcpy(materials_.mapped(), materials.data(), size);
    base_colours_ = image_for(device, "base colours", base_stack, VK_FORMAT_R8G8B8A8_SRGB);
    normal_maps_ = image_for(device, "normal maps", normal_stack, VK_FORMAT_R8G8B8A8_UNORM);
    const std::pair<VkImage, const TextureStack*> images[] = {{base_colours_.handle(), &base_stack},
                                                              {normal_maps_.handle(), &normal_stack}};
    copy_textures(device, images);
    try {
        create_samplers();
        const VkDescriptorPoolSize sizes[] = {{VK_DESCRIPTOR_TYPE_STORAGE_BUFFER, 1},
                                              {VK_DESCRIPTOR_TYPE_COMBINED_IMAGE_SAMPLER, 2}};
        const VkDescriptorPoolCreateInfo pool{.sType = VK_STRUCTURE_TYPE_DESCRIPTOR_POOL_CREATE_INFO,
                                              .maxSets = 1,
                                              .poolSizeCount = static_cast<uint32_t>(std::size(sizes)),
                                              .pPoolSizes = sizes};
        check(vkCreateDescriptorPool(device.handle(), &pool, nullptr, &pool_), "create a descriptor pool");
        set_ = layout.allocate_materials(pool_);
    } catch (...) {
        destroy();
        throw;
    }
    layout.update(set_, {.materials = materials_.handle(),
                         .base_colours = base_colours_.view(),
                         .normal_maps = normal_maps_.view(),
                         .sampler = sampler_});
}

Materials::~Materials() {
    destroy();
}

// A CPU device pays for each sample of an anisotropic one.
void Materials::create_samplers() {
    const bool anisotropic = device_.has_anisotropy() && !device_.is_cpu();
    const VkSamplerCreateInfo sampler{
        .sType = VK_STRUCTURE_TYPE_SAMPLER_CREATE_INFO,
        .magFilter = VK_FILTER_LINEAR,
        .minFilter = VK_FILTER_LINEAR,
        .mipmapMode = VK_SAMPLER_MIPMAP_MODE_LINEAR,
        .addressModeU = VK_SAMPLER_ADDRESS_MODE_REPEAT,
        .addressModeV = VK_SAMPLER_ADDRESS_MODE_REPEAT,
        .addressModeW = VK_SAMPLER_ADDRESS_MODE_CLAMP_TO_EDGE,
        .anisotropyEnable = anisotropic ? VK_TRUE : VK_FALSE,
        .maxAnisotropy = anisotropic ? std::min(max_anisotropy, device_.limits().maxSamplerAnisotropy) : 1.0f,
        .maxLod = VK_LOD_CLAMP_NONE};
    check(vkCreateSampler(device_.handle(), &sampler, nullptr, &sampler_), "create a sampler");
}

void Materials::destroy() {
    vkDestroyDescriptorPool(device_.handle(), pool_, nullptr);
    vkDestroySampler(device_.handle(), sampler_, nullptr);
}

} // namespace brittle::engine
