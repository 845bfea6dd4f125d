#include "physics/solver/lone_bodies.h"

#include <algorithm>
#include <array>

#include "physics/solver/prefetch.h"

namespace brittle::physics {

namespace {

// Four blocks of four bodies: a row depends on the row before, and the rows of the other blocks fill the latency.
constexpr uint32_t block_size = 4, group_size = 4 * block_size;

} // namespace

// Four bodies in lanes, the first with the most points, and their rows.
struct LoneBodies::Block {
    uint32_t count = 0;               // bodies
    std::array<uint32_t, 4> bodies{}; // surplus lanes repeat the last body
    std::array<GroundManifold*, 4> grounds{};
    uint32_t row_count = 0;
    Float4 coefficient;
    FourChanges changes, moved, free; // free: before the impulses of the substep
    FourBodies motion;
    Float4 share;
    FourDescents descents;
    std::array<GroundRows, GroundManifold::max_points> rows;

    void make(std::span<const Lone> group, const StaticRows::State& state, const GroundStep& step) {
        count = static_cast<uint32_t>(group.size());
        std::array<const SolverBody*, 4> solver_bodies{};
        Four inverse_masses{};
        for (size_t lane = 0; lane < 4; ++lane) {
            const Lone& lone = group[std::min<size_t>(lane, count - 1)];
            bodies[lane] = lone.body;
            grounds[lane] = lone.ground;
            solver_bodies[lane] = &state.bodies[lone.body];
            inverse_masses[lane] = solver_bodies[lane]->inverse_mass;
        }
        row_count = grounds[0]->count;
        changes = FourChanges(bodies, inverse_masses, state.changes);
        const FourGrounded four(solver_bodies, {grounds[0], grounds[1], grounds[2], grounds[3]});
        coefficient = four.friction;
        motion = FourBodies(bodies, state.bodies);
        moved = FourChanges(bodies, inverse_masses, state.moved);
        for (uint32_t i = 0; i < row_count; ++i) rows[i] = ground_rows(four, i, step);
    }
    void store_impulses(const StaticRows::State& state) const {
        for (size_t lane = 0; lane < count; ++lane)
            for (uint32_t i = 0; i < grounds[lane]->count; ++i) {
                GroundPoint& point = grounds[lane]->all[i];
                const GroundRows& made = rows[i];
                const auto& along = made.frictions.along;
                const Tangents& tangents = tangents_of_ground();
                point.speed = made.speed[lane];
                if ((FourChanges::acts(made.contacts) >> lane & 1) != 0) state.acted[bodies[lane]] = 1;
                point.last = {made.contacts.total[lane],
                              tangents.first * along[0].total[lane] + tangents.second * along[1].total[lane]};
                point.start = {made.contacts.impulse[lane],
                               tangents.first * along[0].impulse[lane] + tangents.second * along[1].impulse[lane]};
            }
    }
};

// A counting sort by descending number of points.
void LoneBodies::arrange() {
    std::array<uint32_t, GroundManifold::max_points + 1> places{}; // by number of points missing to max_points
    const auto missing = [](const Lone& body) { return GroundManifold::max_points - body.ground->count; };
    for (const Lone& body : bodies_)
        if (missing(body) + 1 < places.size()) ++places[missing(body) + 1];
    for (size_t i = 1; i < places.size(); ++i) places[i] += places[i - 1];
    scratch_.resize(bodies_.size());
    for (const Lone& body : bodies_) scratch_[places[missing(body)]++] = body;
    std::swap(bodies_, scratch_);
}

uint32_t LoneBodies::groups() const {
    return (count() + group_size - 1) / group_size;
}

void LoneBodies::solve(uint32_t begin, uint32_t end, const StaticRows::State& state, const GroundStep& step,
                       const Substeps& substeps) const {
    const std::span<const Lone> all = bodies_;
    const auto group = [&](uint32_t i) {
        return all.subspan(i * group_size, std::min<size_t>(group_size, all.size() - i * group_size));
    };
    for (uint32_t i = begin; i < end; ++i) {
        if (i + 1 < end)
            for (const Lone& body : group(i + 1)) prefetch(body.ground, 512); // covers the points of most manifolds
        solve(group(i), state, step, substeps);
    }
}

void LoneBodies::solve(std::span<const Lone> group, const StaticRows::State& state, const GroundStep& step,
                       const Substeps& substeps) {
    std::array<Block, group_size / block_size> store;
    const std::span<Block> blocks = std::span(store).first((group.size() + block_size - 1) / block_size);
    for (size_t i = 0; i < blocks.size(); ++i)
        blocks[i].make(group.subspan(i * block_size, std::min<size_t>(block_size, group.size() - i * block_size)),
                       state, step);
    // The first row of each block, then the second rows.
    const auto for_rows = [&](const auto& visit) {
        for (uint32_t row = 0; row < blocks[0].row_count; ++row)
            for (Block& block : blocks)
                if (row < block.row_count) visit(block, block.rows[row]);
    };
    const auto sweep = [&](int times) {
        for (int i = 0; i < times; ++i) {
            for_rows([](Block& block, GroundRows& row) { block.changes.solve_contacts(row.contacts); });
            for_rows([](Block& block, GroundRows& row) {
                block.changes.solve_friction(row.frictions, block.coefficient, row.contacts);
            });
        }
    };
    const auto spread = [&] {
        for (Block& block : blocks) block.descents = {};
        spread_blows([&](const auto& visit) {
            for_rows([&](Block& block, GroundRows& row) { visit(row.contacts, block.changes, block.descents); });
        });
    };
    for (int substep = 0; substep < substeps.count; ++substep) {
        for (Block& block : blocks) block.changes.fall(substeps.fall());
        for_rows([&](Block& block, GroundRows& row) { FourChanges::start(row.contacts, block.moved, substeps); });
        for (Block& block : blocks) block.free = block.changes;
        for_rows([](Block& block, GroundRows& row) { block.changes.apply(row.contacts, row.frictions); });
        spread();
        sweep(substeps.first);
        for (Block& block : blocks) {
            block.share = block.motion.energy_share(block.free, block.changes, substeps.fall());
            block.changes.keep(block.free, block.share);
        }
        for_rows([](Block& block, GroundRows& row) { FourChanges::scale(row.contacts, row.frictions, block.share); });
        for (Block& block : blocks)
            block.moved.move(block.motion.linear, block.motion.angular, block.changes, Float4::all(substeps.seconds));
        for_rows([](Block&, GroundRows& row) { FourChanges::start_second(row.contacts); });
        spread();
        const bool last = substep + 1 == substeps.count;
        sweep(last ? substeps.last : substeps.second);
        if (last) {
            bool bounces = false;
            for_rows([&](Block&, GroundRows& row) { bounces = FourChanges::start_bounce(row.contacts) || bounces; });
            if (bounces) {
                spread();
                sweep(substeps.bounce);
            }
        }
        for_rows([](Block&, GroundRows& row) { FourChanges::finish(row.contacts, row.frictions); });
    }
    for (const Block& block : blocks) {
        block.changes.store(block.bodies, block.count, state.changes);
        block.moved.store(block.bodies, block.count, state.moved);
        block.store_impulses(state);
    }
}

} // namespace brittle::physics
