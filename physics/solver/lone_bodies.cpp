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
    struct Row {
        GroundRows made;
        Four correction_impulse, correction_mass;
        bool deep; // at least one lane has overlap to correct
    };

    uint32_t count = 0;               // bodies
    std::array<uint32_t, 4> bodies{}; // surplus lanes repeat the last body
    std::array<GroundManifold*, 4> grounds{};
    uint32_t row_count = 0;
    bool deep = false; // at least one row is deep
    Float4 coefficient;
    FourChanges changes, corrections;
    std::array<Row, GroundManifold::max_points> rows;

    void make(std::span<const Lone> group, const State& state, const GroundStep& step) {
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
        corrections = FourChanges(bodies, inverse_masses, state.corrections);
        const FourGrounded four(solver_bodies, {grounds[0], grounds[1], grounds[2], grounds[3]});
        coefficient = four.friction;
        for (uint32_t i = 0; i < row_count; ++i) {
            Row& row = rows[i];
            row.made = ground_rows(four, i, step);
            const Float4 none = Float4::all(0.0f), correction = Float4::load(row.made.correction.data());
            row.deep = less(none, correction) != 0;
            deep = deep || row.deep;
            none.store(row.correction_impulse.data());
            where_less(none, correction, Float4::load(row.made.contacts.effective_mass.data()), none)
                .store(row.correction_mass.data());
        }
    }
    void correct(Row& row) {
        if (row.deep)
            corrections.solve(row.made.contacts, row.made.correction, row.correction_mass, row.correction_impulse,
                              Float4::all(0.0f), Float4::all(std::numeric_limits<float>::max()));
    }
    void store(const State& state) const {
        changes.store(bodies, count, state.changes);
        if (deep) corrections.store(bodies, count, state.corrections);
        for (size_t lane = 0; lane < count; ++lane)
            for (uint32_t i = 0; i < grounds[lane]->count; ++i) {
                GroundPoint& point = grounds[lane]->all[i];
                const GroundRows& made = rows[i].made;
                const auto& tangent = made.frictions.normal;
                point.speed = made.speed[lane];
                point.tangent = {tangent[0][lane], tangent[1][lane], tangent[2][lane]};
                point.take(made.contacts.impulse[lane], made.frictions.impulse[lane]);
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

void LoneBodies::solve(uint32_t begin, uint32_t end, const State& state, const GroundStep& step, int sweeps) const {
    const std::span<const Lone> all = bodies_;
    const auto group = [&](uint32_t i) {
        return all.subspan(i * group_size, std::min<size_t>(group_size, all.size() - i * group_size));
    };
    for (uint32_t i = begin; i < end; ++i) {
        if (i + 1 < end)
            for (const Lone& body : group(i + 1)) prefetch(body.ground, 512); // covers the points of most manifolds
        solve(group(i), state, step, sweeps);
    }
}

void LoneBodies::solve(std::span<const Lone> group, const State& state, const GroundStep& step, int sweeps) {
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
    for_rows([](Block& block, const Block::Row& row) {
        block.changes.apply(row.made.contacts, Float4::load(row.made.contacts.impulse.data()));
    });
    for (int sweep = 0; sweep < sweeps; ++sweep) {
        for_rows([](Block& block, Block::Row& row) { block.changes.solve_contacts(row.made.contacts); });
        for_rows([](Block& block, Block::Row& row) {
            block.changes.solve_friction(row.made.frictions, block.coefficient, row.made.contacts);
        });
    }
    for (int sweep = 0; sweep < sweeps; ++sweep) for_rows([](Block& block, Block::Row& row) { block.correct(row); });
    for (const Block& block : blocks) block.store(state);
}

} // namespace brittle::physics
