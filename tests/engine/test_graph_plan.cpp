// The oracle below knows of the plan only what a device would see: it replays passes and barriers in order
// and searches every pair of accesses for a chain of barriers. What each access does it takes from a table of
// its own.
#include "engine/graph/frame_graph.h"

#include <doctest/doctest.h>

#include <algorithm>
#include <map>
#include <set>
#include <sstream>

using namespace brittle::engine;

namespace {

constexpr ImageDesc small_image{.width = 4, .height = 4};
constexpr BufferDesc small_buffer{.size = 64};

MemoryNeed need_100(const Plan::Resource&) {
    return {.size = 100};
}

// Compiles a graph that must be right.
Plan compiled(FrameGraph& graph, const MemoryNeeds& needs = need_100) {
    CompileResult result = std::move(graph).compile(needs);
    REQUIRE_MESSAGE(result, (result ? "" : result.error().message));
    return std::move(*result);
}

// Compiles a graph that must be wrong.
std::string error_of(FrameGraph& graph) {
    const CompileResult result = std::move(graph).compile(need_100);
    REQUIRE_FALSE(result);
    return result.error().message;
}

bool contains(const std::string& text, const std::string& part) {
    return text.find(part) != std::string::npos;
}

std::vector<std::string> names(const std::vector<Plan::Pass>& passes) {
    std::vector<std::string> out;
    for (const Plan::Pass& pass : passes) out.push_back(pass.name);
    return out;
}

using Names = std::vector<std::string>;

template<class Setup>
void add(FrameGraph& graph, const char* name, PassKind kind, Setup&& setup) {
    graph.add_pass(name, kind, setup, [](PassContext&) {});
}

// --- The oracle ------------------------------------------------------------------------------------------

struct AccessFacts {
    Access access;
    PassKind kind;
    bool image, buffer;
    bool reads, writes;
    bool replaces; // a write that leaves nothing of what was there
    Layout layout; // of an image
};

constexpr PassKind G = PassKind::graphics, C = PassKind::compute, T = PassKind::transfer;
constexpr AccessFacts facts_table[] = {
    {Access::transfer_read, T, true, true, true, false, false, Layout::transfer_source},
    {Access::transfer_write, T, true, true, false, true, false, Layout::transfer_target},
    {Access::indirect_read, G, false, true, true, false, false, Layout::undefined},
    {Access::indirect_read, C, false, true, true, false, false, Layout::undefined},
    {Access::index_read, G, false, true, true, false, false, Layout::undefined},
    {Access::vertex_read, G, false, true, true, false, false, Layout::undefined},
    {Access::uniform_read, G, false, true, true, false, false, Layout::undefined},
    {Access::uniform_read, C, false, true, true, false, false, Layout::undefined},
    {Access::sampled_fragment, G, true, false, true, false, false, Layout::read_only},
    {Access::sampled_compute, C, true, false, true, false, false, Layout::read_only},
    {Access::storage_read_vertex, G, true, true, true, false, false, Layout::general},
    {Access::storage_read_fragment, G, true, true, true, false, false, Layout::general},
    {Access::storage_write_fragment, G, true, true, false, true, false, Layout::general},
    {Access::storage_read_write_fragment, G, true, true, true, true, false, Layout::general},
    {Access::storage_read_compute, C, true, true, true, false, false, Layout::general},
    {Access::storage_write_compute, C, true, true, false, true, false, Layout::general},
    {Access::storage_read_write_compute, C, true, true, true, true, false, Layout::general},
    {Access::colour_attachment, G, true, false, false, true, true, Layout::attachment},
    {Access::colour_attachment_load, G, true, false, true, true, false, Layout::attachment},
    {Access::depth_attachment, G, true, false, false, true, true, Layout::attachment},
    {Access::depth_attachment_load, G, true, false, true, true, false, Layout::attachment},
    {Access::depth_read, G, true, false, true, false, false, Layout::read_only},
};

AccessFacts facts(Access access) {
    for (const AccessFacts& f : facts_table)
        if (f.access == access) return f;
    switch (access) {
    case Access::acquired:
        return {access, G, true, false, false, true, false, Layout::undefined};
    case Access::present:
        return {access, G, true, false, true, false, false, Layout::present};
    case Access::host_write:
        return {access, G, false, true, false, true, false, Layout::undefined};
    case Access::host_read:
        return {access, G, false, true, true, false, false, Layout::undefined};
    default:
        FAIL("no facts about ", to_string(access));
        return {};
    }
}

// One access at one position: -1 before the frame, pass index, number of passes after the frame.
struct Event {
    int position;
    std::uint32_t resource;
    Access access;
};

std::vector<Event> events_of(const Plan& plan) {
    std::vector<Event> events;
    for (std::uint32_t r = 0; r < plan.resources.size(); ++r) {
        plan.resources[r].import.initial.for_each([&](Access a) { events.push_back({-1, r, a}); });
        plan.resources[r].import.final.for_each([&](Access a) {
            events.push_back({static_cast<int>(plan.passes.size()), r, a});
        });
    }
    for (std::size_t p = 0; p < plan.passes.size(); ++p)
        for (const Plan::Use& use : plan.passes[p].uses)
            events.push_back({static_cast<int>(p), use.resource, use.access});
    return events;
}

const std::vector<Plan::Barrier>& barriers_at(const Plan& plan, int position) {
    const auto p = static_cast<std::size_t>(position);
    return p < plan.passes.size() ? plan.passes[p].barriers : plan.final_barriers;
}

bool share_bytes(const Plan& plan, std::uint32_t a, std::uint32_t b) {
    const Plan::Resource &x = plan.resources[a], &y = plan.resources[b];
    if (a == b || x.imported || y.imported || !x.used() || !y.used() || x.memory.heap != y.memory.heap)
        return false;
    for (std::uint64_t byte = x.memory.offset; byte < x.memory.offset + x.memory.size; ++byte)
        if (byte >= y.memory.offset && byte < y.memory.offset + y.memory.size) return true;
    return false;
}

bool is_hazard(const Plan& plan, const Event& i, const Event& j) {
    if (i.position >= j.position) return false;
    if (i.resource != j.resource) return share_bytes(plan, i.resource, j.resource);
    const AccessFacts a = facts(i.access), b = facts(j.access);
    if (a.writes || b.writes) return true;
    if (plan.resources[i.resource].is_image() && a.layout != b.layout) return true;
    // Reads before the frame promise visibility for themselves alone.
    return i.position == -1 && !plan.resources[i.resource].import.initial.contains(j.access);
}

// Whether j waits for i, through barriers each of which waits for something that waits for i.
bool is_chained(const Plan& plan, const Event& i, const Event& j) {
    AccessSet waiting_in_i, waiting_in_j;
    for (int position = i.position + 1; position <= j.position; ++position)
        for (const Plan::Barrier& barrier : barriers_at(plan, position)) {
            if (barrier.resource == i.resource
                && (barrier.before.contains(i.access) || barrier.before.intersects(waiting_in_i)))
                waiting_in_i |= barrier.after;
            if (barrier.resource != j.resource || i.resource == j.resource) continue;
            const bool takes_over =
                barrier.aliasing
                && (barrier.before.contains(i.access) || barrier.before.intersects(waiting_in_i));
            if (takes_over || barrier.before.intersects(waiting_in_j)) waiting_in_j |= barrier.after;
        }
    return (i.resource == j.resource ? waiting_in_i : waiting_in_j).contains(j.access);
}

// Replays layouts. An image must be in the layout of each access, and may be discarded only where nobody
// misses what it held.
std::string layout_fault(const Plan& plan) {
    const std::vector<Event> events = events_of(plan);
    for (std::uint32_t r = 0; r < plan.resources.size(); ++r) {
        if (!plan.resources[r].is_image()) continue;
        Layout layout = Layout::undefined;
        bool precious = false; // contents that must not be discarded
        for (int position = -1; position <= static_cast<int>(plan.passes.size()); ++position) {
            bool replaces = false;
            for (const Event& event : events)
                if (event.resource == r && event.position == position)
                    replaces |= facts(event.access).replaces;
            for (const Plan::Barrier& barrier :
                 position < 0 ? std::vector<Plan::Barrier>{} : barriers_at(plan, position)) {
                if (barrier.resource != r) continue;
                if (barrier.from == Layout::undefined && precious && !replaces)
                    return "contents of " + plan.resources[r].name + " discarded";
                if (barrier.from != Layout::undefined && barrier.from != layout)
                    return "transition of " + plan.resources[r].name + " from a layout it is not in";
                layout = barrier.to;
            }
            for (const Event& event : events) {
                if (event.resource != r || event.position != position) continue;
                const AccessFacts f = facts(event.access);
                if (position < 0)
                    layout = f.layout;
                else if (layout != f.layout)
                    return plan.resources[r].name + " is in the wrong layout for " + to_string(event.access);
                precious |= event.access != Access::acquired;
            }
        }
    }
    return {};
}

// The first thing wrong with the plan's barriers, or nothing.
std::string barrier_fault(const Plan& plan) {
    const std::vector<Event> events = events_of(plan);
    for (const Event& i : events)
        for (const Event& j : events)
            if (is_hazard(plan, i, j) && !is_chained(plan, i, j))
                return "no barrier from " + plan.resources[i.resource].name + " " + to_string(i.access)
                       + " at " + std::to_string(i.position) + " to " + plan.resources[j.resource].name + " "
                       + to_string(j.access) + " at " + std::to_string(j.position);
    return layout_fault(plan);
}

std::string memory_fault(const Plan& plan, const MemoryNeeds& needs) {
    for (std::uint32_t a = 0; a < plan.resources.size(); ++a) {
        const Plan::Resource& x = plan.resources[a];
        if (x.imported || !x.used()) continue;
        const MemoryNeed need = needs(x);
        if (x.memory.heap >= plan.heaps.size()) return x.name + " has no heap";
        const Plan::Heap& heap = plan.heaps[x.memory.heap];
        if (heap.memory_class != need.memory_class) return x.name + " is in a heap of another class";
        if (x.memory.size != need.size || x.memory.offset % need.alignment) return x.name + " is misplaced";
        if (heap.alignment % need.alignment) return "heap of " + x.name + " is too weakly aligned";
        if (x.memory.offset + x.memory.size > heap.size) return x.name + " sticks out of its heap";
        for (std::uint32_t b = 0; b < a; ++b) {
            const Plan::Resource& y = plan.resources[b];
            const bool apart = x.last_pass < y.first_pass || y.last_pass < x.first_pass;
            if (!apart && share_bytes(plan, a, b))
                return x.name + " and " + y.name + " live in the same bytes";
        }
    }
    return {};
}

std::vector<std::vector<Plan::Barrier>*> barrier_lists(Plan& plan) {
    std::vector<std::vector<Plan::Barrier>*> lists{&plan.final_barriers};
    for (Plan::Pass& pass : plan.passes) lists.push_back(&pass.barriers);
    return lists;
}

// Takes each barrier away in turn: the oracle must miss it, or it was superfluous.
std::string superfluous_barrier(Plan& plan) {
    for (std::vector<Plan::Barrier>* list : barrier_lists(plan))
        for (std::size_t b = 0; b < list->size(); ++b) {
            const Plan::Barrier barrier = (*list)[b];
            list->erase(list->begin() + static_cast<std::ptrdiff_t>(b));
            const bool missed = !barrier_fault(plan).empty();
            list->insert(list->begin() + static_cast<std::ptrdiff_t>(b), barrier);
            if (!missed)
                return plan.resources[barrier.resource].name + ": " + to_string(barrier.before) + " to "
                       + to_string(barrier.after);
        }
    return {};
}

void check_sound(Plan& plan, const MemoryNeeds& needs = need_100) {
    CHECK(barrier_fault(plan) == "");
    CHECK(memory_fault(plan, needs) == "");
    CHECK(superfluous_barrier(plan) == "");
}

// --- Random graphs ---------------------------------------------------------------------------------------

// SplitMix64.
class Random {
  public:
    explicit Random(std::uint64_t seed) : state_(seed) {}
    std::uint32_t below(std::uint32_t bound) {
        std::uint64_t z = (state_ += 0x9e3779b97f4a7c15ull);
        z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9ull;
        z = (z ^ (z >> 27)) * 0x94d049bb133111ebull;
        return static_cast<std::uint32_t>((z ^ (z >> 31)) >> 33) % bound;
    }

