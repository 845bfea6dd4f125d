#include "engine/compute/gpu_classifier.h"

#include <algorithm>
#include <cstring>

#include "compiled/classify_crossing_groups_comp.h"
#include "compiled/classify_signs_comp.h"
#include "compiled/classify_triangles_comp.h"
#include "compiled/classify_triangles_subgroup_comp.h"
#include "compiled/classify_vertices_comp.h"
#include "engine/compute/classify_layout.h"
#include "engine/compute/site_bins.h"
#include "engine/gpu/check.h"
#include "engine/gpu/commands.h"
#include "engine/gpu/device.h"
#include "engine/gpu/memory.h"
#include "engine/gpu/pipeline.h"
#include "engine/graph/execute.h"

namespace brittle::engine {

namespace {

using namespace shared;

static_assert(classify_uncertain == fracture::Classifier::uncertain);
static_assert(classify_crossing == fracture::Classifier::crossing);
static_assert(classify_edge_alone << 2 == fracture::Classifier::edge_alone(2));
static_assert(classify_point_alone == fracture::Classifier::point_alone);
static_assert(classify_sign_known << 4 == fracture::Classifier::sign_known(2));
static_assert(classify_sign_first << 4 == fracture::Classifier::sign_first(2));

constexpr VkBufferUsageFlags storage = VK_BUFFER_USAGE_STORAGE_BUFFER_BIT;

Pipeline triangles_pipeline(const Device& device, VkPipelineLayout layout) {
    constexpr const char* name = "classify triangles";
    return device.has_ballots() ? Pipeline(device, name, layout, classify_triangles_subgroup_comp)
                                : Pipeline(device, name, layout, classify_triangles_comp);
}

uint32_t groups(uint32_t items) {
    return (items + classify_group_size - 1) / classify_group_size;
}

} // namespace

struct GpuClassifier::State {
    explicit State(Device& device_)
        : device(device_), layout(device_),
          vertices(device_, "classify vertices", layout.handle(), classify_vertices_comp),
          triangles(triangles_pipeline(device_, layout.handle())),
          crossing_groups(device_, "count crossing triangles", layout.handle(), classify_crossing_groups_comp),
          signs(device_, "signs of crossing triangles", layout.handle(), classify_signs_comp), executor(device_),
          commands(device_) {}

    [[nodiscard]] bool fits(const Problem& problem) const;
    void reserve(uint32_t binding, DeviceBuffer& buffer, const char* name, uint64_t size, VkBufferUsageFlags usage,
                 MemoryKind kind);
    void write(const Problem& problem);
    void reserve_all();
    void bind(VkCommandBuffer into, const Pipeline& pipeline) const;
    struct Handles;
    void add_copies_in(FrameGraph& graph, Handles& h);
    void add_dispatches(FrameGraph& graph, Handles& h);
    void submit();

