#include "tools/brittle/studio/frame_times.h"

#include <algorithm>

namespace brittle::tools {

void FrameTimes::add(double seconds) {
    if (times_.size() == capacity) {
        times_.erase(times_.begin());
        if (!marks_.empty() && marks_.front() == 0) marks_.erase(marks_.begin());
        for (size_t& at : marks_) --at;
    }
    if (pending_) marks_.push_back(times_.size());
    pending_ = false;
    times_.push_back(static_cast<float>(1e3 * seconds));
}

double FrameTimes::median() const {
    if (times_.empty()) return 0.0;
    std::vector<float> sorted = times_;
    const auto middle = sorted.begin() + static_cast<std::ptrdiff_t>(sorted.size() / 2);
    std::nth_element(sorted.begin(), middle, sorted.end());
    return *middle;
}

} // namespace brittle::tools