  private:
    std::uint64_t state_;
};

MemoryNeed random_need(const Plan::Resource& resource) {
    Random random(std::hash<std::string>{}(resource.name));
    return {
        .size = 1 + random.below(300), .alignment = 1u << random.below(7), .memory_class = random.below(2)};
}

// A random legal graph, with what the test itself knows of it: for each pass the passes whose results it
// needs.
class RandomGraph {
  public:
    explicit RandomGraph(std::uint64_t seed) : random_(seed) {
        const std::uint32_t resources = 2 + random_.below(9);
        for (std::uint32_t r = 0; r < resources; ++r) add_resource(r);
        const std::uint32_t passes = 1 + random_.below(16);
        for (std::uint32_t p = 0; p < passes; ++p) add_pass(p);
    }

    FrameGraph graph;

    // Names of the passes from which an output can be reached.
    [[nodiscard]] std::set<std::string> expected_live() const {
        std::set<std::string> live;
        for (std::size_t p = 0; p < passes_.size(); ++p)
            if (passes_[p].side_effect) mark(static_cast<int>(p), live);
        for (const Resource& resource : resources_)
            if (resource.imported) mark(resource.writer, live);
        return live;
    }

  private:
    struct Resource {
        bool is_image, imported, read_only, defined;
        Image image;
        Buffer buffer;
        int writer = -1; // pass that made the newest version
    };
    struct Pass {
        bool side_effect = false;
        std::vector<int> needs;
    };

