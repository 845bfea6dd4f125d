// Little-endian numbers in byte arrays, for the binary formats.
#pragma once

#include <bit>
#include <cassert>
#include <cstddef>
#include <cstring>
#include <span>
#include <vector>

namespace brittle::fracture {

static_assert(std::endian::native == std::endian::little,
              "binary mesh files are little-endian and are read and written without conversion");

// Returns the T at the offset, at any alignment. The caller has checked that it lies inside `bytes`.
template<class T>
[[nodiscard]] T load(std::span<const std::byte> bytes, size_t offset) {
    assert(offset <= bytes.size() && sizeof(T) <= bytes.size() - offset);
    T value;
    std::memcpy(&value, bytes.data() + offset, sizeof(T));
    return value;
}

template<class T>
void append(std::vector<std::byte>& bytes, const T& value) {
    const size_t at = bytes.size();
    bytes.resize(at + sizeof(T));
    std::memcpy(bytes.data() + at, &value, sizeof(T));
}

} // namespace brittle::fracture
