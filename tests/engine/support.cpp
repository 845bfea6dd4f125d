#include "support.h"

#include <algorithm>
#include <array>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <map>

#include <glm/geometric.hpp>
#include <glm/gtc/quaternion.hpp>

namespace brittle::engine::test {

std::unique_ptr<Device> make_device(FaultInjector* faults) {
    const char* select = std::getenv("BRITTLE_TEST_DEVICE");
    Result<std::unique_ptr<Device>> device =
        Device::create({.select = select ? select : "", .validation = true, .faults = faults});
    if (!device && device.error().status == Status::missing_feature) {
        std::printf("without validation: %s\n", device.error().message.c_str());
        device = Device::create({.select = select ? select : "", .faults = faults});
    }
    if (device) return *std::move(device);
    std::printf("skipped: %s\n", device.error().message.c_str());
    return nullptr;
}

Shape box(glm::vec3 half, uint32_t interior_faces) {
    Shape shape;
    for (uint32_t i = 0; i < 8; ++i)
        shape.positions.push_back(half * glm::vec3(i & 1 ? 1.0f : -1.0f, i & 2 ? 1.0f : -1.0f, i & 4 ? 1.0f : -1.0f));
    const std::array<std::array<uint32_t, 4>, 6> faces{{{0, 4, 6, 2}, // -x
                                                        {1, 3, 7, 5}, // +x
                                                        {0, 1, 5, 4}, // -y
                                                        {2, 6, 7, 3}, // +y
                                                        {0, 2, 3, 1}, // -z
                                                        {4, 5, 7, 6}}};
    for (const auto& [a, b, c, d] : faces) {
        shape.triangles.emplace_back(a, b, c);
        shape.triangles.emplace_back(a, c, d);
    }
    shape.exterior_triangles = 2 * (6 - interior_faces);
    return shape;
}

Shape icosphere(float radius, int levels) {
    Shape shape;
    const float g = 1.6180339887f;
    for (float a : {-1.0f, 1.0f})
        for (float b : {-g, g}) {
            shape.positions.emplace_back(0.0f, a, b);
            shape.positions.emplace_back(a, b, 0.0f);
            shape.positions.emplace_back(b, 0.0f, a);
        }
    // The faces are the twenty triples of vertices with mutual distance 2, the edge length, oriented outwards.
    const auto near = [&](uint32_t i, uint32_t j) {
        return glm::length(shape.positions[i] - shape.positions[j]) < 2.1f;
    };
    for (uint32_t i = 0; i < 12; ++i)
        for (uint32_t j = i + 1; j < 12; ++j)
            for (uint32_t k = j + 1; k < 12; ++k) {
                if (!near(i, j) || !near(j, k) || !near(k, i)) continue;
                const glm::vec3 a = shape.positions[i], b = shape.positions[j], c = shape.positions[k];
                const bool outwards = glm::dot(glm::cross(b - a, c - a), a + b + c) > 0.0f;
                shape.triangles.push_back(outwards ? glm::uvec3(i, j, k) : glm::uvec3(i, k, j));
            }
    for (int level = 0; level < levels; ++level) {
        std::map<std::pair<uint32_t, uint32_t>, uint32_t> middles;
        const auto middle = [&](uint32_t a, uint32_t b) {
            const auto [found, made] = middles.try_emplace(std::minmax(a, b), shape.positions.size());
            if (made) shape.positions.push_back((shape.positions[a] + shape.positions[b]) * 0.5f);
            return found->second;
        };
        std::vector<glm::uvec3> finer;
        for (const glm::uvec3& t : shape.triangles) {
            const uint32_t ab = middle(t.x, t.y), bc = middle(t.y, t.z), ca = middle(t.z, t.x);
            finer.insert(finer.end(), {{t.x, ab, ca}, {ab, t.y, bc}, {ca, bc, t.z}, {ab, bc, ca}});
        }
        for (glm::vec3& p : shape.positions) p = glm::normalize(p);
        shape.triangles = std::move(finer);
    }
    for (glm::vec3& p : shape.positions) p = glm::normalize(p) * radius;
    shape.exterior_triangles = static_cast<uint32_t>(shape.triangles.size());
    return shape;
}

KnownScene::KnownScene() {
    shapes_ = {box({0.5f, 0.3f, 0.4f}, 1), box({0.25f, 0.6f, 0.25f}, 4), icosphere(0.45f, 3), box({0.2f, 0.2f, 0.2f})};
    const glm::vec3 y(0.0f, 1.0f, 0.0f);
    poses = {{.rotation = glm::angleAxis(0.3f, y), .position = {-0.9f, 0.3f, 0.1f}},
             {.rotation = glm::angleAxis(-0.5f, y), .position = {0.1f, 0.6f, -0.5f}},
             {.position = {0.6f, 0.45f, 0.5f}},
             {.rotation = glm::angleAxis(0.7f, glm::normalize(glm::vec3(1.0f, 1.0f, 0.2f))),
              .position = {-0.75f, 1.0f, 0.15f}}};
    const std::array<glm::vec3, 4> corners{glm::vec3(-1.4f, 0.0f, 1.0f), glm::vec3(1.4f, 0.0f, 1.0f),
                                           glm::vec3(1.4f, 1.2f, -1.0f), glm::vec3(-1.4f, 1.2f, -1.0f)};
    for (size_t i = 0; i < corners.size(); ++i) {
        lines.push_back({corners[i]});
        lines.push_back({corners[(i + 1) % corners.size()]});
    }
    spheres = {{{-0.3f, 0.9f, 0.5f}, 0.06f}, {{0.6f, 0.45f, 0.5f}, 0.06f}, {{1.2f, 0.1f, 0.6f}, 0.1f}};

    scene.bounds = {{-1.5f, 0.0f, -1.0f}, {1.3f, 1.3f, 1.0f}};
    scene.camera = look_at_bounds(scene.bounds, 0.35f, 0.4f, 1.6f);
    scene.write_poses = [this](std::span<BodyPose> out, uint64_t) {
        std::copy_n(poses.begin(), std::min(poses.size(), out.size()), out.begin());
    };
    scene.lines = lines;
    scene.spheres = spheres;
}

std::vector<PieceMesh> KnownScene::pieces() const {
    std::vector<PieceMesh> all;
    for (uint32_t i = 0; i < shapes_.size(); ++i) all.push_back(shapes_[i].piece(i, piece_tint(i)));
    return all;
}

bool is_updating_goldens() {
    const char* const update = std::getenv("BRITTLE_UPDATE_GOLDENS");
    return update && std::string(update) == "1";
}

std::string golden_folder() {
    return BRITTLE_GOLDEN_FOLDER;
}

std::string failure_folder() {
    return BRITTLE_FAILURE_FOLDER;
}

namespace {

std::string failure_path(const std::string& name, const char* what) {
    return failure_folder() + "/" + name + "." + what + ".png";
}

// Writes a picture of a failed check. A failure to write it is appended to the message.
void keep(const Bitmap& picture, const std::string& path, std::string& message) {
    const Result<void> written = write_png(picture, path);
    message += "\n  " + (written ? path : written.error().message);
}

// Writes the golden unless it equals the picture byte for byte. The message has the difference and the paths.
GoldenCheck update_golden(const Bitmap& actual, const std::string& name, const std::string& path) {
    std::error_code ignored;
    std::filesystem::create_directories(failure_folder(), ignored);
    std::filesystem::create_directories(std::filesystem::path(path).parent_path(), ignored);
    const Result<Bitmap> before = read_png(path);
    std::string what = "new";
    if (before) {
        const BitmapDifference difference = compare_bitmaps(actual, *before, {.channel = 0, .fraction = 0.0});
        if (difference.within_tolerance) {
            std::printf("golden as before: %s\n", path.c_str());
            return {true, {}};
        }
        what = difference.same_size ? std::to_string(difference.unequal_pixels) + " pixels, by up to "
                                          + std::to_string(difference.largest) + " of 255"
                                    : "another size";
        keep(*before, failure_path(name, "before"), what);
        if (difference.same_size) keep(difference.picture, failure_path(name, "difference"), what);
    }
    const Result<void> written = write_png(actual, path);
    std::printf("golden CHANGED: %s: %s\n", path.c_str(), what.c_str());
    return {written.has_value(), written ? "" : written.error().message};
}

} // namespace

GoldenCheck check_golden(const Bitmap& actual, const std::string& name, const BitmapTolerance& tolerance,
                         const std::string& folder) {
    const std::string path = folder + "/" + name + ".png";
    if (is_updating_goldens()) return update_golden(actual, name, path);
    std::error_code ignored;
    std::filesystem::create_directories(failure_folder(), ignored);

    Result<Bitmap> expected = read_png(path);
    if (!expected) {
        GoldenCheck check{false, "no golden image to compare with: " + expected.error().message
                                     + "\n  Look at the picture, then run tools/update-goldens."};
        keep(actual, failure_path(name, "actual"), check.message);
        return check;
    }
    const BitmapDifference difference = compare_bitmaps(actual, *expected, tolerance);
    if (difference.within_tolerance) return {true, {}};

    GoldenCheck check;
    if (!difference.same_size)
        check.message = name + ": " + std::to_string(actual.width) + " x " + std::to_string(actual.height)
                        + " pixels, the golden has " + std::to_string(expected->width) + " x "
                        + std::to_string(expected->height);
    else
        check.message = name + ": " + std::to_string(difference.unequal_pixels) + " pixels differ, by up to "
                        + std::to_string(difference.largest) + " of 255";
    std::string driver;
    if (std::ifstream file(golden_folder() + "/driver.txt"); std::getline(file, driver))
        check.message += "; the goldens were made with " + driver;
    keep(actual, failure_path(name, "actual"), check.message);
    keep(*expected, failure_path(name, "expected"), check.message);
    if (difference.same_size) keep(difference.picture, failure_path(name, "difference"), check.message);
    return check;
}

uint32_t pixel(const Bitmap& bitmap, uint32_t x, uint32_t y) {
    const uint8_t* p = bitmap.at(x, y);
    return static_cast<uint32_t>(p[0]) << 16 | static_cast<uint32_t>(p[1]) << 8 | p[2];
}

} // namespace brittle::engine::test
