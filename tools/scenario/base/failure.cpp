#include "tools/scenario/base/failure.h"

namespace brittle::tools {

namespace {

ExitCode exit_code(fracture::Status status) {
    using fracture::Status;
    switch (status) {
    case Status::file_not_found:
    case Status::unsupported_format:
    case Status::malformed_file:
        return exit_input;
    case Status::empty_mesh:
    case Status::invalid_mesh:
    case Status::not_closed:
    case Status::non_manifold:
    case Status::not_oriented:
    case Status::inside_out:
    case Status::no_volume:
    case Status::inverted_part:
    case Status::lost_volume:
    case Status::invalid_sites:
        return exit_mesh;
    case Status::invalid_setting:
        return exit_usage;
    case Status::cancelled:
        return exit_interrupted;
    case Status::write_failed:
        return exit_output;
    }
    return exit_failure;
}

// A terminal obeys control characters.
std::string without_control(const std::string& message) {
    constexpr const char* digits = "0123456789abcdef";
    std::string text;
    for (const char c : message) {
        const auto byte = static_cast<unsigned char>(c);
        if ((byte >= 0x20 && byte != 0x7f) || c == '\n')
            text += c;
        else
            text.append("\\x").append(1, digits[byte >> 4]).append(1, digits[byte & 15]);
    }
    return text;
}

} // namespace

Failure::Failure(ExitCode code, const std::string& message)
    : std::runtime_error(without_control(message)), code_(code) {}

Failure::Failure(const fracture::Error& error) : Failure(exit_code(error.status), error.message) {
    status_ = error.status;
}

Failure Failure::at(const std::string& place) const {
    Failure failure(code_, place + ": " + what());
    failure.status_ = status_;
    return failure;
}

} // namespace brittle::tools
