// Windows without a display. Open windows are tested by test_present.cpp and by tests/tools, under Xvfb.
#include <cstdlib>

#include <doctest/doctest.h>

#include "engine/core/window.h"

using namespace brittle::engine;

TEST_CASE("without a display, each attempt to open a window fails and names the command that needs none") {
    unsetenv("DISPLAY");
    unsetenv("WAYLAND_DISPLAY");
    for (int attempt = 0; attempt < 2; ++attempt) {
        const Result<std::unique_ptr<Window>> window = Window::create({});
        REQUIRE_FALSE(window);
        CHECK(window.error().status == Status::no_display);
        CHECK(window.error().message.find("brittle render") != std::string::npos);
        CHECK(window.error().message.find("DISPLAY") != std::string::npos);
    }
}

TEST_CASE("the key code of a letter is its upper-case ASCII code") {
    const Input input{.keys = {Key::space, static_cast<Key>('R')}};
    CHECK(input.pressed('R'));
    CHECK(input.pressed(Key::space));
    CHECK_FALSE(input.pressed('r'));
    CHECK_FALSE(input.pressed(Key::escape));
}
