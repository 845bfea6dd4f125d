// Errors of the engine: the machine it runs on (no driver, no device, no display), files, and arguments out
// of range. A bug in Brittle asserts instead.
//
// Result<T> holds a T or an Error. Check before use:
//
//     Result<std::unique_ptr<Device>> device = Device::create({});
//     if (!device) { std::fputs(device.error().message.c_str(), stderr); return 1; }
//     use(**device);
//
// The fracture library has a type of the same shape (fracture/base/error.h). They are two on purpose: neither
// library includes the other, and their lists of causes have nothing in common.
#pragma once

#include <cassert>
#include <string>
#include <utility>
#include <variant>

namespace brittle::engine {

enum class Status {
    no_driver,        // the machine has no Vulkan driver
    no_device,        // no device, or none that matches what was asked for
    missing_feature,  // the device lacks a feature that Brittle needs
    no_display,       // no window system to open a window on
    device_lost,      // the device was lost or hangs: no object made from it works any more
    device_failure,   // a Vulkan call failed
    out_of_memory,    // host or device memory ran out
    invalid_argument, // an argument outside its documented range
    file_error        // a file could not be read or written
};

// The status in words, e.g. "no_driver"; a static string.
[[nodiscard]] const char* to_string(Status status);

struct Error {
    Status status;
    std::string message; // for people: what is wrong, where, what to do
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

} // namespace brittle::engine
