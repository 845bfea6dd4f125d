#include "engine/core/bitmap.h"

#include <algorithm>
#include <array>
#include <cerrno>
#include <climits>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <memory>

#include <stb_image.h>
#include <stb_image_write.h>

namespace brittle::engine {

namespace {

Error file_error(const std::string& doing, const std::string& path, const std::string& why) {
    return {Status::file_error, doing + " " + path + ": " + why};
}

} // namespace

Result<void> write_png(const Bitmap& image, const std::string& path) {
    if (image.width == 0 || image.height == 0 || image.width > INT_MAX / 4 || image.height > INT_MAX
        || image.pixels.size() != size_t{4} * image.width * image.height)
        return Error{Status::invalid_argument,
                     "cannot write " + path + ": the picture is empty, or its pixels do not match its size"};

    std::vector<uint8_t> png;
    const auto append = [](void* context, void* data, int size) {
        auto& out = *static_cast<std::vector<uint8_t>*>(context);
        const auto* bytes = static_cast<const uint8_t*>(data);
        out.insert(out.end(), bytes, bytes + size);
    };
    if (!stbi_write_png_to_func(append, &png, static_cast<int>(image.width), static_cast<int>(image.height), 4,
                                image.pixels.data(), static_cast<int>(image.width) * 4))
        return Error{Status::out_of_memory, "cannot encode " + path + " as PNG"};

    const std::string temporary = path + ".part";
    std::ofstream file(temporary, std::ios::binary | std::ios::trunc);
    if (!file) return file_error("cannot create", temporary, std::strerror(errno));
    file.write(reinterpret_cast<const char*>(png.data()), static_cast<std::streamsize>(png.size()));
    file.close();
    std::error_code error;
    if (file) std::filesystem::rename(temporary, path, error);
    if (!file || error) {
        const std::string why = error ? error.message() : "the disk is full or not writable";
        std::filesystem::remove(temporary, error);
        return file_error("cannot write", path, why);
    }
    return {};
}

Result<Bitmap> read_png(const std::string& path) {
    std::error_code error;
    const uintmax_t size = std::filesystem::file_size(path, error);
    if (error) return file_error("cannot open", path, error.message());
    if (size > INT_MAX) return file_error("cannot read", path, "the file is too large for a picture");
    std::vector<char> bytes(size);
    std::ifstream file(path, std::ios::binary);
    if (!file.read(bytes.data(), static_cast<std::streamsize>(size)))
        return file_error("cannot read", path, std::strerror(errno));

    int width = 0, height = 0, channels = 0;
    const std::unique_ptr<stbi_uc, void (*)(void*)> pixels(
        stbi_load_from_memory(reinterpret_cast<const stbi_uc*>(bytes.data()), static_cast<int>(bytes.size()), &width,
                              &height, &channels, 4),
        stbi_image_free);
    if (!pixels) return file_error("cannot read", path, "the file is damaged or not a PNG");
    Bitmap image{static_cast<uint32_t>(width), static_cast<uint32_t>(height), {}};
    image.pixels.assign(pixels.get(), pixels.get() + size_t{4} * image.width * image.height);
    return image;
}

Result<Bitmap> decode_image(std::span<const std::byte> bytes, uint64_t max_pixels) {
    // stb reads other formats, too, whose readers have had more faults.
    constexpr std::array<uint8_t, 8> png = {0x89, 'P', 'N', 'G', '\r', '\n', 0x1a, '\n'};
    constexpr std::array<uint8_t, 3> jpeg = {0xff, 0xd8, 0xff};
    const auto begins_with = [&](std::span<const uint8_t> start) {
        return bytes.size() >= start.size() && std::memcmp(bytes.data(), start.data(), start.size()) == 0;
    };
    if (!begins_with(png) && !begins_with(jpeg))
        return Error{Status::invalid_argument, "it is neither a PNG nor a JPEG image"};
    if (bytes.size() > INT_MAX) return Error{Status::invalid_argument, "its file is larger than 2 GiB"};
    const auto* data = reinterpret_cast<const stbi_uc*>(bytes.data());
    const int size = static_cast<int>(bytes.size());
    // A reason of two or three words, such as "too large".
    const auto undecoded = [] {
        const char* reason = stbi_failure_reason();
        return Error{Status::invalid_argument, std::string("it is damaged or too large to decode")
                                                   + (reason ? std::string(" (") + reason + ")" : "")};
    };
    int width = 0, height = 0, channels = 0;
    if (!stbi_info_from_memory(data, size, &width, &height, &channels) || width <= 0 || height <= 0) return undecoded();
    const uint64_t pixels = uint64_t{static_cast<uint32_t>(width)} * static_cast<uint32_t>(height);
    if (pixels > max_pixels)
        return Error{Status::invalid_argument, "it has " + std::to_string(width) + " x " + std::to_string(height)
                                                   + " pixels, and at most " + std::to_string(max_pixels)
                                                   + " are decoded; make it smaller"};
    const std::unique_ptr<stbi_uc, void (*)(void*)> decoded(
        stbi_load_from_memory(data, size, &width, &height, &channels, 4), stbi_image_free);
    if (!decoded || uint64_t{static_cast<uint32_t>(width)} * static_cast<uint32_t>(height) != pixels)
        return undecoded();
    Bitmap image{static_cast<uint32_t>(width), static_cast<uint32_t>(height), {}};
    image.pixels.assign(decoded.get(), decoded.get() + 4 * pixels);
    return image;
}

BitmapDifference compare_bitmaps(const Bitmap& actual, const Bitmap& expected, const BitmapTolerance& tolerance) {
    BitmapDifference result;
    result.same_size = actual.width == expected.width && actual.height == expected.height
                       && actual.pixels.size() == expected.pixels.size();
    if (!result.same_size) return result;

    const size_t count = size_t{actual.width} * actual.height;
    result.picture = {actual.width, actual.height, std::vector<uint8_t>(4 * count)};
    for (size_t i = 0; i < count; ++i) {
        int worst = 0;
        for (size_t c = 0; c < 4; ++c)
            worst = std::max(worst, std::abs(actual.pixels[4 * i + c] - expected.pixels[4 * i + c]));
        result.largest = std::max(result.largest, worst);
        if (worst > tolerance.ignore) ++result.unequal_pixels;
        // A steep colour ramp: a difference of 1 is visible, one of 10 is bright.
        uint8_t* out = &result.picture.pixels[4 * i];
        out[0] = static_cast<uint8_t>(std::min(255, worst * 48));
        out[1] = static_cast<uint8_t>(std::clamp((worst - 4) * 24, 0, 255));
        out[2] = static_cast<uint8_t>(std::clamp((worst - 10) * 6, 0, 255));
        out[3] = 255;
    }
    result.within_tolerance =
        result.largest <= tolerance.channel
        && static_cast<double>(result.unequal_pixels) <= tolerance.fraction * static_cast<double>(count);
    return result;
}

} // namespace brittle::engine
