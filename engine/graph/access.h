// The accesses that a pass makes to a resource, for the plan half of the frame graph, which contains no Vulkan type.
// The execute half owns the one table from Access to Vulkan stage, access mask and usage (access_vulkan.h). Each Layout
// is one VkImageLayout.
//
// An AccessSet is a small bit set of accesses: AccessSet set = Access::vertex_read | Access::index_read;
#pragma once

#include <cstdint>
#include <string>

namespace brittle::engine {

enum class Access : std::uint8_t {
    // Initial and final accesses of imported resources.
    acquired,   // initial: a swapchain image just acquired, contents undefined; its stage is the stage at which the
                // submission waits for the acquire semaphore
    present,    // initial or final: handed to the presentation engine
    host_write, // initial: the CPU wrote it before the submission
    host_read,  // final: the CPU reads it after the frame's fence

    transfer_read,
    transfer_write, // copy, blit, fill, clear

    indirect_read, // draw or dispatch arguments, draw count
    index_read,
    vertex_read,  // vertex attributes
    uniform_read, // uniform buffer, any shader stage

    sampled_fragment, // sampled image
    sampled_compute,

    storage_read_vertex, // storage buffer or storage image
    storage_read_fragment,
    storage_write_fragment,
    storage_read_write_fragment,
    storage_read_compute,
    storage_write_compute,
    storage_read_write_compute,

    colour_attachment,      // replaces the whole image (cleared, or fully drawn over)
    colour_attachment_load, // draws over the present contents
    resolve_attachment,     // replaces the whole image by the mean of each pixel's samples in a multisampled attachment
    depth_attachment,       // test and write; replaces the whole image (cleared)
    depth_attachment_load,  // test and write over the present contents
    depth_read,             // test only; may be combined with sampled_fragment of the same image in one pass

    count
};

// The memory layout an image must be in for an access; transitions between them are barriers.
enum class Layout : std::uint8_t {
    undefined,       // contents are discarded; the layout of every buffer
    transfer_source, // TRANSFER_SRC_OPTIMAL
    transfer_target, // TRANSFER_DST_OPTIMAL
    read_only,       // READ_ONLY_OPTIMAL: sampled, or depth-tested without writing
    attachment,      // ATTACHMENT_OPTIMAL: colour or depth
    general,         // GENERAL: storage image
    present          // PRESENT_SRC
};

// The kind of commands that a pass records. All passes go to one queue in plan order; the kind decides which accesses
// are legal in the pass.
enum class PassKind : std::uint8_t { graphics, compute, transfer };

class AccessSet {
  public:
    constexpr AccessSet() = default;
    constexpr AccessSet(Access access) : bits_(1u << static_cast<unsigned>(access)) {}

    [[nodiscard]] constexpr bool empty() const { return bits_ == 0; }
    [[nodiscard]] constexpr bool contains(AccessSet other) const { return (bits_ & other.bits_) == other.bits_; }
    [[nodiscard]] constexpr bool intersects(AccessSet other) const { return (bits_ & other.bits_) != 0; }
    constexpr AccessSet& operator|=(AccessSet other) {
        bits_ |= other.bits_;
        return *this;
    }
    friend constexpr AccessSet operator|(AccessSet a, AccessSet b) { return a |= b; }
    friend constexpr bool operator==(AccessSet, AccessSet) = default;

    // Calls visit(Access) for each member, in the order of the enum.
    template<class Visit>
    constexpr void for_each(Visit&& visit) const {
        for (unsigned i = 0; i < static_cast<unsigned>(Access::count); ++i)
            if (bits_ >> i & 1u) visit(static_cast<Access>(i));
    }

  private:
    static_assert(static_cast<unsigned>(Access::count) <= 32);
    std::uint32_t bits_ = 0;
};

constexpr AccessSet operator|(Access a, Access b) {
    return AccessSet(a) | AccessSet(b);
}

// The properties of an access that the plan needs.
struct AccessTraits {
    const char* name;
    bool reads;   // needs contents that were written before
    bool writes;  // makes a new version of the resource
    bool keeps;   // a write that preserves untouched contents: all writes but the attachments that replace the image
    bool images;  // legal for an image
    bool buffers; // legal for a buffer
    Layout layout;
    std::uint8_t kinds; // bit per PassKind that may declare it; 0: only as an import's initial or final access
};

[[nodiscard]] const AccessTraits& traits(Access access);

[[nodiscard]] bool writes(AccessSet set); // any member writes
[[nodiscard]] const char* to_string(Access access);
[[nodiscard]] const char* to_string(Layout layout);
[[nodiscard]] const char* to_string(PassKind kind);
[[nodiscard]] std::string to_string(AccessSet set); // "vertex_read|index_read"; "nothing" when empty

} // namespace brittle::engine
