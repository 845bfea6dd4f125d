#include "bindings/c/handles.h"

#include <cmath>
#include <cstddef>
#include <cstdio>

#include "fracture/pieces/certificate.h"

namespace brittle::c {

namespace {

constexpr uint64_t max_rows = 1u << 30;
constexpr double max_coordinate = 1e50; // as fracture()

thread_local bool in_json = false;

size_t size_of(uint32_t type) {
    switch (type) {
    case BRITTLE_FLOAT32:
    case BRITTLE_UINT32:
        return 4;
    case BRITTLE_FLOAT64:
        return 8;
    case BRITTLE_UINT16:
        return 2;
    default:
        return 0;
    }
}

// Returns the distance of rows in bytes.
uint64_t check_array(const brittle_array& array, uint32_t columns, bool integers, const char* name) {
    const bool fits = integers ? array.type == BRITTLE_UINT16 || array.type == BRITTLE_UINT32
                               : array.type == BRITTLE_FLOAT32 || array.type == BRITTLE_FLOAT64;
    if (!fits)
        refuse(std::string(name) + ".type is " + std::to_string(array.type) + "; it must be "
               + (integers ? "BRITTLE_UINT16 or BRITTLE_UINT32" : "BRITTLE_FLOAT32 or BRITTLE_FLOAT64"));
    if (array.columns != columns)
        refuse(std::string(name) + " has " + std::to_string(array.columns) + " columns; it must have "
               + std::to_string(columns));
    if (array.rows > max_rows)
        refuse(std::string(name) + " has " + std::to_string(array.rows) + " rows; 2^30 is the maximum");
    if (array.rows > 0 && !array.data) refuse(std::string(name) + ".data is NULL");
    const uint64_t row = columns * size_of(array.type);
    if (array.stride != 0 && (array.stride < row || array.stride > max_rows))
        refuse(std::string(name) + ".stride is " + std::to_string(array.stride) + " bytes; a row takes "
               + std::to_string(row) + ", and 2^30 is the maximum");
    return array.stride != 0 ? array.stride : row;
}

template<class From, class To>
void copy_numbers(const brittle_array& array, uint64_t stride, std::vector<To>& out) {
    const auto* bytes = static_cast<const unsigned char*>(array.data);
    for (uint64_t row = 0; row < array.rows; ++row) {
        for (uint32_t column = 0; column < array.columns; ++column) {
            From number;
            std::memcpy(&number, bytes + row * stride + column * sizeof(From), sizeof(From));
            out.push_back(static_cast<To>(number));
        }
    }
}

} // namespace

brittle_status status_of(fracture::Status status) {
    // The enumeration of the library begins with file_not_found and has the order of the C header.
    static_assert(static_cast<int>(fracture::Status::file_not_found) + 1 == BRITTLE_FILE_NOT_FOUND);
    static_assert(static_cast<int>(fracture::Status::inside_out) + 1 == BRITTLE_INSIDE_OUT);
    static_assert(static_cast<int>(fracture::Status::no_volume) + 1 == BRITTLE_NO_VOLUME);
    static_assert(static_cast<int>(fracture::Status::write_failed) + 1 == BRITTLE_WRITE_FAILED);
    return static_cast<brittle_status>(status) + 1;
}

JsonMemory::JsonMemory() noexcept : before_(std::exchange(in_json, true)) {}

JsonMemory::~JsonMemory() {
    in_json = before_;
}

bool JsonMemory::is_on() noexcept {
    return in_json;
}

bool repairable(brittle_status status) {
    return status >= BRITTLE_NOT_CLOSED && status <= BRITTLE_INSIDE_OUT;
}

brittle_status report(brittle_error* error, brittle_status status, std::string_view message) noexcept {
    if (!error) return status;
    const size_t head = offsetof(brittle_error, message);
    const size_t size = std::min<size_t>(error->struct_size, sizeof(brittle_error));
    if (size < head) return status;
    error->status = status;
    if (size == head) return status;
    size_t length = std::min(message.size(), size - head - 1);
    // A character of several bytes is not cut.
    while (length < message.size() && length > 0 && (static_cast<unsigned char>(message[length]) & 0xc0) == 0x80)
        --length;
    if (length > 0) std::memcpy(error->message, message.data(), length);
    error->message[length] = '\0';
    return status;
}

std::string read_text(const char* text, const char* name) {
    return &need(text, name);
}

std::vector<double> read_floats(const brittle_array& array, uint32_t columns, const char* name) {
    const uint64_t stride = check_array(array, columns, false, name);
    std::vector<double> numbers;
    numbers.reserve(array.rows * columns);
    if (array.type == BRITTLE_FLOAT32) {
        copy_numbers<float>(array, stride, numbers);
    } else {
        copy_numbers<double>(array, stride, numbers);
    }
    return numbers;
}

std::vector<uint32_t> read_integers(const brittle_array& array, uint32_t columns, const char* name) {
    const uint64_t stride = check_array(array, columns, true, name);
    std::vector<uint32_t> numbers;
    numbers.reserve(array.rows * columns);
    if (array.type == BRITTLE_UINT16) {
        copy_numbers<uint16_t>(array, stride, numbers);
    } else {
        copy_numbers<uint32_t>(array, stride, numbers);
    }
    return numbers;
}

std::vector<glm::dvec3> read_points(const brittle_array& array, const char* name, brittle_status status) {
    const std::vector<double> numbers = read_floats(array, 3, name);
    std::vector<glm::dvec3> points(array.rows);
    for (size_t row = 0; row < points.size(); ++row) {
        points[row] = {numbers[3 * row], numbers[3 * row + 1], numbers[3 * row + 2]};
        for (int k = 0; k < 3; ++k)
            if (!(std::abs(points[row][k]) <= max_coordinate))
                refuse(std::string(name) + " has " + std::to_string(points[row][k]) + " in row " + std::to_string(row)
                           + ", column " + std::to_string(k) + "; coordinates must be finite and at most 1e50",
                       status);
    }
    return points;
}

double in_range(double value, double low, double high, const char* name) {
    if (!(value >= low && value <= high)) {
        char text[160];
        std::snprintf(text, sizeof text, "%s is %g; it must be from %g to %g", name, value, low, high);
        refuse(text, BRITTLE_INVALID_SETTING);
    }
    return value;
}

void refuse_which(uint32_t which, uint32_t last) {
    refuse("which is " + std::to_string(which) + "; it must be from 1 to " + std::to_string(last));
}

} // namespace brittle::c

const brittle::fracture::Certificate& brittle_pieces::certificate() const {
    std::call_once(certified_, [&] { certificate_ = brittle::fracture::certify(source->mesh, fragments); });
    return certificate_;
}
