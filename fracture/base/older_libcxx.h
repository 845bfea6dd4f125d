// What libc++ before version 16 lacks of C++20. Builds for the browser, by Emscripten of Debian 12, include it before
// every source (bindings/web/CMakeLists.txt); no other build knows of it.
#pragma once

#include <version>

#if defined(_LIBCPP_VERSION) && _LIBCPP_VERSION < 16000

#include <algorithm>
#include <atomic>
#include <charconv>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <functional>
#include <iterator>
#include <span>
#include <string>
#include <type_traits>
#include <utility>

_LIBCPP_BEGIN_NAMESPACE_STD

template<class T>
class atomic_ref {
  public:
    explicit atomic_ref(T& value) : value_(&value) {}
    T load(memory_order order = memory_order_seq_cst) const noexcept {
        return __atomic_load_n(value_, static_cast<int>(order));
    }
    void store(T desired, memory_order order = memory_order_seq_cst) const noexcept {
        __atomic_store_n(value_, desired, static_cast<int>(order));
    }
    T exchange(T desired, memory_order order = memory_order_seq_cst) const noexcept {
        return __atomic_exchange_n(value_, desired, static_cast<int>(order));
    }
    bool compare_exchange_weak(T& expected, T desired, memory_order order = memory_order_seq_cst) const noexcept {
        return __atomic_compare_exchange_n(value_, &expected, desired, true, static_cast<int>(order), __ATOMIC_RELAXED);
    }
    bool compare_exchange_strong(T& expected, T desired, memory_order order = memory_order_seq_cst) const noexcept {
        return __atomic_compare_exchange_n(value_, &expected, desired, false, static_cast<int>(order),
                                           __ATOMIC_RELAXED);
    }

  private:
    T* value_;
};

#if !defined(__cpp_lib_bit_cast)
template<class To, class From>
[[nodiscard]] constexpr To bit_cast(const From& from) noexcept {
    return __builtin_bit_cast(To, from);
}
#endif

// The fewest digits that give the number back. Where the standard takes the shorter of 100000 and 1e+05, printf() may take
// the other: text differs, numbers do not.
inline to_chars_result to_chars(char* first, char* last, double value) {
    char text[40];
    int size = 0;
    for (int digits = 1; digits <= 17; ++digits) {
        size = std::snprintf(text, sizeof text, "%.*g", digits, value);
        if (std::strtod(text, nullptr) == value || value != value) break;
    }
    if (size > last - first) return {last, errc::value_too_large};
    std::memcpy(first, text, static_cast<size_t>(size));
    return {first + size, errc{}};
}
inline to_chars_result to_chars(char* first, char* last, float value) {
    char text[40];
    int size = 0;
    for (int digits = 1; digits <= 9; ++digits) {
        size = std::snprintf(text, sizeof text, "%.*g", digits, static_cast<double>(value));
        if (std::strtof(text, nullptr) == value || value != value) break;
    }
    if (size > last - first) return {last, errc::value_too_large};
    std::memcpy(first, text, static_cast<size_t>(size));
    return {first + size, errc{}};
}

// strtod() takes more: spaces, a plus sign and hexadecimal digits.
inline from_chars_result from_chars(const char* first, const char* last, double& value) {
    const char* at = first != last && *first == '-' ? first + 1 : first;
    const bool word = last - at >= 3 && (*at == 'i' || *at == 'I' || *at == 'n' || *at == 'N');
    const bool number = at != last && (word || *at == '.' || (*at >= '0' && *at <= '9'));
    if (!number) return {first, errc::invalid_argument};
    if (last - at >= 2 && at[0] == '0' && (at[1] == 'x' || at[1] == 'X')) {
        value = at == first ? 0.0 : -0.0;
        return {at + 1, errc{}};
    }
    const std::string text(first, std::min<ptrdiff_t>(last - first, 2000)); // strtod() needs an end
    char* end = nullptr;
    const double found = std::strtod(text.c_str(), &end);
    if (end == text.c_str()) return {first, errc::invalid_argument};
    const char* stop = first + (end - text.c_str());
    if (!word && (found == HUGE_VAL || found == -HUGE_VAL)) return {stop, errc::result_out_of_range};
    value = found;
    return {stop, errc{}};
}
inline from_chars_result from_chars(const char* first, const char* last, float& value) {
    double found = 0.0;
    const from_chars_result result = from_chars(first, last, found);
    if (result.ec == errc{}) value = static_cast<float>(found);
    return result;
}

#if !defined(__cpp_lib_ranges)
namespace ranges {

struct itself {
    template<class T>
    const T& operator()(const T& value) const {
        return value;
    }
};

template<class Range, class Compare = std::less<>, class Projection = itself>
void sort(Range&& range, Compare compare = {}, Projection of = {}) {
    std::sort(std::begin(range), std::end(range), [&](const auto& a, const auto& b) {
        return std::invoke(compare, std::invoke(of, a), std::invoke(of, b));
    });
}

template<class Range, class Compare = std::less<>, class Projection = itself>
void stable_sort(Range&& range, Compare compare = {}, Projection of = {}) {
    std::stable_sort(std::begin(range), std::end(range), [&](const auto& a, const auto& b) {
        return std::invoke(compare, std::invoke(of, a), std::invoke(of, b));
    });
}

template<class Range, class Predicate>
bool all_of(Range&& range, Predicate holds) {
    return std::all_of(std::begin(range), std::end(range), [&](const auto& a) { return std::invoke(holds, a); });
}

template<class Range, class Predicate>
bool any_of(Range&& range, Predicate holds) {
    return std::any_of(std::begin(range), std::end(range), [&](const auto& a) { return std::invoke(holds, a); });
}

template<class Range, class Predicate>
bool none_of(Range&& range, Predicate holds) {
    return !ranges::any_of(range, holds);
}

template<class Range, class T, class Projection = itself>
auto count(Range&& range, const T& value, Projection of = {}) {
    return std::count_if(std::begin(range), std::end(range),
                         [&](const auto& a) { return std::invoke(of, a) == value; });
}

template<class Range, class T, class Projection = itself>
auto find(Range&& range, const T& value, Projection of = {}) {
    return std::find_if(std::begin(range), std::end(range), [&](const auto& a) { return std::invoke(of, a) == value; });
}

template<class Range, class T, class Compare = std::less<>, class Projection = itself>
auto lower_bound(Range&& range, const T& value, Compare compare = {}, Projection of = {}) {
    return std::lower_bound(std::begin(range), std::end(range), value,
                            [&](const auto& a, const T& b) { return std::invoke(compare, std::invoke(of, a), b); });
}

template<class Range, class Compare = std::less<>, class Projection = itself>
auto max_element(Range&& range, Compare compare = {}, Projection of = {}) {
    return std::max_element(std::begin(range), std::end(range), [&](const auto& a, const auto& b) {
        return std::invoke(compare, std::invoke(of, a), std::invoke(of, b));
    });
}

template<class Range, class T>
void replace(Range&& range, const T& old_value, const T& new_value) {
    std::replace(std::begin(range), std::end(range), old_value, new_value);
}

template<class First, class Second, class Out>
void set_union(First&& first, Second&& second, Out out) {
    std::set_union(std::begin(first), std::end(first), std::begin(second), std::end(second), out);
}

} // namespace ranges
#endif

_LIBCPP_END_NAMESPACE_STD

#endif
