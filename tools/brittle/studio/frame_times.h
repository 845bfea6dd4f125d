// Frame times of the last few seconds, for the graph and the number beside it.
#pragma once

#include <cstddef>
#include <vector>

namespace brittle::tools {

class FrameTimes {
  public:
    static constexpr size_t capacity = 180; // frames

    void add(double seconds);
    void mark() { pending_ = true; } // marks the next frame as the one that took over a fracture

    [[nodiscard]] const std::vector<float>& milliseconds() const { return times_; } // oldest first
    [[nodiscard]] const std::vector<size_t>& marks() const { return marks_; } // indices into milliseconds(), ascending
    [[nodiscard]] double median() const;                                      // ms; 0 without frames

  private:
    std::vector<float> times_;
    std::vector<size_t> marks_;
    bool pending_ = false;
};

} // namespace brittle::tools
