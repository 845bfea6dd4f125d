// Blows on bonded pieces, judged whole in the step in which they begin.
//
// What comes slowly, lands flat or has a gap left to close gives its impulse over several steps (contact_blows.h). Bonds do not
// wait for the last of them: where a blow breaks something, the contacts of its step are taken back (structure.h), and that can be
// done for one step only. So the whole is told from the first: it took so much impulse to stop a part of the approach, and what
// is left of that will take its share. What then comes is held against it, over at most four steps; only more is a blow again.
// Where next to nothing has been stopped yet, it is waited for the next step.
//
//     BondBlows book;
//     each step: for (const BondBlows::JudgedBlow& judged : book.update(of_step)) ...
//                for (each contact that is too slow) load += book.load_part(piece, other, impulse);
//
// The step's blows are contacts that came in fast, so weight at rest never adds up to one. What of a blow comes slower, at its
// end, is judged already: it is no load either, which would wear bonds. N s, J, m/s. Deterministic: those of before that end
// without a contact come first, then in the order of the step's blows.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include <glm/vec3.hpp>

#include "physics/world/world.h"

namespace brittle::physics {

// A blow that was hard enough to break the piece itself: impulse above toughness(material) * volume^(2/3), as a blow
// of a kilogram, and of which the bonds around have left energy. Who wants things to break again takes the piece away
// (isolate, take_piece), fractures it at the point and makes a structure of the result.
struct Impact {
    uint32_t piece = 0;
    BodyId other;           // what hit it; the default for the ground
    glm::vec3 point{0.0f};  // world, m
    glm::vec3 normal{0.0f}; // unit, towards the piece
    float impulse = 0.0f;   // N s
    float sharpness = 1.0f; // cube root of 1 kg / mass that was stopped: for the time that it took
    float energy = 0.0f;    // J, half of impulse times approach speed: what a dead blow turns into cracks and heat; of
                            // Structure::Changes, what bonds have left of it
};

class BondBlows {
  public:
    static constexpr int max_steps = 4; // of one blow; a longer push is several
    // The part of an approach that must have been stopped before the whole is told from it: the smaller, the more what the
    // solver leaves undone counts.
    static constexpr float min_stopped_ratio = 0.2f;

    struct StepBlow {
        Impact blow;                     // what the step gave; its sharpness is not looked at
        float remaining_approach = 0.0f; // m/s, mean of the approach after the step, weighed by impulse
    };
    struct JudgedBlow {
        Impact blow;                 // the whole
        float new_impulse = 0.0f;    // N s of it that were not judged before: more than 0
        float judged_impulse = 0.0f; // N s that were
    };
    // To be called after each step with its blows, at most one of a piece and what hit it.
    [[nodiscard]] std::vector<JudgedBlow> update(std::span<const StepBlow> blows);
    // Of the impulse of a contact that is too slow for a blow, after update(): what is none of what a blow that was judged has
    // yet to give, but a load.
    [[nodiscard]] float load_part(uint32_t piece, BodyId other, float impulse);

  private:
    struct Running {
        StepBlow sum;                // of what came so far; left is the last step's
        float speed = 0.0f;          // m/s, mean of its first step
        float judged_impulse = 0.0f; // N s
        int steps = 1;
    };
    // N s that were judged and have not come.
    [[nodiscard]] static float outstanding(const Running& running) {
        return running.judged_impulse - running.sum.blow.impulse;
    }
    [[nodiscard]] static bool matches(const Running& running, uint32_t piece, BodyId other);
    static void judge(Running& running, float whole, std::vector<JudgedBlow>& judged);

    std::vector<Running> running_;
};

} // namespace brittle::physics
