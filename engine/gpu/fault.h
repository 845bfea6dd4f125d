// Failures on demand: how a test sees Brittle meet a lost device, exhausted memory or a window that changes
// under it, on a machine where none of that happens.
//
//     FaultInjector faults;
//     Result<std::unique_ptr<Device>> device = Device::create({.faults = &faults});
//     faults.fail(Call::allocate, VK_ERROR_OUT_OF_DEVICE_MEMORY, 3); // the third allocation from now on
//     faults.hide("drawIndirectFirstInstance");                              // before create(): no such feature
//
// Calls may come from any thread. Each kind is made in one place, by Device::attempt(). Without an injector
// that costs the test of a null pointer. `brittle` takes a plan from the variable BRITTLE_FAULTS (see plan()).
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
    // The n-th call of the kind from now on, counted from 1, returns `result`, and so do the `times - 1`
    // after it. One order a kind; a new one replaces it, and VK_SUCCESS takes it back. Like a real device, one
    // that was lost stays lost.
    void fail(Call kind, VkResult result, uint32_t n = 1, uint32_t times = 1);

    // Device::create() finds no feature, instance extension, device extension or layer of this name; "subgroupBallot" is
    // the subgroup operation.
    void hide(std::string name) { hidden_.push_back(std::move(name)); }
    [[nodiscard]] bool hides(std::string_view name) const;

    // Orders in words, separated by commas: KIND:RESULT:N or KIND:RESULT:N:TIMES, with RESULT the number of a
    // VkResult, and hide:NAME. "submit:-4:40" loses the device in the fortieth submission. Fails with
    // invalid_argument.
    [[nodiscard]] Result<void> plan(std::string_view text);

    // How often calls of the kind were made or answered since the injector was made.
    [[nodiscard]] uint32_t count(Call kind) const;

    // Makes the call, or answers in its place.
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
        uint32_t first = 0; // in calls, as `seen`
        uint32_t last = 0;
        uint32_t seen = 0;
    };

    [[nodiscard]] VkResult next_result(Call kind);
    [[nodiscard]] static bool call_still_made(Call kind, VkResult fault);

    mutable std::mutex mutex_; // of orders_ and lost_
    std::array<Rule, call_kinds> rules_{};
    std::vector<std::string> hidden_;
    bool lost_ = false;
};

} // namespace brittle::engine
