// Errors that a caller must expect: bad files, bad meshes, bad settings. A bug in Brittle asserts instead.
//
// Result<T> holds either a T or an Error. Check it before use:
//
//     Result<TriangleMesh> mesh = import_mesh("bunny.obj");
//     if (!mesh) { std::fputs(mesh.error().message.c_str(), stderr); return 1; }
//     use(*mesh);
#pragma once

#include <cassert>
#include <string>
#include <utility>
#include <variant>

namespace brittle::fracture {

enum class Status {
    file_not_found,     // the file does not exist, or may not be read
    unsupported_format, // no reader or writer has this file extension
    malformed_file,     // the content of the file is damaged, truncated or of another format than the extension says
    empty_mesh,         // the mesh has no triangles
    invalid_mesh,       // a coordinate is not finite or too large, an index out of range, a vertex repeated
    not_closed,         // an edge belongs to one triangle only
    non_manifold,       // an edge belongs to three triangles or more, or a vertex to several fans
    not_oriented,       // adjacent triangles have opposite orientations
    inside_out,         // the enclosed volume is negative: the triangles face inwards
    no_volume,          // the enclosed volume is zero up to rounding
    invalid_sites,      // there are no sites, or a site is not finite or too far away
    invalid_setting,    // a setting is outside its documented range
    cancelled,          // Settings::cancelled returned true
    write_failed        // the output could not be written; an existing file is unchanged
};

// Returns the name of the status, for example "malformed_file". The string is static.
[[nodiscard]] constexpr const char* to_string(Status status) {
    switch (status) {
    case Status::file_not_found:
        return "file_not_found";
    case Status::unsupported_format:
        return "unsupported_format";
    case Status::malformed_file:
        return "malformed_file";
    case Status::empty_mesh:
        return "empty_mesh";
    case Status::invalid_mesh:
        return "invalid_mesh";
    case Status::not_closed:
        return "not_closed";
    case Status::non_manifold:
        return "non_manifold";
    case Status::not_oriented:
        return "not_oriented";
    case Status::inside_out:
        return "inside_out";
    case Status::no_volume:
        return "no_volume";
    case Status::invalid_sites:
        return "invalid_sites";
    case Status::invalid_setting:
        return "invalid_setting";
    case Status::cancelled:
        return "cancelled";
    case Status::write_failed:
        return "write_failed";
    }
    return "unknown";
}

struct Error {
    Status status;
    std::string message; // for people: the fault, its place (file, line, index, value) and the remedy
};

template<class T>
class [[nodiscard]] Result {
  public:
    Result(T value) : state_(std::in_place_index<0>, std::move(value)) {}
    Result(Error error) : state_(std::in_place_index<1>, std::move(error)) {}

    [[nodiscard]] bool has_value() const { return state_.index() == 0; }
    explicit operator bool() const { return has_value(); }

    T& operator*() & { return value(); }
    const T& operator*() const& { return value(); }
    T&& operator*() && { return std::move(value()); }
    T* operator->() { return &value(); }
    const T* operator->() const { return &value(); }

    [[nodiscard]] const Error& error() const {
        assert(!has_value());
        return *std::get_if<1>(&state_);
    }

  private:
    T& value() {
        assert(has_value());
        return *std::get_if<0>(&state_);
    }
    const T& value() const {
        assert(has_value());
        return *std::get_if<0>(&state_);
    }

    std::variant<T, Error> state_;
};

// A Result without a value: success, or an Error.
template<>
class [[nodiscard]] Result<void> {
  public:
    Result() = default;
    Result(Error error) : error_(std::move(error)), failed_(true) {}

    [[nodiscard]] bool has_value() const { return !failed_; }
    explicit operator bool() const { return has_value(); }
    [[nodiscard]] const Error& error() const {
        assert(failed_);
        return error_;
    }

  private:
    Error error_{};
    bool failed_ = false;
};

} // namespace brittle::fracture
