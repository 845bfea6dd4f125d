// Texture stacks: sizes and mipmaps against values by hand.
#include <array>
#include <initializer_list>

#include <doctest/doctest.h>

#include "engine/render/texture_stack.h"

using namespace brittle::engine;

namespace {

using Texel = std::array<uint8_t, 4>;

Bitmap bitmap(uint32_t width, uint32_t height, std::initializer_list<Texel> texels) {
    Bitmap made{width, height, {}};
    for (const Texel& texel : texels) made.pixels.insert(made.pixels.end(), texel.begin(), texel.end());
    REQUIRE(made.pixels.size() == size_t{4} * width * height);
    return made;
}

Texel texel(const TextureStack& stack, uint32_t level, size_t index) {
    const std::span<const uint8_t> all = stack.level(level);
    REQUIRE(4 * index + 4 <= all.size());
    return {all[4 * index], all[4 * index + 1], all[4 * index + 2], all[4 * index + 3]};
}

constexpr Texel black{0, 0, 0, 255}, white{255, 255, 255, 255};

} // namespace

TEST_CASE("texture stack: no image, and an image of one texel") {
    CHECK(TextureStack::of({}).layers() == 0);
    CHECK(TextureStack::of({}).levels() == 0);
    CHECK(TextureStack::joined({}).layers() == 0);
    const Bitmap one = bitmap(1, 1, {{1, 2, 3, 4}});
    const TextureStack stack = TextureStack::of({&one, 1});
    CHECK(stack.levels() == 1);
    CHECK(stack.layers() == 1);
    CHECK(texel(stack, 0, 0) == Texel{1, 2, 3, 4});
}

TEST_CASE("texture stack: mipmaps of colours are means of light, those of normals means of numbers") {
    const Bitmap checker = bitmap(2, 2, {black, white, white, black});
    const TextureStack colours = TextureStack::of({&checker, 1}),
                       normals = TextureStack::of({&checker, 1}, {.srgb = false});
    REQUIRE(colours.levels() == 2);
    CHECK(colours.level(0).size() == 16);
    CHECK(texel(colours, 0, 1) == white);
    CHECK(texel(colours, 1, 0) == Texel{188, 188, 188, 255}); // half the light
    CHECK(texel(normals, 1, 0) == Texel{128, 128, 128, 255});
}

TEST_CASE("texture stack: the colour of invisible texels does not show") {
    const Bitmap leaf = bitmap(2, 1, {{255, 0, 0, 255}, {0, 255, 0, 0}});
    const TextureStack stack = TextureStack::of({&leaf, 1});
    REQUIRE(stack.levels() == 2);
    const Texel mean = texel(stack, 1, 0);
    CHECK(mean[0] == 255);
    CHECK(mean[1] < 15);
    CHECK(mean[3] == 128);
}

TEST_CASE("texture stack: images of several sizes get that of the largest sides, and keep their order") {
    const Bitmap images[] = {bitmap(1, 1, {{10, 20, 30, 255}}), bitmap(4, 1, {black, black, white, white}),
                             bitmap(1, 2, {white, black})};
    const TextureStack stack = TextureStack::of(images);
    CHECK(stack.width() == 4);
    CHECK(stack.height() == 2);
    CHECK(stack.layers() == 3);
    CHECK(stack.levels() == 3); // 4 x 2, 2 x 1, 1 x 1
    for (size_t i = 0; i < 8; ++i) CHECK(texel(stack, 0, i) == Texel{10, 20, 30, 255});
    for (size_t i = 8; i < 16; ++i) CHECK(texel(stack, 0, i) == (i % 4 < 2 ? black : white));
    for (size_t i = 16; i < 24; ++i) CHECK(texel(stack, 0, i) == (i < 20 ? white : black));
    CHECK(stack.level(1).size() == 3 * 2 * 4);
    CHECK(stack.level(2).size() == 3 * 4);
}

TEST_CASE("texture stack: sides and bytes are limited") {
    const Bitmap wide{64, 2, std::vector<uint8_t>(64 * 2 * 4, 200)};
    const TextureStack narrow = TextureStack::of({&wide, 1}, {.max_side = 16});
    CHECK(narrow.width() == 16);
    CHECK(narrow.height() == 1);
    CHECK(texel(narrow, 0, 7) == Texel{200, 200, 200, 200});
    const std::vector<Bitmap> many(10, wide);
    const TextureStack small = TextureStack::of(many, {.max_bytes = 4000});
    CHECK(small.layers() == 10);
    CHECK(small.width() == 32);
    CHECK(small.height() == 1);
    const TextureStack least = TextureStack::of(many, {.max_bytes = 0});
    CHECK(least.width() == 1);
    CHECK(least.layers() == 10);
}

TEST_CASE("texture stack: joined stacks equal one of all images") {
    const Bitmap a = bitmap(2, 2, {black, white, white, black}), b = bitmap(2, 2, {white, white, black, {9, 8, 7, 6}}),
                 larger = bitmap(4, 2, {black, white, black, white, white, black, white, black});
    const TextureStack of_a = TextureStack::of({&a, 1}), of_b = TextureStack::of({&b, 1}),
                       of_larger = TextureStack::of({&larger, 1}), none;
    const TextureStack* equal[] = {&of_a, &none, &of_b};
    const Bitmap both[] = {a, b};
    const TextureStack joined = TextureStack::joined(equal), made = TextureStack::of(both);
    REQUIRE(joined.layers() == 2);
    REQUIRE(joined.levels() == made.levels());
    for (uint32_t k = 0; k < made.levels(); ++k)
        CHECK(std::equal(joined.level(k).begin(), joined.level(k).end(), made.level(k).begin(), made.level(k).end()));
    const TextureStack* differing[] = {&of_a, &of_larger};
    const Bitmap of_two[] = {a, larger};
    const TextureStack enlarged = TextureStack::joined(differing), at_once = TextureStack::of(of_two);
    REQUIRE(enlarged.width() == 4);
    REQUIRE(enlarged.levels() == at_once.levels());
    for (uint32_t k = 0; k < at_once.levels(); ++k)
        CHECK(std::equal(enlarged.level(k).begin(), enlarged.level(k).end(), at_once.level(k).begin(),
                         at_once.level(k).end()));
}
