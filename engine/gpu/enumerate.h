// What Vulkan lists in two calls: first how many there are, then which.
//
//     const auto devices = enumerate<VkPhysicalDevice>(vkEnumeratePhysicalDevices, instance);
#pragma once

#include <cstdint>
#include <vector>

namespace brittle::engine {

// `list` takes the arguments, a pointer to the count and one to the elements. What it returns is ignored: a failure lists
// nothing, and what comes between the two calls is left out. A caller that must know checks within `list`.
template<class Element, class Function, class... Arguments>
[[nodiscard]] std::vector<Element> enumerate(const Function& list, Arguments... arguments) {
    uint32_t count = 0;
    list(arguments..., &count, nullptr);
    std::vector<Element> elements(count);
    list(arguments..., &count, elements.data());
    elements.resize(count);
    return elements;
}

} // namespace brittle::engine
