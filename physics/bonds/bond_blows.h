// Judges a blow on bonded pieces as a whole in the step in which it begins. structure.h defines a blow.
//
// A slow, flat or not yet closed contact spreads its impulse over several steps (contact_blows.h). Bonds cannot wait
// for the last of them: a blow that breaks something rewinds the contacts of its step (structure.h), which works for
// one step only. So the whole impulse is extrapolated from the first step: if the impulse so far stopped a part of the
// approach speed, the rest of the approach takes its share. Later impulse is charged against this forecast for at most
// max_steps steps; only the excess is a blow again. While less than min_stopped_ratio of the approach has been
// stopped, the judgement is postponed to the next step.
//
//     BondBlows blows;
//     each step: for (const BondBlows::JudgedBlow& judged : blows.update(step_blows)) ...
//                for (each contact below impact_speed) load += blows.load_part(piece, other, impulse);
//
// Blows consist of fast contacts, so weight at rest never adds up to one. The slow end of a judged blow is part of the
// forecast, and load_part() excludes it from the loads that wear bonds. N s, J, m/s. Deterministic order: unfinished
// blows that ended without a contact, then the order of the step's blows. Not thread-safe.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include <glm/vec3.hpp>

#include "physics/world/world.h"

namespace brittle::physics {

// A blow against one piece. In Structure::Changes: one that is hard enough to break the piece itself, as impulse *
// sharpness / impact_seconds > breaking_force(material, volume^(2/3)) and the bonds left some of its energy. To break
// the piece, fracture it at the point and give the parts to Structure::divide().
struct Impact {
    uint32_t piece = 0;
    BodyId other;           // the striker; BodyId{} for the ground
    glm::vec3 point{0.0f};  // world, m
    glm::vec3 normal{0.0f}; // unit, towards the piece
    float impulse = 0.0f;   // N s
    float sharpness = 1.0f; // (1 kg / stopped mass)^(1/3): scales the impulse to that of a striker of 1 kg
    // J, half of impulse times approach speed, which an inelastic impact turns into cracks and heat. In
    // Structure::Changes: the part that the bonds left.
    float energy = 0.0f;
};

class BondBlows {
  public:
    static constexpr int max_steps = 4; // of one blow; a longer push counts as several blows
    // Stopped share of the approach speed from which the whole is extrapolated. A smaller one amplifies solver
    // residuals.
    static constexpr float min_stopped_ratio = 0.2f;

    struct StepBlow {
        Impact blow;                     // of this step alone; sharpness is ignored
        float remaining_approach = 0.0f; // m/s, after the step; mean weighted by impulse
    };
    struct JudgedBlow {
        Impact blow;                 // the whole, forecast included
        float new_impulse = 0.0f;    // N s, the part of blow.impulse that is judged now, > 0
        float judged_impulse = 0.0f; // N s, the part of blow.impulse that earlier steps judged
    };
    // Takes the blows of the last step, at most one per piece and striker, and returns the new judgements. Call it
    // once a step.
    [[nodiscard]] std::vector<JudgedBlow> update(std::span<const StepBlow> blows);
    // Returns the part of a slow contact's impulse (N s) that is a load: the impulse less what a judged blow of the
    // same piece and striker still has outstanding. Call it after update().
    [[nodiscard]] float load_part(uint32_t piece, BodyId other, float impulse);

  private:
    struct Running {
        StepBlow sum;                // of all steps so far; remaining_approach of the last step
        float speed = 0.0f;          // m/s, approach in the first step; mean weighted by impulse
        float judged_impulse = 0.0f; // N s, forecast included
        int steps = 1;
    };
    // N s that were judged and have not arrived.
    [[nodiscard]] static float outstanding(const Running& running) {
        return running.judged_impulse - running.sum.blow.impulse;
    }
    [[nodiscard]] static bool matches(const Running& running, uint32_t piece, BodyId other);
    static void judge(Running& running, float whole, std::vector<JudgedBlow>& judged);

    std::vector<Running> running_;
};

} // namespace brittle::physics
