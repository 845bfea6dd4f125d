#include "physics/bonds/bond_blows.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace brittle::physics {

namespace {

// Less than this part more is the same blow: what the solver leaves of one step to the next.
constexpr float same_part = 0.05f;

} // namespace

std::vector<BondBlows::Judged> BondBlows::take_up(std::span<const OfStep> blows) {
    std::vector<Judged> judged;
    std::vector<Running> now, on_their_way;
    for (const OfStep& blow : blows) now.push_back({blow, 2.0f * blow.blow.energy / blow.blow.impulse});
    for (Running& before : running_) {
        const auto next = std::ranges::find_if(
            now, [&](const Running& running) { return is_of(running, before.sum.blow.piece, before.sum.blow.other); });
        if (next == now.end()) {
            judge(before, before.sum.blow.impulse, judged);
            if (++before.steps < max_steps && owed(before) > 0.0f) on_their_way.push_back(before);
            continue;
        }
        const float sum = next->sum.blow.impulse + before.sum.blow.impulse, part = before.sum.blow.impulse / sum;
        next->sum.blow.point += (before.sum.blow.point - next->sum.blow.point) * part;
        if (part > 0.5f) next->sum.blow.normal = before.sum.blow.normal;
        next->sum.blow.impulse = sum;
        next->speed = before.speed;
        next->judged = before.judged;
        next->steps = before.steps + 1;
    }
    running_ = std::move(on_their_way);
    for (Running& running : now) {
        const float left = std::clamp(running.sum.left, 0.0f, running.speed);
        const bool known = running.speed - left >= min_part * running.speed, last = running.steps >= max_steps;
        const float sum = running.sum.blow.impulse;
        if (known || last) judge(running, known ? sum * running.speed / (running.speed - left) : sum, judged);
        if (left > 0.0f && !last) running_.push_back(running);
    }
    return judged;
}

float BondBlows::load_of(uint32_t piece, BodyId other, float impulse) {
    const auto at =
        std::ranges::find_if(running_, [&](const Running& running) { return is_of(running, piece, other); });
    if (at == running_.end()) return impulse;
    const float of_blow = std::clamp(owed(*at), 0.0f, impulse);
    at->sum.blow.impulse += of_blow;
    return impulse - of_blow;
}

bool BondBlows::is_of(const Running& running, uint32_t piece, BodyId other) {
    return running.sum.blow.piece == piece && running.sum.blow.other == other;
}

void BondBlows::judge(Running& running, float whole, std::vector<Judged>& judged) {
    if (!(whole - running.judged > same_part * whole)) return;
    Impact blow = running.sum.blow;
    blow.impulse = whole;
    blow.energy = 0.5f * whole * running.speed;
    blow.sharpness = std::cbrt(running.speed / whole); // mass = impulse / speed
    const float before = std::exchange(running.judged, whole);
    judged.push_back({blow, whole - before, before});
}

} // namespace brittle::physics
