#include "physics/solver/static_rows.h"

#include <algorithm>
#include <functional>

#include "physics/solver/four_rows.h"

namespace brittle::physics {

namespace {

// Number of blocks whose rows are interleaved in solve_lone(): a row depends on the row before, and the rows of the
// other blocks fill the latency.
constexpr uint32_t group_size = 4;
constexpr uint32_t max_counted = 48; // rows of a body that the counting sort of sort_bodies() tells apart

} // namespace

// Sorts bodies by bundle, bodies without a bundle last, and within a bundle by descending number of rows. A counting
// sort; the few bodies beyond max_counted rows are sorted by comparison.
void StaticRows::sort_bodies(const Bundles& bundles) {
    const auto key_of = [&](uint32_t body) {
        const size_t bundle = std::min(bundles.of(body), bundles.count());
        return bundle * (max_counted + 1) + (max_counted - std::min(counts_[body], max_counted));
    };
    const auto bodies = static_cast<uint32_t>(counts_.size());
    starts_.assign((bundles.count() + 1) * (max_counted + 1) + 1, 0);
    for (uint32_t body = 0; body < bodies; ++body)
        if (counts_[body] > 0) ++starts_[key_of(body) + 1];
    for (size_t i = 1; i < starts_.size(); ++i) starts_[i] += starts_[i - 1];
    order_.resize(starts_.back());
    next_ = starts_;
    for (uint32_t body = 0; body < bodies; ++body)
        if (counts_[body] > 0) order_[next_[key_of(body)]++] = body;
    for (size_t key = 0; key < starts_.size() - 1; key += max_counted + 1)
        std::ranges::stable_sort(std::span(order_).subspan(starts_[key], starts_[key + 1] - starts_[key]),
                                 std::ranges::greater{}, [this](uint32_t body) { return counts_[body]; });
}

void StaticRows::arrange(std::span<const uint32_t> bodies, std::span<const float> inverse_masses,
                         const Bundles& bundles) {
    bodies_.assign(bodies.begin(), bodies.end());
    counts_.assign(inverse_masses.size(), 0);
    for (const uint32_t body : bodies) ++counts_[body];
    sort_bodies(bundles);

    blocks_.clear();
    lanes_.resize(inverse_masses.size());
    firsts_.clear();
    uint32_t end = 0;
    for (const uint32_t body : order_) {
        const uint32_t bundle = std::min(bundles.of(body), bundles.count());
        const bool another = firsts_.size() <= bundle;
        while (firsts_.size() <= bundle) firsts_.push_back(static_cast<uint32_t>(blocks_.size()));
        if (another || blocks_.back().count == 4) {
            blocks_.push_back({.begin = end, .end = end + counts_[body]});
            blocks_.back().bodies.fill(body); // surplus lanes read a valid body
            end = blocks_.back().end;
        }
        Block& block = blocks_.back();
        lanes_[body] = static_cast<uint32_t>(4 * (blocks_.size() - 1)) + block.count;
        block.bodies[block.count] = body;
        block.inverse_mass[block.count++] = inverse_masses[body];
    }
    firsts_.resize(bundles.count() + 1, static_cast<uint32_t>(blocks_.size()));
    contacts_.resize(end);
    frictions_.resize(end);
    coefficients_.resize(end);
    for (const Block& block : blocks_) { // zero rows where a lane has fewer rows than its block
        const uint32_t full = block.count < 4 ? 0 : counts_[block.bodies.back()];
        for (uint32_t at = block.begin + full; at < block.end; ++at) {
            contacts_[at] = frictions_[at] = {};
            coefficients_[at] = {};
        }
    }

    std::ranges::fill(counts_, 0);
    slots_.clear();
    for (const uint32_t body : bodies)
        slots_.push_back(4 * (blocks_[lanes_[body] / 4].begin + counts_[body]++) + lanes_[body] % 4);
}

void StaticRows::put(size_t contact, const Row& row, const Row& friction, float coefficient) {
    const size_t at = slots_[contact] / 4, lane = slots_[contact] % 4;
    put(contacts_[at], lane, row);
    put(frictions_[at], lane, friction);
    coefficients_[at][lane] = coefficient;
}

void StaticRows::put(size_t contact, const FourRows& rows, const FourRows& frictions, size_t lane, float coefficient) {
    const size_t at = slots_[contact] / 4, to = slots_[contact] % 4;
    const auto copy = [&](const FourRows& from, FourRows& into) {
        for (size_t axis = 0; axis < 3; ++axis) {
            into.normal[axis][to] = from.normal[axis][lane];
            into.angular[axis][to] = from.angular[axis][lane];
            into.inverse_inertia_angular[axis][to] = from.inverse_inertia_angular[axis][lane];
        }
        into.bias[to] = from.bias[lane];
        into.effective_mass[to] = from.effective_mass[lane];
        into.impulse[to] = from.impulse[lane];
    };
    copy(rows, contacts_[at]);
    copy(frictions, frictions_[at]);
    coefficients_[at][to] = coefficient;
}

void StaticRows::put(FourRows& rows, size_t lane, const Row& row) {
    for (size_t axis = 0; axis < 3; ++axis) {
        rows.normal[axis][lane] = row.normal[axis];
        rows.angular[axis][lane] = row.angular_a[axis];
        rows.inverse_inertia_angular[axis][lane] = row.inverse_inertia_angular_a[axis];
    }
    rows.bias[lane] = row.bias;
    rows.effective_mass[lane] = row.effective_mass;
    rows.impulse[lane] = row.impulse;
}

Row StaticRows::row(size_t contact) const {
    const size_t at = slots_[contact] / 4, lane = slots_[contact] % 4;
    const FourRows& rows = contacts_[at];
    Row row{};
    for (size_t axis = 0; axis < 3; ++axis) {
        row.normal[axis] = rows.normal[axis][lane];
        row.angular_a[axis] = rows.angular[axis][lane];
        row.inverse_inertia_angular_a[axis] = rows.inverse_inertia_angular[axis][lane];
    }
    row.bias = rows.bias[lane];
    row.effective_mass = rows.effective_mass[lane];
    row.impulse = rows.impulse[lane];
    row.a = bodies_[contact];
    row.inverse_mass_a = blocks_[lanes_[row.a] / 4].inverse_mass[lane];
    return row;
}

StaticRows::Impulses StaticRows::impulses(size_t contact) const {
    const size_t at = slots_[contact] / 4, lane = slots_[contact] % 4;
    return {contacts_[at].impulse[lane], frictions_[at].impulse[lane]};
}

// Calls visit(row, dv of the block's bodies) for all rows of a bundle.
void StaticRows::for_rows(uint32_t bundle, VelocityChange* changes, const auto& visit) const {
    for (const Block& block : of(bundle)) {
        FourChanges moving(block.bodies, block.inverse_mass, changes);
        for (size_t at = block.begin; at < block.end; ++at) visit(at, moving);
        moving.store(block.bodies, block.count, changes);
    }
}

void StaticRows::apply(uint32_t bundle, VelocityChange* changes) const {
    for_rows(bundle, changes, [this](size_t at, FourChanges& of) {
        of.apply(contacts_[at], Float4::load(contacts_[at].impulse.data()));
    });
}

void StaticRows::solve_contacts(uint32_t bundle, VelocityChange* changes) {
    for_rows(bundle, changes, [this](size_t at, FourChanges& of) { of.solve_contacts(contacts_[at]); });
}

void StaticRows::solve_friction(uint32_t bundle, VelocityChange* changes) {
    for_rows(bundle, changes, [this](size_t at, FourChanges& of) { solve_friction(at, of); });
}

inline void StaticRows::solve_friction(size_t at, FourChanges& moving) {
    moving.solve_friction(frictions_[at], Float4::load(coefficients_[at].data()), contacts_[at]);
}

uint32_t StaticRows::lone_groups() const {
    return (static_cast<uint32_t>(blocks_.size()) - lone() + group_size - 1) / group_size;
}

void StaticRows::solve_lone(uint32_t begin, uint32_t end, int sweeps, VelocityChange* changes) {
    const std::span<const Block> blocks = std::span<const Block>(blocks_).subspan(lone());
    for (size_t group = begin; group < end; ++group) {
        const size_t first = group * group_size;
        solve_lone(blocks.subspan(first, std::min<size_t>(group_size, blocks.size() - first)), sweeps, changes);
    }
}

void StaticRows::solve_lone(std::span<const Block> group, int sweeps, VelocityChange* changes) {
    std::array<FourChanges, group_size> moving;
    for (size_t i = 0; i < group.size(); ++i) moving[i] = FourChanges(group[i].bodies, group[i].inverse_mass, changes);
    // The first row of each block, then the second rows; the first block has the most rows.
    const auto for_rows = [&](const auto& visit) {
        for (uint32_t row = 0; row < group[0].end - group[0].begin; ++row)
            for (size_t i = 0; i < group.size() && row < group[i].end - group[i].begin; ++i)
                visit(group[i].begin + row, moving[i]);
    };
    for_rows(
        [this](size_t at, FourChanges& of) { of.apply(contacts_[at], Float4::load(contacts_[at].impulse.data())); });
    for (int sweep = 0; sweep < sweeps; ++sweep) {
        for_rows([this](size_t at, FourChanges& of) { of.solve_contacts(contacts_[at]); });
        for_rows([this](size_t at, FourChanges& of) { solve_friction(at, of); });
    }
    for (size_t i = 0; i < group.size(); ++i) moving[i].store(group[i].bodies, group[i].count, changes);
}

} // namespace brittle::physics
