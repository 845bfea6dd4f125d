// Fault injection: makes Vulkan calls fail on demand, so that a test covers a lost device, exhausted memory or a window
// that changes during a frame.
//
//     FaultInjector faults;
//     Result<std::unique_ptr<Device>> device = Device::create({.faults = &faults});
//     faults.fail(Call::allocate, VK_ERROR_OUT_OF_DEVICE_MEMORY, 3); // the third allocation from now on
//     faults.hide("drawIndirectFirstInstance");                      // before Device::create(): hides a feature
//
// All calls of a kind pass through Device::attempt(), on any thread; hide() must precede Device::create(). Without an
// injector, the cost is the test of a null pointer. `brittle` reads a plan from the variable BRITTLE_FAULTS (plan()).
#pragma once

#include <array>
#include <cstdint>
#include <mutex>
#include <string>
#include <string_view>
#include <vector>

#include <vulkan/vulkan.h>

#include "engine/core/result.h"

namespace brittle::engine {

enum class Call { create_device, allocate, map, submit, wait, create_swapchain, acquire, present };
inline constexpr size_t call_kinds = 8;

class FaultInjector {
  public:
    // Makes the n-th call of the kind from now on, counted from 1, and the `times - 1` calls after it return `result`.
    // A kind has one rule; a new rule replaces it, and VK_SUCCESS removes it. After VK_ERROR_DEVICE_LOST the device
    // stays lost.
    void fail(Call kind, VkResult result, uint32_t n = 1, uint32_t times = 1);

    // Hides a feature, instance extension, device extension or layer from Device::create(). "subgroupBallot" is the
    // subgroup operation.
    void hide(std::string name) { hidden_.push_back(std::move(name)); }
    [[nodiscard]] bool hides(std::string_view name) const;

    // Applies rules from text, separated by commas: KIND:RESULT:N or KIND:RESULT:N:TIMES for fail(), with RESULT the
    // number of a VkResult, and hide:NAME for hide(). "submit:-4:40" loses the device in the fortieth submission. Fails
    // with invalid_argument.
    [[nodiscard]] Result<void> plan(std::string_view text);

    // Returns the number of calls of the kind so far, injected failures included.
    [[nodiscard]] uint32_t count(Call kind) const;

    // Makes the call, or returns the injected failure.
    template<class Function>
    VkResult attempt(Call kind, Function&& call) {
        const VkResult fault = next_result(kind);
        if (fault == VK_SUCCESS) return call();
        if (call_still_made(kind, fault))
            if (const VkResult real = call(); real < 0) return real;
        return fault;
    }

  private:
    struct Rule {
        VkResult result = VK_SUCCESS;
        uint32_t first = 0; // the first and last call that fail, counted from 1
        uint32_t last = 0;
        uint32_t seen = 0; // calls so far
    };

    [[nodiscard]] VkResult next_result(Call kind);
    [[nodiscard]] static bool call_still_made(Call kind, VkResult fault);

    mutable std::mutex mutex_; // guards rules_ and lost_
    std::array<Rule, call_kinds> rules_{};
    std::vector<std::string> hidden_;
    bool lost_ = false;
};

} // namespace brittle::engine