    void mark(int pass, std::set<std::string>& live) const {
        if (pass < 0 || !live.insert("pass" + std::to_string(pass)).second) return;
        for (const int needed : passes_[static_cast<std::size_t>(pass)].needs) mark(needed, live);
    }

    void add_resource(std::uint32_t r) {
        Resource resource{};
        resource.is_image = random_.below(2);
        resource.imported = random_.below(3) == 0;
        const std::string name = (resource.is_image ? "image" : "buffer") + std::to_string(r);
        if (resource.imported) {
            static const AccessSet image_edges[] = {Access::acquired,
                                                    {},
                                                    Access::sampled_fragment,
                                                    Access::transfer_read,
                                                    Access::sampled_fragment | Access::sampled_compute,
                                                    Access::storage_write_compute};
            static const AccessSet buffer_edges[] = {Access::host_write,
                                                     {},
                                                     Access::vertex_read | Access::index_read,
                                                     Access::storage_read_compute,
                                                     Access::transfer_write,
                                                     Access::storage_write_compute | Access::vertex_read};
            Import import{.initial = (resource.is_image ? image_edges : buffer_edges)[random_.below(6)]};
            resource.defined = !import.initial.empty() && import.initial != AccessSet(Access::acquired);
            resource.read_only = resource.defined && random_.below(4) == 0;
            import.read_only = resource.read_only;
            // A reading final access wants contents; without them the graph would rightly be refused.
            static const AccessSet final_edges[][3] = {
                {{}, Access::host_read, Access::vertex_read | Access::storage_read_compute},
                {{}, Access::present, Access::sampled_compute}};
            if (resource.defined) import.final = final_edges[resource.is_image][random_.below(3)];
            if (resource.is_image)
                resource.image = graph.import_image(name, small_image, import);
            else
                resource.buffer = graph.import_buffer(name, small_buffer, import);
        } else if (resource.is_image) {
            resource.image = graph.create_image(name, small_image);
        } else {
            resource.buffer = graph.create_buffer(name, small_buffer);
        }
        resources_.push_back(resource);
    }

    void add_pass(std::uint32_t p) {
        Pass& pass = passes_.emplace_back();
        const auto kind = static_cast<PassKind>(random_.below(3));
        graph.add_pass(
            "pass" + std::to_string(p), kind,
            [&](PassBuilder& builder) {
                if (random_.below(12) == 0) {
                    pass.side_effect = true;
                    builder.side_effect();
                }
                std::map<std::size_t, Layout> used;
                for (std::uint32_t uses = 1 + random_.below(5); uses > 0; --uses)
                    add_use(builder, pass, static_cast<int>(p), kind, used);
            },
            [](PassContext&) {});
    }

    void add_use(PassBuilder& builder, Pass& pass, int p, PassKind kind,
                 std::map<std::size_t, Layout>& used) {
        const std::size_t r = random_.below(static_cast<std::uint32_t>(resources_.size()));
        Resource& resource = resources_[r];
        const AccessFacts& f = facts_table[random_.below(std::size(facts_table))];
        if (f.kind != kind || !(resource.is_image ? f.image : f.buffer)) return;
        if (f.reads && !resource.defined) return;
        if (f.writes && resource.read_only) return;
        const bool again = used.count(r);
        const bool reads_agree = !f.writes && (!resource.is_image || (again && used[r] == f.layout));
        if (again && (!reads_agree || wrote_.count({p, r}))) return;
        used[r] = f.layout;
        if (!f.replaces) pass.needs.push_back(resource.writer);
        if (!f.writes) {
            resource.is_image ? builder.read(resource.image, f.access)
                              : builder.read(resource.buffer, f.access);
            return;
        }
        wrote_.insert({p, r});
        if (resource.is_image)
            resource.image = builder.write(resource.image, f.access);
        else
            resource.buffer = builder.write(resource.buffer, f.access);
        resource.writer = p;
        resource.defined = true;
    }

    Random random_;
    std::vector<Resource> resources_;
    std::vector<Pass> passes_;
    std::set<std::pair<int, std::size_t>> wrote_;
};

} // namespace

// --- Degenerate ------------------------------------------------------------------------------------------

TEST_CASE("an empty graph compiles to an empty plan") {
    FrameGraph graph;
    const Plan plan = compiled(graph);
    CHECK(plan.passes.empty());
    CHECK(plan.final_barriers.empty());
    CHECK(plan.heaps.empty());
    CHECK(contains(to_dot(plan), "digraph"));
}

