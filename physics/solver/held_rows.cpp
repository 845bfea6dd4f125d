#include "physics/solver/held_rows.h"

#include <algorithm>
#include <functional>

#include "physics/solver/four_rows.h"

namespace brittle::physics {

namespace {

// Blocks that are solved in all sweeps at once come in groups of so many: each row waits for the one before, and in between those
// of the other blocks are worked on.
constexpr uint32_t group_size = 4;
constexpr uint32_t max_counted = 48; // rows of a body: see sort_movers()

} // namespace

// By bundle, those without one behind, of each those with most rows first. By counting; of those with very many rows, which are few,
// by comparing.
void HeldRows::sort_movers(const Bundles& bundles) {
    const auto key_of = [&](uint32_t mover) {
        const size_t bundle = std::min(bundles.of(mover), bundles.count());
        return bundle * (max_counted + 1) + (max_counted - std::min(counts_[mover], max_counted));
    };
    const auto movers = static_cast<uint32_t>(counts_.size());
    starts_.assign((bundles.count() + 1) * (max_counted + 1) + 1, 0);
    for (uint32_t mover = 0; mover < movers; ++mover)
        if (counts_[mover] > 0) ++starts_[key_of(mover) + 1];
    for (size_t i = 1; i < starts_.size(); ++i) starts_[i] += starts_[i - 1];
    order_.resize(starts_.back());
    next_ = starts_;
    for (uint32_t mover = 0; mover < movers; ++mover)
        if (counts_[mover] > 0) order_[next_[key_of(mover)]++] = mover;
    for (size_t key = 0; key < starts_.size() - 1; key += max_counted + 1)
        std::ranges::stable_sort(std::span(order_).subspan(starts_[key], starts_[key + 1] - starts_[key]),
                                 std::ranges::greater{}, [this](uint32_t mover) { return counts_[mover]; });
}

void HeldRows::arrange(std::span<const uint32_t> movers, std::span<const float> lights, const Bundles& bundles) {
    movers_.assign(movers.begin(), movers.end());
    counts_.assign(lights.size(), 0);
    for (const uint32_t mover : movers) ++counts_[mover];
    sort_movers(bundles);

    blocks_.clear();
    lanes_.resize(lights.size());
    firsts_.clear();
    uint32_t end = 0;
    for (const uint32_t mover : order_) {
        const uint32_t bundle = std::min(bundles.of(mover), bundles.count());
        const bool another = firsts_.size() <= bundle;
        while (firsts_.size() <= bundle) firsts_.push_back(static_cast<uint32_t>(blocks_.size()));
        if (another || blocks_.back().count == 4) {
            blocks_.push_back({.begin = end, .end = end + counts_[mover]});
            blocks_.back().movers.fill(mover); // lanes that stay empty read something
            end = blocks_.back().end;
        }
        Block& block = blocks_.back();
        lanes_[mover] = static_cast<uint32_t>(4 * (blocks_.size() - 1)) + block.count;
        block.movers[block.count] = mover;
        block.light[block.count++] = lights[mover];
    }
    firsts_.resize(bundles.count() + 1, static_cast<uint32_t>(blocks_.size()));
    contacts_.resize(end);
    frictions_.resize(end);
    coefficients_.resize(end);
    for (const Block& block : blocks_) { // what nobody puts is without effect
        const uint32_t full = block.count < 4 ? 0 : counts_[block.movers.back()];
        for (uint32_t at = block.begin + full; at < block.end; ++at) {
            contacts_[at] = frictions_[at] = {};
            coefficients_[at] = {};
        }
    }

    std::ranges::fill(counts_, 0);
    slots_.clear();
    for (const uint32_t mover : movers)
        slots_.push_back(4 * (blocks_[lanes_[mover] / 4].begin + counts_[mover]++) + lanes_[mover] % 4);
}

void HeldRows::put(size_t contact, const Row& row, const Row& friction, float coefficient) {
    const size_t at = slots_[contact] / 4, lane = slots_[contact] % 4;
    put(contacts_[at], lane, row);
    put(frictions_[at], lane, friction);
    coefficients_[at][lane] = coefficient;
}

void HeldRows::put(size_t contact, const FourRows& rows, const FourRows& frictions, size_t lane, float coefficient) {
    const size_t at = slots_[contact] / 4, to = slots_[contact] % 4;
    const auto copy = [&](const FourRows& from, FourRows& into) {
        for (size_t axis = 0; axis < 3; ++axis) {
            into.normal[axis][to] = from.normal[axis][lane];
            into.arm[axis][to] = from.arm[axis][lane];
            into.turn[axis][to] = from.turn[axis][lane];
        }
        into.wanted[to] = from.wanted[lane];
        into.gain[to] = from.gain[lane];
        into.impulse[to] = from.impulse[lane];
    };
    copy(rows, contacts_[at]);
    copy(frictions, frictions_[at]);
    coefficients_[at][to] = coefficient;
}

void HeldRows::put(FourRows& rows, size_t lane, const Row& row) {
    for (size_t axis = 0; axis < 3; ++axis) {
        rows.normal[axis][lane] = row.normal[axis];
        rows.arm[axis][lane] = row.arm_a[axis];
        rows.turn[axis][lane] = row.turn_a[axis];
    }
    rows.wanted[lane] = row.wanted;
    rows.gain[lane] = row.gain;
    rows.impulse[lane] = row.impulse;
}

Row HeldRows::row(size_t contact) const {
    const size_t at = slots_[contact] / 4, lane = slots_[contact] % 4;
    const FourRows& rows = contacts_[at];
    Row row{};
    for (size_t axis = 0; axis < 3; ++axis) {
        row.normal[axis] = rows.normal[axis][lane];
        row.arm_a[axis] = rows.arm[axis][lane];
        row.turn_a[axis] = rows.turn[axis][lane];
    }
    row.wanted = rows.wanted[lane];
    row.gain = rows.gain[lane];
    row.impulse = rows.impulse[lane];
    row.a = movers_[contact];
    row.light_a = blocks_[lanes_[row.a] / 4].light[lane];
    return row;
}

HeldRows::Impulses HeldRows::impulses(size_t contact) const {
    const size_t at = slots_[contact] / 4, lane = slots_[contact] % 4;
    return {contacts_[at].impulse[lane], frictions_[at].impulse[lane]};
}

// Calls visit(place, motions of the bodies) for the rows of a bundle.
void HeldRows::for_rows(uint32_t bundle, Motion* motions, const auto& visit) const {
    for (const Block& block : of(bundle)) {
        FourMotions moving(block.movers, block.light, motions);
        for (size_t at = block.begin; at < block.end; ++at) visit(at, moving);
        moving.store(block.movers, block.count, motions);
    }
}

void HeldRows::give(uint32_t bundle, Motion* motions) const {
    for_rows(bundle, motions,
             [this](size_t at, FourMotions& of) { of.act(contacts_[at], Float4::load(contacts_[at].impulse.data())); });
}

void HeldRows::press(uint32_t bundle, Motion* motions) {
    for_rows(bundle, motions, [this](size_t at, FourMotions& of) { of.press(contacts_[at]); });
}

void HeldRows::rub(uint32_t bundle, Motion* motions) {
    for_rows(bundle, motions, [this](size_t at, FourMotions& of) { rub(at, of); });
}

inline void HeldRows::rub(size_t at, FourMotions& moving) {
    moving.rub(frictions_[at], Float4::load(coefficients_[at].data()), contacts_[at]);
}

uint32_t HeldRows::lone_groups() const {
    return (static_cast<uint32_t>(blocks_.size()) - lone() + group_size - 1) / group_size;
}

void HeldRows::settle(uint32_t begin, uint32_t end, int sweeps, Motion* motions) {
    const std::span<const Block> blocks = std::span<const Block>(blocks_).subspan(lone());
    for (size_t group = begin; group < end; ++group) {
        const size_t first = group * group_size;
        settle(blocks.subspan(first, std::min<size_t>(group_size, blocks.size() - first)), sweeps, motions);
    }
}

void HeldRows::settle(std::span<const Block> group, int sweeps, Motion* motions) {
    std::array<FourMotions, group_size> moving;
    for (size_t i = 0; i < group.size(); ++i) moving[i] = FourMotions(group[i].movers, group[i].light, motions);
    // The first row of each, then the second ones; the first block has most.
    const auto for_rows = [&](const auto& visit) {
        for (uint32_t row = 0; row < group[0].end - group[0].begin; ++row)
            for (size_t i = 0; i < group.size() && row < group[i].end - group[i].begin; ++i)
                visit(group[i].begin + row, moving[i]);
    };
    for_rows([this](size_t at, FourMotions& of) { of.act(contacts_[at], Float4::load(contacts_[at].impulse.data())); });
    for (int sweep = 0; sweep < sweeps; ++sweep) {
        for_rows([this](size_t at, FourMotions& of) { of.press(contacts_[at]); });
        for_rows([this](size_t at, FourMotions& of) { rub(at, of); });
    }
    for (size_t i = 0; i < group.size(); ++i) moving[i].store(group[i].movers, group[i].count, motions);
}

} // namespace brittle::physics
