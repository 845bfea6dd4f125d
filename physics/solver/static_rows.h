// Rows of contacts with static bodies and the ground, four bodies at a time.
//
// In a heap half of all contacts are with the ground. A row against a static side (row.h) changes the velocity of one
// body only, so the rows of four bodies form a block: the first rows of the four are solved in lanes, then the second
// rows, while the four velocities stay in registers. Bodies with similar numbers of rows share a block. The rows of one
// body are solved in their order; results may differ from those of RowSolver by rounding.
//
// A body without other rows is independent of all other bodies: its rows go through all substeps in one call, on any
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
    void put(size_t contact, const Row& row, const FrictionRows& friction, float coefficient);
    // Copies them from one lane of four rows.
    void put(size_t contact, const FourRows& rows, const FourFrictions& frictions, size_t lane, float coefficient);

    // The parts of a substep for the bodies of a bundle (row.h). Thread-safe for different bundles.
    void start(uint32_t bundle, const Substeps& substeps, Displacement* moved);
    void apply(uint32_t bundle, VelocityChange* changes);
    // The parts of RowSolver::spread(). descent() calls add(body, part of the body's rows).
    [[nodiscard]] bool find_residuals(uint32_t bundle, VelocityChange* changes);
    void descent(uint32_t bundle, VelocityChange* changes, const auto& add) const;
    void add_residuals(uint32_t bundle, VelocityChange* changes) const;
    void spread(uint32_t bundle, VelocityChange* changes, const auto& factor_of);
    void solve_contacts(uint32_t bundle, VelocityChange* changes);
    void solve_friction(uint32_t bundle, VelocityChange* changes);
    // Multiplies the impulses on each body by its share.
    void scale(uint32_t bundle, const auto& share_of);
    void start_second(uint32_t bundle) { start_second(of(bundle)); }
    [[nodiscard]] bool start_bounce(uint32_t bundle) { return start_bounce(of(bundle)); }
    void finish(uint32_t bundle, uint8_t* acted) { finish(of(bundle), acted); }

    // All substeps for a range of groups of bodies without a bundle. Thread-safe for different groups.
    struct State {
        const SolverBody* bodies;
        VelocityChange* changes;
        Displacement* moved;
        uint8_t* acted; // by body: 1 if a contact had an impulse or its overlap was corrected
    };
    [[nodiscard]] uint32_t lone_groups() const;
    void solve_lone(uint32_t begin, uint32_t end, const Substeps& substeps, const State& state);

    // The impulses of a contact: those of the step, and those from which the next substep starts.
    struct Impulses {
        float total, start;
        std::array<float, 2> friction_total, friction_start;
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
    static void put(FourFrictions& rows, size_t lane, const FrictionRows& friction);
    void for_rows(uint32_t bundle, VelocityChange* changes, const auto& visit) const;
    void solve_friction(size_t at, FourChanges& changes);
    void solve_lone(std::span<const Block> group, const Substeps& substeps, const State& state);
    void start_second(std::span<const Block> blocks);
    [[nodiscard]] bool start_bounce(std::span<const Block> blocks);
    void finish(std::span<const Block> blocks, uint8_t* acted);
    [[nodiscard]] std::span<const Block> of(uint32_t bundle) const {
        return std::span(blocks_).subspan(firsts_[bundle], firsts_[bundle + 1] - firsts_[bundle]);
    }
    [[nodiscard]] uint32_t lone() const { return firsts_.back(); }

    std::vector<Block> blocks_;
    std::vector<uint32_t> firsts_{0}; // by bundle: its first block; last: the first block of bodies without a bundle
    std::vector<FourRows> contacts_;  // parallel arrays
    std::vector<FourFrictions> frictions_;
    std::vector<Four> coefficients_;              // mu, parallel to them
    std::vector<uint32_t> bodies_, slots_;        // by contact; a slot is four times the row plus the lane
    std::vector<uint32_t> lanes_;                 // by body: four times its block plus the lane
    std::vector<uint32_t> counts_;                // scratch of arrange(): rows by body
    std::vector<uint32_t> starts_, next_, order_; // scratch: counting sort; order_: bodies that have rows
};

void StaticRows::descent(uint32_t bundle, VelocityChange* changes, const auto& add) const {
    for (const Block& block : of(bundle)) {
        const FourChanges moving(block.bodies, block.inverse_mass, changes);
        Float4 sum = Float4::all(0.0f);
        for (size_t at = block.begin; at < block.end; ++at) sum = sum + moving.descent(contacts_[at]);
        Four parts;
        sum.store(parts.data());
        for (size_t lane = 0; lane < block.count; ++lane) add(block.bodies[lane], parts[lane]);
    }
}

void StaticRows::spread(uint32_t bundle, VelocityChange* changes, const auto& factor_of) {
    for (const Block& block : of(bundle)) {
        Four factors{};
        for (size_t lane = 0; lane < block.count; ++lane) factors[lane] = factor_of(block.bodies[lane]);
        FourChanges moving(block.bodies, block.inverse_mass, changes);
        for (size_t at = block.begin; at < block.end; ++at) moving.spread(contacts_[at], Float4::load(factors.data()));
        moving.store(block.bodies, block.count, changes);
    }
}

void StaticRows::scale(uint32_t bundle, const auto& share_of) {
    for (const Block& block : of(bundle)) {
        Four shares{};
        for (size_t lane = 0; lane < block.count; ++lane) shares[lane] = share_of(block.bodies[lane]);
        for (size_t at = block.begin; at < block.end; ++at)
            FourChanges::scale(contacts_[at], frictions_[at], Float4::load(shares.data()));
    }
}

} // namespace brittle::physics