TEST_CASE("a resource that no live pass uses gets no memory and no barrier") {
    FrameGraph graph;
    (void)graph.create_image("unused", small_image);
    (void)graph.import_buffer("arena", small_buffer,
                              {.initial = Access::vertex_read, .final = Access::vertex_read});
    const Plan plan = compiled(graph);
    CHECK_FALSE(plan.resources[0].used());
    CHECK(plan.heaps.empty());
    CHECK(plan.final_barriers.empty());
}

TEST_CASE("a default-made handle names nothing") {
    CHECK_FALSE(Image().valid());
    CHECK(Image(3, 2).valid());
    CHECK(Image(3, 2).resource() == 3);
    CHECK(Image(3, 2).version() == 2);
    CHECK(Image(3, 2) != Image(3, 1));
    static_assert(sizeof(Image) == 4);
    static_assert(!std::is_convertible_v<Image, Buffer>);
}

TEST_CASE("the planner's facts about each access agree with the tests' own table") {
    for (const AccessFacts& f : facts_table) {
        CAPTURE(to_string(f.access));
        const AccessTraits& t = traits(f.access);
        CHECK(t.reads == f.reads);
        CHECK(t.writes == f.writes);
        CHECK((t.writes && !t.keeps) == f.replaces);
        CHECK(t.images == f.image);
        CHECK(t.buffers == f.buffer);
        if (f.image) CHECK(t.layout == f.layout);
        CHECK((t.kinds >> static_cast<unsigned>(f.kind) & 1) == 1);
    }
    CHECK(to_string(Access::vertex_read | Access::index_read) == "index_read|vertex_read");
    CHECK(to_string(AccessSet{}) == "nothing");
}

// --- Hazards ---------------------------------------------------------------------------------------------

TEST_CASE("a read after a write waits for it") {
    FrameGraph graph;
    Buffer data = graph.create_buffer("data", small_buffer);
    add(graph, "make", C, [&](PassBuilder& p) { data = p.write(data, Access::storage_write_compute); });
    add(graph, "use", G, [&](PassBuilder& p) {
        p.read(data, Access::vertex_read);
        p.side_effect();
    });
    Plan plan = compiled(graph);
    CHECK(names(plan.passes) == Names{"make", "use"});
    CHECK(plan.passes[0].barriers.empty());
    REQUIRE(plan.passes[1].barriers.size() == 1);
    const Plan::Barrier& barrier = plan.passes[1].barriers[0];
    CHECK(barrier.resource == data.resource());
    CHECK(barrier.before == AccessSet(Access::storage_write_compute));
    CHECK(barrier.after == AccessSet(Access::vertex_read));
    CHECK_FALSE(barrier.aliasing);
    check_sound(plan);
}

TEST_CASE("a write after a read waits for it") {
    FrameGraph graph;
    Buffer data = graph.import_buffer("data", small_buffer, {.initial = Access::vertex_read});
    add(graph, "draw", G, [&](PassBuilder& p) {
        p.read(data, Access::vertex_read);
        p.side_effect();
    });
    add(graph, "refill", T, [&](PassBuilder& p) { data = p.write(data, Access::transfer_write); });
    Plan plan = compiled(graph);
    CHECK(plan.passes[0].barriers.empty()); // visible already, says the import
    REQUIRE(plan.passes[1].barriers.size() == 1);
    CHECK(plan.passes[1].barriers[0].before == AccessSet(Access::vertex_read));
    CHECK(plan.passes[1].barriers[0].after == AccessSet(Access::transfer_write));
    check_sound(plan);
}

TEST_CASE("a write after a write waits for it and keeps or discards what was there") {
    FrameGraph graph;
    Image colour = graph.import_image("colour", small_image, {.final = Access::transfer_read});
    add(graph, "fill", C, [&](PassBuilder& p) { colour = p.write(colour, Access::storage_write_compute); });
    add(graph, "over", G, [&](PassBuilder& p) { colour = p.write(colour, Access::colour_attachment_load); });
    Plan plan = compiled(graph);
    REQUIRE(plan.passes.size() == 2);
    CHECK(plan.passes[0].barriers.at(0).from == Layout::undefined);
    CHECK(plan.passes[0].barriers.at(0).to == Layout::general);
    CHECK(plan.passes[0].barriers.at(0).before.empty());
    CHECK(plan.passes[1].barriers.at(0).from == Layout::general);
    CHECK(plan.passes[1].barriers.at(0).to == Layout::attachment);
    CHECK(plan.final_barriers.at(0).from == Layout::attachment);
    check_sound(plan);

    FrameGraph other;
    colour = other.import_image("colour", small_image, {.initial = Access::sampled_fragment});
    add(other, "clear", G, [&](PassBuilder& p) { colour = p.write(colour, Access::colour_attachment); });
    plan = compiled(other);
    CHECK(plan.passes[0].barriers.at(0).from == Layout::undefined); // yet it waits for the old readers
    CHECK(plan.passes[0].barriers.at(0).before == AccessSet(Access::sampled_fragment));
    check_sound(plan);
}

TEST_CASE("reads in a row in different stages share one barrier that names them all") {
    FrameGraph graph;
    Image map = graph.create_image("map", small_image);
    add(graph, "make", G, [&](PassBuilder& p) { map = p.write(map, Access::depth_attachment); });
    for (const auto& [name, kind, access] :
         {std::tuple{"first", G, Access::sampled_fragment}, std::tuple{"second", C, Access::sampled_compute},
          std::tuple{"third", G, Access::depth_read}})
        add(graph, name, kind, [&, a = access](PassBuilder& p) {
            p.read(map, a);
            p.side_effect();
        });
    Plan plan = compiled(graph);
    REQUIRE(plan.passes[1].barriers.size() == 1);
    CHECK(plan.passes[1].barriers[0].after
          == (Access::sampled_fragment | Access::sampled_compute | Access::depth_read));
    CHECK(plan.passes[2].barriers.empty());
    CHECK(plan.passes[3].barriers.empty());
    check_sound(plan);
}

