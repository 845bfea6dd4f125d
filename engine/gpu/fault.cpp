#include "engine/gpu/fault.h"

#include <algorithm>
#include <charconv>
#include <limits>

namespace brittle::engine {

namespace {

constexpr std::array<std::string_view, call_kinds> call_names{
    "create_device", "allocate", "map", "submit", "wait", "create_swapchain", "acquire", "present"};

// Removes the text before the next separator, and the separator, from `text`; returns the removed text.
std::string_view take(std::string_view& text, char separator) {
    const size_t end = text.find(separator);
    const std::string_view word = text.substr(0, end);
    text = end == std::string_view::npos ? std::string_view() : text.substr(end + 1);
    return word;
}

template<class Number>
bool read_number(std::string_view word, Number& number) {
    const char* end = word.data() + word.size();
    const auto read = std::from_chars(word.data(), end, number);
    return read.ec == std::errc() && read.ptr == end;
}

} // namespace

void FaultInjector::fail(Call kind, VkResult result, uint32_t n, uint32_t times) {
    const std::scoped_lock lock(mutex_);
    Rule& rule = rules_[static_cast<size_t>(kind)];
    rule.result = result;
    rule.first = rule.seen + n;
    rule.last = times - 1 > std::numeric_limits<uint32_t>::max() - rule.first ? std::numeric_limits<uint32_t>::max()
                                                                              : rule.first + (times - 1);
}

uint32_t FaultInjector::count(Call kind) const {
    const std::scoped_lock lock(mutex_);
    return rules_[static_cast<size_t>(kind)].seen;
}

bool FaultInjector::hides(std::string_view name) const {
    return std::ranges::find(hidden_, name) != hidden_.end();
}

Result<void> FaultInjector::plan(std::string_view text) {
    while (!text.empty()) {
        const std::string_view rule = take(text, ',');
        std::string_view rest = rule;
        const std::string_view kind = take(rest, ':');
        if (kind == "hide" && !rest.empty()) {
            hide(std::string(rest));
            continue;
        }
        const auto name = std::ranges::find(call_names, kind);
        int result = 0;
        uint32_t n = 0, times = 1;
        if (name == call_names.end() || !read_number(take(rest, ':'), result) || !read_number(take(rest, ':'), n)
            || n == 0 || (!rest.empty() && (!read_number(rest, times) || times == 0)))
            return Error{Status::invalid_argument,
                         "cannot read the fault \"" + std::string(rule)
                             + "\": it must be KIND:RESULT:N, KIND:RESULT:N:TIMES or hide:NAME"};
        fail(static_cast<Call>(name - call_names.begin()), static_cast<VkResult>(result), n, times);
    }
    return {};
}

VkResult FaultInjector::next_result(Call kind) {
    const std::scoped_lock lock(mutex_);
    Rule& rule = rules_[static_cast<size_t>(kind)];
    ++rule.seen;
    const bool device_call = kind >= Call::submit;
    if (lost_ && device_call) return VK_ERROR_DEVICE_LOST;
    if (rule.seen < rule.first || rule.seen > rule.last) return VK_SUCCESS;
    lost_ = lost_ || (device_call && rule.result == VK_ERROR_DEVICE_LOST);
    return rule.result;
}

// Returns whether the real call is made before the injected result is returned. A failed present has waited for its
// semaphore. A device declared lost is still at work, so the wait must finish before its objects are destroyed. A
// suboptimal acquire delivers an image.
bool FaultInjector::call_still_made(Call kind, VkResult fault) {
    return kind == Call::present || (kind == Call::wait && fault == VK_ERROR_DEVICE_LOST) || fault == VK_SUBOPTIMAL_KHR;
}

} // namespace brittle::engine
