// The plan of one frame, the result of FrameGraph::compile() and the input of the execute half. It contains no Vulkan
// type.
//
// To run a plan on one queue: allocate the heaps; create the transients at their offsets; for each pass, record its
// barriers and call its execute function; at the end, record final_barriers.
//
// Between frames, only the imports' initial and final accesses are synchronised. Transient memory must be idle when the
// frame starts: keep one set of heaps for each frame in flight.
#pragma once

#include "engine/core/format.h"
#include "engine/graph/access.h"

#include <compare>
#include <cstdint>
#include <functional>
#include <string>
#include <variant>
#include <vector>

namespace brittle::engine {

class PassContext; // defined by the execute half: command buffer, resource look-up

using Execute = std::function<void(PassContext&)>;

struct ImageDesc {
    std::uint32_t width = 0;
    std::uint32_t height = 0;
    Format format = Format::rgba8_unorm;
    std::uint32_t samples = 1;
    std::uint32_t mip_levels = 1;
    std::uint32_t layers = 1;
    friend bool operator==(const ImageDesc&, const ImageDesc&) = default;
};

struct BufferDesc {
    std::uint64_t size = 0; // bytes
    friend bool operator==(const BufferDesc&, const BufferDesc&) = default;
};

// One version of a resource of one graph, in 4 bytes. Every version of a resource has the same resource(), so
// an execute function may capture the handle as it was before or after the pass's own write.
template<class Tag>
class Handle {
  public:
    constexpr Handle() = default; // not valid
    constexpr Handle(std::uint32_t resource, std::uint32_t version) : bits_(version << 20 | resource) {}

    [[nodiscard]] constexpr bool valid() const { return resource() < max_resources; }
    // The index in Plan::resources.
    [[nodiscard]] constexpr std::uint32_t resource() const { return bits_ & max_resources; }
    // 0 as created or imported; each write makes the next version.
    [[nodiscard]] constexpr std::uint32_t version() const { return bits_ >> 20; }
    friend constexpr auto operator<=>(Handle, Handle) = default;

    static constexpr std::uint32_t max_resources = (1u << 20) - 1; // also the index of an invalid handle
    static constexpr std::uint32_t max_version = (1u << 12) - 1;

  private:
    std::uint32_t bits_ = ~0u;
};
using Image = Handle<struct ImageTag>;
using Buffer = Handle<struct BufferTag>;

// The memory of a transient. Two transients whose lifetimes do not overlap may share bytes.
struct Memory {
    std::uint32_t heap = 0;   // in Plan::heaps
    std::uint64_t offset = 0; // bytes from the heap's start
    std::uint64_t size = 0;   // bytes
};

// How an imported resource enters and leaves the frame.
struct Import {
    // The last accesses by an earlier frame or the CPU. The frame waits for the writes among them; the reads are those
    // to which the contents are already visible. Empty: nothing to wait for, contents undefined.
    AccessSet initial = {};
    AccessSet final = {};       // the accesses after the frame; empty: the state that the last pass leaves
    bool read_only = false;     // a pass that writes the resource is an error
    std::uint64_t external = 0; // a number by which the execute half finds its object
};

struct Plan {
    // A barrier for one resource before one pass. An image barrier from Layout::undefined discards the contents.
    struct Barrier {
        std::uint32_t resource;
        AccessSet before; // the accesses to finish, with their writes made available; may be empty
        AccessSet after;  // the accesses that wait: this pass's and, for consecutive reads, those of later passes
        Layout from = Layout::undefined; // images only
        Layout to = Layout::undefined;
        // `before` holds accesses to other resources in the same bytes. A barrier on this resource alone does not cover
        // them; they need a global memory barrier.
        bool aliasing = false;
    };

    struct Use {
        std::uint32_t resource;
        std::uint32_t version; // the version read; for a write, the version made
        Access access;
    };

    struct Pass {
        std::string name;
        PassKind kind;
        bool side_effect;
        std::vector<Use> uses;         // in the order of declaration
        std::vector<Barrier> barriers; // before the pass; at most one for each resource, by ascending resource
        Execute execute;
    };

    struct Resource {
        std::string name;
        std::variant<ImageDesc, BufferDesc> desc;
        bool imported;
        Import import;      // for imported resources only
        AccessSet accesses; // the union over all live passes and the import's initial and final accesses
        // The first and last pass that use the resource, as indices of `passes`. If no live pass uses it, first > last,
        // and a transient has no memory and must not be created.
        std::uint32_t first_pass = 1;
        std::uint32_t last_pass = 0;
        Memory memory; // for transients only

        [[nodiscard]] bool is_image() const { return desc.index() == 0; }
        [[nodiscard]] bool used() const { return first_pass <= last_pass; }
    };

    struct Heap {
        std::uint32_t memory_class; // MemoryNeed::memory_class of its transients
        std::uint64_t size;         // bytes
        std::uint64_t alignment;    // bytes, the largest of its transients
    };

    std::vector<Pass> passes;            // live, in the order of declaration, which is also a topological order
    std::vector<Pass> culled;            // passes without an effect outside the graph; in the order of declaration
    std::vector<Resource> resources;     // indexed by Handle::resource()
    std::vector<Barrier> final_barriers; // take imported resources to their final accesses
    std::vector<Heap> heaps;             // memory of the transients
};

// Returns the graph as Graphviz text. Passes are boxes and resource versions are ellipses, doubled for imports. Culled
// passes, and versions that only they mention, are grey. Equal plans give equal text.
[[nodiscard]] std::string to_dot(const Plan& plan);

} // namespace brittle::engine
