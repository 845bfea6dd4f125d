// The declaration of a frame graph. It is built anew each frame, compiled to a Plan and discarded. It contains no
// Vulkan type.
//
//     FrameGraph graph;
//     Image depth = graph.create_image("depth", {.width = w, .height = h, .format = Format::d32_float});
//     Image target = graph.import_image("swapchain", {.width = w, .height = h},
//                                       {.initial = Access::acquired, .final = Access::present});
//     graph.add_pass(
//         "shade", PassKind::graphics,
//         [&](PassBuilder& p) {
//             p.read(shadow, Access::sampled_fragment);
//             depth = p.write(depth, Access::depth_attachment);
//             target = p.write(target, Access::colour_attachment);
//         },
//         [=](PassContext& context) { ... });
//     CompileResult plan = std::move(graph).compile(needs);
//     if (!plan) { log(plan.error().message); return; }
//
// Rules:
// - Setup runs at once. Execute runs later, and only if the pass is live.
// - A write returns a new handle, and the old handle is dead. Only the newest handle of a resource may be read or
//   written, so the order of declaration is a topological order.
// - A pass either reads a resource, with any accesses of one image layout, or writes it once. To do both, it uses a
//   read_write or _load access.
// - A pass is live if it has a side effect, makes the last version of an imported resource, or makes a version that a
//   live pass needs. All other passes are culled.
// - A write needs the version before it, because it may leave parts untouched. The exceptions are colour_attachment,
//   depth_attachment and resolve_attachment, which replace the whole image.
//
// Misuse neither throws nor asserts: compile() reports every mistake with pass and resource names. Not thread-safe.
#pragma once

#include "engine/graph/plan.h"

#include <cassert>
#include <functional>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace brittle::engine {

class FrameGraph;

// The memory requirements of a transient. Transients of one memory class share a heap. The execute half uses Vulkan's
// memory type as the class and raises the alignment to bufferImageGranularity.
struct MemoryNeed {
    std::uint64_t size = 0;      // bytes
    std::uint64_t alignment = 1; // bytes, a power of two
    std::uint32_t memory_class = 0;
};

// Called once for each transient that a live pass uses, after its `accesses` are complete.
using MemoryNeeds = std::function<MemoryNeed(const Plan::Resource&)>;

struct GraphError {
    std::string message; // for people: one line for each misuse, with pass and resource names
};

class [[nodiscard]] CompileResult {
  public:
    CompileResult(Plan plan) : plan_(std::move(plan)) {}
    CompileResult(GraphError error) : error_(std::move(error)) {}

    explicit operator bool() const { return plan_.has_value(); }
    Plan& operator*() { return *plan_; }
    Plan* operator->() { return &*plan_; }
    [[nodiscard]] const GraphError& error() const {
        assert(!plan_);
        return error_;
    }

  private:
    std::optional<Plan> plan_;
    GraphError error_;
};

// Declares the resource accesses of one pass; valid during its setup only.
class PassBuilder {
  public:
    void read(Image image, Access access);
    void read(Buffer buffer, Access access);
    // Returns the handle of the new version; `image` is dead from here on.
    [[nodiscard]] Image write(Image image, Access access);
    [[nodiscard]] Buffer write(Buffer buffer, Access access);
    void side_effect(); // the pass is never culled

  private:
    friend class FrameGraph;
    PassBuilder(FrameGraph& graph, std::uint32_t pass) : graph_(graph), pass_(pass) {}

    FrameGraph& graph_;
    std::uint32_t pass_;
};

class FrameGraph {
  public:
    // Creates transients, which exist within the frame; their contents are undefined until written. compile() reports
    // zero extents.
    [[nodiscard]] Image create_image(std::string_view name, const ImageDesc& desc);
    [[nodiscard]] Buffer create_buffer(std::string_view name, const BufferDesc& desc);

    [[nodiscard]] Image import_image(std::string_view name, const ImageDesc& desc, const Import& import);
    [[nodiscard]] Buffer import_buffer(std::string_view name, const BufferDesc& desc, const Import& import);

    template<class Setup>
    void add_pass(std::string_view name, PassKind kind, Setup&& setup, Execute execute) {
        PassBuilder builder(*this, begin_pass(name, kind, std::move(execute)));
        setup(builder);
    }

    // Returns the plan, or every mistake of the declaration. Moves the passes out of the graph.
    CompileResult compile(const MemoryNeeds& needs) &&;

  private:
    friend class PassBuilder;

    static constexpr std::uint32_t no_pass = ~0u;

    std::uint32_t begin_pass(std::string_view name, PassKind kind, Execute execute);
    std::uint32_t add_resource(std::string_view name, std::variant<ImageDesc, BufferDesc> desc, bool imported,
                               const Import& import);
    // Checks and records one use. Returns the newest version of the resource: for a legal write, the version just made.
    std::uint32_t add_use(std::uint32_t pass, Plan::Use use, bool image, bool write);
    // Returns the mistake in the use, or "". The resource exists.
    [[nodiscard]] std::string use_error(const Plan::Pass& pass, const Plan::Use& use, bool write) const;
    [[nodiscard]] bool contents_defined(std::uint32_t resource) const; // of its newest version
    [[nodiscard]] std::uint32_t newest(std::uint32_t resource) const {
        return static_cast<std::uint32_t>(writers_[resource].size() - 1);
    }
    void check_final_accesses();
    [[nodiscard]] std::vector<bool> find_live_passes() const;
    void fail(std::string message) { errors_.push_back(std::move(message)); }

    std::vector<Plan::Pass> passes_;
    std::vector<Plan::Resource> resources_;
    // The pass that made each version, indexed by resource and version; version 0 is made by no_pass.
    std::vector<std::vector<std::uint32_t>> writers_;
    std::vector<std::string> errors_;
};

} // namespace brittle::engine
