#include "tools/brittle/pictures/id_picture.h"

#include <array>
#include <set>

#include <doctest/doctest.h>

using namespace brittle::tools;
using brittle::engine::Bitmap;
using brittle::engine::IdImage;

TEST_CASE("an id picture of size zero, and one without pieces") {
    CHECK(id_picture({}).pixels.empty());
    const Bitmap none = id_picture({2, 1, {0, 0}});
    CHECK(none.pixels == std::vector<uint8_t>(8, 0));
    CHECK_FALSE(piece_of_colour(none.at(0, 0)));
}

TEST_CASE("every piece has a colour of its own that leads back to its number") {
    IdImage ids{1, 70'000, {}};
    for (uint32_t k = 0; k < ids.height; ++k) ids.ids.push_back(k == 69'999 ? 0xffffff : k + 1);
    const Bitmap picture = id_picture(ids);
    std::set<uint32_t> colours;
    for (uint32_t y = 0; y < ids.height; ++y) {
        const uint8_t* p = picture.at(0, y);
        REQUIRE(p[3] == 255);
        REQUIRE(piece_of_colour(p) == ids.ids[y] - 1);
        colours.insert(static_cast<uint32_t>(p[0]) << 16 | static_cast<uint32_t>(p[1]) << 8 | p[2]);
    }
    CHECK(colours.size() == ids.height);
    CHECK_FALSE(colours.contains(0));
}

TEST_CASE("the first colours follow the manual's formula and are clearly different") {
    const Bitmap picture = id_picture({3, 1, {1, 2, 3}});
    const std::array<uint8_t, 12> expected{0x9E, 0x37, 0x79, 255, 0x3C, 0x6E, 0xF2, 255, 0xDA, 0xA6, 0x6B, 255};
    CHECK(std::equal(picture.pixels.begin(), picture.pixels.end(), expected.begin(), expected.end()));
}
