// Errors of the engine: the machine (no driver, no device, no display), files, and arguments out of range. A bug in
// Brittle asserts instead.
//
// Result<T> holds a T or an Error. Check before use:
//
//     Result<std::unique_ptr<Device>> device = Device::create({});
//     if (!device) { std::fputs(device.error().message.c_str(), stderr); return 1; }
//     use(**device);
#pragma once

#include <string>

#include "fracture/base/result.h"

namespace brittle::engine {

enum class Status {
    no_driver,        // the machine has no Vulkan driver
    no_device,        // no usable device, or none that matches the request
    missing_feature,  // the device lacks a feature that Brittle needs
    no_display,       // no window system to open a window on
    device_lost,      // the device was lost or hangs; every object made from it is unusable
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

// A T, or an Error; fracture/base/result.h documents its members. Result<void> holds success, or an Error.
template<class T>
class [[nodiscard]] Result : public BasicResult<T, Error> {
  public:
    using BasicResult<T, Error>::BasicResult;
};

} // namespace brittle::engine
