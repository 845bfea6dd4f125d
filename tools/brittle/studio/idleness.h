// Decides when the studio need not draw: nothing moves, no work is under way, and there has been no input for a moment.
#pragma once

#include <algorithm>
#include <cmath>

namespace brittle::tools {

class Idleness {
  public:
    // Frames drawn after the last change, because hints and the results of a click appear one frame later. Long frames
    // count for several, so that a scene whose frames take seconds settles as well.
    static constexpr int settling = 8, min_settling = 3;
    static constexpr double usual_frame = 1.0 / 60.0; // s
    static constexpr double pause = 0.25;             // s, shortest interval between checks of an idle window
    // The share of the time, at most, for frames that show something that changes slowly by itself.
    static constexpr double slow_share = 0.2;

    // `frame`: duration of the last frame that was drawn, s.
    void took(double frame) { frame_ = frame; }
    // Returns the time for which Window::poll() waits for an event, s.
    [[nodiscard]] double wait() const { return left_ > 0 ? 0.0 : std::max(pause, frame_ * (1.0 / slow_share - 1.0)); }
    // Returns whether to draw a frame now. `lively`: something changed or moves. `slow`: something changes slowly by
    // itself, such as a blinking cursor, a message that will disappear or the progress of work.
    [[nodiscard]] bool draws(bool lively, bool slow) {
        const bool was_still = left_ == 0;
        if (lively)
            left_ = settling;
        else
            left_ = std::max(left_ - frames_worth(), 0);
        return left_ > 0 || (was_still && slow);
    }

  private:
    [[nodiscard]] int frames_worth() const {
        constexpr double most = (settling + min_settling - 1) / min_settling; // rounded up
        return static_cast<int>(std::clamp(std::round(frame_ / usual_frame), 1.0, most));
    }

    int left_ = settling;
    double frame_ = 0.0;
};

} // namespace brittle::tools