    Device& device;
    ClassifyLayout layout;
    Pipeline vertices, triangles, crossing_groups, signs;
    SiteBins bins;
    // Mapped: the CPU writes the first two and reads the answers.
    DeviceBuffer positions, triangle_indices, vertex_answers, triangle_answers;
    // Device-local, because invocations read them at random; each has a mapped staging buffer.
    DeviceBuffer staged_sites, sites, staged_site_positions, site_positions, staged_bins, bin_begin;
    DeviceBuffer site_of_vertex, pattern_of_triangle, crossing, crossing_count, dispatch;
    uint32_t vertex_count = 0, triangle_count = 0;
    uint64_t site_bytes = 0, bin_bytes = 0, vertex_bytes = 0, triangle_bytes = 0;
    bool started = false;
    std::string error;
    std::vector<PassTime> times;
    GraphExecutor executor;
    CommandSlot commands; // last, because its destructor waits for the device before the buffers are destroyed
};

bool GpuClassifier::State::fits(const Problem& problem) const {
    const uint64_t max_range = device.limits().maxStorageBufferRange;
    const uint64_t max_items = uint64_t{device.limits().maxComputeWorkGroupCount[0]} * classify_group_size;
    return problem.positions.size() <= max_items && problem.triangles.size() <= max_items
           && problem.positions.size() * 3 * sizeof(float) <= max_range
           && problem.triangles.size() * sizeof(fracture::Triangle) <= max_range
           && problem.sites.size() * sizeof(glm::vec4) <= max_range;
}

// Grows the buffer to 1.5 times `size` if it is too small, so that a series of growing meshes rarely allocates.
void GpuClassifier::State::reserve(uint32_t binding, DeviceBuffer& buffer, const char* name, uint64_t size,
                                   VkBufferUsageFlags usage, MemoryKind kind) {
    if (!buffer.handle() || buffer.size() < size) buffer = DeviceBuffer(device, name, size + size / 2, usage, kind);
    if (binding < classify_binding_count) layout.write(binding, buffer);
}

void GpuClassifier::State::write(const Problem& problem) {
    vertex_count = static_cast<uint32_t>(problem.positions.size());
    triangle_count = static_cast<uint32_t>(problem.triangles.size());
    bins.build(problem.sites, problem.box);
    bins.grid.bins.w = vertex_count;
    bins.grid.counts.x = triangle_count;
    site_bytes = bins.sites.size() * sizeof(glm::vec4);
    bin_bytes = bins.begin.size() * sizeof(uint32_t);
    vertex_bytes = uint64_t{vertex_count} * sizeof(uint32_t);
    triangle_bytes = uint64_t{triangle_count} * sizeof(uint32_t);
    reserve_all();

    float* at = positions.mapped_as<float>(0, size_t{3} * vertex_count).data();
    for (const glm::dvec3& p : problem.positions) {
        at[0] = static_cast<float>(p.x);
        at[1] = static_cast<float>(p.y);
        at[2] = static_cast<float>(p.z);
        at += 3;
    }
    std::memcpy(triangle_indices.mapped(), problem.triangles.data(), problem.triangles.size_bytes());
    std::memcpy(staged_sites.mapped(), bins.sites.data(), site_bytes);
    std::memcpy(staged_bins.mapped(), bins.begin.data(), bin_bytes);
    glm::vec4* position = staged_site_positions.mapped_as<glm::vec4>(0, problem.sites.size()).data();
    for (const glm::dvec3& s : problem.sites) *position++ = glm::vec4(s, 0.0f);
}

void GpuClassifier::State::reserve_all() {
    constexpr uint32_t unbound = classify_binding_count;
    constexpr VkBufferUsageFlags source = VK_BUFFER_USAGE_TRANSFER_SRC_BIT;
    constexpr VkBufferUsageFlags target = VK_BUFFER_USAGE_TRANSFER_DST_BIT;
    constexpr MemoryKind upload = MemoryKind::upload, device_local = MemoryKind::device,
                         readback = MemoryKind::readback;
    reserve(classify_binding_positions, positions, "vertices to classify", 3 * vertex_bytes, storage, upload);
    reserve(classify_binding_triangles, triangle_indices, "triangles to classify", 3 * triangle_bytes, storage, upload);
    reserve(unbound, staged_sites, "staged sites", site_bytes, source, upload);
    reserve(unbound, staged_site_positions, "staged site positions", site_bytes, source, upload);
    reserve(unbound, staged_bins, "staged bins", bin_bytes, source, upload);
    reserve(classify_binding_sites, sites, "sites", site_bytes, storage | target, device_local);
    reserve(classify_binding_site_positions, site_positions, "site positions", site_bytes, storage | target,
            device_local);
    reserve(classify_binding_bins, bin_begin, "bins", bin_bytes, storage | target, device_local);
    reserve(classify_binding_vertex_answers, site_of_vertex, "site of vertex", vertex_bytes, storage | source,
            device_local);
    reserve(classify_binding_triangle_answers, pattern_of_triangle, "pattern of triangle", triangle_bytes,
            storage | source, device_local);
    reserve(classify_binding_crossing, crossing, "crossing triangles", triangle_bytes, storage, device_local);
    reserve(classify_binding_crossing_count, crossing_count, "count of crossing triangles", sizeof(uint32_t),
            storage | target, device_local);
    reserve(classify_binding_dispatch, dispatch, "groups of crossing triangles", sizeof(VkDispatchIndirectCommand),
            storage | VK_BUFFER_USAGE_INDIRECT_BUFFER_BIT, device_local);
    reserve(unbound, vertex_answers, "vertex answers", vertex_bytes, target, readback);
    reserve(unbound, triangle_answers, "triangle answers", triangle_bytes, target, readback);
}

void GpuClassifier::State::bind(VkCommandBuffer into, const Pipeline& pipeline) const {
    vkCmdBindPipeline(into, VK_PIPELINE_BIND_POINT_COMPUTE, pipeline.handle());
    const VkDescriptorSet set = layout.set();
    vkCmdBindDescriptorSets(into, VK_PIPELINE_BIND_POINT_COMPUTE, layout.handle(), 0, 1, &set, 0, nullptr);
    vkCmdPushConstants(into, layout.handle(), VK_SHADER_STAGE_COMPUTE_BIT, 0, sizeof bins.grid, &bins.grid);
}

// The graph's handles of the buffers; each write replaces one.
struct GpuClassifier::State::Handles {
    Handles(FrameGraph& graph, External& external, const State& s) : graph_(graph), external_(external) {
        positions = from_host("vertices", s.positions);
        triangle_indices = from_host("triangles", s.triangle_indices);
        staged_sites = from_host("staged sites", s.staged_sites);
        staged_site_positions = from_host("staged site positions", s.staged_site_positions);
        staged_bins = from_host("staged bins", s.staged_bins);
        sites = from_device("sites", s.sites, Access::storage_read_compute);
        site_positions = from_device("site positions", s.site_positions, Access::storage_read_compute);
        bins = from_device("bins", s.bin_begin, Access::storage_read_compute);
        site_of = from_device("site of vertex", s.site_of_vertex, Access::transfer_read);
        pattern_of = from_device("pattern of triangle", s.pattern_of_triangle, Access::transfer_read);
        crossing = from_device("crossing triangles", s.crossing, Access::storage_read_compute);
        count = from_device("count of crossing", s.crossing_count, Access::storage_read_compute);
        dispatch = from_device("dispatch", s.dispatch, Access::indirect_read);
        vertex_out = from_device("vertex answers", s.vertex_answers, Access::host_read);
        triangle_out = from_device("triangle answers", s.triangle_answers, Access::host_read);
    }

