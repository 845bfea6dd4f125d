// The plan of one frame: what FrameGraph::compile() makes and the execute half walks through. No Vulkan type
// here.
//
// To run it: allocate heap_sizes; create the transients at their offsets; for each pass put its barriers,
// then call its execute; at the end put final_barriers. All on one queue.
//
// Between frames the plan synchronises nothing but what the imports' initial and final accesses say.
// Transient memory must be idle when the frame starts: keep one set of heaps for each frame in flight.
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
    constexpr Handle() = default; // names nothing
    constexpr Handle(std::uint32_t resource, std::uint32_t version) : bits_(version << 20 | resource) {}

    [[nodiscard]] constexpr bool valid() const { return resource() < max_resources; }
    // The index in Plan::resources.
    [[nodiscard]] constexpr std::uint32_t resource() const { return bits_ & max_resources; }
    // 0 as created or imported; each write makes the next.
    [[nodiscard]] constexpr std::uint32_t version() const { return bits_ >> 20; }
    friend constexpr auto operator<=>(Handle, Handle) = default;

    static constexpr std::uint32_t max_resources = (1u << 20) - 1; // the last index names nothing
    static constexpr std::uint32_t max_version = (1u << 12) - 1;

  private:
    std::uint32_t bits_ = ~0u;
};
using Image = Handle<struct ImageTag>;
using Buffer = Handle<struct BufferTag>;

// Where a transient lives. Two transients with no pass in common may share bytes.
struct Memory {
    std::uint32_t heap = 0;   // in Plan::heaps
    std::uint64_t offset = 0; // bytes from the heap's start
    std::uint64_t size = 0;   // bytes
};

// How an imported resource enters and leaves the frame.
struct Import {
    // The accesses last made to it, by an earlier frame or the CPU: writes among them are waited for; reads
    // tell what its contents are already visible to. Empty: nothing to wait for and contents undefined.
    AccessSet initial = {};
    AccessSet final = {};       // what comes after the frame; empty: whatever the last pass left
    bool read_only = false;     // a pass that writes it is an error
    std::uint64_t external = 0; // whatever the execute half needs to find its own object again
};

struct Plan {
    // Of one resource in one pass. An image barrier from `undefined` discards the contents.
    struct Barrier {
        std::uint32_t resource;
        AccessSet before; // everything that must be over, and whose writes must be available; may be empty
        AccessSet after;  // everything that waits: this pass's access and, for reads in a row, those of later passes
        Layout from = Layout::undefined; // images only
        Layout to = Layout::undefined;
        // `before` holds accesses to other resources in the same bytes: a barrier on this resource alone does
        // not cover them, it takes a global memory barrier.
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
        std::vector<Barrier> barriers; // before the pass; at most one a resource, by rising resource
        Execute execute;
    };

    struct Resource {
        std::string name;
        std::variant<ImageDesc, BufferDesc> desc;
        bool imported;
        Import import;      // imported ones only
        AccessSet accesses; // all that live passes and the import's edges do: the usage to create it with
        // First and last pass that use it, as indices of `passes`; first > last if no live pass does, and
        // then a transient needs no memory and must not be created.
        std::uint32_t first_pass = 1;
        std::uint32_t last_pass = 0;
        Memory memory; // transients only

        [[nodiscard]] bool is_image() const { return desc.index() == 0; }
        [[nodiscard]] bool used() const { return first_pass <= last_pass; }
    };

    struct Heap {
        std::uint32_t memory_class; // MemoryNeed::memory_class of all that lives here
        std::uint64_t size;         // bytes
        std::uint64_t alignment;    // the strictest of all that lives here
    };

    std::vector<Pass> passes;            // live, in the order of declaration, which is also a topological order
    std::vector<Pass> culled;            // nothing outside the graph depends on them; in the order of declaration
    std::vector<Resource> resources;     // by Handle::resource()
    std::vector<Barrier> final_barriers; // bring imported resources to their final accesses
    std::vector<Heap> heaps;             // for the transients
};

// The graph as Graphviz text: passes are boxes, resource versions ellipses (imported ones doubled), culled
// passes and what only they make grey. Equal plans give equal text.
[[nodiscard]] std::string to_dot(const Plan& plan);

} // namespace brittle::engine
