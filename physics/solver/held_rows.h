// Rows of contacts with what never moves, four bodies at a time.
//
// Each body has its own: nobody else's velocity changes with them. So the first rows of four bodies are solved side by side,
// then their second ones, while the velocities of the four stay in registers; bodies with about as many rows come together.
// In a heap half of all contacts are with the ground. Each body's rows are solved in their order, with the same operations as
// one at a time: not a bit is different.
//
// A body that has no other rows waits for nobody between two sweeps: its rows are solved in all sweeps at once, while they are at
// hand, on any thread. Bodies with other rows too are solved in sweeps, with their bundle. What touches nothing but the ground has no
// rows here at all: lone_bodies.h.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "physics/solver/bundles.h"
#include "physics/solver/four_rows.h"
#include "physics/solver/row.h"

namespace brittle::physics {

class HeldRows {
  public:
    // Makes place for contacts, by their movers, those of one mover in the order in which they are to be solved. Inverse masses are by
    // mover; who has rows elsewhere is in a bundle.
    void arrange(std::span<const uint32_t> movers, std::span<const float> lights, const Bundles& bundles);
    // Of the contact that was given in that place, and of its friction. For different contacts, on any threads.
    void put(size_t contact, const Row& row, const Row& friction, float coefficient);
    // The same, from one lane of four rows.
    void put(size_t contact, const FourRows& rows, const FourRows& frictions, size_t lane, float coefficient);

    // Of the bodies of a bundle; for different ones, on any threads. Lets the impulses act from which contacts start.
    void give(uint32_t bundle, Motion* motions) const;
    void press(uint32_t bundle, Motion* motions); // one sweep over contacts
    void rub(uint32_t bundle, Motion* motions);   // and one over their friction

    // All of that, and so many sweeps, for the others: those of some groups of bodies. For different groups, on any threads.
    [[nodiscard]] uint32_t lone_groups() const;
    void settle(uint32_t begin, uint32_t end, int sweeps, Motion* motions);

    // As it was put, with the impulse that it has now.
    [[nodiscard]] Row row(size_t contact) const;
    struct Impulses {
        float contact, friction;
    };
    [[nodiscard]] Impulses impulses(size_t contact) const;

  private:
    struct Block {
        uint32_t begin = 0, end = 0; // its rows; who has fewer has rows without effect
        uint32_t count = 0;          // bodies
        std::array<uint32_t, 4> movers{};
        Four light{};
    };

    void sort_movers(const Bundles& bundles);
    static void put(FourRows& rows, size_t lane, const Row& row);
    void for_rows(uint32_t bundle, Motion* motions, const auto& visit) const;
    void rub(size_t at, FourMotions& moving);
    void settle(std::span<const Block> group, int sweeps, Motion* motions);
    [[nodiscard]] std::span<const Block> of(uint32_t bundle) const {
        return std::span(blocks_).subspan(firsts_[bundle], firsts_[bundle + 1] - firsts_[bundle]);
    }
    [[nodiscard]] uint32_t lone() const { return firsts_.back(); }

    std::vector<Block> blocks_;
    std::vector<uint32_t> firsts_{0}; // blocks of bundles; from the last one on, of bodies without rows elsewhere
    std::vector<FourRows> contacts_, frictions_;  // side by side
    std::vector<Four> coefficients_;              // of friction, beside them
    std::vector<uint32_t> movers_, slots_;        // by contact; its row, times four, and lane
    std::vector<uint32_t> lanes_;                 // by mover: its block, times four, and lane
    std::vector<uint32_t> counts_;                // scratch of arrange(), as the next: rows by mover
    std::vector<uint32_t> starts_, next_, order_; // movers that have any, in order, and where those of a kind begin
};

} // namespace brittle::physics
