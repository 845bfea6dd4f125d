// Decides when the studio need not draw: nothing moves, no work is under way, and there has been no input for a moment.
#pragma once

namespace brittle::tools {

class Idleness {
  public:
    // Frames drawn after the last change, because hints and the results of a click appear one frame later.
    static constexpr int settling = 8;
    static constexpr double pause = 0.25; // s, interval between checks of an idle window

    // Returns the time for which Window::poll() waits for an event, s.
    [[nodiscard]] double wait() const { return left_ > 0 ? 0.0 : pause; }
    // Returns whether to draw a frame now. `lively`: something changed or moves. `slow`: something changes slowly by
    // itself, such as a blinking cursor or a message that will disappear.
    [[nodiscard]] bool draws(bool lively, bool slow) {
        const bool was_still = left_ == 0;
        if (lively)
            left_ = settling;
        else if (left_ > 0)
            --left_;
        return left_ > 0 || (was_still && slow);
    }

  private:
    int left_ = settling;
};

} // namespace brittle::tools
