// BasicResult<T, Error> holds either the value of a function that succeeded or the Error of one that failed. A bug
// asserts instead.
//
// - Each library derives its own Result<T> from it, with its own Error: fracture/base/error.h, engine/core/result.h.
// - A T and an Error both convert to it, so a function returns either one as it is.
// - Reading the value of a failure, or the error of a success, is a bug.
//
//     Result<TriangleMesh> mesh = import_mesh("bunny.obj");
//     if (!mesh) return mesh.error();
//     use(*mesh);
#pragma once

#include <cassert>
#include <utility>
#include <variant>

namespace brittle {

template<class T, class Error>
class [[nodiscard]] BasicResult {
  public:
    BasicResult(T value) : state_(std::in_place_index<0>, std::move(value)) {}
    BasicResult(Error error) : state_(std::in_place_index<1>, std::move(error)) {}

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

// Success without a value, or an Error.
template<class Error>
class [[nodiscard]] BasicResult<void, Error> {
  public:
    BasicResult() = default;
    BasicResult(Error error) : error_(std::move(error)), failed_(true) {}

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

} // namespace brittle
