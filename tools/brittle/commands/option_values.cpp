#include "tools/brittle/commands/option_values.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <functional>
#include <sstream>
#include <vector>

#include "physics/world/magnitude.h"

namespace brittle::tools {

namespace {

// The number with its shortest digits; whole ones in groups of three.
std::string written(double number) {
    if (number == std::floor(number) && std::abs(number) < 1e15) {
        std::string digits = std::to_string(static_cast<int64_t>(std::abs(number)));
        for (size_t at = digits.size(); at > 3;) digits.insert(at -= 3, ",");
        return (number < 0.0 ? "-" : "") + digits;
    }
    char digits[32];
    return {digits, std::to_chars(digits, digits + sizeof digits, number).ptr};
}

// `wanted` completes "is not"; the help shows `range`.
CLI::Validator number_validator(const std::string& wanted, const std::string& range,
                                const std::function<bool(double)>& is_right) {
    const auto check = [=](const std::string& text) -> std::string {
        char* end = nullptr;
        const double number = std::strtod(text.c_str(), &end);
        const bool is_number = !text.empty() && *end == '\0';
        if (is_number && std::isfinite(number) && is_right(number)) return {};
        return "'" + text + "' is not " + wanted;
    };
    return CLI::Validator(check, range);
}

// The physics is in single precision.
void check_magnitude(const char* option, const std::string& text, const glm::dvec3& v) {
    constexpr auto largest = static_cast<double>(physics::max_magnitude);
    for (int axis = 0; axis < 3; ++axis)
        if (!(std::abs(v[axis]) <= largest))
            throw CLI::ValidationError(option, "'" + text + "' has the number " + written(v[axis])
                                                   + ", which is larger than " + written(largest));
}

} // namespace

CLI::Validator number_from(double low, double high) {
    const std::string range = written(low) + " to " + written(high);
    return number_validator("a number from " + range, range,
                            [=](double number) { return number >= low && number <= high; });
}

CLI::Validator positive_number() {
    return number_validator("a number above 0", "above 0", [](double number) { return number > 0.0; });
}

CLI::Validator non_negative_number() {
    return number_validator("a number from 0", "from 0", [](double number) { return number >= 0.0; });
}

CLI::Validator finite_number() {
    return number_validator("a finite number", "", [](double) { return true; });
}

CLI::Validator known_words(const std::vector<std::string>& words) {
    std::string list;
    for (const std::string& word : words) list += (list.empty() ? "{" : ",") + word;
    return CLI::Validator([](std::string&) { return std::string(); }, list + "}");
}

Ball parse_ball(const std::string& option, const std::string& text) {
    Ball ball;
    char rest = 0;
    const bool read = std::sscanf(text.c_str(), "%lf,%lf,%lf,%lf%c", &ball.centre.x, &ball.centre.y, &ball.centre.z,
                                  &ball.radius, &rest)
                      == 4;
    if (!read || !std::isfinite(ball.centre.x + ball.centre.y + ball.centre.z + ball.radius))
        throw CLI::ValidationError(option, "'" + text + "' is not X,Y,Z,RADIUS");
    return ball;
}

Anchor parse_anchor(const std::string& text) {
    const Ball ball = parse_ball("--anchor", text);
    if (ball.radius < 0.001 || ball.radius > 10.0)
        throw CLI::ValidationError("--anchor", "'" + text + "' has a radius that is not in [0.001, 10]");
    check_magnitude("--anchor", text, ball.centre);
    return {ball.centre, ball.radius};
}

Shot parse_shot(const std::string& text) {
    std::vector<double> numbers;
    std::istringstream stream(text);
    double number = 0.0;
    char comma = ',';
    while (comma == ',' && stream >> number) {
        numbers.push_back(number);
        comma = '\0';
        stream >> comma;
    }
    const bool read = comma == '\0' && (numbers.size() == 7 || numbers.size() == 8);
    if (!read || !std::ranges::all_of(numbers, [](double value) { return std::isfinite(value); }))
        throw CLI::ValidationError("--shot", "'" + text + "' is not X,Y,Z,VX,VY,VZ,RADIUS or that and ,SECONDS");
    const Shot shot{.time = numbers.size() == 8 ? numbers[7] : 0.0,
                    .from = {numbers[0], numbers[1], numbers[2]},
                    .velocity = {numbers[3], numbers[4], numbers[5]},
                    .radius = numbers[6]};
    check_magnitude("--shot", text, shot.from);
    check_magnitude("--shot", text, shot.velocity);
    if (shot.radius < 0.001 || shot.radius > 10.0)
        throw CLI::ValidationError("--shot", "'" + text + "' has a radius that is not in [0.001, 10]");
    if (shot.time < 0.0 || shot.time > 1e4)
        throw CLI::ValidationError("--shot", "'" + text + "' has a time that is not in [0, 10000]");
    return shot;
}

glm::uvec2 parse_size(const std::string& text) {
    unsigned width = 0;
    unsigned height = 0;
    char rest = 0;
    const bool read = std::sscanf(text.c_str(), "%5ux%5u%c", &width, &height, &rest) == 2;
    if (!read || width < 16 || height < 16 || width > 8192 || height > 8192)
        throw CLI::ValidationError("--size", "'" + text
                                                 + "' is not a size; give WIDTHxHEIGHT, each between 16 and 8192, "
                                                   "e.g. 1280x720");
    return {width, height};
}

} // namespace brittle::tools
