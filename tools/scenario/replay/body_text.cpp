#include "tools/scenario/replay/body_text.h"

#include <algorithm>
#include <charconv>

namespace brittle::tools {

namespace {

constexpr uint64_t max_bodies = 100'000'000; // limit that keeps the sum of damaged counts from overflowing

// The digits of one body, or the length of a run of unchanged bodies.
struct Token {
    std::string_view digits;
    uint64_t bodies = 1;
};

// Removes and returns the first token; nothing if there is none.
std::optional<Token> take(std::string_view& text) {
    if (text.starts_with('(')) {
        Token run;
        const char* end = text.data() + text.size();
        const auto [at, error] = std::from_chars(text.data() + 1, end, run.bodies);
        if (error != std::errc{} || at == end || *at != ')' || run.bodies == 0 || run.bodies > max_bodies) return {};
        text.remove_prefix(static_cast<size_t>(at - text.data()) + 1);
        return run;
    }
    const std::string_view digits = text.substr(0, 4);
    if (digits.size() < 4 || digits.find_first_not_of("0123456789abcdef") != digits.npos) return {};
    text.remove_prefix(4);
    return Token{digits};
}

} // namespace

std::optional<uint64_t> count_bodies(std::string_view text) {
    uint64_t count = 0;
    while (!text.empty()) {
        const std::optional<Token> token = take(text);
        if (!token) return {};
        count += token->bodies;
        if (count > max_bodies) return {};
    }
    return count;
}

std::optional<uint64_t> first_difference(std::string_view a, std::string_view b) {
    uint64_t body = 0;
    Token left{{}, 0}, right{{}, 0};
    const auto refill = [](Token& token, std::string_view& text) {
        if (token.bodies > 0) return true;
        const std::optional<Token> next = take(text);
        token = next.value_or(Token{{}, 0});
        return next.has_value();
    };
    while (refill(left, a) && refill(right, b)) {
        if (left.digits != right.digits) return body;
        const uint64_t both = std::min(left.bodies, right.bodies);
        body += both;
        left.bodies -= both;
        right.bodies -= both;
    }
    return {};
}

} // namespace brittle::tools
