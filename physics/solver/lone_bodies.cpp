#include "physics/solver/lone_bodies.h"

#include <algorithm>
#include <array>

#include "physics/solver/fetch.h"

namespace brittle::physics {

namespace {

// Four blocks of four: each row waits for the one before, and in between those of the other blocks are worked on.
constexpr uint32_t block_size = 4, group_size = 4 * block_size;

} // namespace

// Bodies side by side, the first with most points, and their rows.
struct LoneBodies::Block {
    struct Row {
        GroundRows made;
        Four parting_impulse, parting_gain;
        bool deep; // one of them is to part
    };

    uint32_t count = 0;               // bodies
    std::array<uint32_t, 4> movers{}; // lanes that stay empty are the last body's
    std::array<GroundManifold*, 4> grounds{};
    uint32_t row_count = 0;
    bool deep = false; // one of the rows
    Float4 coefficient;
    FourMotions motions, parting;
    std::array<Row, GroundManifold::max_points> rows;

    void make(std::span<const Lone> bodies, const Movers& all, const GroundStep& step) {
        count = static_cast<uint32_t>(bodies.size());
        std::array<const Mover*, 4> of_all{};
        Four lights{};
        for (size_t lane = 0; lane < 4; ++lane) {
            const Lone& body = bodies[std::min<size_t>(lane, count - 1)];
            movers[lane] = body.mover;
            grounds[lane] = body.ground;
            of_all[lane] = &all.movers[body.mover];
            lights[lane] = of_all[lane]->light;
        }
        row_count = grounds[0]->count;
        motions = FourMotions(movers, lights, all.motions);
        parting = FourMotions(movers, lights, all.parting);
        const FourGrounded four(of_all, {grounds[0], grounds[1], grounds[2], grounds[3]});
        coefficient = four.friction;
        for (uint32_t i = 0; i < row_count; ++i) {
            Row& row = rows[i];
            row.made = ground_rows(four, i, step);
            const Float4 none = Float4::all(0.0f), depth = Float4::load(row.made.depth.data());
            row.deep = less(none, depth) != 0;
            deep = deep || row.deep;
            none.store(row.parting_impulse.data());
            where_less(none, depth, Float4::load(row.made.contacts.gain.data()), none).store(row.parting_gain.data());
        }
    }
    void part(Row& row) {
        if (row.deep)
            parting.solve(row.made.contacts, row.made.depth, row.parting_gain, row.parting_impulse, Float4::all(0.0f),
                          Float4::all(std::numeric_limits<float>::max()));
    }
    void hand_back(const Movers& all) const {
        motions.store(movers, count, all.motions);
        if (deep) parting.store(movers, count, all.parting);
        for (size_t lane = 0; lane < count; ++lane)
            for (uint32_t i = 0; i < grounds[lane]->count; ++i) {
                GroundPoint& point = grounds[lane]->all[i];
                const GroundRows& made = rows[i].made;
                const auto& along = made.frictions.normal;
                point.speed = made.speed[lane];
                point.along = {along[0][lane], along[1][lane], along[2][lane]};
                point.take(made.contacts.impulse[lane], made.frictions.impulse[lane]);
            }
    }
};

// By counting.
void LoneBodies::arrange() {
    std::array<uint32_t, GroundManifold::max_points + 1> places{}; // by how many points are missing
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

void LoneBodies::solve(uint32_t begin, uint32_t end, const Movers& movers, const GroundStep& step, int sweeps) const {
    const std::span<const Lone> all = bodies_;
    const auto group = [&](uint32_t i) {
        return all.subspan(i * group_size, std::min<size_t>(group_size, all.size() - i * group_size));
    };
    for (uint32_t i = begin; i < end; ++i) {
        if (i + 1 < end)
            for (const Lone& body : group(i + 1)) fetch(body.ground, 512); // as many points as most have
        solve(group(i), movers, step, sweeps);
    }
}

void LoneBodies::solve(std::span<const Lone> group, const Movers& movers, const GroundStep& step, int sweeps) {
    std::array<Block, group_size / block_size> store;
    const std::span<Block> blocks = std::span(store).first((group.size() + block_size - 1) / block_size);
    for (size_t i = 0; i < blocks.size(); ++i)
        blocks[i].make(group.subspan(i * block_size, std::min<size_t>(block_size, group.size() - i * block_size)),
                       movers, step);
    // The first row of each, then the second ones.
    const auto for_rows = [&](const auto& visit) {
        for (uint32_t row = 0; row < blocks[0].row_count; ++row)
            for (Block& block : blocks)
                if (row < block.row_count) visit(block, block.rows[row]);
    };
    for_rows([](Block& block, const Block::Row& row) {
        block.motions.act(row.made.contacts, Float4::load(row.made.contacts.impulse.data()));
    });
    for (int sweep = 0; sweep < sweeps; ++sweep) {
        for_rows([](Block& block, Block::Row& row) { block.motions.press(row.made.contacts); });
        for_rows([](Block& block, Block::Row& row) {
            block.motions.rub(row.made.frictions, block.coefficient, row.made.contacts);
        });
    }
    for (int sweep = 0; sweep < sweeps; ++sweep) for_rows([](Block& block, Block::Row& row) { block.part(row); });
    for (const Block& block : blocks) block.hand_back(movers);
}

} // namespace brittle::physics
