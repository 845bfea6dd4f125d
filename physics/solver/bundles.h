// Contacts between bodies that move, in bundles that have no body in common.
//
// Who presses on whom, directly or through others, must be solved together; what lies apart need not wait. So each
// bundle is swept by itself, on any thread and while it is at hand: a thing that broke has its pieces around it and
// nobody else. A bundle of less than some contacts is not worth a task and takes others in. In which bundle a contact
// is changes no bit of its solution: the contacts of any two bodies that have to do with each other keep their order.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

namespace brittle::physics {

class Bundles {
  public:
    static constexpr uint32_t none = UINT32_MAX;

    // So many movers, none of which touches another one.
    void start(size_t movers);
    // Two of them touch, at so many points.
    void join(uint32_t a, uint32_t b, uint32_t points);
    // The bundle with the largest group comes first; but for the last one all have at least so many points.
    void finish(uint32_t min_points);

    [[nodiscard]] uint32_t count() const { return count_; }
    // None for a mover that touches no other one.
    [[nodiscard]] uint32_t of(uint32_t mover) const { return bundles_[mover]; }

  private:
    std::vector<uint32_t> parents_, points_, bundles_; // by mover
    std::vector<uint32_t> groups_;                     // scratch of finish(): roots
    uint32_t count_ = 0;
};

} // namespace brittle::physics
