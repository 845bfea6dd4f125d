// How a failed Vulkan call travels inside the engine: as an exception, from any depth to the public function
// that was called, which turns it into a Result. Nearly every line of rendering code can fail with "device
// lost" or "out of memory", always with the same answer, and RAII cleans up on the way; threading a Result
// through each would bury the code. No exception leaves the engine.
//
//     Result<void> Renderer::warm_up() {
//         return guarded([&]() -> Result<void> { ...check(vkQueueSubmit2(...), "submit a frame")...; return
//         {}; });
//     }
#pragma once

#include <new>
#include <utility>

#include <vulkan/vulkan.h>

#include "engine/core/result.h"

namespace brittle::engine {

struct VulkanFailure {
    Error error;
};

[[nodiscard]] const char* to_string(VkResult result);

// Throws VulkanFailure unless the result is a success code; `doing` completes "cannot ...".
void check(VkResult result, const char* doing);

// Runs a function that returns a Result, and turns a VulkanFailure or an exhausted host memory into its
// Error.
template<class Function>
auto guarded(Function&& function) -> decltype(function()) {
    try {
        return std::forward<Function>(function)();
    } catch (const VulkanFailure& failure) {
        return failure.error;
    } catch (const std::bad_alloc&) {
        return Error{Status::out_of_memory, "out of memory"};
    }
}

} // namespace brittle::engine
