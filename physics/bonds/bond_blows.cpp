#include "physics/bonds/bond_blows.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace brittle::physics {

namespace {

// Relative excess over the judged impulse below which the blow counts as judged; covers solver residuals.
constexpr float same_blow_ratio = 0.05f;

} // namespace

std::vector<BondBlows::JudgedBlow> BondBlows::update(std::span<const StepBlow> blows) {
    std::vector<JudgedBlow> judged;
    std::vector<Running> current, unfinished;
    for (const StepBlow& blow : blows) current.push_back({blow, 2.0f * blow.blow.energy / blow.blow.impulse});
    for (Running& before : running_) {
        const auto next = std::ranges::find_if(current, [&](const Running& running) {
            return matches(running, before.sum.blow.piece, before.sum.blow.other);
        });
        if (next == current.end()) {
            judge(before, before.sum.blow.impulse, judged);
            if (++before.steps < max_steps && outstanding(before) > 0.0f) unfinished.push_back(before);
            continue;
        }
        const float sum = next->sum.blow.impulse + before.sum.blow.impulse, part = before.sum.blow.impulse / sum;
        next->sum.blow.point += (before.sum.blow.point - next->sum.blow.point) * part;
        if (part > 0.5f) next->sum.blow.normal = before.sum.blow.normal;
        next->sum.blow.impulse = sum;
        next->speed = before.speed;
        next->judged_impulse = before.judged_impulse;
        next->steps = before.steps + 1;
    }
    running_ = std::move(unfinished);
    for (Running& running : current) {
        const float remaining = std::clamp(running.sum.remaining_approach, 0.0f, running.speed);
        const bool known = running.speed - remaining >= min_stopped_ratio * running.speed,
                   last = running.steps >= max_steps;
        const float sum = running.sum.blow.impulse;
        if (known || last) judge(running, known ? sum * running.speed / (running.speed - remaining) : sum, judged);
        if (remaining > 0.0f && !last) running_.push_back(running);
    }
    return judged;
}

float BondBlows::load_part(uint32_t piece, BodyId other, float impulse) {
    const auto at =
        std::ranges::find_if(running_, [&](const Running& running) { return matches(running, piece, other); });
    if (at == running_.end()) return impulse;
    const float of_blow = std::clamp(outstanding(*at), 0.0f, impulse);
    at->sum.blow.impulse += of_blow;
    return impulse - of_blow;
}

bool BondBlows::matches(const Running& running, uint32_t piece, BodyId other) {
    return running.sum.blow.piece == piece && running.sum.blow.other == other;
}

void BondBlows::judge(Running& running, float whole, std::vector<JudgedBlow>& judged) {
    if (!(whole - running.judged_impulse > same_blow_ratio * whole)) return;
    Impact blow = running.sum.blow;
    blow.impulse = whole;
    blow.energy = 0.5f * whole * running.speed;
    blow.sharpness = std::cbrt(running.speed / whole); // mass = impulse / speed
    const float before = std::exchange(running.judged_impulse, whole);
    judged.push_back({blow, whole - before, before});
}

} // namespace brittle::physics
