// The sites of the recipe on the stage, whether placed by hand or by the pattern, and the selection among them.
#pragma once

#include <cstdint>
#include <vector>

#include <glm/vec3.hpp>

#include "tools/brittle/studio/object.h"
#include "tools/scenario/recipe/input.h"

namespace brittle::tools {

class StageSites {
  public:
    // Generates the sites of a recipe, without its strikes. Throws a Failure, and has no sites then.
    void generate(const FractureOptions& recipe, const Object& object);

    [[nodiscard]] const std::vector<glm::dvec3>& on_stage() const { return on_stage_; }
    // The sites in the coordinates of the file, as a recipe lists them.
    [[nodiscard]] const std::vector<PlacedSite>& placed() const { return placed_; }

    // The selected sites in the order of selection.
    [[nodiscard]] std::vector<PlacedSite> selected() const;
    // Indices of all sites that share a group with a selected one.
    [[nodiscard]] std::vector<uint32_t> fellows_of_selected() const;

    std::vector<uint32_t> selection; // indices of the selected sites

  private:
    std::vector<glm::dvec3> on_stage_;
    std::vector<PlacedSite> placed_;
};

} // namespace brittle::tools
