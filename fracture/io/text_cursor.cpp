#include "fracture/io/text_cursor.h"

#include <algorithm>
#include <charconv>
#include <limits>

namespace brittle::fracture {
namespace {

bool is_space(char c) {
    return c == ' ' || c == '\t' || c == '\r' || c == '\v' || c == '\f';
}

} // namespace

size_t TextCursor::continuation() const {
    const std::string_view rest = text_.substr(at_);
    if (rest.starts_with("\\\n")) return 2;
    if (rest.starts_with("\\\r\n")) return 3;
    return 0;
}

std::string_view TextCursor::token() {
    while (at_ < text_.size()) {
        if (is_space(text_[at_])) {
            ++at_;
        } else if (const size_t skipped = continuation()) {
            at_ += skipped;
            ++line_;
        } else {
            break;
        }
    }
    const size_t begin = at_;
    while (at_ < text_.size() && text_[at_] != '\n' && !is_space(text_[at_]) && continuation() == 0) ++at_;
    return text_.substr(begin, at_ - begin);
}

std::string_view TextCursor::token_of_any_line() {
    while (true) {
        const std::string_view found = token();
        if (!found.empty() || at_end()) return found;
        next_line();
    }
}

std::string_view TextCursor::rest_of_line() {
    while (at_ < text_.size() && is_space(text_[at_])) ++at_;
    size_t end = std::min(text_.find('\n', at_), text_.size());
    const size_t begin = at_;
    at_ = end;
    while (end > begin && is_space(text_[end - 1])) --end;
    return text_.substr(begin, end - begin);
}

void TextCursor::next_line() {
    while (at_ < text_.size() && text_[at_] != '\n') {
        const size_t skipped = continuation();
        line_ += skipped > 0 ? 1 : 0;
        at_ += skipped > 0 ? skipped : 1;
    }
    if (at_ < text_.size()) {
        ++at_;
        ++line_;
    }
}

std::optional<double> parse_number(std::string_view token) {
    if (token.starts_with('+') && !token.starts_with("+-")) token.remove_prefix(1);
    double value = 0.0;
    const auto [end, code] = std::from_chars(token.data(), token.data() + token.size(), value);
    if (end != token.data() + token.size() || code == std::errc::invalid_argument) return std::nullopt;
    if (code == std::errc::result_out_of_range) {
        const bool tiny = token.find("e-") != token.npos || token.find("E-") != token.npos;
        return tiny ? 0.0 : std::numeric_limits<double>::infinity();
    }
    return value;
}

std::string written(double number) {
    char digits[32];
    return {digits, std::to_chars(digits, digits + sizeof digits, number).ptr};
}

std::string printable(std::string_view token) {
    constexpr size_t longest = 40;
    std::string result;
    for (const char c : token.substr(0, longest)) result += c >= ' ' && c <= '~' ? c : '?';
    return result + (token.size() > longest ? "..." : "");
}

std::string quoted(std::string_view token) {
    return "'" + printable(token) + "'";
}

} // namespace brittle::fracture
