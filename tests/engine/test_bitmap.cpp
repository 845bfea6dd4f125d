#include <cstdio>
#include <filesystem>
#include <fstream>

#include <doctest/doctest.h>

#include "engine/core/bitmap.h"
#include "support.h"

using namespace brittle::engine;
using namespace brittle::engine::test;

namespace {

Bitmap gradient(uint32_t width, uint32_t height) {
    Bitmap image{width, height, std::vector<uint8_t>(size_t{4} * width * height)};
    for (uint32_t y = 0; y < height; ++y)
        for (uint32_t x = 0; x < width; ++x) {
            uint8_t* p = image.at(x, y);
            p[0] = static_cast<uint8_t>(x * 7);
            p[1] = static_cast<uint8_t>(y * 11);
            p[2] = static_cast<uint8_t>(x * y);
            p[3] = static_cast<uint8_t>(255 - x);
        }
    return image;
}

Bitmap shifted(const Bitmap& image) {
    Bitmap result = image;
    for (uint32_t y = 0; y < image.height; ++y)
        for (uint32_t x = 1; x < image.width; ++x) std::copy_n(image.at(x - 1, y), 4, result.at(x, y));
    return result;
}

std::string scratch(const char* name) {
    std::filesystem::create_directories(failure_folder());
    return failure_folder() + "/" + name;
}

} // namespace

TEST_CASE("an empty bitmap is not written") {
    const Result<void> written = write_png({}, scratch("empty.png"));
    REQUIRE_FALSE(written);
    CHECK(written.error().status == Status::invalid_argument);
    CHECK_FALSE(std::filesystem::exists(scratch("empty.png")));
}

TEST_CASE("a bitmap whose pixels do not fit its size is not written") {
    Bitmap image = gradient(8, 8);
    image.pixels.pop_back();
    CHECK_FALSE(write_png(image, scratch("short.png")));
}

TEST_CASE("reading a file that is not a PNG gives an error that names the file") {
    const std::string text = scratch("text.png"), nothing = scratch("nothing.png");
    std::ofstream(text) << "not a picture";
    std::ofstream{nothing};
    for (const std::string& path : {text, nothing, scratch("missing.png"), failure_folder()}) {
        CAPTURE(path);
        const Result<Bitmap> image = read_png(path);
        REQUIRE_FALSE(image);
        CHECK(image.error().status == Status::file_error);
        CHECK(image.error().message.find(path) != std::string::npos);
    }
}

TEST_CASE("a truncated PNG gives an error") {
    const std::string path = scratch("truncated.png");
    REQUIRE(write_png(gradient(64, 64), path));
    std::filesystem::resize_file(path, std::filesystem::file_size(path) / 2);
    CHECK_FALSE(read_png(path));
}

TEST_CASE("writing into a folder that does not exist gives an error that names the file") {
    const Result<void> written = write_png(gradient(4, 4), scratch("no/such/folder.png"));
    REQUIRE_FALSE(written);
    CHECK(written.error().message.find("no/such/folder.png") != std::string::npos);
}

TEST_CASE("a bitmap written as PNG is read back byte for byte") {
    const Bitmap image = gradient(37, 21);
    const std::string path = scratch("round_trip.png");
    REQUIRE(write_png(image, path));
    const Result<Bitmap> read = read_png(path);
    REQUIRE(read);
    CHECK(read->width == image.width);
    CHECK(read->height == image.height);
    CHECK(read->pixels == image.pixels);
    CHECK_FALSE(std::filesystem::exists(path + ".part"));
}

TEST_CASE("equal bitmaps do not differ") {
    const Bitmap image = gradient(20, 20);
    const BitmapDifference difference = compare_bitmaps(image, image);
    CHECK(difference.within_tolerance);
    CHECK(difference.unequal_pixels == 0);
    CHECK(difference.largest == 0);
}

TEST_CASE("a shifted bitmap is beyond the tolerance") {
    const Bitmap image = gradient(20, 20);
    CHECK_FALSE(compare_bitmaps(shifted(image), image).within_tolerance);
}

TEST_CASE("bitmaps of different size are beyond any tolerance") {
    const BitmapDifference difference =
        compare_bitmaps(gradient(20, 20), gradient(20, 21), {.ignore = 255, .channel = 255, .fraction = 1.0});
    CHECK_FALSE(difference.same_size);
    CHECK_FALSE(difference.within_tolerance);
}

TEST_CASE("bitmap tolerance: its limits are exact") {
    const Bitmap image = gradient(20, 20); // 0.5 % of its pixels are two pixels
    const auto with = [&](uint32_t pixels, int by) {
        Bitmap other = image;
        for (uint32_t i = 0; i < pixels; ++i) other.at(i, 1)[1] = static_cast<uint8_t>(other.at(i, 1)[1] + by);
        return compare_bitmaps(other, image);
    };
    CHECK(with(2, 3).within_tolerance);
    CHECK(with(2, 3).unequal_pixels == 2);
    CHECK_FALSE(with(3, 3).within_tolerance);
    CHECK_FALSE(with(2, 4).within_tolerance);
    CHECK(with(2, 4).largest == 4);
}

TEST_CASE("a golden check fails for a shifted, a resized and a missing picture") {
    if (std::getenv("BRITTLE_UPDATE_GOLDENS")) return; // the variable makes every check pass
    const Bitmap image = gradient(24, 16);
    const std::string folder = scratch("goldens");
    std::filesystem::create_directories(folder);
    REQUIRE(write_png(image, folder + "/known.png"));
    CHECK(check_golden(image, "known", {}, folder).passed);

    const GoldenCheck moved = check_golden(shifted(image), "known", {}, folder);
    CHECK_FALSE(moved.passed);
    for (const char* what : {"actual", "expected", "difference"}) {
        const std::string path = failure_folder() + "/known." + what + ".png";
        CHECK(moved.message.find(path) != std::string::npos);
        CHECK(read_png(path));
    }
    CHECK_FALSE(check_golden(gradient(24, 17), "known", {}, folder).passed);

    const GoldenCheck missing = check_golden(image, "unknown", {}, folder);
    CHECK_FALSE(missing.passed);
    CHECK(missing.message.find("tools/update-goldens") != std::string::npos);
    CHECK_FALSE(std::filesystem::exists(folder + "/unknown.png"));
}
