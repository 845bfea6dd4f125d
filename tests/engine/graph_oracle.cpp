#include "tests/engine/graph_oracle.h"

#include <doctest/doctest.h>

#include <set>
#include <sstream>

namespace brittle::engine::test {
AccessFacts facts(Access access) {
    for (const AccessFacts& f : facts_table)
        if (f.access == access) return f;
    switch (access) {
    case Access::acquired:
        return {access, PassKind::graphics, true, false, false, true, false, Layout::undefined};
    case Access::present:
        return {access, PassKind::graphics, true, false, true, false, false, Layout::present};
    case Access::host_write:
        return {access, PassKind::graphics, false, true, false, true, false, Layout::undefined};
    case Access::host_read:
        return {access, PassKind::graphics, false, true, true, false, false, Layout::undefined};
    default:
        FAIL("no facts about ", to_string(access));
        return {};
    }
}

namespace {

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
    if (a == b || x.imported || y.imported || !x.used() || !y.used() || x.memory.heap != y.memory.heap) return false;
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
    // Reads before the frame guarantee visibility only to equal reads.
    return i.position == -1 && !plan.resources[i.resource].import.initial.contains(j.access);
}

// Returns whether j waits for i through a chain of barriers.
bool is_chained(const Plan& plan, const Event& i, const Event& j) {
    AccessSet waiting_in_i, waiting_in_j;
    for (int position = i.position + 1; position <= j.position; ++position)
        for (const Plan::Barrier& barrier : barriers_at(plan, position)) {
            if (barrier.resource == i.resource
                && (barrier.before.contains(i.access) || barrier.before.intersects(waiting_in_i)))
                waiting_in_i |= barrier.after;
            if (barrier.resource != j.resource || i.resource == j.resource) continue;
            const bool takes_over =
                barrier.aliasing && (barrier.before.contains(i.access) || barrier.before.intersects(waiting_in_i));
            if (takes_over || barrier.before.intersects(waiting_in_j)) waiting_in_j |= barrier.after;
        }
    return (i.resource == j.resource ? waiting_in_i : waiting_in_j).contains(j.access);
}

// Replays layouts. An image must be in the layout of each access, and its contents may be discarded only if no later
// access needs them.
std::string layout_fault(const Plan& plan) {
    const std::vector<Event> events = events_of(plan);
    for (std::uint32_t r = 0; r < plan.resources.size(); ++r) {
        if (!plan.resources[r].is_image()) continue;
        Layout layout = Layout::undefined;
        bool precious = false; // contents that must not be discarded
        for (int position = -1; position <= static_cast<int>(plan.passes.size()); ++position) {
            bool replaces = false;
            for (const Event& event : events)
                if (event.resource == r && event.position == position) replaces |= facts(event.access).replaces;
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

} // namespace

Plan compiled(FrameGraph& graph, const MemoryNeeds& needs) {
    CompileResult result = std::move(graph).compile(needs);
    REQUIRE_MESSAGE(result, (result ? "" : result.error().message));
    return std::move(*result);
}

Names names(const std::vector<Plan::Pass>& passes) {
    Names out;
    for (const Plan::Pass& pass : passes) out.push_back(pass.name);
    return out;
}

std::vector<std::vector<Plan::Barrier>*> barrier_lists(Plan& plan) {
    std::vector<std::vector<Plan::Barrier>*> lists{&plan.final_barriers};
    for (Plan::Pass& pass : plan.passes) lists.push_back(&pass.barriers);
    return lists;
}

std::string barrier_fault(const Plan& plan) {
    const std::vector<Event> events = events_of(plan);
    for (const Event& i : events)
        for (const Event& j : events)
            if (is_hazard(plan, i, j) && !is_chained(plan, i, j))
                return "no barrier from " + plan.resources[i.resource].name + " " + to_string(i.access) + " at "
                       + std::to_string(i.position) + " to " + plan.resources[j.resource].name + " "
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
            if (!apart && share_bytes(plan, a, b)) return x.name + " and " + y.name + " live in the same bytes";
        }
    }
    return {};
}

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

} // namespace brittle::engine::test
