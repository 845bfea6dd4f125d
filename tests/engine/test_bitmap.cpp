#include <array>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <random>

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

namespace {

// Eight by eight pixels of one colour, about (200, 60, 30).
constexpr std::array<uint8_t, 287> small_jpeg = {
    0xff, 0xd8, 0xff, 0xe0, 0x00, 0x10, 0x4a, 0x46, 0x49, 0x46, 0x00, 0x01, 0x01, 0x00, 0x00, 0x01, 0x00, 0x01,
    0x00, 0x00, 0xff, 0xdb, 0x00, 0x43, 0x00, 0x10, 0x0b, 0x0c, 0x0e, 0x0c, 0x0a, 0x10, 0x0e, 0x0d, 0x0e, 0x12,
    0x11, 0x10, 0x13, 0x18, 0x28, 0x1a, 0x18, 0x16, 0x16, 0x18, 0x31, 0x23, 0x25, 0x1d, 0x28, 0x3a, 0x33, 0x3d,
    0x3c, 0x39, 0x33, 0x38, 0x37, 0x40, 0x48, 0x5c, 0x4e, 0x40, 0x44, 0x57, 0x45, 0x37, 0x38, 0x50, 0x6d, 0x51,
    0x57, 0x5f, 0x62, 0x67, 0x68, 0x67, 0x3e, 0x4d, 0x71, 0x79, 0x70, 0x64, 0x78, 0x5c, 0x65, 0x67, 0x63, 0xff,
    0xdb, 0x00, 0x43, 0x01, 0x11, 0x12, 0x12, 0x18, 0x15, 0x18, 0x2f, 0x1a, 0x1a, 0x2f, 0x63, 0x42, 0x38, 0x42,
    0x63, 0x63, 0x63, 0x63, 0x63, 0x63, 0x63, 0x63, 0x63, 0x63, 0x63, 0x63, 0x63, 0x63, 0x63, 0x63, 0x63, 0x63,
    0x63, 0x63, 0x63, 0x63, 0x63, 0x63, 0x63, 0x63, 0x63, 0x63, 0x63, 0x63, 0x63, 0x63, 0x63, 0x63, 0x63, 0x63,
    0x63, 0x63, 0x63, 0x63, 0x63, 0x63, 0x63, 0x63, 0x63, 0x63, 0x63, 0x63, 0x63, 0x63, 0xff, 0xc0, 0x00, 0x11,
    0x08, 0x00, 0x08, 0x00, 0x08, 0x03, 0x01, 0x22, 0x00, 0x02, 0x11, 0x01, 0x03, 0x11, 0x01, 0xff, 0xc4, 0x00,
    0x15, 0x00, 0x01, 0x01, 0x00, 0x00, 0x00, 0x00, 0x00, 0x00, 0x00, 0x00, 0x00, 0x00, 0x00, 0x00, 0x00, 0x00,
    0x00, 0x04, 0xff, 0xc4, 0x00, 0x14, 0x10, 0x01, 0x00, 0x00, 0x00, 0x00, 0x00, 0x00, 0x00, 0x00, 0x00, 0x00,
    0x00, 0x00, 0x00, 0x00, 0x00, 0x00, 0xff, 0xc4, 0x00, 0x15, 0x01, 0x01, 0x01, 0x00, 0x00, 0x00, 0x00, 0x00,
    0x00, 0x00, 0x00, 0x00, 0x00, 0x00, 0x00, 0x00, 0x00, 0x05, 0x06, 0xff, 0xc4, 0x00, 0x14, 0x11, 0x01, 0x00,
    0x00, 0x00, 0x00, 0x00, 0x00, 0x00, 0x00, 0x00, 0x00, 0x00, 0x00, 0x00, 0x00, 0x00, 0x00, 0xff, 0xda, 0x00,
    0x0c, 0x03, 0x01, 0x00, 0x02, 0x11, 0x03, 0x11, 0x00, 0x3f, 0x00, 0x80, 0x01, 0xaa, 0x27, 0xff, 0xd9,
};

constexpr uint64_t million = 1'000'000;

std::vector<std::byte> png_of(const Bitmap& image) {
    const std::string path = scratch("encoded.png");
    REQUIRE(write_png(image, path));
    std::ifstream file(path, std::ios::binary);
    const std::string bytes((std::istreambuf_iterator<char>(file)), {});
    const auto* begin = reinterpret_cast<const std::byte*>(bytes.data());
    return {begin, begin + bytes.size()};
}

void put_big_endian(std::vector<std::byte>& bytes, size_t at, uint32_t value) {
    for (size_t k = 0; k < 4; ++k) bytes[at + k] = static_cast<std::byte>(value >> (24 - 8 * k));
}

} // namespace

