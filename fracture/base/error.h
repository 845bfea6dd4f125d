// Errors that a caller is expected to meet: bad files, bad meshes, bad settings. A bug in Brittle asserts instead.
//
// Result<T> holds a T or an Error. Check before use:
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
    file_not_found,     // no such file, or no permission to read it
    unsupported_format, // a file ending that no reader claims
    malformed_file,     // the file's content is damaged, truncated or not what its ending says
    empty_mesh,         // no triangle
    invalid_mesh,       // a position not finite or too far out, an index out of range, a vertex named twice
    not_closed,         // the surface has a rim: edges of one triangle
    non_manifold,       // edges of three triangles or more
    not_oriented,       // neighbouring triangles face opposite ways
    inside_out,         // the triangles face inwards: the volume is negative
    no_volume,          // the surface is closed around nothing
    invalid_sites,      // no site, or a non-finite one
    invalid_setting,    // a setting outside its documented range
    cancelled,          // Settings::cancelled said so
    write_failed        // the output could not be written; an existing file was left as it was
};

// The status in words, e.g. "malformed_file"; a static string.
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
    std::string message; // for people: what is wrong, where (file, line, index, value), what to do
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
