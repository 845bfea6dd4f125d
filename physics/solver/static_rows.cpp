#include "physics/solver/static_rows.h"

#include <algorithm>
#include <functional>

#include "physics/solver/four_rows.h"

namespace brittle::physics {

namespace {

// Number of blocks whose rows are interleaved in solve_lone(): a row depends on the row before, and the rows of the
// other blocks fill the latency.
constexpr uint32_t group_size = 4;
constexpr Four FourRows::*row_members[] = {
    &FourRows::rest,   &FourRows::bias,    &FourRows::effective_mass, &FourRows::gap,   &FourRows::slop,
    &FourRows::bounce, &FourRows::impulse, &FourRows::total,          &FourRows::start, &FourRows::share};
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
            contacts_[at] = {};
            frictions_[at] = {};
            coefficients_[at] = {};
        }
    }

    std::ranges::fill(counts_, 0);
    slots_.clear();
    for (const uint32_t body : bodies)
        slots_.push_back(4 * (blocks_[lanes_[body] / 4].begin + counts_[body]++) + lanes_[body] % 4);
}

void StaticRows::put(size_t contact, const Row& row, const FrictionRows& friction, float coefficient) {
    const size_t at = slots_[contact] / 4, lane = slots_[contact] % 4;
    put(contacts_[at], lane, row);
    put(frictions_[at], lane, friction);
    coefficients_[at][lane] = coefficient;
}

void StaticRows::put(size_t contact, const FourRows& rows, const FourFrictions& frictions, size_t lane,
                     float coefficient) {
    const size_t at = slots_[contact] / 4, to = slots_[contact] % 4;
    const auto copy = [&](const std::array<Four, 3>& from, std::array<Four, 3>& into) {
        for (size_t axis = 0; axis < 3; ++axis) into[axis][to] = from[axis][lane];
    };
    FourRows& contact_row = contacts_[at];
    copy(rows.normal, contact_row.normal);
    copy(rows.angular, contact_row.angular);
    copy(rows.inverse_inertia_angular, contact_row.inverse_inertia_angular);
    for (Four FourRows::*const member : row_members) (contact_row.*member)[to] = (rows.*member)[lane];
    FourFrictions& friction = frictions_[at];
    for (size_t i = 0; i < 2; ++i) {
        const FourFrictions::Along& from = frictions.along[i];
        FourFrictions::Along& into = friction.along[i];
        copy(from.tangent, into.tangent);
        copy(from.angular, into.angular);
        copy(from.inverse_inertia_angular, into.inverse_inertia_angular);
        into.rest[to] = from.rest[lane];
        into.impulse[to] = from.impulse[lane];
        into.total[to] = 0.0f;
    }
    friction.mass_11[to] = frictions.mass_11[lane];
    friction.mass_12[to] = frictions.mass_12[lane];
    friction.mass_22[to] = frictions.mass_22[lane];
    friction.sliding_mass[to] = frictions.sliding_mass[lane];
    coefficients_[at][to] = coefficient;
}

void StaticRows::put(FourRows& rows, size_t lane, const Row& row) {
    for (size_t axis = 0; axis < 3; ++axis) {
        rows.normal[axis][lane] = row.normal[axis];
        rows.angular[axis][lane] = row.angular_a[axis];
        rows.inverse_inertia_angular[axis][lane] = row.inverse_inertia_angular_a[axis];
    }
    rows.rest[lane] = row.rest;
    rows.bias[lane] = row.bias;
    rows.effective_mass[lane] = row.effective_mass;
    rows.gap[lane] = row.gap;
    rows.slop[lane] = row.slop;
    rows.bounce[lane] = row.bounce;
    rows.impulse[lane] = row.impulse;
    rows.total[lane] = row.total;
    rows.start[lane] = row.start;
    rows.share[lane] = row.share;
}

void StaticRows::put(FourFrictions& rows, size_t lane, const FrictionRows& friction) {
    for (size_t i = 0; i < 2; ++i) {
        const FrictionRows::Along& from = friction.along[i];
        FourFrictions::Along& into = rows.along[i];
        for (size_t axis = 0; axis < 3; ++axis) {
            into.tangent[axis][lane] = from.tangent[axis];
            into.angular[axis][lane] = from.angular_a[axis];
            into.inverse_inertia_angular[axis][lane] = from.inverse_inertia_angular_a[axis];
        }
        into.rest[lane] = from.rest;
        into.impulse[lane] = friction.impulse[i];
        into.total[lane] = friction.total[i];
    }
    rows.mass_11[lane] = friction.mass_11;
    rows.mass_12[lane] = friction.mass_12;
    rows.mass_22[lane] = friction.mass_22;
    rows.sliding_mass[lane] = friction.sliding_mass;
}

StaticRows::Impulses StaticRows::impulses(size_t contact) const {
    const size_t at = slots_[contact] / 4, lane = slots_[contact] % 4;
    const FourRows& rows = contacts_[at];
    const FourFrictions::Along &first = frictions_[at].along[0], &second = frictions_[at].along[1];
    return {.total = rows.total[lane],
            .start = rows.impulse[lane],
            .friction_total = {first.total[lane], second.total[lane]},
            .friction_start = {first.impulse[lane], second.impulse[lane]}};
}

// Calls visit(row, dv of the block's bodies) for all rows of a bundle.
void StaticRows::for_rows(uint32_t bundle, VelocityChange* changes, const auto& visit) const {
    for (const Block& block : of(bundle)) {
        FourChanges moving(block.bodies, block.inverse_mass, changes);
        for (size_t at = block.begin; at < block.end; ++at) visit(at, moving);
        moving.store(block.bodies, block.count, changes);
    }
}