TEST_CASE("decode_image: nothing, other data and formats that are not shown") {
    CHECK_FALSE(decode_image({}, million));
    for (const std::string text : {"P", "not an image", "GIF89a\x01\0\x01\0", "BM......................"}) {
        const auto decoded = decode_image(std::as_bytes(std::span(text)), million);
        REQUIRE_FALSE(decoded);
        CHECK(decoded.error().status == Status::invalid_argument);
        CHECK(decoded.error().message.find("neither a PNG nor a JPEG") != std::string::npos);
    }
}

TEST_CASE("decode_image: PNG and JPEG") {
    const Bitmap image = gradient(13, 7);
    const auto png = decode_image(png_of(image), 13 * 7);
    REQUIRE(png);
    CHECK(png->width == 13);
    CHECK(png->height == 7);
    CHECK(png->pixels == image.pixels);
    const auto jpeg = decode_image(std::as_bytes(std::span(small_jpeg)), million);
    REQUIRE(jpeg);
    CHECK(jpeg->width == 8);
    CHECK(jpeg->height == 8);
    for (uint32_t i = 0; i < 64; ++i) {
        CHECK(std::abs(jpeg->pixels[4 * i] - 200) < 12);
        CHECK(std::abs(jpeg->pixels[4 * i + 1] - 60) < 12);
        CHECK(std::abs(jpeg->pixels[4 * i + 2] - 30) < 12);
        CHECK(jpeg->pixels[4 * i + 3] == 255);
    }
}

TEST_CASE("decode_image: an image of too many pixels is refused before it takes memory") {
    std::vector<std::byte> bytes = png_of(gradient(13, 7));
    const auto refused = decode_image(bytes, 13 * 7 - 1);
    REQUIRE_FALSE(refused);
    CHECK(refused.error().message.find("13 x 7 pixels") != std::string::npos);
    put_big_endian(bytes, 16, 9000); // width and height in the header
    put_big_endian(bytes, 20, 9000);
    const auto huge = decode_image(bytes, uint64_t{8192} * 8192);
    REQUIRE_FALSE(huge);
    CHECK(huge.error().message.find("9000 x 9000") != std::string::npos);
    for (const uint32_t side : {1'000'000u, 0x7fffffffu, 0xffffffffu}) {
        put_big_endian(bytes, 16, side);
        put_big_endian(bytes, 20, side);
        CHECK_FALSE(decode_image(bytes, ~uint64_t{0}));
    }
}

TEST_CASE("decode_image: images that are cut short or damaged give an image or a message") {
    const std::vector<std::byte> png = png_of(gradient(13, 7));
    const std::span<const std::byte> jpeg = std::as_bytes(std::span(small_jpeg));
    for (const std::span<const std::byte> whole : {std::span<const std::byte>(png), jpeg})
        for (size_t length = 0; length < whole.size(); ++length) {
            const auto decoded = decode_image(whole.first(length), million);
            if (decoded)
                CHECK(decoded->pixels.size() == size_t{4} * decoded->width * decoded->height);
            else
                CHECK_FALSE(decoded.error().message.empty());
        }
    CHECK_FALSE(decode_image(std::span(png).first(60), million));
    std::mt19937 random(1);
    for (int round = 0; round < 2000; ++round) {
        const std::span<const std::byte> whole = round % 2 ? std::span<const std::byte>(png) : jpeg;
        std::vector<std::byte> bytes(whole.begin(), whole.end());
        for (uint32_t k = 1 + random() % 4; k > 0; --k)
            bytes[random() % bytes.size()] = static_cast<std::byte>(random());
        const auto decoded = decode_image(bytes, million);
        if (decoded) CHECK(decoded->pixels.size() == size_t{4} * decoded->width * decoded->height);
    }
}
