// The test oracle of plans. It uses only the parts of a plan that a device sees: it replays passes and barriers in
// order and searches a chain of barriers for every pair of accesses. The properties of accesses come from a table of
// its own.
#pragma once

#include "engine/graph/frame_graph.h"

#include <string>
#include <vector>

namespace brittle::engine::test {

struct AccessFacts {
    Access access;
    PassKind kind;
    bool image, buffer;
    bool reads, writes;
    bool replaces; // a write that replaces all contents
    Layout layout; // for images
};

inline constexpr AccessFacts facts_table[] = {
    {Access::transfer_read, PassKind::transfer, true, true, true, false, false, Layout::transfer_source},
    {Access::transfer_write, PassKind::transfer, true, true, false, true, false, Layout::transfer_target},
    {Access::indirect_read, PassKind::graphics, false, true, true, false, false, Layout::undefined},
    {Access::indirect_read, PassKind::compute, false, true, true, false, false, Layout::undefined},
    {Access::index_read, PassKind::graphics, false, true, true, false, false, Layout::undefined},
    {Access::vertex_read, PassKind::graphics, false, true, true, false, false, Layout::undefined},
    {Access::uniform_read, PassKind::graphics, false, true, true, false, false, Layout::undefined},
    {Access::uniform_read, PassKind::compute, false, true, true, false, false, Layout::undefined},
    {Access::sampled_fragment, PassKind::graphics, true, false, true, false, false, Layout::read_only},
    {Access::sampled_compute, PassKind::compute, true, false, true, false, false, Layout::read_only},
    {Access::storage_read_vertex, PassKind::graphics, true, true, true, false, false, Layout::general},
    {Access::storage_read_fragment, PassKind::graphics, true, true, true, false, false, Layout::general},
    {Access::storage_write_fragment, PassKind::graphics, true, true, false, true, false, Layout::general},
    {Access::storage_read_write_fragment, PassKind::graphics, true, true, true, true, false, Layout::general},
    {Access::storage_read_compute, PassKind::compute, true, true, true, false, false, Layout::general},
    {Access::storage_write_compute, PassKind::compute, true, true, false, true, false, Layout::general},
    {Access::storage_read_write_compute, PassKind::compute, true, true, true, true, false, Layout::general},
    {Access::colour_attachment, PassKind::graphics, true, false, false, true, true, Layout::attachment},
    {Access::colour_attachment_load, PassKind::graphics, true, false, true, true, false, Layout::attachment},
    {Access::resolve_attachment, PassKind::graphics, true, false, false, true, true, Layout::attachment},
    {Access::depth_attachment, PassKind::graphics, true, false, false, true, true, Layout::attachment},
    {Access::depth_attachment_load, PassKind::graphics, true, false, true, true, false, Layout::attachment},
    {Access::depth_read, PassKind::graphics, true, false, true, false, false, Layout::read_only},
};

AccessFacts facts(Access access); // the entry above, or that of an initial or final access

inline constexpr ImageDesc small_image{.width = 4, .height = 4};
inline constexpr BufferDesc small_buffer{.size = 64};

// Compiles a graph and returns its plan. An error of the graph fails the test.
Plan compiled(FrameGraph& graph, const MemoryNeeds& needs);

using Names = std::vector<std::string>;
Names names(const std::vector<Plan::Pass>& passes);

// Returns all lists of barriers in the plan.
std::vector<std::vector<Plan::Barrier>*> barrier_lists(Plan& plan);

// Returns the first hazard without a chain of barriers, image in a wrong layout, or loss of needed contents; "" if
// there is none.
std::string barrier_fault(const Plan& plan);

// Returns the first transient that is misplaced, or shares bytes with another live transient; "" if there is none.
std::string memory_fault(const Plan& plan, const MemoryNeeds& needs);

// Returns the first barrier whose removal causes no barrier_fault(); "" if there is none.
std::string superfluous_barrier(Plan& plan);

// Checks that text of to_dot() has matching quotes and braces, and edges between declared nodes only.
void check_dot(const std::string& dot);

inline bool contains(const std::string& text, const std::string& part) {
    return text.find(part) != std::string::npos;
}

} // namespace brittle::engine::test
