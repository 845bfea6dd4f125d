// What the handles of the C interface hold, and the border between exceptions and statuses. Internal.
//
// Every C function runs its body in guarded(): a Refusal, a failed Result and any exception become a status and a
// message. The body assigns outputs last, so that a failure leaves them unchanged.
#pragma once

#include <algorithm>
#include <atomic>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <functional>
#include <limits>
#include <memory>
#include <mutex>
#include <new>
#include <span>
#include <stdexcept>
#include <string>
#include <string_view>
#include <type_traits>
#include <utility>
#include <vector>

#include <glm/vec3.hpp>

#include "bindings/c/brittle.h"
#include "fracture/base/error.h"
#include "fracture/fracture.h"
#include "fracture/io/export.h"
#include "fracture/io/model.h"
#include "fracture/pieces/fragments.h"
#include "physics/material.h"

struct brittle_mesh {
    std::shared_ptr<const brittle::fracture::Model> model; // pieces share it
};

struct brittle_text {
    std::string text;
};

struct brittle_files {
    std::vector<brittle::fracture::ExportedFile> files;
};

struct brittle_sites {
    std::vector<glm::dvec3> sites;
    std::vector<double> weights;
    std::vector<uint32_t> groups;
};

struct brittle_workspace {
    brittle::fracture::Workspace workspace;
};

struct brittle_pieces {
    std::shared_ptr<const brittle::fracture::Model> source;
    std::vector<glm::dvec3> sites;
    bool rough = false;
    brittle::fracture::Fragments fragments;

    // Computed by the first caller that asks.
    const brittle::fracture::Certificate& certificate() const;

  private:
    mutable std::once_flag certified_;
    mutable brittle::fracture::Certificate certificate_;
};

namespace brittle::c {

// A refusal of arguments, thrown inside guarded() only.
struct Refusal {
    brittle_status status;
    std::string message;
};

// The material of a name, stone for NULL; or a Refusal that lists all names.
[[nodiscard]] const physics::MaterialPreset& preset_of(const char* name);

[[nodiscard]] brittle_status status_of(fracture::Status status);

[[noreturn]] inline void refuse(std::string message, brittle_status status = BRITTLE_INVALID_ARGUMENT) {
    throw Refusal{status, std::move(message)};
}

// What a mesh that does not bound a solid needs, in words that suit every language.
inline constexpr const char* remedy = "; repair the mesh first, and inspect it for all flaws";
[[nodiscard]] bool repairable(brittle_status status);

// The value of a result, or a Refusal with its error.
template<class T>
T must(fracture::Result<T> result) {
    if (!result) {
        const brittle_status status = status_of(result.error().status);
        throw Refusal{status, result.error().message + (repairable(status) ? remedy : "")};
    }
    if constexpr (!std::is_void_v<T>) return *std::move(result);
}

brittle_status report(brittle_error* error, brittle_status status, std::string_view message) noexcept;

template<class Body>
brittle_status guarded(brittle_error* error, Body&& body) noexcept {
    try {
        body();
        return BRITTLE_OK;
    } catch (const Refusal& refusal) {
        return report(error, refusal.status, refusal.message);
    } catch (const std::bad_alloc&) {
        return report(error, BRITTLE_OUT_OF_MEMORY, "there is not enough memory");
    } catch (const std::length_error&) {
        return report(error, BRITTLE_OUT_OF_MEMORY, "an array would exceed the address space");
    } catch (const std::exception& exception) {
        return report(error, BRITTLE_INTERNAL_ERROR, exception.what());
    } catch (...) {
        return report(error, BRITTLE_INTERNAL_ERROR, "an exception of unknown type");
    }
}

// While it lives, its thread gets from the C library what the allocator of the caller refuses: values of JSON take memory
// even where they are destroyed, and end the program where there is none.
class JsonMemory {
  public:
    JsonMemory() noexcept;
    ~JsonMemory();
    JsonMemory(const JsonMemory&) = delete;
    JsonMemory& operator=(const JsonMemory&) = delete;
    [[nodiscard]] static bool is_on() noexcept; // on this thread

