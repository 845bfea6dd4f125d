#include "engine/graph/execute.h"

#include <algorithm>
#include <cassert>
#include <chrono>
#include <utility>

#include "engine/gpu/check.h"
#include "engine/gpu/memory.h"
#include "engine/graph/access_vulkan.h"

namespace brittle::engine {

namespace {

VkImageCreateInfo image_info(const Plan::Resource& resource) {
    const auto& desc = std::get<ImageDesc>(resource.desc);
    return {.sType = VK_STRUCTURE_TYPE_IMAGE_CREATE_INFO,
            .imageType = VK_IMAGE_TYPE_2D,
            .format = to_vulkan(desc.format),
            .extent = {desc.width, desc.height, 1},
            .mipLevels = desc.mip_levels,
            .arrayLayers = desc.layers,
            .samples = static_cast<VkSampleCountFlagBits>(desc.samples),
            .tiling = VK_IMAGE_TILING_OPTIMAL,
            .usage = to_vulkan(resource.accesses).image_usage,
            .sharingMode = VK_SHARING_MODE_EXCLUSIVE,
            .initialLayout = VK_IMAGE_LAYOUT_UNDEFINED};
}

VkBufferCreateInfo buffer_info(const Plan::Resource& resource) {
    return {.sType = VK_STRUCTURE_TYPE_BUFFER_CREATE_INFO,
            .size = std::get<BufferDesc>(resource.desc).size,
            .usage = to_vulkan(resource.accesses).buffer_usage,
            .sharingMode = VK_SHARING_MODE_EXCLUSIVE};
}

VkMemoryRequirements requirements(const Device& device, const Plan::Resource& resource) {
    VkMemoryRequirements2 needs{.sType = VK_STRUCTURE_TYPE_MEMORY_REQUIREMENTS_2};
    if (resource.is_image()) {
        const VkImageCreateInfo info = image_info(resource);
        const VkDeviceImageMemoryRequirements query{.sType = VK_STRUCTURE_TYPE_DEVICE_IMAGE_MEMORY_REQUIREMENTS,
                                                    .pCreateInfo = &info};
        vkGetDeviceImageMemoryRequirements(device.handle(), &query, &needs);
    } else {
        const VkBufferCreateInfo info = buffer_info(resource);
        const VkDeviceBufferMemoryRequirements query{.sType = VK_STRUCTURE_TYPE_DEVICE_BUFFER_MEMORY_REQUIREMENTS,
                                                     .pCreateInfo = &info};
        vkGetDeviceBufferMemoryRequirements(device.handle(), &query, &needs);
    }
    return needs.memoryRequirements;
}

bool same_transient(const Plan::Resource& a, const Plan::Resource& b) {
    return a.desc == b.desc && a.accesses == b.accesses && a.memory.heap == b.memory.heap
           && a.memory.offset == b.memory.offset;
}

// An image with no other usage is only copied, and has no view.
constexpr VkImageUsageFlags transfers = VK_IMAGE_USAGE_TRANSFER_SRC_BIT | VK_IMAGE_USAGE_TRANSFER_DST_BIT;

bool is_transient(const Plan::Resource& resource) {
    return !resource.imported && resource.used();
}

VkImageAspectFlags aspect_of(const Plan::Resource& resource) {
    const bool depth = std::get<ImageDesc>(resource.desc).format == Format::d32_float;
    return depth ? VK_IMAGE_ASPECT_DEPTH_BIT : VK_IMAGE_ASPECT_COLOR_BIT;
}

} // namespace

VkImage PassContext::image(Image handle) const {
    return objects_[handle.resource()].image;
}

VkImageView PassContext::view(Image handle) const {
    return objects_[handle.resource()].view;
}

VkExtent2D PassContext::extent(Image handle) const {
    const auto& desc = std::get<ImageDesc>(plan_->resources[handle.resource()].desc);
    return {desc.width, desc.height};
}

VkBuffer PassContext::buffer(Buffer handle) const {
    return objects_[handle.resource()].buffer;
}

GraphExecutor::GraphExecutor(const Device& device) : device_(device) {}

GraphExecutor::~GraphExecutor() {
    destroy_transients();
    if (queries_) vkDestroyQueryPool(device_.handle(), queries_, nullptr);
}

MemoryNeeds GraphExecutor::memory_needs() const {
    return [this](const Plan::Resource& resource) -> MemoryNeed {
        const VkMemoryRequirements needs = requirements(device_, resource);
        std::optional<uint32_t> type =
            device_.find_memory_type(needs.memoryTypeBits, VK_MEMORY_PROPERTY_DEVICE_LOCAL_BIT);
        if (!type) type = device_.find_memory_type(needs.memoryTypeBits, 0);
        assert(type && "Vulkan promises at least one memory type for every resource");
        // With this alignment, images and buffers may be adjacent in a heap.
        const uint64_t alignment = std::max<uint64_t>(needs.alignment, device_.limits().bufferImageGranularity);
        return {needs.size, alignment, *type};
    };
}

// Keeps what the plan needs again, wherever its list names it: a frame with one import more has the same transients at
// other indices, and an allocation of device memory can take a GPU's driver milliseconds.
void GraphExecutor::prepare_transients(const Plan& plan) {
    const auto fits = [](const Plan::Heap& present, const Plan::Heap& needed) {
        return present.memory_class == needed.memory_class && present.size >= needed.size
               && present.size / 2 <= needed.size;
    };
    if (!std::ranges::equal(heap_descs_, plan.heaps, fits)) destroy_transients();
    try {
        if (heaps_.empty()) allocate_heaps(plan);
        create_transients(plan);
    } catch (...) {
        destroy_transients(); // a partial set would be reused as complete by the next call
        throw;
    }
}

void GraphExecutor::allocate_heaps(const Plan& plan) {
    for (const Plan::Heap& heap : plan.heaps) {
        heaps_.push_back(allocate_memory(device_, heap.size, 1u << heap.memory_class, MemoryKind::device));
        heap_descs_.push_back(heap);
    }
}

void GraphExecutor::create_transients(const Plan& plan) {
    std::vector<Transient> previous = std::exchange(transients_, {});
    try {
        for (const Plan::Resource& resource : plan.resources) {
            Transient& transient = transients_.emplace_back(Transient{resource, {}});
            if (!is_transient(resource)) continue;
            const auto equal = std::ranges::find_if(previous, [&](const Transient& other) {
                return other.object.exists() && same_transient(other.resource, resource);
            });
            if (equal != previous.end())
                std::swap(transient.object, equal->object);
            else
                create_transient(transient);
        }
    } catch (...) {
        destroy_objects(previous);
        throw;
    }
    destroy_objects(previous);
}

void GraphExecutor::create_transient(Transient& transient) const {
    const Plan::Resource& resource = transient.resource;
    PassContext::Object& object = transient.object;
    const VkDeviceMemory heap = heaps_[resource.memory.heap];
    if (resource.is_image()) {
        const VkImageCreateInfo info = image_info(resource);
        check(vkCreateImage(device_.handle(), &info, nullptr, &object.image), "create a transient image");
        check(vkBindImageMemory(device_.handle(), object.image, heap, resource.memory.offset),
              "bind a transient image's memory");
        if (info.usage & ~transfers) object.view = create_view(device_.handle(), object.image, info.format);
        device_.set_name(VK_OBJECT_TYPE_IMAGE, reinterpret_cast<uint64_t>(object.image), resource.name.c_str());
    } else {
        const VkBufferCreateInfo info = buffer_info(resource);
        check(vkCreateBuffer(device_.handle(), &info, nullptr, &object.buffer), "create a transient buffer");
        check(vkBindBufferMemory(device_.handle(), object.buffer, heap, resource.memory.offset),
              "bind a transient buffer's memory");
        device_.set_name(VK_OBJECT_TYPE_BUFFER, reinterpret_cast<uint64_t>(object.buffer), resource.name.c_str());
    }
}

void GraphExecutor::destroy_objects(const std::vector<Transient>& transients) const {
    for (const Transient& transient : transients) {
        vkDestroyImageView(device_.handle(), transient.object.view, nullptr);
        vkDestroyImage(device_.handle(), transient.object.image, nullptr);
        vkDestroyBuffer(device_.handle(), transient.object.buffer, nullptr);
    }
}

void GraphExecutor::destroy_transients() {
    destroy_objects(transients_);
    for (VkDeviceMemory heap : heaps_) vkFreeMemory(device_.handle(), heap, nullptr);
    transients_.clear();
    heaps_.clear();
    heap_descs_.clear();
}

void GraphExecutor::prepare_queries(size_t passes) {
    if (!device_.limits().timestampComputeAndGraphics || 2 * passes <= query_capacity_) return;
    if (queries_) vkDestroyQueryPool(device_.handle(), queries_, nullptr);
    queries_ = VK_NULL_HANDLE;
    query_capacity_ = 0;
    const VkQueryPoolCreateInfo info{.sType = VK_STRUCTURE_TYPE_QUERY_POOL_CREATE_INFO,
                                     .queryType = VK_QUERY_TYPE_TIMESTAMP,
                                     .queryCount = static_cast<uint32_t>(4 * passes)};
    check(vkCreateQueryPool(device_.handle(), &info, nullptr, &queries_), "create a query pool");
    query_capacity_ = info.queryCount;
}

void GraphExecutor::record_barriers(const std::vector<Plan::Barrier>& barriers, const PassContext& context) const {
    std::vector<VkImageMemoryBarrier2> images;
    // Buffers have no layout, so one global barrier serves all of them and all aliased memory; drivers treat buffer
    // barriers as global barriers anyway.
    VkMemoryBarrier2 memory{.sType = VK_STRUCTURE_TYPE_MEMORY_BARRIER_2};
    for (const Plan::Barrier& barrier : barriers) {
        const Plan::Resource& resource = context.plan_->resources[barrier.resource];
        const VulkanAccess before = to_vulkan(barrier.before);
        const VulkanAccess after = to_vulkan(barrier.after);
        if (barrier.aliasing || !resource.is_image()) {
            memory.srcStageMask |= before.stages;
            memory.srcAccessMask |= before.access;
            memory.dstStageMask |= after.stages;
            memory.dstAccessMask |= after.access;
        }
        if (!resource.is_image()) continue;
        images.push_back(
            {.sType = VK_STRUCTURE_TYPE_IMAGE_MEMORY_BARRIER_2,
             .srcStageMask = before.stages,
             .srcAccessMask = before.access,
             .dstStageMask = after.stages,
             .dstAccessMask = after.access,
             .oldLayout = to_vulkan(barrier.from),
             .newLayout = to_vulkan(barrier.to),
             .srcQueueFamilyIndex = VK_QUEUE_FAMILY_IGNORED,
             .dstQueueFamilyIndex = VK_QUEUE_FAMILY_IGNORED,
             .image = context.objects_[barrier.resource].image,
             .subresourceRange = {aspect_of(resource), 0, VK_REMAINING_MIP_LEVELS, 0, VK_REMAINING_ARRAY_LAYERS}});
    }
    const bool global = memory.srcStageMask != 0 || memory.dstStageMask != 0;
    if (!global && images.empty()) return;
    const VkDependencyInfo info{.sType = VK_STRUCTURE_TYPE_DEPENDENCY_INFO,
                                .memoryBarrierCount = global ? 1u : 0u,
                                .pMemoryBarriers = &memory,
                                .imageMemoryBarrierCount = static_cast<uint32_t>(images.size()),
                                .pImageMemoryBarriers = images.data()};
    vkCmdPipelineBarrier2(context.commands, &info);
}

void GraphExecutor::record(const Plan& plan, const External& external, VkCommandBuffer commands) {
    prepare_transients(plan);
    prepare_queries(plan.passes.size());

    PassContext context;
    context.commands = commands;
    context.plan_ = &plan;
    for (size_t i = 0; i < plan.resources.size(); ++i) {
        if (plan.resources[i].imported) {
            const External::Object& object = external.objects_[plan.resources[i].import.external];
            context.objects_.push_back({object.image, object.view, object.buffer});
        } else {
            context.objects_.push_back(transients_[i].object);
        }
    }

    pass_names_.clear();
    if (queries_) vkCmdResetQueryPool(commands, queries_, 0, static_cast<uint32_t>(2 * plan.passes.size()));
    const auto stamp = [&](uint32_t query) {
        if (queries_) vkCmdWriteTimestamp2(commands, VK_PIPELINE_STAGE_2_ALL_COMMANDS_BIT, queries_, query);
    };
    for (const Plan::Pass& pass : plan.passes) {
        const auto query = static_cast<uint32_t>(2 * pass_names_.size());
        device_.begin_label(commands, pass.name.c_str());
        stamp(query);
        record_barriers(pass.barriers, context);
        pass.execute(context);
        stamp(query + 1);
        device_.end_label(commands);
        pass_names_.push_back(pass.name);
    }
    record_barriers(plan.final_barriers, context);
}

std::vector<PassTime> GraphExecutor::collect_times() {
    std::vector<PassTime> times;
    if (!queries_ || pass_names_.empty()) return times;
    std::vector<uint64_t> stamps(2 * pass_names_.size());
    check(vkGetQueryPoolResults(device_.handle(), queries_, 0, static_cast<uint32_t>(stamps.size()),
                                stamps.size() * sizeof(uint64_t), stamps.data(), sizeof(uint64_t),
                                VK_QUERY_RESULT_64_BIT),
          "read timestamps");
    const auto period = static_cast<double>(device_.limits().timestampPeriod);
    const std::chrono::nanoseconds now = std::chrono::steady_clock::now().time_since_epoch();
    const ClockMatch match = device_.match_clocks().value_or(ClockMatch{stamps.back(), now.count(), period});
    for (size_t i = 0; i < pass_names_.size(); ++i) {
        const auto ticks = static_cast<double>(stamps[2 * i + 1] - stamps[2 * i]);
        times.push_back({pass_names_[i], ticks * period * 1e-6, match.host(stamps[2 * i])});
    }
    return times;
}

} // namespace brittle::engine
