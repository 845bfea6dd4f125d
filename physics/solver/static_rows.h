// Rows of contacts with static bodies and the ground, four bodies at a time.
//
// In a heap half of all contacts are with the ground. A row against a static side (row.h) changes the velocity of one
// body only, so the rows of four bodies form a block: the first rows of the four are solved in lanes, then the second
// rows, while the four velocities stay in registers. Bodies with similar numbers of rows share a block. The rows of one
// body are solved in their order, with the operations of RowSolver::solve_row(), so results are equal bit for bit.
//
// A body without other rows is independent of all other bodies: its rows go through all sweeps in one call, on any
// thread. A body with other rows belongs to a bundle and is solved sweep by sweep with it. Bodies that touch the ground
// only have no rows here: lone_bodies.h.
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
    // Reserves places for contacts. `bodies` holds the body of each contact; contacts of one body come in the order of
    // solution. Inverse masses are by body. A body that has rows elsewhere is in a bundle.
    void arrange(std::span<const uint32_t> bodies, std::span<const float> inverse_masses, const Bundles& bundles);
    // Writes the row of a contact and of its friction. Thread-safe for different contacts.
    void put(size_t contact, const Row& row, const Row& friction, float coefficient);
    // Copies them from one lane of four rows.
    void put(size_t contact, const FourRows& rows, const FourRows& frictions, size_t lane, float coefficient);

    // Warm starting, one sweep over contacts, and one sweep over friction, for the bodies of a bundle. Thread-safe for
    // different bundles.
    void apply(uint32_t bundle, VelocityChange* changes) const;
    void solve_contacts(uint32_t bundle, VelocityChange* changes);
    void solve_friction(uint32_t bundle, VelocityChange* changes);

    // Warm starting and all sweeps for a range of groups of bodies without a bundle. Thread-safe for different groups.
    [[nodiscard]] uint32_t lone_groups() const;
    void solve_lone(uint32_t begin, uint32_t end, int sweeps, VelocityChange* changes);

    // The row that put() wrote, with its present impulse.
    [[nodiscard]] Row row(size_t contact) const;
    struct Impulses {
        float contact, friction;
    };
    [[nodiscard]] Impulses impulses(size_t contact) const;

  private:
    struct Block {
        uint32_t begin = 0, end = 0; // its rows; shorter lanes are filled up with zero rows
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
    std::vector<uint32_t> firsts_{0}; // by bundle: its first block; last: the first block of bodies without a bundle
    std::vector<FourRows> contacts_, frictions_;  // parallel arrays
    std::vector<Four> coefficients_;              // mu, parallel to them
    std::vector<uint32_t> bodies_, slots_;        // by contact; a slot is four times the row plus the lane
    std::vector<uint32_t> lanes_;                 // by body: four times its block plus the lane
    std::vector<uint32_t> counts_;                // scratch of arrange(): rows by body
    std::vector<uint32_t> starts_, next_, order_; // scratch: counting sort; order_: bodies that have rows
};

} // namespace brittle::physics