  private:
    bool before_;
};

// guarded() for bodies that read or write JSON.
template<class Body>
brittle_status guarded_json(brittle_error* error, Body&& body) noexcept {
    return guarded(error, [&] {
        const JsonMemory memory;
        body();
    });
}

// The object behind a pointer that must not be null.
template<class T>
T& need(T* pointer, const char* name) {
    if (!pointer) refuse(std::string(name) + " is NULL");
    return *pointer;
}

// Whether a caller cancels: by its function, or by its flag, which any thread may set. Empty where it gave neither.
[[nodiscard]] inline std::function<bool()> cancel_question(int32_t (*call)(void*), void* user, const int32_t* flag) {
    if (!call && !flag) return {};
    return [call, user, flag] {
        if (flag && std::atomic_ref(*const_cast<int32_t*>(flag)).load(std::memory_order_relaxed) != 0) return true;
        return call && call(user) != 0;
    };
}

constexpr size_t max_struct_size = 4096; // bytes; a larger struct_size was never set

// Copies the fields that the caller knows over the defaults. Precondition: S begins with struct_size.
template<class S>
S read_settings(const S* given, const S& defaults, const char* name) {
    S settings = defaults;
    if (!given) return settings;
    const size_t size = given->struct_size;
    if (size < 2 * sizeof(uint32_t) || size > max_struct_size)
        refuse(std::string(name) + ".struct_size is " + std::to_string(size) + "; set it to sizeof of the structure");
    const auto* bytes = reinterpret_cast<const unsigned char*>(given);
    for (size_t k = sizeof(S); k < size; ++k)
        if (bytes[k] != 0)
            refuse(std::string(name) + " sets a field at byte " + std::to_string(k)
                   + " that this version of the library does not know; take a newer library");
    std::memcpy(static_cast<void*>(&settings), given, std::min(size, sizeof(S)));
    settings.struct_size = sizeof(S);
    return settings;
}

// Fills in the fields that the caller knows; clears those that the library does not know.
template<class S>
void write_struct(S value, S* out, const char* name) {
    const size_t size = need(out, name).struct_size;
    if (size < 2 * sizeof(uint32_t) || size > max_struct_size)
        refuse(std::string(name) + ".struct_size is " + std::to_string(size) + "; set it to sizeof of the structure");
    value.struct_size = static_cast<uint32_t>(size);
    std::memcpy(static_cast<void*>(out), &value, std::min(size, sizeof(S)));
    if (size > sizeof(S)) std::memset(reinterpret_cast<unsigned char*>(out) + sizeof(S), 0, size - sizeof(S));
}

// For the public init functions.
template<class S>
void init_struct(S* out, size_t size, const S& defaults) {
    if (!out || size < 2 * sizeof(uint32_t) || size > max_struct_size) return;
    out->struct_size = static_cast<uint32_t>(size);
    write_struct(defaults, out, "settings");
}

// Text of the caller's, or a Refusal for NULL.
[[nodiscard]] std::string read_text(const char* text, const char* name);

// Numbers of the caller's. Refuses a wrong type, number of columns or stride, and more than 2^30 rows.
[[nodiscard]] std::vector<double> read_floats(const brittle_array& array, uint32_t columns, const char* name);
[[nodiscard]] std::vector<uint32_t> read_integers(const brittle_array& array, uint32_t columns, const char* name);
// Finite points of at most 1e50 in magnitude; others give a Refusal of this status.
[[nodiscard]] std::vector<glm::dvec3> read_points(const brittle_array& array, const char* name, brittle_status status);

// Three finite numbers behind a pointer.
template<class T>
glm::vec<3, T> read_vector(const T* numbers, const char* name) {
    need(numbers, name);
    const glm::vec<3, T> v(numbers[0], numbers[1], numbers[2]);
    for (int k = 0; k < 3; ++k)
        if (!(std::abs(v[k]) <= std::numeric_limits<T>::max()))
            refuse(std::string(name) + "[" + std::to_string(k) + "] is " + std::to_string(v[k])
                   + "; it must be finite");
    return v;
}

// A number, or a Refusal unless low <= value <= high.
double in_range(double value, double low, double high, const char* name);

// A view of one member of each element of an array; `first` points at the member in the first element.
template<class T, class E>
brittle_array view(const std::vector<E>& elements, const T* first, uint32_t columns) {
    constexpr uint32_t type = std::is_same_v<T, float>      ? BRITTLE_FLOAT32
                              : std::is_same_v<T, double>   ? BRITTLE_FLOAT64
                              : std::is_same_v<T, uint16_t> ? BRITTLE_UINT16
                                                            : BRITTLE_UINT32;
    return {type, columns, elements.size(), sizeof(E), elements.empty() ? nullptr : first};
}

// A view of an array whose elements are numbers or vectors of numbers.
template<class T, class E>
brittle_array view(const std::vector<E>& elements) {
    static_assert(sizeof(E) % sizeof(T) == 0);
    return view(elements, reinterpret_cast<const T*>(elements.data()), sizeof(E) / sizeof(T));
}

[[noreturn]] void refuse_which(uint32_t which, uint32_t last);

} // namespace brittle::c
