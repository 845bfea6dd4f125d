#include "fracture/sites/sites.h"

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <fstream>
#include <optional>
#include <string>
#include <string_view>
#include <system_error>

#include "fracture/base/random.h"

namespace brittle::fracture {
namespace {

constexpr size_t max_line_length = 4096; // bytes; far longer than any line of a site, soon exceeded in a binary file
constexpr size_t max_sites = 10'000'000; // 240 MB of sites, far more than a fracture can use

enum class LineEnd { newline, end_of_file, too_long };

// std::getline with bounded memory.
LineEnd read_line(std::streambuf& in, std::string& line) {
    using Traits = std::streambuf::traits_type;
    line.clear();
    for (;;) {
        const Traits::int_type c = in.sbumpc();
        if (Traits::eq_int_type(c, Traits::eof())) return LineEnd::end_of_file;
        if (c == '\n') return LineEnd::newline;
        if (line.size() == max_line_length) return LineEnd::too_long;
        line.push_back(Traits::to_char_type(c));
    }
}

// Returns the text as a message may print it: short, on one line, without control characters.
std::string printable(std::string_view text) {
    constexpr size_t longest = 60;
    std::string out = "'";
    for (const char c : text.substr(0, longest)) out += static_cast<unsigned char>(c) < 0x20 || c == 0x7f ? '?' : c;
    out += text.size() > longest ? "...'" : "'";
    return out;
}

bool is_blank(char c) {
    return c == ' ' || c == '\t';
}

std::string_view skip_blanks(std::string_view text) {
    while (!text.empty() && is_blank(text.front())) text.remove_prefix(1);
    return text;
}

// Skips a separator: blanks with at most one comma. Returns nothing if there is none.
std::optional<std::string_view> skip_separator(std::string_view text) {
    std::string_view rest = skip_blanks(text);
    if (!rest.empty() && rest.front() == ',') rest = skip_blanks(rest.substr(1));
    if (rest.size() == text.size()) return std::nullopt;
    return rest;
}

struct ParsedLine {
    glm::dvec3 site{0.0};
    std::optional<double> radius{};
    std::string complaint; // empty for a valid line
    Status status = Status::malformed_file;
};

ParsedLine parse_site(std::string_view line) {
    constexpr std::array<const char*, 4> names = {"x", "y", "z", "radius"};
    ParsedLine parsed;
    std::string_view rest = line;
    for (int k = 0; k < 4; ++k) {
        if (k == 3 && skip_blanks(rest).empty()) return parsed;
        if (k > 0) {
            const auto after = skip_separator(rest);
            if (!after && !rest.empty()) {
                parsed.complaint = "expected a space, a tab or a comma before " + printable(rest);
                return parsed;
            }
            rest = after.value_or(rest);
        }
        if (rest.empty()) {
            parsed.complaint = std::string("expected three numbers 'x y z', but ") + names[static_cast<size_t>(k)]
                               + " is missing in " + printable(line);
            return parsed;
        }
        // std::from_chars does not accept a plus sign. Dropping it must not make "+-1" valid.
        const bool plus = rest.size() > 1 && rest[0] == '+' && rest[1] != '-' && rest[1] != '+';
        double value = 0.0;
        const char* const begin = rest.data() + (plus ? 1 : 0);
        const char* const end = rest.data() + rest.size();
        const auto [stop, code] = std::from_chars(begin, end, value);
        if (code == std::errc::invalid_argument) {
            parsed.complaint = "expected a number, found " + printable(rest);
            return parsed;
        }
        if (code == std::errc::result_out_of_range || !std::isfinite(value)) {
            const auto length = static_cast<size_t>(stop - rest.data());
            parsed.complaint =
                "expected a finite number within the range of a double, found " + printable(rest.substr(0, length));
            parsed.status = Status::invalid_sites;
            return parsed;
        }
        rest = std::string_view(stop, static_cast<size_t>(end - stop));
        if (k < 3) {
            parsed.site[k] = value;
        } else if (value >= 0.0) {
            parsed.radius = value;
        } else {
            parsed.complaint = "the radius is negative; give 0 or more";
            parsed.status = Status::invalid_sites;
            return parsed;
        }
    }
    rest = skip_blanks(rest);
    if (!rest.empty()) parsed.complaint = "expected 'x y z' or 'x y z radius', found more text: " + printable(rest);
    return parsed;
}

// Returns the data of a line: without comment, carriage return and blanks at the ends.
std::string_view data_of(std::string_view line) {
    line = skip_blanks(line.substr(0, line.find('#')));
    while (!line.empty() && (is_blank(line.back()) || line.back() == '\r')) line.remove_suffix(1);
    return line;
}

} // namespace

std::vector<glm::dvec3> uniform_sites(const Box& box, uint32_t count, uint64_t seed) {
    Random random(seed);
    std::vector<glm::dvec3> sites(count);
    for (glm::dvec3& site : sites) site = random.uniform_in(box);
    return sites;
}

Result<SiteList> read_sites(const std::filesystem::path& file) {
    const std::string name = file.string();
    std::error_code ignored;
    if (std::filesystem::is_directory(file, ignored)) {
        return Error{Status::file_not_found, name + ": is a folder; give a text file of 'x y z' lines"};
    }
    std::ifstream in(file, std::ios::binary);
    if (!in)
        return Error{Status::file_not_found,
                     name + ": cannot be read; check that the file exists and that you may read it"};

    SiteList list;
    std::string line;
    LineEnd end = LineEnd::newline;
    for (uint64_t number = 1; end == LineEnd::newline; ++number) {
        end = read_line(*in.rdbuf(), line);
        const auto at_line = [&] { return name + ":" + std::to_string(number) + ": "; };
        if (end == LineEnd::too_long) {
            return Error{Status::malformed_file, at_line() + "longer than " + std::to_string(max_line_length)
                                                     + " bytes; give a text file of 'x y z' lines. The line starts "
                                                     + printable(line)};
        }
        std::string_view text = line;
        constexpr std::string_view byte_order_mark = "\xef\xbb\xbf";
        if (number == 1 && text.starts_with(byte_order_mark)) text.remove_prefix(byte_order_mark.size());
        text = data_of(text);
        if (text.empty()) continue;
        const ParsedLine parsed = parse_site(text);
        if (!parsed.complaint.empty()) return Error{parsed.status, at_line() + parsed.complaint};
        if (list.sites.size() == max_sites) {
            return Error{Status::invalid_sites,
                         at_line() + "more than " + std::to_string(max_sites) + " sites; give fewer"};
        }
        list.sites.push_back(parsed.site);
        if (!parsed.radius && list.weights.empty()) continue;
        list.weights.resize(list.sites.size() - 1, 0.0);
        list.weights.push_back(parsed.radius.value_or(0.0) * parsed.radius.value_or(0.0));
    }
    if (list.sites.empty()) {
        return Error{Status::invalid_sites, name + ": holds no site; give lines of 'x y z'"};
    }
    return list;
}

} // namespace brittle::fracture
