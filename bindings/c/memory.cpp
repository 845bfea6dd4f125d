// The memory of libbrittle: the C++ operators new and delete, through the allocator of brittle_set_allocator().
//
// The operators are hidden, like everything but the C interface: they serve the code in this library and no other. The
// library holds its own C++ library, so that no code outside frees what these operators gave, and the reverse.
//
// Each block begins with a header, which says where it goes when it is freed. So the allocator may change while blocks
// live.
#include <algorithm>
#include <atomic>
#include <cstdlib>
#include <new>

#include "bindings/c/brittle.h"
#include "bindings/c/handles.h"

namespace brittle::c {

namespace {

struct Allocator {
    void* (*allocate)(void* user, size_t size, size_t alignment);
    void (*release)(void* user, void* block, size_t size, size_t alignment);
    void* user;
    const Allocator* older; // blocks name their allocator, so none is ever freed
};

void* allocate_by_default(void*, size_t size, size_t alignment) {
    return std::aligned_alloc(alignment, (size + alignment - 1) / alignment * alignment);
}

void release_by_default(void*, void* block, size_t, size_t) {
    std::free(block);
}

constexpr Allocator default_allocator{allocate_by_default, release_by_default, nullptr, nullptr};

std::atomic<const Allocator*> chosen{&default_allocator};

struct Header {
    const Allocator* allocator;
    size_t size; // of the block with its header
};

constexpr size_t min_alignment = 16;
static_assert(sizeof(Header) <= min_alignment && alignof(std::max_align_t) <= min_alignment);

// Returns null where there is no memory. The header ends where the memory of the caller begins.
void* allocate(size_t size, size_t alignment) noexcept {
    alignment = std::max(alignment, min_alignment);
    if (size > PTRDIFF_MAX - 2 * alignment) return nullptr;
    const Allocator* allocator = chosen.load(std::memory_order_acquire);
    void* block = allocator->allocate(allocator->user, size + alignment, alignment);
    if (!block && JsonMemory::is_on()) {
        allocator = &default_allocator;
        block = allocator->allocate(nullptr, size + alignment, alignment);
    }
    if (!block) return nullptr;
    void* const memory = static_cast<char*>(block) + alignment;
    new (static_cast<Header*>(memory) - 1) Header{allocator, size + alignment};
    return memory;
}

void release(void* memory, size_t alignment) noexcept {
    if (!memory) return;
    alignment = std::max(alignment, min_alignment);
    const Header header = static_cast<Header*>(memory)[-1];
    header.allocator->release(header.allocator->user, static_cast<char*>(memory) - alignment, header.size, alignment);
}

void* allocate_or_throw(size_t size, size_t alignment) {
    void* const memory = allocate(size, alignment);
    if (!memory) throw std::bad_alloc();
    return memory;
}

} // namespace

} // namespace brittle::c

using brittle::c::allocate;
using brittle::c::allocate_or_throw;
using brittle::c::release;

// The other forms of the standard library call these.
void* operator new(size_t size) {
    return allocate_or_throw(size, 1);
}
void* operator new(size_t size, std::align_val_t alignment) {
    return allocate_or_throw(size, static_cast<size_t>(alignment));
}
void operator delete(void* memory) noexcept {
    release(memory, 1);
}
void operator delete(void* memory, size_t) noexcept {
    release(memory, 1);
}
void operator delete(void* memory, std::align_val_t alignment) noexcept {
    release(memory, static_cast<size_t>(alignment));
}
void operator delete(void* memory, size_t, std::align_val_t alignment) noexcept {
    release(memory, static_cast<size_t>(alignment));
}

extern "C" brittle_status brittle_set_allocator(const brittle_allocator* allocator, brittle_error* error) {
    using namespace brittle;
    return c::guarded(error, [&] {
        const brittle_allocator given = c::read_settings(allocator, brittle_allocator{}, "allocator");
        if (!given.allocate != !given.release)
            c::refuse(std::string("allocator.") + (given.allocate ? "release" : "allocate") + " is NULL");
        if (!given.allocate) {
            c::chosen.store(&c::default_allocator);
            return;
        }
        // A caller that chooses the same one again and again uses no memory for it.
        const auto is_given = [&](const c::Allocator& a) {
            return a.allocate == given.allocate && a.release == given.release && a.user == given.user;
        };
        static std::atomic<const c::Allocator*> newest{nullptr};
        const c::Allocator* known = newest.load();
        while (known && !is_given(*known)) known = known->older;
        if (!known) {
            auto* const made = static_cast<c::Allocator*>(std::malloc(sizeof(c::Allocator)));
            if (!made) throw std::bad_alloc();
            new (made) c::Allocator{given.allocate, given.release, given.user, newest.load()};
            while (!newest.compare_exchange_weak(made->older, made)) {
            }
            known = made;
        }
        c::chosen.store(known);
    });
}
