// Failure of Vulkan calls inside the engine. A failed call throws VulkanFailure; the public function that the caller
// entered turns the exception into a Result. Nearly every line of rendering code can fail with "device lost" or "out of
// memory", the response is always the same, and RAII cleans up; passing a Result through each line would bury the
// code. No exception leaves the engine.
//
//     Result<void> Renderer::warm_up() {
//         return guarded([&]() -> Result<void> {
//             check(vkQueueSubmit2(...), "submit a frame");
//             return {};
//         });
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

// Throws VulkanFailure unless the result is a success code. `doing` completes the message "cannot ...".
void check(VkResult result, const char* doing);

// Calls a function that returns a Result. A VulkanFailure or a std::bad_alloc that it throws becomes the Result's
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
