// A minimal window manager for tests under Xvfb, which has none. It maps and minimises windows on request and sets
// WM_STATE, which GLFW reads.
#include <cstdio>

#include <X11/Xlib.h>
#include <X11/Xutil.h>

namespace {

void set_state(Display* display, Window window, long state) {
    const Atom name = XInternAtom(display, "WM_STATE", False);
    const long data[] = {state, None};
    XChangeProperty(display, window, name, name, 32, PropModeReplace, reinterpret_cast<const unsigned char*>(data), 2);
}

void grant(Display* display, const XConfigureRequestEvent& wanted) {
    XWindowChanges changes{wanted.x,     wanted.y,     wanted.width, wanted.height, wanted.border_width,
                           wanted.above, wanted.detail};
    XConfigureWindow(display, wanted.window, static_cast<unsigned>(wanted.value_mask), &changes);
}

} // namespace

int main() {
    Display* display = XOpenDisplay(nullptr);
    if (!display) {
        std::fputs("window_manager: no display\n", stderr);
        return 1;
    }
    // A window may have been destroyed before its request is read.
    XSetErrorHandler([](Display*, XErrorEvent*) { return 0; });
    XSelectInput(display, DefaultRootWindow(display), SubstructureRedirectMask | SubstructureNotifyMask);
    XSync(display, False);
    std::puts("ready");
    std::fflush(stdout);
    const Atom change_state = XInternAtom(display, "WM_CHANGE_STATE", False);
    for (XEvent event;;) {
        XNextEvent(display, &event);
        if (event.type == ConfigureRequest) grant(display, event.xconfigurerequest);
        if (event.type == MapRequest) {
            set_state(display, event.xmaprequest.window, NormalState);
            XMapWindow(display, event.xmaprequest.window);
        }
        if (event.type == ClientMessage && event.xclient.message_type == change_state
            && event.xclient.data.l[0] == IconicState) {
            XUnmapWindow(display, event.xclient.window);
            set_state(display, event.xclient.window, IconicState);
        }
    }
}
