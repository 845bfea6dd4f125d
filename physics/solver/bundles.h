// Bundles: groups of contacts between moving bodies that have no body in common.
//
// Bodies that press on each other, directly or through others, form a connected component and must be solved together;
// components are independent. A bundle is one large component, or several small ones that together are worth a task.
// All sweeps over a bundle run in one task, on any thread, while its data is in the cache. The assignment to bundles
// changes no bit of the solution, because the contacts within a component keep their order.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

namespace brittle::physics {

class Bundles {
  public:
    static constexpr uint32_t none = UINT32_MAX;

    // Starts with this many moving bodies (movers), each a component of its own.
    void start(size_t movers);
    // Joins the components of two movers that touch at `points` points.
    void join(uint32_t a, uint32_t b, uint32_t points);
    // Forms bundles, the largest component first. All bundles except the last have at least min_points points.
    void finish(uint32_t min_points);

    [[nodiscard]] uint32_t count() const { return count_; }
    // The component of a mover, named by one of its movers.
    [[nodiscard]] uint32_t component(uint32_t mover) const { return parents_[mover]; }
    // The bundle of a mover; `none` for a mover that touches no other mover.
    [[nodiscard]] uint32_t of(uint32_t mover) const { return bundles_[mover]; }

  private:
    std::vector<uint32_t> parents_, points_, bundles_; // by mover
    std::vector<uint32_t> groups_;                     // scratch of finish(): roots of components
    uint32_t count_ = 0;
};

} // namespace brittle::physics
