// Iterates over the tokens and lines of a text file, for the text formats.
#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <string_view>

namespace brittle::fracture {

// Spaces and tabs separate tokens. A backslash before the end of a line continues the line, as in OBJ.
class TextCursor {
  public:
    explicit TextCursor(std::string_view text) : text_(text) {}

    [[nodiscard]] size_t line() const { return line_; } // counted from 1
    [[nodiscard]] bool at_end() const { return at_ == text_.size(); }

    // Returns the next token of this line; empty at its end.
    std::string_view token();
    // Returns the next token of this line or a later one; empty at the end of the text.
    std::string_view token_of_any_line();
    // Returns the rest of this line, trimmed of blanks. For names, which may contain blanks.
    std::string_view rest_of_line();
    // Skips the rest of this line.
    void next_line();

  private:
    [[nodiscard]] size_t continuation() const; // length of a backslash and line end here; 0 where there is none

    std::string_view text_;
    size_t at_ = 0;
    size_t line_ = 1;
};

// Parses the whole token as a number, independent of the locale; nothing where it is not a number. "nan" and "inf" are
// numbers; a number out of the range of double is infinite or zero.
[[nodiscard]] std::optional<double> parse_number(std::string_view token);

// The number as people write it, for a message: the shortest digits, without exponent where it is short.
[[nodiscard]] std::string written(double number);

// The token for a message: shortened, with bytes that could upset a terminal replaced.
[[nodiscard]] std::string printable(std::string_view token);

// printable(), in quotes.
[[nodiscard]] std::string quoted(std::string_view token);

} // namespace brittle::fracture