TEST_CASE("reads of an image in two layouts need a transition between them") {
    FrameGraph graph;
    Image image = graph.create_image("image", small_image);
    add(graph, "make", C, [&](PassBuilder& p) { image = p.write(image, Access::storage_write_compute); });
    add(graph, "sample", G, [&](PassBuilder& p) {
        p.read(image, Access::sampled_fragment);
        p.side_effect();
    });
    add(graph, "copy", T, [&](PassBuilder& p) {
        p.read(image, Access::transfer_read);
        p.side_effect();
    });
    Plan plan = compiled(graph);
    CHECK(plan.passes[2].barriers.at(0).from == Layout::read_only);
    CHECK(plan.passes[2].barriers.at(0).to == Layout::transfer_source);
    check_sound(plan);
}

TEST_CASE("a diamond runs its arms after its top and before its bottom") {
    FrameGraph graph;
    Buffer top = graph.create_buffer("top", small_buffer);
    Buffer left = graph.create_buffer("left", small_buffer);
    Buffer right = graph.create_buffer("right", small_buffer);
    Buffer out = graph.import_buffer("out", small_buffer, {.final = Access::host_read});
    add(graph, "top", C, [&](PassBuilder& p) { top = p.write(top, Access::storage_write_compute); });
    add(graph, "left", C, [&](PassBuilder& p) {
        p.read(top, Access::storage_read_compute);
        left = p.write(left, Access::storage_write_compute);
    });
    add(graph, "right", C, [&](PassBuilder& p) {
        p.read(top, Access::uniform_read);
        right = p.write(right, Access::storage_write_compute);
    });
    add(graph, "bottom", C, [&](PassBuilder& p) {
        p.read(left, Access::storage_read_compute);
        p.read(right, Access::storage_read_compute);
        out = p.write(out, Access::storage_write_compute);
    });
    Plan plan = compiled(graph);
    CHECK(names(plan.passes) == Names{"top", "left", "right", "bottom"});
    CHECK(plan.passes[1].barriers.size() == 1);
    CHECK(plan.passes[1].barriers[0].after == (Access::storage_read_compute | Access::uniform_read));
    CHECK(plan.passes[2].barriers.empty());
    CHECK(plan.passes[3].barriers.size() == 2);
    CHECK(plan.final_barriers.size() == 1);
    check_sound(plan);
}

// --- Imports ---------------------------------------------------------------------------------------------

TEST_CASE("a swapchain image goes from acquired to drawn to present") {
    FrameGraph graph;
    Image target = graph.import_image(
        "swapchain", small_image, {.initial = Access::acquired, .final = Access::present, .external = 42});
    add(graph, "draw", G, [&](PassBuilder& p) { target = p.write(target, Access::colour_attachment); });
    Plan plan = compiled(graph);
    const Plan::Barrier& first = plan.passes.at(0).barriers.at(0);
    CHECK(first.before
          == AccessSet(Access::acquired)); // else the transition would not wait for the semaphore
    CHECK(first.from == Layout::undefined);
    CHECK(first.to == Layout::attachment);
    const Plan::Barrier& last = plan.final_barriers.at(0);
    CHECK(last.before == AccessSet(Access::colour_attachment));
    CHECK(last.from == Layout::attachment);
    CHECK(last.to == Layout::present);
    CHECK(plan.resources[0].import.external == 42);
    CHECK(plan.resources[0].accesses == (Access::acquired | Access::colour_attachment | Access::present));
    CHECK(plan.heaps.empty());
    check_sound(plan);
}

TEST_CASE(
    "a read that the import's initial reads do not cover gets a barrier, one that they cover does not") {
    FrameGraph graph;
    const Buffer data =
        graph.import_buffer("data", small_buffer, {.initial = Access::vertex_read | Access::index_read});
    add(graph, "covered", G, [&](PassBuilder& p) {
        p.read(data, Access::index_read);
        p.side_effect();
    });
    add(graph, "new stage", C, [&](PassBuilder& p) {
        p.read(data, Access::storage_read_compute);
        p.side_effect();
    });
    Plan plan = compiled(graph);
    CHECK(plan.passes[0].barriers.empty());
    CHECK(plan.passes[1].barriers.size() == 1);
    check_sound(plan);
}

TEST_CASE("a final read joins the reads in a row before it") {
    FrameGraph graph;
    Image history = graph.import_image("history", small_image, {.final = Access::sampled_compute});
    add(graph, "make", G, [&](PassBuilder& p) { history = p.write(history, Access::colour_attachment); });
    add(graph, "show", G, [&](PassBuilder& p) {
        p.read(history, Access::sampled_fragment);
        p.side_effect();
    });
    Plan plan = compiled(graph);
    CHECK(plan.passes[1].barriers.at(0).after == (Access::sampled_fragment | Access::sampled_compute));
    CHECK(plan.final_barriers.empty());
    check_sound(plan);
}

// --- Culling ---------------------------------------------------------------------------------------------

TEST_CASE("passes that no output needs are culled, chains and all") {
    FrameGraph graph;
    Buffer a = graph.create_buffer("a", small_buffer);
    Buffer b = graph.create_buffer("b", small_buffer);
    Image target = graph.import_image("target", small_image, {.final = Access::present});
    add(graph, "dead start", C, [&](PassBuilder& p) { a = p.write(a, Access::storage_write_compute); });
    add(graph, "dead end", C, [&](PassBuilder& p) {
        p.read(a, Access::storage_read_compute);
        b = p.write(b, Access::storage_write_compute);
    });
    add(graph, "draw", G, [&](PassBuilder& p) { target = p.write(target, Access::colour_attachment); });
    const Plan plan = compiled(graph);
    CHECK(names(plan.passes) == Names{"draw"});
    CHECK(names(plan.culled) == Names{"dead start", "dead end"});
    CHECK(plan.heaps.empty());
}

TEST_CASE("a write that replaces the image culls earlier writes, one that loads keeps them") {
    for (const bool load : {false, true}) {
        FrameGraph graph;
        Image target = graph.import_image("target", small_image, {.final = Access::present});
        add(graph, "first", G, [&](PassBuilder& p) { target = p.write(target, Access::colour_attachment); });
        add(graph, "second", G, [&](PassBuilder& p) {
            target = p.write(target, load ? Access::colour_attachment_load : Access::colour_attachment);
        });
        const Plan plan = compiled(graph);
        CHECK(names(plan.passes) == (load ? Names{"first", "second"} : Names{"second"}));
    }
}

