#include "tools/brittle/picture_name.h"

#include <cassert>
#include <regex>

namespace brittle::tools {

namespace {
const std::regex numbered("((?:[^%]|%%)*)%(0?[1-9]?)d((?:[^%]|%%)*)");
const std::regex plain("(?:[^%]|%%)*");

std::string unescape(const std::string& text) { return std::regex_replace(text, std::regex("%%"), "%"); }
} // namespace

bool is_numbered(const std::string& pattern) { return std::regex_match(pattern, numbered); }
bool is_plain(const std::string& pattern) { return std::regex_match(pattern, plain); }

std::string picture_name(const std::string& pattern, uint32_t frame) {
    std::smatch parts;
    if (!std::regex_match(pattern, parts, numbered)) {
        assert(is_plain(pattern));
        return unescape(pattern);
    }
    const std::string flags = parts[2];
    const bool zeros = flags.starts_with('0');
    const size_t width = flags.size() > (zeros ? 1 : 0) ? static_cast<size_t>(flags.back() - '0') : 0;
    std::string number = std::to_string(frame);
    if (number.size() < width) number.insert(0, width - number.size(), zeros ? '0' : ' ');
    return unescape(parts[1]) + number + unescape(parts[3]);
}

} // namespace brittle::tools
