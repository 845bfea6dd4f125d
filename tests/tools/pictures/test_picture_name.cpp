#include <doctest/doctest.h>

#include "tests/tools/support.h"
#include "tools/brittle/pictures/picture_name.h"

using namespace brittle::tools;

TEST_CASE("a pattern is numbered by exactly one decimal placeholder") {
    CHECK(is_numbered("frame_%04d.png"));
    CHECK(is_numbered("%d"));
    CHECK(is_numbered("100%%_%3d.png"));
    CHECK_FALSE(is_numbered("frame.png"));
    CHECK_FALSE(is_numbered("%d_%d.png"));
    CHECK_FALSE(is_numbered("%s.png"));
    CHECK_FALSE(is_numbered("%04x.png"));
    CHECK_FALSE(is_numbered("%n%d"));
    CHECK_FALSE(is_numbered("frame_%"));
    CHECK_FALSE(is_numbered(""));
}

TEST_CASE("a plain name holds no placeholder") {
    CHECK(is_plain("frame.png"));
    CHECK(is_plain("100%%.png"));
    CHECK_FALSE(is_plain("100%.png"));
    CHECK_FALSE(is_plain("%d.png"));
}

TEST_CASE("frame numbers are padded as printf pads them") {
    CHECK(picture_name("frame_%04d.png", 7) == "frame_0007.png");
    CHECK(picture_name("frame_%04d.png", 123456) == "frame_123456.png");
    CHECK(picture_name("%d", 0) == "0");
    CHECK(picture_name("a%3d", 5) == "a  5");
    CHECK(picture_name("50%%_%02d", 3) == "50%_03");
    CHECK(picture_name("still.png", 9) == "still.png");
    CHECK(picture_name("50%%.png", 9) == "50%.png");
}

TEST_CASE("an unused name is the first name without a file") {
    const test::Folder folder;
    const std::string pattern = folder / "a_%03d.png";
    CHECK(unused_name(pattern) == folder / "a_000.png");
    for (const char* name : {"a_000.png", "a_002.png"}) folder.write(name, "x");
    CHECK(unused_name(pattern) == folder / "a_001.png");
}