TEST_CASE("two copies into one buffer both live, for each may write a part") {
    FrameGraph graph;
    Buffer readback = graph.import_buffer("readback", small_buffer, {.final = Access::host_read});
    add(graph, "low half", T, [&](PassBuilder& p) { readback = p.write(readback, Access::transfer_write); });
    add(graph, "high half", T, [&](PassBuilder& p) { readback = p.write(readback, Access::transfer_write); });
    CHECK(names(compiled(graph).passes) == Names{"low half", "high half"});
}

// --- Memory ----------------------------------------------------------------------------------------------

TEST_CASE("a chain of passes lives in the memory of two images") {
    FrameGraph graph;
    std::vector<Image> images;
    for (int i = 0; i < 8; ++i) {
        images.push_back(graph.create_image("image" + std::to_string(i), small_image));
        add(graph, "step", G, [&](PassBuilder& p) {
            if (i > 0) p.read(images[images.size() - 2], Access::sampled_fragment);
            images.back() = p.write(images.back(), Access::colour_attachment);
            if (i == 7) p.side_effect();
        });
    }
    Plan plan = compiled(graph);
    REQUIRE(plan.heaps.size() == 1);
    CHECK(plan.heaps[0].size == 200);
    // Image 2 takes the bytes of image 0, which pass 1 sampled last.
    const std::vector<Plan::Barrier>& barriers = plan.passes[2].barriers;
    const auto born = std::find_if(barriers.begin(), barriers.end(), [&](const Plan::Barrier& b) {
        return b.resource == images[2].resource();
    });
    REQUIRE(born != barriers.end());
    CHECK(born->aliasing);
    CHECK(born->before == AccessSet(Access::sampled_fragment));
    CHECK(born->from == Layout::undefined);
    check_sound(plan);
}

TEST_CASE("resources of different memory classes never share a heap, and offsets are aligned") {
    FrameGraph graph;
    Image image = graph.create_image("image", small_image);
    Buffer small = graph.create_buffer("small", small_buffer);
    Buffer big = graph.create_buffer("big", small_buffer);
    add(graph, "all", C, [&](PassBuilder& p) {
        image = p.write(image, Access::storage_write_compute);
        small = p.write(small, Access::storage_write_compute);
        big = p.write(big, Access::storage_write_compute);
        p.side_effect();
    });
    const MemoryNeeds needs = [](const Plan::Resource& r) -> MemoryNeed {
        if (r.is_image()) return {.size = 10, .alignment = 1, .memory_class = 7};
        return {.size = r.name == "big" ? 100u : 5u, .alignment = 64, .memory_class = 3};
    };
    Plan plan = compiled(graph, needs);
    REQUIRE(plan.heaps.size() == 2);
    CHECK(plan.heaps[0].memory_class == 7);
    CHECK(plan.heaps[1].memory_class == 3);
    CHECK(plan.heaps[1].alignment == 64);
    CHECK(plan.resources[big.resource()].memory.offset == 0);
    CHECK(plan.resources[small.resource()].memory.offset == 128);
    CHECK(plan.heaps[1].size == 133);
    check_sound(plan, needs);
}

// --- Execute ---------------------------------------------------------------------------------------------

namespace brittle::engine {
class PassContext {
  public:
    std::string log;
};
} // namespace brittle::engine

TEST_CASE("the plan carries each pass's execute function") {
    FrameGraph graph;
    for (const char* name : {"a", "b"})
        graph.add_pass(
            name, G, [](PassBuilder& p) { p.side_effect(); },
            [name](PassContext& context) { context.log += name; });
    const Plan plan = compiled(graph);
    PassContext context;
    for (const Plan::Pass& pass : plan.passes) pass.execute(context);
    CHECK(context.log == "ab");
}

// --- Impossible graphs -----------------------------------------------------------------------------------

TEST_CASE("reading a transient before any write is refused by name") {
    FrameGraph graph;
    const Image shadow = graph.create_image("shadow", small_image);
    add(graph, "shade", G, [&](PassBuilder& p) { p.read(shadow, Access::sampled_fragment); });
    CHECK(error_of(graph) == "pass 'shade' reads 'shadow' as sampled_fragment, but no pass wrote it before");
}

TEST_CASE("loading what was never written is refused by name") {
    FrameGraph graph;
    Image target = graph.import_image("target", small_image, {.initial = Access::acquired});
    add(graph, "overlay", G,
        [&](PassBuilder& p) { target = p.write(target, Access::colour_attachment_load); });
    CHECK(error_of(graph)
          == "pass 'overlay' writes 'target' as colour_attachment_load, but it was imported with undefined "
             "contents and no "
             "pass wrote it before");
}

TEST_CASE("a dead handle is refused with the pass that killed it") {
    FrameGraph graph;
    const Buffer data = graph.create_buffer("data", small_buffer);
    add(graph, "make", C, [&](PassBuilder& p) { (void)p.write(data, Access::storage_write_compute); });
    SUBCASE("for reading") {
        add(graph, "use", C, [&](PassBuilder& p) { p.read(data, Access::storage_read_compute); });
        CHECK(error_of(graph)
              == "pass 'use' reads version 0 of 'data', but pass 'make' already replaced that version: use "
                 "the handle that "
                 "its write() returned");
    }
    SUBCASE("for writing, which would make two writers of one version") {
        add(graph, "again", C, [&](PassBuilder& p) { (void)p.write(data, Access::storage_write_compute); });
        const std::string error = error_of(graph);
        CHECK(contains(error, "pass 'again' writes version 0 of 'data'"));
        CHECK(contains(error, "pass 'make'"));
    }
}

TEST_CASE("writing a read-only import is refused by name") {
    FrameGraph graph;
    const Buffer arena =
        graph.import_buffer("arena", small_buffer, {.initial = Access::vertex_read, .read_only = true});
    add(graph, "scribble", T, [&](PassBuilder& p) { (void)p.write(arena, Access::transfer_write); });
    CHECK(error_of(graph)
          == "pass 'scribble' writes 'arena' as transfer_write, but it is imported as read-only");
}