void StaticRows::start(uint32_t bundle, const Substeps& substeps, Displacement* moved) {
    for (const Block& block : of(bundle)) {
        FourChanges displaced(block.bodies, block.inverse_mass, moved);
        for (size_t at = block.begin; at < block.end; ++at) FourChanges::start(contacts_[at], displaced, substeps);
        displaced.store(block.bodies, block.count, moved);
    }
}

void StaticRows::apply(uint32_t bundle, VelocityChange* changes) {
    for_rows(bundle, changes, [this](size_t at, FourChanges& of) { of.apply(contacts_[at], frictions_[at]); });
}

bool StaticRows::find_residuals(uint32_t bundle, VelocityChange* changes) {
    bool any = false;
    for_rows(bundle, changes, [&](size_t at, FourChanges& of) { any = of.find_residuals(contacts_[at]) || any; });
    return any;
}

void StaticRows::add_residuals(uint32_t bundle, VelocityChange* changes) const {
    for_rows(bundle, changes, [this](size_t at, FourChanges& of) { of.add_residuals(contacts_[at]); });
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

void StaticRows::start_second(std::span<const Block> blocks) {
    for (const Block& block : blocks)
        for (size_t at = block.begin; at < block.end; ++at) FourChanges::start_second(contacts_[at]);
}

bool StaticRows::start_bounce(std::span<const Block> blocks) {
    bool any = false;
    for (const Block& block : blocks)
        for (size_t at = block.begin; at < block.end; ++at) any = FourChanges::start_bounce(contacts_[at]) || any;
    return any;
}

void StaticRows::finish(std::span<const Block> blocks, uint8_t* acted) {
    for (const Block& block : blocks)
        for (size_t at = block.begin; at < block.end; ++at) {
            FourChanges::finish(contacts_[at], frictions_[at]);
            const uint32_t lanes = FourChanges::acts(contacts_[at]);
            for (size_t lane = 0; lane < block.count; ++lane)
                if ((lanes >> lane & 1) != 0) acted[block.bodies[lane]] = 1;
        }
}

uint32_t StaticRows::lone_groups() const {
    return (static_cast<uint32_t>(blocks_.size()) - lone() + group_size - 1) / group_size;
}

void StaticRows::solve_lone(uint32_t begin, uint32_t end, const Substeps& substeps, const State& state) {
    const std::span<const Block> blocks = std::span<const Block>(blocks_).subspan(lone());
    for (size_t group = begin; group < end; ++group) {
        const size_t first = group * group_size;
        solve_lone(blocks.subspan(first, std::min<size_t>(group_size, blocks.size() - first)), substeps, state);
    }
}

void StaticRows::solve_lone(std::span<const Block> group, const Substeps& substeps, const State& state) {
    struct Moving {
        FourChanges changes, moved, free; // free: before the impulses of the substep
        FourBodies bodies;
        Float4 share;
        FourDescents descents;
    };
    std::array<Moving, group_size> moving;
    for (size_t i = 0; i < group.size(); ++i) {
        const Block& block = group[i];
        moving[i].changes = FourChanges(block.bodies, block.inverse_mass, state.changes);
        moving[i].moved = FourChanges(block.bodies, block.inverse_mass, state.moved);
        moving[i].bodies = FourBodies(block.bodies, state.bodies);
    }
    // The first row of each block, then the second rows; the first block has the most rows.
    const auto for_rows = [&](const auto& visit) {
        for (uint32_t row = 0; row < group[0].end - group[0].begin; ++row)
            for (size_t i = 0; i < group.size() && row < group[i].end - group[i].begin; ++i)
                visit(group[i].begin + row, moving[i]);
    };
    const auto sweep = [&](int count) {
        for (int i = 0; i < count; ++i) {
            for_rows([this](size_t at, Moving& of) { of.changes.solve_contacts(contacts_[at]); });
            for_rows([this](size_t at, Moving& of) { solve_friction(at, of.changes); });
        }
    };
    const auto spread = [&] {
        for (Moving& of : std::span(moving).first(group.size())) of.descents = {};
        spread_blows([&](const auto& visit) {
            for_rows([&](size_t at, Moving& of) { visit(contacts_[at], of.changes, of.descents); });
        });
    };
    for (int substep = 0; substep < substeps.count; ++substep) {
        for (Moving& of : std::span(moving).first(group.size())) of.changes.fall(substeps.fall());
        for_rows([&](size_t at, Moving& of) { FourChanges::start(contacts_[at], of.moved, substeps); });
        for (Moving& of : std::span(moving).first(group.size())) of.free = of.changes;
        for_rows([this](size_t at, Moving& of) { of.changes.apply(contacts_[at], frictions_[at]); });
        spread();
        sweep(substeps.first);
        for (Moving& of : std::span(moving).first(group.size())) {
            of.share = of.bodies.energy_share(of.free, of.changes, substeps.fall());
            of.changes.keep(of.free, of.share);
        }
        for_rows([this](size_t at, Moving& of) { FourChanges::scale(contacts_[at], frictions_[at], of.share); });
        for (Moving& of : std::span(moving).first(group.size()))
            of.moved.move(of.bodies.linear, of.bodies.angular, of.changes, Float4::all(substeps.seconds));
        start_second(group);
        spread();
        const bool last = substep + 1 == substeps.count;
        sweep(last ? substeps.last : substeps.second);
        if (last && start_bounce(group)) {
            spread();
            sweep(substeps.bounce);
        }
        finish(group, state.acted);
    }
    for (size_t i = 0; i < group.size(); ++i) {
        moving[i].changes.store(group[i].bodies, group[i].count, state.changes);
        moving[i].moved.store(group[i].bodies, group[i].count, state.moved);
    }
}

} // namespace brittle::physics
