// Drops a file on a window as a file manager does (XDND, version 5), for tests under Xvfb: owns the selection,
// announces that it is over the window and drops. Exit code 0 once the window has taken the file.
//
//     drop_file WINDOW FILE
#include <array>
#include <cstdio>
#include <cstdlib>
#include <string>

#include <X11/Xatom.h>
#include <X11/Xlib.h>
#include <unistd.h>

namespace {

constexpr unsigned patience = 30; // s; then the alarm ends the program

class Source {
  public:
    Source(Display* display, Window target, std::string file)
        : display_(display), target_(target), text_("file://" + std::move(file) + "\r\n"),
          own_(XCreateSimpleWindow(display, DefaultRootWindow(display), 0, 0, 1, 1, 0, 0, 0)) {}

    // Returns whether the window took the file.
    bool drop() {
        constexpr long version = 5;
        XSetSelectionOwner(display_, atom("XdndSelection"), own_, CurrentTime);
        send("XdndEnter", {version << 24, static_cast<long>(atom("text/uri-list")), None, None});
        send("XdndPosition", {0, 200L << 16 | 200, CurrentTime, static_cast<long>(atom("XdndActionCopy"))});
        for (XEvent event;;) {
            XNextEvent(display_, &event);
            if (event.type == SelectionRequest) answer(event.xselectionrequest);
            if (event.type != ClientMessage) continue;
            const XClientMessageEvent& message = event.xclient;
            if (message.message_type == atom("XdndStatus")) {
                if (!(message.data.l[1] & 1)) return false;
                send("XdndDrop", {0, CurrentTime, 0, 0});
            }
            // GLFW 3.3 puts the number of bytes in a field of which only the lowest bit counts.
            if (message.message_type == atom("XdndFinished")) return message.data.l[1] != 0;
        }
    }

  private:
    [[nodiscard]] Atom atom(const char* name) const { return XInternAtom(display_, name, False); }

    void send(const char* type, const std::array<long, 4>& data) {
        XEvent event{};
        event.xclient.type = ClientMessage;
        event.xclient.window = target_;
        event.xclient.message_type = atom(type);
        event.xclient.format = 32;
        event.xclient.data.l[0] = static_cast<long>(own_);
        for (size_t k = 0; k < data.size(); ++k) event.xclient.data.l[k + 1] = data[k];
        XSendEvent(display_, target_, False, NoEventMask, &event);
        XFlush(display_);
    }

    void answer(const XSelectionRequestEvent& request) {
        XChangeProperty(display_, request.requestor, request.property, request.target, 8, PropModeReplace,
                        reinterpret_cast<const unsigned char*>(text_.data()), static_cast<int>(text_.size()));
        XEvent event{};
        event.xselection.type = SelectionNotify;
        event.xselection.requestor = request.requestor;
        event.xselection.selection = request.selection;
        event.xselection.target = request.target;
        event.xselection.property = request.property;
        event.xselection.time = request.time;
        XSendEvent(display_, request.requestor, False, NoEventMask, &event);
        XFlush(display_);
    }

    Display* display_;
    Window target_;
    std::string text_;
    Window own_;
};

} // namespace

int main(int argc, char** argv) {
    Display* display = XOpenDisplay(nullptr);
    if (argc != 3 || !display) {
        std::fputs("drop_file: needs a display, a window's number and a file\n", stderr);
        return 2;
    }
    alarm(patience);
    const bool taken = Source(display, std::strtoul(argv[1], nullptr, 10), argv[2]).drop();
    XCloseDisplay(display);
    return taken ? 0 : 1;
}