    Buffer positions, triangle_indices, staged_sites, staged_site_positions, staged_bins; // from the CPU
    Buffer sites, site_positions, bins, site_of, pattern_of, crossing, count, dispatch;
    Buffer vertex_out, triangle_out; // to the CPU

  private:
    [[nodiscard]] Buffer from_host(const char* name, const DeviceBuffer& buffer) {
        return graph_.import_buffer(name, {buffer.size()},
                                    {.initial = Access::host_write,
                                     .final = {},
                                     .read_only = true,
                                     .external = external_.add(buffer.handle())});
    }
    [[nodiscard]] Buffer from_device(const char* name, const DeviceBuffer& buffer, AccessSet final) {
        return graph_.import_buffer(name, {buffer.size()},
                                    {.initial = {}, .final = final, .external = external_.add(buffer.handle())});
    }
    FrameGraph& graph_;
    External& external_;
};

namespace {

void copy(PassContext& context, Buffer source, Buffer target, uint64_t bytes) {
    const VkBufferCopy region{0, 0, bytes};
    vkCmdCopyBuffer(context.commands, context.buffer(source), context.buffer(target), 1, &region);
}

} // namespace

void GpuClassifier::State::add_copies_in(FrameGraph& graph, Handles& h) {
    graph.add_pass(
        "upload sites", PassKind::transfer,
        [&](PassBuilder& pass) {
            for (const Buffer staged : {h.staged_sites, h.staged_site_positions, h.staged_bins})
                pass.read(staged, Access::transfer_read);
            for (Buffer* target : {&h.sites, &h.site_positions, &h.bins, &h.count})
                *target = pass.write(*target, Access::transfer_write);
        },
        [h, this](PassContext& context) {
            copy(context, h.staged_sites, h.sites, site_bytes);
            copy(context, h.staged_site_positions, h.site_positions, site_bytes);
            copy(context, h.staged_bins, h.bins, bin_bytes);
            vkCmdFillBuffer(context.commands, context.buffer(h.count), 0, sizeof(uint32_t), 0);
        });
}

void GpuClassifier::State::add_dispatches(FrameGraph& graph, Handles& h) {
    constexpr Access reads = Access::storage_read_compute;
    graph.add_pass(
        "classify vertices", PassKind::compute,
        [&](PassBuilder& pass) {
            for (const Buffer input : {h.positions, h.sites, h.bins}) pass.read(input, reads);
            h.site_of = pass.write(h.site_of, Access::storage_write_compute);
        },
        [this](PassContext& context) {
            bind(context.commands, vertices);
            vkCmdDispatch(context.commands, groups(vertex_count), 1, 1);
        });
    graph.add_pass(
        "classify triangles", PassKind::compute,
        [&](PassBuilder& pass) {
            for (const Buffer input : {h.site_of, h.triangle_indices}) pass.read(input, reads);
            for (Buffer* made : {&h.pattern_of, &h.crossing}) *made = pass.write(*made, Access::storage_write_compute);
            h.count = pass.write(h.count, Access::storage_read_write_compute);
        },
        [this](PassContext& context) {
            bind(context.commands, triangles);
            vkCmdDispatch(context.commands, groups(triangle_count), 1, 1);
        });
    graph.add_pass(
        "count crossing", PassKind::compute,
        [&](PassBuilder& pass) {
            pass.read(h.count, reads);
            h.dispatch = pass.write(h.dispatch, Access::storage_write_compute);
        },
        [this](PassContext& context) {
            bind(context.commands, crossing_groups);
            vkCmdDispatch(context.commands, 1, 1, 1);
        });
    graph.add_pass(
        "signs of crossing", PassKind::compute,
        [&](PassBuilder& pass) {
            for (const Buffer input :
                 {h.positions, h.triangle_indices, h.sites, h.site_positions, h.bins, h.site_of, h.crossing, h.count})
                pass.read(input, reads);
            pass.read(h.dispatch, Access::indirect_read);
            h.pattern_of = pass.write(h.pattern_of, Access::storage_write_compute);
        },
        [h, this](PassContext& context) {
            bind(context.commands, signs);
            vkCmdDispatchIndirect(context.commands, context.buffer(h.dispatch), 0);
        });
}

void GpuClassifier::State::submit() {
    FrameGraph graph;
    External external;
    Handles h(graph, external, *this);
    add_copies_in(graph, h);
    add_dispatches(graph, h);
    graph.add_pass(
        "read answers back", PassKind::transfer,
        [&](PassBuilder& pass) {
            for (const Buffer answers : {h.site_of, h.pattern_of}) pass.read(answers, Access::transfer_read);
            for (Buffer* out : {&h.vertex_out, &h.triangle_out}) *out = pass.write(*out, Access::transfer_write);
        },
        [h, this](PassContext& context) {
            copy(context, h.site_of, h.vertex_out, vertex_bytes);
            copy(context, h.pattern_of, h.triangle_out, triangle_bytes);
        });

    CompileResult plan = std::move(graph).compile(executor.memory_needs());
    if (!plan) throw VulkanFailure{{Status::invalid_argument, plan.error().message}};
    commands.begin();
    executor.record(*plan, external, commands.buffer());
    commands.submit({}, {});
}

GpuClassifier::GpuClassifier(std::unique_ptr<State> state) : state_(std::move(state)) {}
GpuClassifier::~GpuClassifier() = default;

Result<std::unique_ptr<GpuClassifier>> GpuClassifier::create(Device& device) {
    return guarded([&]() -> Result<std::unique_ptr<GpuClassifier>> {
        return std::unique_ptr<GpuClassifier>(new GpuClassifier(std::make_unique<State>(device)));
    });
}

bool GpuClassifier::start(const Problem& problem) {
    const Result<void> done = guarded([&]() -> Result<void> {
        state_->started = false;
        state_->commands.wait(); // for the submission of a fracture that never called finish()
        if (!state_->fits(problem))
            return Error{Status::invalid_argument,
                         "the mesh exceeds the device's limit for storage buffers or dispatches"};
        state_->write(problem);
        state_->submit();
        state_->started = true;
        return {};
    });
    state_->error = done ? "" : done.error().message;
    return bool(done);
}

bool GpuClassifier::finish(std::span<uint32_t> site_of_vertex, std::span<uint32_t> site_of_triangle) {
    if (!state_->started || site_of_vertex.size() != state_->vertex_count
        || site_of_triangle.size() != state_->triangle_count) {
        state_->error = "finish() was called without start() for the same mesh";
        return false;
    }
    state_->started = false;
    const Result<void> done = guarded([&]() -> Result<void> {
        state_->commands.wait();
        state_->times = state_->executor.collect_times();
        return {};
    });
    state_->error = done ? "" : done.error().message;
    if (!done) return false;
    std::memcpy(site_of_vertex.data(), state_->vertex_answers.mapped(), site_of_vertex.size_bytes());
    std::memcpy(site_of_triangle.data(), state_->triangle_answers.mapped(), site_of_triangle.size_bytes());
    return true;
}

const std::vector<PassTime>& GpuClassifier::timings() const {
    return state_->times;
}

const std::string& GpuClassifier::error() const {
    return state_->error;
}

} // namespace brittle::engine
