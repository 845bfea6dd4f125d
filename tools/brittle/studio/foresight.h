// Prediction of a blow in a breakable world. Runs the steps of the simulation without motion: the same piece is hit at
// the same point and cut by Destruction's own plan.
//
//     Foresight foresight;  // one thread at a time
//     Foreseen what = foresight.of_whole(*object, recipe, version, {.at = p, .direction = d}, cancelled);
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <vector>

#include "fracture/pieces/fragments.h"
#include "physics/cutting/destruction.h"
#include "tools/brittle/studio/object.h"
#include "tools/scenario/run/simulation.h"

namespace brittle::tools {

// A blow of the hammer at a mesh that is still whole. Coordinates of the stage.
struct AimedBlow {
    glm::dvec3 at{0.0};
    glm::dvec3 direction{0.0, 0.0, -1.0}; // unit
    double radius = 0.3;                  // m

    friend bool operator==(const AimedBlow&, const AimedBlow&) = default;
};

// The predicted pieces, in the coordinates of the stage at the start. `falls` marks pieces that the blow detaches.
struct Foreseen {
    fracture::Fragments fragments;
    std::vector<uint8_t> falls;
};

// Returns the parts of a piece under a cut. All but the largest part fall.
[[nodiscard]] Foreseen foresee(const physics::PlannedCut& cut, const std::function<bool()>& cancelled);

class Foresight {
  public:
    // Predicts a blow in the breakable world of a recipe, whole or cut beforehand. Keeps the simulation for further
    // calls; `version` identifies the recipe. Throws a Failure.
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

// Returns the hammer action of an aimed blow in a simulation that has just started; nothing if the blow misses.
[[nodiscard]] std::optional<Hammer> hammer_at(const Simulation& simulation, const fracture::Fragments& fragments,
                                              const AimedBlow& blow, uint32_t max_pieces);

} // namespace brittle::tools
