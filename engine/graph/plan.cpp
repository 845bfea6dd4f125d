// From a checked declaration to a plan. FrameGraph::compile(), at the end, is the table of contents.
#include "engine/graph/frame_graph.h"

#include <algorithm>
#include <map>

namespace brittle::engine {
namespace {

bool lifetimes_overlap(const Plan::Resource& a, const Plan::Resource& b) {
    return a.first_pass <= b.last_pass && b.first_pass <= a.last_pass;
}

bool bytes_overlap(const Memory& a, const Memory& b) {
    return a.heap == b.heap && a.offset < b.offset + b.size && b.offset < a.offset + a.size;
}

std::uint64_t align_up(std::uint64_t value, std::uint64_t alignment) {
    return (value + alignment - 1) & ~(alignment - 1);
}

// --- Lifetimes -------------------------------------------------------------------------------------------

void find_lifetimes(Plan& plan) {
    for (std::uint32_t p = 0; p < plan.passes.size(); ++p)
        for (const Plan::Use& use : plan.passes[p].uses) {
            Plan::Resource& resource = plan.resources[use.resource];
            if (!resource.used()) resource.first_pass = p;
            resource.last_pass = p;
            resource.accesses |= use.access;
        }
    for (Plan::Resource& resource : plan.resources)
        resource.accesses |= resource.import.initial | resource.import.final;
}

// --- Memory ----------------------------------------------------------------------------------------------

std::uint32_t find_or_add_heap(std::vector<Plan::Heap>& heaps, const MemoryNeed& need) {
    const auto found = std::find_if(heaps.begin(), heaps.end(),
                                    [&](const Plan::Heap& heap) { return heap.memory_class == need.memory_class; });
    if (found == heaps.end()) {
        heaps.push_back({need.memory_class, 0, need.alignment});
        return static_cast<std::uint32_t>(heaps.size() - 1);
    }
    found->alignment = std::max(found->alignment, need.alignment);
    return static_cast<std::uint32_t>(found - heaps.begin());
}

// The lowest aligned offset where `size` bytes clash with none of `taken`.
std::uint64_t first_fit(std::vector<Memory>& taken, std::uint64_t size, std::uint64_t alignment) {
    std::sort(taken.begin(), taken.end(), [](const Memory& a, const Memory& b) { return a.offset < b.offset; });
    std::uint64_t offset = 0;
    for (const Memory& memory : taken) {
        if (offset + size <= memory.offset) break;
        offset = std::max(offset, align_up(memory.offset + memory.size, alignment));
    }
    return offset;
}

// Places transients greedily by size: the largest first, each at the lowest offset that is free for its whole lifetime.
// Optimal packing is NP-hard; on frame graphs, greedy-by-size is at or near the lower bound (Pisarchyk and Lee, 2020).
// Quadratic in the number of transients; a frame has tens.
void place_transients(Plan& plan, const MemoryNeeds& needs) {
    struct Item {
        Plan::Resource* resource;
        std::uint64_t alignment;
    };
    std::vector<Item> items;
    for (Plan::Resource& resource : plan.resources) {
        if (resource.imported || !resource.used()) continue;
        const MemoryNeed need = needs(resource);
        assert(need.alignment && !(need.alignment & (need.alignment - 1)));
        resource.memory = {find_or_add_heap(plan.heaps, need), 0, need.size};
        items.push_back({&resource, need.alignment});
    }
    std::stable_sort(items.begin(), items.end(),
                     [](const Item& a, const Item& b) { return a.resource->memory.size > b.resource->memory.size; });

    std::vector<Memory> taken;
    for (std::size_t i = 0; i < items.size(); ++i) {
        Plan::Resource& resource = *items[i].resource;
        Memory& memory = resource.memory;
        taken.clear();
        for (std::size_t k = 0; k < i; ++k)
            if (items[k].resource->memory.heap == memory.heap && lifetimes_overlap(*items[k].resource, resource))
                taken.push_back(items[k].resource->memory);
        memory.offset = first_fit(taken, memory.size, items[i].alignment);
        std::uint64_t& heap_size = plan.heaps[memory.heap].size;
        heap_size = std::max(heap_size, memory.offset + memory.size);
    }
}

// --- Barriers --------------------------------------------------------------------------------------------

constexpr std::uint32_t before_frame = ~0u;

// An interval of a resource's life that needs no barrier inside: one write, or consecutive reads in one layout.
// Every step from one epoch to the next is one barrier, placed before the first pass of the next epoch, with all
// accesses of both. It covers hazards between the two epochs directly, and earlier ones by a chain: the accesses of an
// epoch wait for all accesses of the previous one.
struct Epoch {
    std::uint32_t first; // index of the first pass; before_frame; or the number of passes, for the final accesses
    AccessSet accesses;
    Layout layout; // undefined for buffers
    bool writes;
    bool discards; // starts by replacing all contents
};
using Timeline = std::vector<Epoch>;

Epoch make_epoch(std::uint32_t pass, AccessSet accesses, bool image) {
    Epoch epoch{pass, accesses, Layout::undefined, false, true};
    accesses.for_each([&](Access access) {
        const AccessTraits& t = traits(access);
        if (image) epoch.layout = t.layout; // equal for all accesses; the declaration has checked it
        epoch.writes |= t.writes;
        epoch.discards &= t.writes && !t.keeps;
    });
    return epoch;
}

// Appends an epoch, or merges it into the last one if both only read in one layout. The epoch before the frame has no
// barrier that could be widened: a read joins it only if the import's initial accesses contain that read.
void append(Timeline& timeline, const Epoch& next) {
    if (!timeline.empty()) {
        Epoch& last = timeline.back();
        const bool reads_in_a_row = !last.writes && !next.writes && last.layout == next.layout;
        if (reads_in_a_row && (last.first != before_frame || last.accesses.contains(next.accesses))) {
            last.accesses |= next.accesses;
            return;
        }
    }
    timeline.push_back(next);
}

// Returns the union of a pass's accesses to each of its resources. Appended one by one, the pass's first read might
// join the initial epoch and its second read open a new one; the barrier of the new epoch would precede the first read
// and hide it from the next write.
std::map<std::uint32_t, AccessSet> merged_uses(const Plan::Pass& pass) {
    std::map<std::uint32_t, AccessSet> merged;
    for (const Plan::Use& use : pass.uses) merged[use.resource] |= use.access;
    return merged;
}

std::vector<Timeline> make_timelines(const Plan& plan) {
    std::vector<Timeline> timelines(plan.resources.size());
    const auto add = [&](std::uint32_t r, std::uint32_t pass, AccessSet accesses) {
        if (!accesses.empty()) append(timelines[r], make_epoch(pass, accesses, plan.resources[r].is_image()));
    };
    for (std::uint32_t r = 0; r < plan.resources.size(); ++r) add(r, before_frame, plan.resources[r].import.initial);
    const auto pass_count = static_cast<std::uint32_t>(plan.passes.size());
    for (std::uint32_t p = 0; p < pass_count; ++p)
        for (const auto& [resource, accesses] : merged_uses(plan.passes[p])) add(resource, p, accesses);
    for (std::uint32_t r = 0; r < plan.resources.size(); ++r) add(r, pass_count, plan.resources[r].import.final);
    return timelines;
}

// Returns the last accesses, before the first use of `resource`, to the bytes that it reuses. The last epoch of each
// earlier owner suffices: its barriers chain it to the epochs before.
AccessSet inherited_accesses(const Plan& plan, const std::vector<Timeline>& timelines, const Plan::Resource& resource) {
    AccessSet accesses;
    for (std::size_t r = 0; r < plan.resources.size(); ++r) {
        const Plan::Resource& other = plan.resources[r];
        if (!other.imported && other.used() && other.last_pass < resource.first_pass
            && bytes_overlap(other.memory, resource.memory))
            accesses |= timelines[r].back().accesses;
    }
    return accesses;
}

void place_barriers(Plan& plan) {
    const std::vector<Timeline> timelines = make_timelines(plan);
    for (std::uint32_t r = 0; r < plan.resources.size(); ++r) {
        const Plan::Resource& resource = plan.resources[r];
        const Epoch* previous = nullptr;
        for (const Epoch& epoch : timelines[r]) {
            Plan::Barrier barrier{r, {}, epoch.accesses, Layout::undefined, epoch.layout, false};
            if (previous) {
                barrier.before = previous->accesses;
                if (!epoch.discards) barrier.from = previous->layout;
            } else if (!resource.imported) {
                barrier.before = inherited_accesses(plan, timelines, resource);
                barrier.aliasing = !barrier.before.empty();
            }
            previous = &epoch;
            if (epoch.first == before_frame) continue;
            // Without earlier accesses a buffer needs no barrier; an image still needs its transition from `undefined`.
            if (barrier.before.empty() && !resource.is_image()) continue;
            const bool after_frame = epoch.first == plan.passes.size();
            (after_frame ? plan.final_barriers : plan.passes[epoch.first].barriers).push_back(barrier);
        }
    }
}

} // namespace

// A pass is live if it has a side effect, makes the last version of an import, or makes a version that a live pass
// needs. Passes depend only on earlier passes, so one sweep from the last pass to the first finds all live ones.
std::vector<bool> FrameGraph::find_live_passes() const {
    std::vector<bool> live(passes_.size());
    const auto need = [&](std::uint32_t resource, std::uint32_t version) {
        const std::uint32_t writer = writers_[resource][version];
        if (writer != no_pass) live[writer] = true;
    };
    for (std::uint32_t r = 0; r < resources_.size(); ++r)
        if (resources_[r].imported) need(r, newest(r));
    for (std::size_t p = passes_.size(); p-- > 0;) {
        if (!passes_[p].side_effect && !live[p]) continue;
        live[p] = true;
        for (const Plan::Use& use : passes_[p].uses) {
            const AccessTraits& t = traits(use.access);
            if (!t.writes) need(use.resource, use.version);
            if (t.keeps) need(use.resource, use.version - 1);
        }
    }
    return live;
}

CompileResult FrameGraph::compile(const MemoryNeeds& needs) && {
    check_final_accesses();
    if (!errors_.empty()) {
        std::string message;
        for (const std::string& error : errors_) message += (message.empty() ? "" : "\n") + error;
        return GraphError{std::move(message)};
    }
    Plan plan;
    const std::vector<bool> live = find_live_passes();
    for (std::size_t p = 0; p < passes_.size(); ++p)
        (live[p] ? plan.passes : plan.culled).push_back(std::move(passes_[p]));
    plan.resources = std::move(resources_);
    find_lifetimes(plan);
    place_transients(plan, needs);
    place_barriers(plan);
    return plan;
}

} // namespace brittle::engine
