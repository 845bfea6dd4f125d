// Rows of contacts with static bodies and the ground, four bodies at a time.
//
// Such a row changes one body's velocity only. So the first rows of four bodies are solved side by side, then their
// second ones, while the velocities of the four stay in registers; bodies with about as many rows come together. In a
// heap half of all contacts are with the ground. Each body's rows are solved in their order, with the operations of
// one at a time: not a bit differs.
//
// Bodies without other rows depend on nothing between two sweeps: their rows are solved in all sweeps at once, on any
// thread. Bodies with other rows are solved sweep by sweep, with their bundle. Bodies that touch nothing but the
// ground have no rows here: lone_bodies.h.
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

class StaticRows {
  public:
    // Reserves places for contacts, given by their bodies; those of one body in the order in which they are to be
    // solved. Inverse masses are by body. A body that has rows elsewhere is in a bundle.
    void arrange(std::span<const uint32_t> bodies, std::span<const float> inverse_masses, const Bundles& bundles);
    // Writes the rows of the contact with that index, and of its friction. For different contacts, on any threads.
    void put(size_t contact, const Row& row, const Row& friction, float coefficient);
    // From one lane of four rows.
    void put(size_t contact, const FourRows& rows, const FourRows& frictions, size_t lane, float coefficient);

    // Of the bodies of a bundle; for different bundles, on any threads: warm starting, one sweep over contacts, and
    // one over their friction.
    void apply(uint32_t bundle, VelocityChange* changes) const;
    void solve_contacts(uint32_t bundle, VelocityChange* changes);
    void solve_friction(uint32_t bundle, VelocityChange* changes);

    // All of that, and so many sweeps, for some groups of the bodies without a bundle. For different groups, on any
    // threads.
    [[nodiscard]] uint32_t lone_groups() const;
    void solve_lone(uint32_t begin, uint32_t end, int sweeps, VelocityChange* changes);

    // As it was put, with its present impulse.
    [[nodiscard]] Row row(size_t contact) const;
    struct Impulses {
        float contact, friction;
    };
    [[nodiscard]] Impulses impulses(size_t contact) const;

  private:
    struct Block {
        uint32_t begin = 0, end = 0; // its rows; a body with fewer has rows without effect
        uint32_t count = 0;          // bodies
        std::array<uint32_t, 4> bodies{};
        Four inverse_mass{};
    };

    void sort_bodies(const Bundles& bundles);
    static void put(FourRows& rows, size_t lane, const Row& row);
    void for_rows(uint32_t bundle, VelocityChange* changes, const auto& visit) const;
    void solve_friction(size_t at, FourChanges& changes);
    void solve_lone(std::span<const Block> group, int sweeps, VelocityChange* changes);
    [[nodiscard]] std::span<const Block> of(uint32_t bundle) const {
        return std::span(blocks_).subspan(firsts_[bundle], firsts_[bundle + 1] - firsts_[bundle]);
    }
    [[nodiscard]] uint32_t lone() const { return firsts_.back(); }

    std::vector<Block> blocks_;
    std::vector<uint32_t> firsts_{0}; // blocks of bundles; from the last one on, of bodies without rows elsewhere
    std::vector<FourRows> contacts_, frictions_;  // side by side
    std::vector<Four> coefficients_;              // of friction, beside them
    std::vector<uint32_t> bodies_, slots_;        // by contact; its row, times four, and lane
    std::vector<uint32_t> lanes_;                 // by body: its block, times four, and lane
    std::vector<uint32_t> counts_;                // scratch of arrange(), as the next: rows by body
    std::vector<uint32_t> starts_, next_, order_; // bodies that have rows, in order, and where those of a kind begin
};

} // namespace brittle::physics
