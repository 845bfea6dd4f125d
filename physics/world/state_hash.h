// FNV-1a over the bits of numbers, for comparing states bit for bit.
#pragma once

#include <bit>
#include <concepts>
#include <cstddef>
#include <cstdint>

namespace brittle::physics {

class StateHash {
  public:
    template<std::unsigned_integral Bits>
    void add(Bits bits) {
        for (size_t byte = 0; byte < sizeof(Bits); ++byte)
            value_ = (value_ ^ (static_cast<uint64_t>(bits) >> (8 * byte) & 0xffu)) * 0x100000001b3ull;
    }
    void add(float value) { add(std::bit_cast<uint32_t>(value)); }
    void add(double value) { add(std::bit_cast<uint64_t>(value)); }
    [[nodiscard]] uint64_t value() const { return value_; }

  private:
    uint64_t value_ = 0xcbf29ce484222325ull;
};

} // namespace brittle::physics
