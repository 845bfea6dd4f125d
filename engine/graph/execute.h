// The execute half of the frame graph: creates a plan's transients, records its barriers and passes, and times the
// passes.
//
//     GraphExecutor executor(device);                       // one for each frame in flight
//     External targets;
//     Image image = graph.import_image("target", desc, {.external = targets.add(vk_image, vk_view), ...});
//     ...
//     CompileResult plan = std::move(graph).compile(executor.memory_needs());
//     executor.record(*plan, targets, commands);            // within a begun command buffer
//     ... submit, wait for its fence ...
//     for (const PassTime& time : executor.collect_times()) ...
//
// A transient of the previous frame is reused where the plan has an equal one, and their memory where it suffices.
// The device must have finished the executor's last frame when record() is called and when the executor is destroyed:
// wait for the frame's fence first.
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include <vulkan/vulkan.h>

#include "engine/gpu/device.h"
#include "engine/graph/frame_graph.h"
#include "engine/graph/pass_time.h"

namespace brittle::engine {

// The Vulkan objects behind a graph's imports. add() returns the value of Import::external for the object.
class External {
  public:
    [[nodiscard]] uint64_t add(VkImage image, VkImageView view) { return add({image, view, VK_NULL_HANDLE}); }
    [[nodiscard]] uint64_t add(VkBuffer buffer) { return add({VK_NULL_HANDLE, VK_NULL_HANDLE, buffer}); }

  private:
    friend class GraphExecutor;
    struct Object {
        VkImage image;
        VkImageView view;
        VkBuffer buffer;
    };
    [[nodiscard]] uint64_t add(const Object& object) {
        objects_.push_back(object);
        return objects_.size() - 1;
    }
    std::vector<Object> objects_;
};

// The argument of a pass's execute function: its command buffer, and the objects behind the handles that it declared.
class PassContext {
  public:
    VkCommandBuffer commands = VK_NULL_HANDLE;

    [[nodiscard]] VkImage image(Image handle) const;
    [[nodiscard]] VkImageView view(Image handle) const;
    [[nodiscard]] VkExtent2D extent(Image handle) const;
    [[nodiscard]] VkBuffer buffer(Buffer handle) const;

  private:
    friend class GraphExecutor;
    struct Object {
        VkImage image = VK_NULL_HANDLE;
        VkImageView view = VK_NULL_HANDLE;
        VkBuffer buffer = VK_NULL_HANDLE;
        [[nodiscard]] bool exists() const { return image || buffer; }
    };
    const Plan* plan_ = nullptr;
    std::vector<Object> objects_; // indexed by Handle::resource()
};

class GraphExecutor {
  public:
    explicit GraphExecutor(const Device& device);
    ~GraphExecutor();
    GraphExecutor(const GraphExecutor&) = delete;
    GraphExecutor& operator=(const GraphExecutor&) = delete;

    // Returns the argument of FrameGraph::compile(). The memory class is Vulkan's memory type.
    [[nodiscard]] MemoryNeeds memory_needs() const;

    // Throws VulkanFailure (gpu/check.h).
    void record(const Plan& plan, const External& external, VkCommandBuffer commands);

    // Returns the times of the passes last recorded, which the device must have finished. Empty on a device without
    // timestamps.
    [[nodiscard]] std::vector<PassTime> collect_times();

  private:
    struct Transient {
        Plan::Resource resource;
        PassContext::Object object;
    };

    void prepare_transients(const Plan& plan);
    void allocate_heaps(const Plan& plan);
    void create_transients(const Plan& plan);
    void create_transient(Transient& transient) const;
    void destroy_objects(const std::vector<Transient>& transients) const;
    void destroy_transients();
    void prepare_queries(size_t passes);
    void record_barriers(const std::vector<Plan::Barrier>& barriers, const PassContext& context) const;

    const Device& device_;
    std::vector<Plan::Heap> heap_descs_;
    std::vector<VkDeviceMemory> heaps_;
    std::vector<Transient> transients_; // parallel to Plan::resources; imported and unused ones stay empty
    VkQueryPool queries_ = VK_NULL_HANDLE;
    size_t query_capacity_ = 0;
    std::vector<std::string> pass_names_; // names of the passes last recorded
};

} // namespace brittle::engine
