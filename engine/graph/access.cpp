#include "engine/graph/access.h"

#include <array>
#include <cassert>

namespace brittle::engine {
namespace {

constexpr std::uint8_t bit(PassKind kind) {
    return static_cast<std::uint8_t>(1u << static_cast<unsigned>(kind));
}

constexpr std::uint8_t edge = 0; // legal only as an import's initial or final access
constexpr std::uint8_t draw = bit(PassKind::graphics);
constexpr std::uint8_t dispatch = bit(PassKind::compute);
constexpr std::uint8_t copy = bit(PassKind::transfer);
constexpr std::uint8_t shader = draw | dispatch;

// In the order of the enum.
constexpr std::array<AccessTraits, static_cast<std::size_t>(Access::count)> table = {{
    // name                       reads  writes keeps  image  buffer layout                  kinds
    {"acquired", false, true, false, true, false, Layout::undefined, edge},
    {"present", true, false, false, true, false, Layout::present, edge},
    {"host_write", false, true, true, false, true, Layout::undefined, edge},
    {"host_read", true, false, false, false, true, Layout::undefined, edge},
    {"transfer_read", true, false, false, true, true, Layout::transfer_source, copy},
    {"transfer_write", false, true, true, true, true, Layout::transfer_target, copy},
    {"indirect_read", true, false, false, false, true, Layout::undefined, shader},
    {"index_read", true, false, false, false, true, Layout::undefined, draw},
    {"vertex_read", true, false, false, false, true, Layout::undefined, draw},
    {"uniform_read", true, false, false, false, true, Layout::undefined, shader},
    {"sampled_fragment", true, false, false, true, false, Layout::read_only, draw},
    {"sampled_compute", true, false, false, true, false, Layout::read_only, dispatch},
    {"storage_read_vertex", true, false, false, true, true, Layout::general, draw},
    {"storage_read_fragment", true, false, false, true, true, Layout::general, draw},
    {"storage_write_fragment", false, true, true, true, true, Layout::general, draw},
    {"storage_read_write_fragment", true, true, true, true, true, Layout::general, draw},
    {"storage_read_compute", true, false, false, true, true, Layout::general, dispatch},
    {"storage_write_compute", false, true, true, true, true, Layout::general, dispatch},
    {"storage_read_write_compute", true, true, true, true, true, Layout::general, dispatch},
    {"colour_attachment", false, true, false, true, false, Layout::attachment, draw},
    {"colour_attachment_load", true, true, true, true, false, Layout::attachment, draw},
    {"resolve_attachment", false, true, false, true, false, Layout::attachment, draw},
    {"depth_attachment", false, true, false, true, false, Layout::attachment, draw},
    {"depth_attachment_load", true, true, true, true, false, Layout::attachment, draw},
    {"depth_read", true, false, false, true, false, Layout::read_only, draw},
}};

} // namespace

const AccessTraits& traits(Access access) {
    assert(access < Access::count);
    return table[static_cast<std::size_t>(access)];
}

bool writes(AccessSet set) {
    bool any = false;
    set.for_each([&](Access access) { any |= traits(access).writes; });
    return any;
}

const char* to_string(Access access) {
    return traits(access).name;
}

const char* to_string(Layout layout) {
    switch (layout) {
    case Layout::undefined:
        return "undefined";
    case Layout::transfer_source:
        return "transfer_source";
    case Layout::transfer_target:
        return "transfer_target";
    case Layout::read_only:
        return "read_only";
    case Layout::attachment:
        return "attachment";
    case Layout::general:
        return "general";
    case Layout::present:
        return "present";
    }
    return "unknown";
}

const char* to_string(PassKind kind) {
    switch (kind) {
    case PassKind::graphics:
        return "graphics";
    case PassKind::compute:
        return "compute";
    case PassKind::transfer:
        return "transfer";
    }
    return "unknown";
}

std::string to_string(AccessSet set) {
    std::string text;
    set.for_each([&](Access access) {
        if (!text.empty()) text += '|';
        text += to_string(access);
    });
    return text.empty() ? "nothing" : text;
}

} // namespace brittle::engine
