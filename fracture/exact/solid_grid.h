// A coarse grid over the scene that tells what certainly lies outside the solid.
//
// The covered bins are those that the surface may meet, and those that cannot be reached from the box past them. So the
// solid lies in the covered bins, and around all others the winding number is zero. Of many sites, most lie far from a
// thin solid, and their cells are not built at all (diagram.h).
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include <glm/vec3.hpp>

#include "fracture/base/threads.h"
#include "fracture/mesh/mesh.h"

namespace brittle::fracture::exact {

class SolidGrid {
  public:
    static constexpr uint32_t max_bins = 1024;
    // The box contains all positions. `bins` is the number of bins along its longest axis, at most max_bins.
    void build(std::span<const glm::dvec3> positions, std::span<const Triangle> triangles, const Box& box,
               uint32_t bins, Threads& threads);

    // Returns whether the bin of a point is covered; false outside the box.
    [[nodiscard]] bool covers(const glm::dvec3& point) const;
    // Returns whether a covered bin meets a box. False only where the box certainly lies outside the solid.
    [[nodiscard]] bool meets(const Box& box) const;
    // One point of each connected group of covered bins.
    [[nodiscard]] std::span<const glm::dvec3> group_points() const { return group_points_; }

  private:
    enum State : uint8_t { unknown, touched, outside, covered };

    [[nodiscard]] glm::ivec3 place_of(const glm::dvec3& point) const;
    [[nodiscard]] uint32_t index_of(const glm::ivec3& place) const;
    void touch(std::span<const glm::dvec3> positions, std::span<const Triangle> triangles, Threads& threads);
    void find_outside();
    void find_groups();
    // Visits the bins beside a bin.
    template<class Visit>
    void visit_beside(uint32_t bin, const Visit& visit) const;

    glm::dvec3 low_{0.0};
    double size_ = 1.0, per_length_ = 1.0; // the size of a bin, and its inverse
    double margin_ = 0.0;                  // covers the rounding of places
    glm::ivec3 count_{0};                  // of bins along the axes
    std::vector<uint8_t> state_;
    std::vector<uint32_t> place_of_vertex_; // ten bits an axis
    std::vector<uint32_t> stack_;
    std::vector<glm::dvec3> group_points_;
};

} // namespace brittle::fracture::exact
