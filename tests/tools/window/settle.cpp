// Waits until a window has processed all earlier input and drawn the result, for tests under Xvfb. Sends the window
// pings (_NET_WM_PING), which GLFW answers when it reads events, once per frame. The first answer shows that earlier
// input was read, each further one that a frame has passed. A fixed pause would be too long on a fast machine and too
// short on a busy one. Work of other threads is not covered.
//
//     settle WINDOW [FRAMES]     waits for FRAMES frames, 2 by default; exit code 1 if the window is gone
#include <cstdio>
#include <cstdlib>

#include <X11/Xlib.h>
#include <unistd.h>

namespace {

// Seconds per answer, since frames are slow under sanitizers. Then the alarm ends the program.
constexpr unsigned patience = 60;

void ping(Display* display, Window window, long number) {
    XEvent event{};
    event.xclient.type = ClientMessage;
    event.xclient.window = window;
    event.xclient.message_type = XInternAtom(display, "WM_PROTOCOLS", False);
    event.xclient.format = 32;
    event.xclient.data.l[0] = static_cast<long>(XInternAtom(display, "_NET_WM_PING", False));
    event.xclient.data.l[1] = number;
    event.xclient.data.l[2] = static_cast<long>(window);
    XSendEvent(display, window, False, NoEventMask, &event);
    XFlush(display);
}

// The answer goes to the root window, where other clients may receive answers at the same time.
bool answers(const XEvent& event, Window window, long number) {
    return event.type == ClientMessage && event.xclient.data.l[1] == number
           && static_cast<Window>(event.xclient.data.l[2]) == window;
}

} // namespace

int main(int argc, char** argv) {
    Display* display = XOpenDisplay(nullptr);
    if (argc < 2 || argc > 3 || !display) {
        std::fputs("settle: needs a display and a window's number\n", stderr);
        return 2;
    }
    const Window window = std::strtoul(argv[1], nullptr, 10);
    const long frames = argc > 2 ? std::strtol(argv[2], nullptr, 10) : 2;
    XSelectInput(display, DefaultRootWindow(display), SubstructureNotifyMask);
    for (long k = 0; k <= frames; ++k) {
        alarm(patience);
        // Normally a time stamp; the value is returned unchanged.
        const long number = static_cast<long>(getpid()) * 256 + k;
        ping(display, window, number);
        for (XEvent event;;) {
            XNextEvent(display, &event);
            if (answers(event, window, number)) break;
        }
    }
    XCloseDisplay(display);
    return 0;
}
