#include "physics/bullet/held_rows.h"

#include <algorithm>
#include <limits>

#include "physics/bullet/float4.h"

namespace brittle::physics {

namespace {

constexpr float no_limit = std::numeric_limits<float>::max();

} // namespace

struct HeldRows::Moving {
    std::array<Float4, 3> linear, angular; // x, y, z of four bodies
    Float4 light;

    Moving(const Block& block, const Motion* motions) : light(Float4::load(block.light.data())) {
        const auto motion = [&](size_t lane) -> const Motion& { return motions[block.movers[lane]]; };
        linear = columns(motion(0).linear, motion(1).linear, motion(2).linear, motion(3).linear);
        angular = columns(motion(0).angular, motion(1).angular, motion(2).angular, motion(3).angular);
    }
    void store(const Block& block, Motion* motions) const {
        for (size_t axis = 0; axis < 3; ++axis) {
            Four of_linear, of_angular;
            linear[axis].store(of_linear.data());
            angular[axis].store(of_angular.data());
            for (size_t lane = 0; lane < block.count; ++lane) {
                motions[block.movers[lane]].linear[axis] = of_linear[lane];
                motions[block.movers[lane]].angular[axis] = of_angular[lane];
            }
        }
    }

  private:
    static std::array<Float4, 3> columns(const float* a, const float* b, const float* c, const float* d) {
        std::array<Float4, 3> result;
        for (size_t axis = 0; axis < 3; ++axis) {
            const Four four{a[axis], b[axis], c[axis], d[axis]};
            result[axis] = Float4::load(four.data());
        }
        return result;
    }
};

void HeldRows::arrange(std::span<const uint32_t> movers, std::span<const float> lights) {
    movers_.assign(movers.begin(), movers.end());
    counts_.assign(lights.size(), 0);
    for (const uint32_t mover : movers) ++counts_[mover];
    order_.clear(); // those with most rows first
    for (uint32_t mover = 0; mover < lights.size(); ++mover)
        if (counts_[mover] > 0) order_.push_back(static_cast<uint64_t>(UINT32_MAX - counts_[mover]) << 32 | mover);
    std::ranges::sort(order_);

    blocks_.clear();
    lanes_.resize(lights.size());
    uint32_t end = 0;
    for (const uint64_t key : order_) {
        const auto mover = static_cast<uint32_t>(key);
        if (blocks_.empty() || blocks_.back().count == 4) {
            blocks_.push_back({.begin = end, .end = end + counts_[mover]});
            blocks_.back().movers.fill(mover); // lanes that stay empty read something
            end = blocks_.back().end;
        }
        Block& block = blocks_.back();
        lanes_[mover] = static_cast<uint32_t>(4 * (blocks_.size() - 1)) + block.count;
        block.movers[block.count] = mover;
        block.light[block.count++] = lights[mover];
    }
    contacts_.assign(end, {});
    frictions_.assign(end, {});
    coefficients_.assign(end, {});

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

void HeldRows::put(Rows& rows, size_t lane, const Row& row) {
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
    const Rows& rows = contacts_[at];
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

inline void HeldRows::act(const Rows& rows, const auto& impulse, Moving& moving) {
    const Float4 speed = impulse * moving.light;
    for (size_t axis = 0; axis < 3; ++axis) {
        moving.linear[axis] = moving.linear[axis] + Float4::load(rows.normal[axis].data()) * speed;
        moving.angular[axis] = moving.angular[axis] + Float4::load(rows.turn[axis].data()) * impulse;
    }
}

inline void HeldRows::solve(Rows& rows, const auto& low, const auto& high, Moving& moving) {
    std::array<Float4, 3> along;
    for (size_t axis = 0; axis < 3; ++axis)
        along[axis] = Float4::load(rows.normal[axis].data()) * moving.linear[axis]
                      + Float4::load(rows.arm[axis].data()) * moving.angular[axis];
    const Float4 apart = (along[0] + along[1]) + along[2];
    const Float4 before = Float4::load(rows.impulse.data());
    const Float4 free = before + Float4::load(rows.wanted.data()) - apart * Float4::load(rows.gain.data());
    const Float4 impulse = min(max(free, low), high);
    impulse.store(rows.impulse.data());
    act(rows, impulse - before, moving);
}

void HeldRows::give(Motion* motions) const {
    for (const Block& block : blocks_) {
        Moving moving(block, motions);
        for (size_t at = block.begin; at < block.end; ++at)
            act(contacts_[at], Float4::load(contacts_[at].impulse.data()), moving);
        moving.store(block, motions);
    }
}

void HeldRows::press(Motion* motions) {
    const Float4 low = Float4::all(0.0f), high = Float4::all(no_limit);
    for (const Block& block : blocks_) {
        Moving moving(block, motions);
        for (size_t at = block.begin; at < block.end; ++at) solve(contacts_[at], low, high, moving);
        moving.store(block, motions);
    }
}

void HeldRows::rub(Motion* motions) {
    const Float4 none = Float4::all(0.0f);
    for (const Block& block : blocks_) {
        Moving moving(block, motions);
        for (size_t at = block.begin; at < block.end; ++at) {
            const Float4 most = Float4::load(coefficients_[at].data()) * Float4::load(contacts_[at].impulse.data());
            solve(frictions_[at], none - most, most, moving);
        }
        moving.store(block, motions);
    }
}

} // namespace brittle::physics