TEST_CASE("an access that the resource, the pass or the direction does not allow is refused by name") {
    FrameGraph graph;
    const Buffer data = graph.create_buffer("data", small_buffer);
    const Image image = graph.create_image("image", small_image);
    SUBCASE("attachment access to a buffer") {
        add(graph, "p", G, [&](PassBuilder& p) { (void)p.write(data, Access::colour_attachment); });
        CHECK(error_of(graph)
              == "pass 'p' writes 'data' as colour_attachment, which is no access to a buffer");
    }
    SUBCASE("vertex access to an image") {
        add(graph, "p", G, [&](PassBuilder& p) { p.read(image, Access::vertex_read); });
        CHECK(error_of(graph) == "pass 'p' reads 'image' as vertex_read, which is no access to an image");
    }
    SUBCASE("attachment in a compute pass") {
        add(graph, "p", C, [&](PassBuilder& p) { (void)p.write(image, Access::depth_attachment); });
        CHECK(error_of(graph)
              == "pass 'p' writes 'image' as depth_attachment, which is not allowed in a compute pass");
    }
    SUBCASE("writing with a reading access") {
        add(graph, "p", C, [&](PassBuilder& p) { (void)p.write(data, Access::storage_read_compute); });
        CHECK(error_of(graph) == "pass 'p' writes 'data' as storage_read_compute, which only reads");
    }
    SUBCASE("reading with a writing access") {
        add(graph, "p", C, [&](PassBuilder& p) { p.read(data, Access::storage_write_compute); });
        CHECK(error_of(graph) == "pass 'p' reads 'data' as storage_write_compute, which writes");
    }
    SUBCASE("an access for edges of the frame inside it") {
        add(graph, "p", G, [&](PassBuilder& p) { p.read(image, Access::present); });
        CHECK(error_of(graph)
              == "pass 'p' reads 'image' as present, which is only for the edges of an import");
    }
}

TEST_CASE("conflicting uses of one resource in one pass are refused by name") {
    FrameGraph graph;
    Image image = graph.import_image("image", small_image, {.initial = Access::sampled_fragment});
    SUBCASE("read and write") {
        add(graph, "p", G, [&](PassBuilder& p) {
            p.read(image, Access::sampled_fragment);
            image = p.write(image, Access::colour_attachment);
        });
        CHECK(contains(error_of(graph),
                       "pass 'p' writes 'image' as colour_attachment, but also uses it as sampled_fragment"));
    }
    SUBCASE("write and read of the new version") {
        add(graph, "p", G, [&](PassBuilder& p) {
            image = p.write(image, Access::colour_attachment);
            p.read(image, Access::sampled_fragment);
        });
        CHECK(contains(error_of(graph),
                       "pass 'p' reads 'image' as sampled_fragment, but also uses it as colour_attachment"));
    }
    SUBCASE("two writes") {
        add(graph, "p", G, [&](PassBuilder& p) {
            image = p.write(image, Access::colour_attachment);
            image = p.write(image, Access::colour_attachment);
        });
        CHECK(contains(error_of(graph), "but also uses it as colour_attachment"));
    }
    SUBCASE("reads in two layouts") {
        add(graph, "p", G, [&](PassBuilder& p) {
            p.read(image, Access::sampled_fragment);
            p.read(image, Access::storage_read_fragment);
        });
        CHECK(contains(error_of(graph), "the two need different image layouts"));
    }
}

TEST_CASE("several reads of one resource in one pass are one use each and no conflict") {
    FrameGraph graph;
    const Buffer arena = graph.import_buffer("arena", small_buffer, {.initial = Access::transfer_write});
    add(graph, "draw", G, [&](PassBuilder& p) {
        p.read(arena, Access::vertex_read);
        p.read(arena, Access::index_read);
        p.read(arena, Access::index_read);
        p.side_effect();
    });
    Plan plan = compiled(graph);
    CHECK(plan.passes[0].uses.size() == 2);
    CHECK(plan.passes[0].barriers.at(0).after == (Access::vertex_read | Access::index_read));
    check_sound(plan);
}

TEST_CASE("impossible resources are refused by name") {
    FrameGraph graph;
    SUBCASE("zero-sized image") {
        (void)graph.create_image("minimised", {.width = 0, .height = 720});
        CHECK(contains(error_of(graph), "image 'minimised' is 0x720"));
    }
    SUBCASE("zero-sized buffer") {
        (void)graph.create_buffer("nothing", {.size = 0});
        CHECK(error_of(graph) == "buffer 'nothing' has size 0");
    }
    SUBCASE("initial accesses in two layouts") {
        (void)graph.import_image("torn", small_image,
                                 {.initial = Access::sampled_fragment | Access::transfer_read});
        CHECK(error_of(graph)
              == "imported 'torn': initial accesses transfer_read and sampled_fragment need different image "
                 "layouts");
    }
    SUBCASE("initial access of the wrong sort") {
        (void)graph.import_buffer("odd", small_buffer, {.initial = Access::present});
        CHECK(error_of(graph) == "imported 'odd': present is no access to a buffer");
    }
    SUBCASE("edge accesses at the wrong edge") {
        (void)graph.import_image("late", small_image, {.final = Access::acquired});
        (void)graph.import_buffer("early", small_buffer, {.initial = Access::host_read});
        (void)graph.import_buffer("after", small_buffer, {.final = Access::host_write});
        CHECK(error_of(graph)
              == "imported 'late': acquired is no final access\nimported 'early': host_read is no initial "
                 "access\n"
                 "imported 'after': host_write is no final access");
    }
    SUBCASE("final read of contents that nobody made") {
        (void)graph.import_image("blank", small_image,
                                 {.initial = Access::acquired, .final = Access::present});
        CHECK(error_of(graph) == "imported 'blank' is to end as present, but no pass wrote it");
    }
}

TEST_CASE("handles that name nothing in the graph are refused") {
    FrameGraph graph, other;
    const Image foreign = other.create_image("foreign", small_image);
    const Buffer data = graph.create_buffer("data", small_buffer);
    add(graph, "a", G, [&](PassBuilder& p) { p.read(Image(), Access::sampled_fragment); });
    add(graph, "b", G, [&](PassBuilder& p) { (void)p.write(foreign, Access::colour_attachment); });
    add(graph, "c", C, [&](PassBuilder& p) {
        p.read(Buffer(data.resource(), data.version() + 1), Access::storage_read_compute);
    });
    const std::string error = error_of(graph);
    for (const char* part : {"pass 'a' reads an image handle that names nothing in this graph",
                             "pass 'b' writes an image handle that names nothing",
                             "pass 'c' reads a buffer handle that names nothing"})
        CHECK(contains(error, part));
}

