// A window that opens needs a display: tests of tools/brittle do that, under Xvfb.
#include <cstdlib>

#include <doctest/doctest.h>

#include "engine/core/window.h"

using namespace brittle::engine;

TEST_CASE("without a display there is an error that names the way without one, each time") {
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

TEST_CASE("letters are keys by their upper-case code") {
    const Input input{.keys = {Key::space, static_cast<Key>('R')}};
    CHECK(input.pressed('R'));
    CHECK(input.pressed(Key::space));
    CHECK_FALSE(input.pressed('r'));
    CHECK_FALSE(input.pressed(Key::escape));
}
