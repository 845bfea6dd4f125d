#include "engine/compute/classify_layout.h"

#include <array>

#include "engine/gpu/check.h"
#include "engine/gpu/device.h"
#include "engine/gpu/memory.h"
#include "shaders/classify.h"

namespace brittle::engine {

using namespace shared;

ClassifyLayout::ClassifyLayout(const Device& device) : device_(device.handle()) {
    try {
        create();
    } catch (...) {
        destroy();
        throw;
    }
}

ClassifyLayout::~ClassifyLayout() {
    destroy();
}

void ClassifyLayout::create() {
    std::array<VkDescriptorSetLayoutBinding, classify_binding_count> bindings{};
    for (uint32_t k = 0; k < classify_binding_count; ++k)
        bindings[k] = {k, VK_DESCRIPTOR_TYPE_STORAGE_BUFFER, 1, VK_SHADER_STAGE_COMPUTE_BIT, nullptr};
    const VkDescriptorSetLayoutCreateInfo set_layout{.sType = VK_STRUCTURE_TYPE_DESCRIPTOR_SET_LAYOUT_CREATE_INFO,
                                                     .bindingCount = classify_binding_count,
                                                     .pBindings = bindings.data()};
    check(vkCreateDescriptorSetLayout(device_, &set_layout, nullptr, &set_layout_), "create a descriptor set layout");
    const VkPushConstantRange constants{VK_SHADER_STAGE_COMPUTE_BIT, 0, sizeof(ClassifyGrid)};
    const VkPipelineLayoutCreateInfo layout{.sType = VK_STRUCTURE_TYPE_PIPELINE_LAYOUT_CREATE_INFO,
                                            .setLayoutCount = 1,
                                            .pSetLayouts = &set_layout_,
                                            .pushConstantRangeCount = 1,
                                            .pPushConstantRanges = &constants};
    check(vkCreatePipelineLayout(device_, &layout, nullptr, &layout_), "create a pipeline layout");
    const VkDescriptorPoolSize size{VK_DESCRIPTOR_TYPE_STORAGE_BUFFER, classify_binding_count};
    const VkDescriptorPoolCreateInfo pool{
        .sType = VK_STRUCTURE_TYPE_DESCRIPTOR_POOL_CREATE_INFO, .maxSets = 1, .poolSizeCount = 1, .pPoolSizes = &size};
    check(vkCreateDescriptorPool(device_, &pool, nullptr, &pool_), "create a descriptor pool");
    const VkDescriptorSetAllocateInfo set{.sType = VK_STRUCTURE_TYPE_DESCRIPTOR_SET_ALLOCATE_INFO,
                                          .descriptorPool = pool_,
                                          .descriptorSetCount = 1,
                                          .pSetLayouts = &set_layout_};
    check(vkAllocateDescriptorSets(device_, &set, &set_), "allocate a descriptor set");
}

void ClassifyLayout::destroy() {
    vkDestroyDescriptorPool(device_, pool_, nullptr);
    vkDestroyPipelineLayout(device_, layout_, nullptr);
    vkDestroyDescriptorSetLayout(device_, set_layout_, nullptr);
}

void ClassifyLayout::write(uint32_t binding, const DeviceBuffer& buffer) const {
    const VkDescriptorBufferInfo info{buffer.handle(), 0, VK_WHOLE_SIZE};
    const VkWriteDescriptorSet write{.sType = VK_STRUCTURE_TYPE_WRITE_DESCRIPTOR_SET,
                                     .dstSet = set_,
                                     .dstBinding = binding,
                                     .descriptorCount = 1,
                                     .descriptorType = VK_DESCRIPTOR_TYPE_STORAGE_BUFFER,
                                     .pBufferInfo = &info};
    vkUpdateDescriptorSets(device_, 1, &write, 0, nullptr);
}

} // namespace brittle::engine