TEST_CASE("every mistake is reported, each once") {
    FrameGraph graph;
    Image a = graph.create_image("a", small_image);
    Buffer b = graph.create_buffer("b", small_buffer);
    add(graph, "one", G, [&](PassBuilder& p) { p.read(a, Access::sampled_fragment); });
    add(graph, "two", G, [&](PassBuilder& p) { b = p.write(b, Access::colour_attachment); });
    add(graph, "three", C, [&](PassBuilder& p) { b = p.write(b, Access::storage_write_compute); });
    const std::string error = error_of(graph);
    CHECK(std::count(error.begin(), error.end(), '\n') == 1);
    CHECK(contains(error, "'one'"));
    CHECK(contains(error, "'two'"));
}

TEST_CASE("a resource has a bounded number of versions") {
    FrameGraph graph;
    Buffer data = graph.import_buffer("data", small_buffer, {.initial = Access::transfer_write});
    for (std::uint32_t i = 0; i < Buffer::max_version; ++i)
        add(graph, "fill", T, [&](PassBuilder& p) { data = p.write(data, Access::transfer_write); });
    SUBCASE("the last one is good") {
        CHECK(compiled(graph).passes.size() == Buffer::max_version);
    }
    SUBCASE("one more is refused") {
        add(graph, "too much", T, [&](PassBuilder& p) { data = p.write(data, Access::transfer_write); });
        CHECK(contains(error_of(graph),
                       "pass 'too much' writes 'data' as transfer_write, but it was written 4095 times"));
    }
}

// --- Random graphs ---------------------------------------------------------------------------------------

TEST_CASE("random graphs: every hazard has a barrier, no barrier is superfluous, no two live resources share "
          "bytes") {
    std::size_t barriers = 0, aliased = 0, culled = 0, live = 0;
    for (std::uint64_t seed = 0; seed < 600; ++seed) {
        CAPTURE(seed);
        RandomGraph random(seed);
        const std::set<std::string> expected = random.expected_live();
        Plan plan = compiled(random.graph, random_need);
        const Names passes = names(plan.passes);
        REQUIRE(std::set<std::string>(passes.begin(), passes.end()) == expected);
        REQUIRE(barrier_fault(plan) == "");
        REQUIRE(memory_fault(plan, random_need) == "");
        REQUIRE(superfluous_barrier(plan) == "");
        live += plan.passes.size();
        culled += plan.culled.size();
        for (const std::vector<Plan::Barrier>* list : barrier_lists(plan))
            for (const Plan::Barrier& barrier : *list) {
                ++barriers;
                aliased += barrier.aliasing;
            }
    }
    // The graphs are worth the name.
    MESSAGE(live, " live passes, ", culled, " culled, ", barriers, " barriers, ", aliased,
            " of them aliasing");
    CHECK(live > 1500);
    CHECK(culled > 300);
    CHECK(barriers > 1500);
    CHECK(aliased > 50);
}

TEST_CASE("equal declarations give equal plans") {
    for (const std::uint64_t seed : {1u, 2u, 3u}) {
        RandomGraph a(seed), b(seed);
        CHECK(to_dot(compiled(a.graph, random_need)) == to_dot(compiled(b.graph, random_need)));
    }
}

// --- DOT -------------------------------------------------------------------------------------------------

namespace {

// Splits DOT text of the shape that to_dot() writes; checks quotes, braces, and that edges join declared
// nodes.
void check_dot(const std::string& dot) {
    CHECK(dot.rfind("digraph frame {", 0) == 0);
    bool quote = false;
    int depth = 0;
    for (std::size_t i = 0; i < dot.size(); ++i) {
        if (quote && dot[i] == '\\')
            ++i;
        else if (dot[i] == '"')
            quote = !quote;
        else if (!quote)
            depth += (dot[i] == '{') - (dot[i] == '}');
    }
    CHECK_FALSE(quote);
    CHECK(depth == 0);

    std::set<std::string> nodes, ends;
    std::istringstream lines(dot);
    for (std::string line; std::getline(lines, line);) {
        std::istringstream words(line);
        std::string first, second, third;
        words >> first >> second >> third;
        if (second == "->")
            ends.insert({first, third});
        else if (contains(line, "shape="))
            CHECK(nodes.insert(first).second);
    }
    for (const std::string& end : ends) CHECK(nodes.count(end) == 1);
}

} // namespace

TEST_CASE("the graph prints itself as DOT") {
    FrameGraph graph;
    Image odd = graph.create_image("a \"quoted\\\" {name\nin two lines", small_image);
    Image target =
        graph.import_image("target", small_image, {.initial = Access::acquired, .final = Access::present});
    Buffer waste = graph.create_buffer("waste", small_buffer);
    add(graph, "make", G, [&](PassBuilder& p) { odd = p.write(odd, Access::colour_attachment); });
    add(graph, "useless", C, [&](PassBuilder& p) { waste = p.write(waste, Access::storage_write_compute); });
    add(graph, "tonemap", G, [&](PassBuilder& p) {
        p.read(odd, Access::sampled_fragment);
        target = p.write(target, Access::colour_attachment);
    });
    const std::string dot = to_dot(compiled(graph));
    check_dot(dot);
    CHECK(contains(dot, "p1 [shape=box, label=\"tonemap\\ngraphics\\nbarriers: 2\"]"));
    CHECK(contains(dot, "c0 [shape=box, label=\"useless\\ncompute\", color=grey"));
    CHECK(contains(dot, "r0v1 -> p1 [label=\"sampled_fragment\"]"));
    CHECK(contains(dot, "p1 -> r1v1 [label=\"colour_attachment\"]"));
    CHECK(contains(dot, "peripheries=2"));
}

TEST_CASE("random graphs print well-formed DOT") {
    for (std::uint64_t seed = 0; seed < 40; ++seed) {
        CAPTURE(seed);
        RandomGraph random(seed);
        check_dot(to_dot(compiled(random.graph, random_need)));
    }
}
