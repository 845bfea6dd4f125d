// A table from numbers to dense indices: the first number gets 0, the next new one 1, and so on. Open addressing.
#pragma once

#include <cstdint>
#include <vector>

#include "fracture/mesh/mesh.h"

namespace brittle::fracture {

class NumberTable {
  public:
    explicit NumberTable(uint32_t expected = 16) { reserve(expected); }

    [[nodiscard]] uint32_t size() const { return size_; }
    // Returns the index of a number; no_index for one that the table lacks.
    [[nodiscard]] uint32_t find(uint32_t number) const { return slots_[slot_of(number)].index; }
    // Returns the index of a number, a new one if need be.
    uint32_t add(uint32_t number) {
        if (2 * (size_ + 1) > slots_.size()) reserve(2 * size_);
        Slot& slot = slots_[slot_of(number)];
        if (slot.index == no_index) slot = {number, size_++};
        return slot.index;
    }
    void clear() {
        slots_.assign(slots_.size(), {});
        size_ = 0;
    }

  private:
    struct Slot {
        uint32_t number = 0;
        uint32_t index = no_index;
    };

    [[nodiscard]] size_t slot_of(uint32_t number) const {
        const size_t mask = slots_.size() - 1;
        size_t at = (uint64_t{number} * 0x9e3779b97f4a7c15u >> 32) & mask;
        while (slots_[at].index != no_index && slots_[at].number != number) at = (at + 1) & mask;
        return at;
    }
    void reserve(uint32_t expected) {
        size_t capacity = 32;
        while (capacity < 2 * size_t{expected} + 2) capacity *= 2;
        std::vector<Slot> old(capacity);
        old.swap(slots_);
        for (const Slot& slot : old)
            if (slot.index != no_index) slots_[slot_of(slot.number)] = slot;
    }

    std::vector<Slot> slots_;
    uint32_t size_ = 0;
};

} // namespace brittle::fracture
