// What a blow will do to what is breakable, before it happens. It does what the simulation would do, with all but the
// moving: the same piece is hit at the same place, and cut by Destruction's own plan.
//
//     Foresight foresight;                                        // one thread at a time
//     Foreseen what = foresight.of_whole(*object, recipe, version, {.at = p, .direction = d, .radius = 0.3}, cancelled);
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <vector>

#include "fracture/pieces/fragments.h"
#include "physics/cutting/destruction.h"
#include "tools/brittle/run/simulation.h"
#include "tools/brittle/studio/object.h"

namespace brittle::tools {

// Of the hammer, at what is whole still. On the stage.
struct AimedBlow {
    glm::dvec3 at{0.0};
    glm::dvec3 direction{0.0, 0.0, -1.0}; // unit
    double radius = 0.3;                  // m

    friend bool operator==(const AimedBlow&, const AimedBlow&) = default;
};

// Pieces as they would be, in the coordinates of the stage at the start; those that the blow loosens by `falls`.
struct Foreseen {
    fracture::Fragments fragments;
    std::vector<uint8_t> falls;
};

// Of one piece that is cut: the largest part is what stays.
[[nodiscard]] Foreseen foresee(const physics::PlannedCut& cut, const std::function<bool()>& cancelled);

class Foresight {
  public:
    // Of what the recipe makes breakable, whole or cut beforehand. Keeps the simulation that stands there: `version` tells
    // recipes apart. Throws a Failure.
    [[nodiscard]] Foreseen of_whole(const std::shared_ptr<const Object>& object, const FractureOptions& recipe,
                                    uint64_t version, const AimedBlow& blow, const std::function<bool()>& cancelled);

  private:
    void stand(const std::shared_ptr<const Object>& object, const FractureOptions& recipe, uint64_t version,
               const std::function<bool()>& cancelled);

    std::shared_ptr<const Object> object_;
    uint64_t version_ = 0;
    fracture::Fragments fragments_;
    std::unique_ptr<Simulation> simulation_;
};

// Where an aimed blow meets a simulation that has just been started; nothing where it misses.
[[nodiscard]] std::optional<Hammer> hammer_at(const Simulation& simulation, const fracture::Fragments& fragments,
                                              const AimedBlow& blow, uint32_t max_pieces);

} // namespace brittle::tools
