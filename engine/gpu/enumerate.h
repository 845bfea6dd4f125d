// Vulkan's enumerations, which take two calls: one for the count, one for the elements.
//
//     const auto devices = enumerate<VkPhysicalDevice>(vkEnumeratePhysicalDevices, instance);
#pragma once

#include <cstdint>
#include <vector>

namespace brittle::engine {

// Calls list(arguments..., &count, elements) twice and returns the elements. The result of `list` is ignored: a failure
// gives no elements, and elements that appear between the two calls are omitted. A caller that needs the result checks
// it inside `list`.
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
