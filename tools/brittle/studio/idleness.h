// When the studio need not draw: nothing moves, no work is under way, and nobody has touched the window for a moment.
//
//     Idleness idleness;
//     for (;;) {
//         const Input& input = window.poll(idleness.wait());
//         if (!idleness.draws(input.stirred || moving, typing)) continue;
//         draw(); ...
#pragma once

namespace brittle::tools {

class Idleness {
  public:
    // Frames that are drawn after the last change: hints, and what a click has opened, show in the frame after it.
    static constexpr int settling = 8;
    static constexpr double pause = 0.25; // s, between looks at a window at rest

    // For Window::poll(): how long to wait for an event.
    [[nodiscard]] double wait() const { return left_ > 0 ? 0.0 : pause; }
    // Whether to draw a frame now. `lively`: something changed or moves. `slow`: something changes slowly by itself, as a
    // cursor that blinks does, or a message that will go.
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
