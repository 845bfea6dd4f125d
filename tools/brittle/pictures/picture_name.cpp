#include "tools/brittle/pictures/picture_name.h"

#include <cassert>
#include <filesystem>
#include <optional>
#include <system_error>

namespace brittle::tools {

namespace {

// A parsed pattern, with `%%` replaced by `%`.
struct Parts {
    std::string before;
    std::string after;
    bool numbered = false; // whether there is a placeholder between the two
    bool zeros = false;    // whether the number is padded with zeros instead of spaces
    size_t width = 0;
};

// Parses a pattern. Returns nothing for a second placeholder or one that is not for a decimal number.
std::optional<Parts> parse(const std::string& pattern) {
    Parts parts;
    for (size_t i = 0; i < pattern.size(); ++i) {
        std::string& text = parts.numbered ? parts.after : parts.before;
        if (pattern[i] != '%') {
            text += pattern[i];
            continue;
        }
        const auto next = [&] { return ++i < pattern.size() ? pattern[i] : '\0'; };
        char c = next();
        if (c == '%') {
            text += '%';
            continue;
        }
        if (parts.numbered) return {};
        parts.numbered = true;
        if (c == '0') {
            parts.zeros = true;
            c = next();
        }
        if (c >= '1' && c <= '9') {
            parts.width = static_cast<size_t>(c - '0');
            c = next();
        }
        if (c != 'd') return {};
    }
    return parts;
}

} // namespace

bool is_numbered(const std::string& pattern) {
    const std::optional<Parts> parts = parse(pattern);
    return parts && parts->numbered;
}

bool is_plain(const std::string& pattern) {
    const std::optional<Parts> parts = parse(pattern);
    return parts && !parts->numbered;
}

std::string picture_name(const std::string& pattern, uint32_t frame) {
    const std::optional<Parts> parts = parse(pattern);
    assert(parts);
    if (!parts->numbered) return parts->before;
    std::string number = std::to_string(frame);
    if (number.size() < parts->width) number.insert(0, parts->width - number.size(), parts->zeros ? '0' : ' ');
    return parts->before + number + parts->after;
}

std::string unused_name(const std::string& pattern) {
    constexpr uint32_t max_names = 1000;
    std::string name;
    for (uint32_t k = 0; k < max_names; ++k) {
        name = picture_name(pattern, k);
        std::error_code error;
        if (!std::filesystem::exists(name, error)) break;
    }
    return name;
}

} // namespace brittle::tools
