// Pictures of a known scene, compared with those in tests/images. tools/update-goldens rewrites them; inspect them
// afterwards.

#include <cmath>
#include <fstream>
#include <vector>

#include <doctest/doctest.h>
#include <glm/geometric.hpp>
#include <glm/gtc/quaternion.hpp>

#include "renderer_fixture.h"

using namespace brittle::engine;
using namespace brittle::engine::test;

namespace {

constexpr glm::uvec2 size{480, 300};

// The CPU driver that made the goldens reproduces them byte for byte; GPUs round differently.
BitmapTolerance tolerance_of(const Device& device) {
    return device.is_cpu() ? BitmapTolerance{} : BitmapTolerance{.ignore = 3, .channel = 255, .fraction = 0.02};
}

// Quality is fixed, so that all devices draw one picture.
void check_picture(const char* name, const Quality& quality, const std::function<void(Scene&)>& change,
                   std::span<const float> fades = {}) {
    const Fixture f(quality);
    if (!f) return;
    KnownScene known;
    change(known.scene);
    const auto handles = f.renderer->set_pieces(known.pieces());
    REQUIRE(handles);
    for (size_t i = 0; i < fades.size(); ++i) REQUIRE(f.renderer->fade_pieces({&(*handles)[i], 1}, fades[i]));
    const GoldenCheck check = check_golden(f.draw(known.scene, size), name, tolerance_of(*f.device), golden_folder());
    CHECK_MESSAGE(check.passed, check.message);
}

constexpr Quality plain{.shadow_size = 1024, .soft_shadows = false, .samples = 1, .ambient_occlusion = false};

Quality soft_shadows() {
    Quality quality = plain;
    quality.soft_shadows = true;
    return quality;
}

Quality four_samples() {
    Quality quality = plain;
    quality.samples = 4;
    return quality;
}

// The default quality of a GPU.
constexpr Quality best{.shadow_size = 2048, .soft_shadows = true, .samples = 4, .ambient_occlusion = true};

} // namespace

TEST_CASE("goldens: the driver that made them is recorded beside them") {
    const std::unique_ptr<Device> device = make_device();
    if (!device) return;
    const std::string path = golden_folder() + "/driver.txt";
    if (is_updating_goldens()) std::ofstream(path) << device->info().name << ", " << device->info().driver << "\n";
    std::ifstream file(path);
    std::string line;
    REQUIRE(std::getline(file, line));
    CHECK(line.find("LLVM") != std::string::npos); // lavapipe's name contains its version of LLVM
}

TEST_CASE("goldens: the known scene") {
    check_picture("known_scene", plain, [](Scene&) {});
}

TEST_CASE("goldens: marks on top of the known scene") {
    check_picture("marks_on_top", plain, [](Scene& scene) {
        scene.lines_on_top = true;
        scene.spheres_on_top = true;
    });
}

TEST_CASE("goldens: soft shadows") {
    check_picture("soft_shadows", soft_shadows(), [](Scene& scene) {
        scene.lines = {};
        scene.spheres = {};
    });
}

TEST_CASE("goldens: four samples a pixel") {
    check_picture("four_samples", four_samples(), [](Scene&) {});
}

TEST_CASE("goldens: the known scene at the best quality") {
    check_picture("best_quality", best, [](Scene& scene) {
        scene.lines = {};
        scene.spheres = {};
    });
}

TEST_CASE("goldens: fading pieces") {
    const float fades[] = {0.25f, 0.5f, 0.75f, 0.0f};
    const auto no_marks = [](Scene& scene) {
        scene.lines = {};
        scene.spheres = {};
    };
    check_picture("fading", plain, no_marks, fades);
    check_picture("fading_best_quality", best, no_marks, fades);
}

TEST_CASE("goldens: smooth shading and the wireframe") {
    check_picture("smooth", plain, [](Scene& scene) { scene.smooth = true; });
    check_picture("wireframe", four_samples(), [](Scene& scene) { scene.wireframe = true; });
}

TEST_CASE("goldens: dust and splinters") {
    std::vector<DustPuff> dust;
    std::vector<Splinter> splinters;
    for (uint32_t k = 0; k < 24; ++k) {
        const auto turn = 0.7f * static_cast<float>(k), out = 0.25f + 0.05f * static_cast<float>(k);
        const glm::vec3 at(out * std::cos(turn), 0.15f + 0.03f * static_cast<float>(k % 5), out * std::sin(turn));
        dust.push_back({.centre = at,
                        .radius = 0.16f + 0.016f * static_cast<float>(k % 9),
                        .colour = {0.42f, 0.30f, 0.22f},
                        .opacity = 0.7f,
                        .pattern = k});
        splinters.push_back({.rotation = glm::angleAxis(turn, glm::normalize(glm::vec3(1.0f, 0.4f, 0.2f))),
                             .centre = 1.2f * at,
                             .length = 0.03f + 0.003f * static_cast<float>(k),
                             .colour = {0.5f, 0.42f, 0.33f},
                             .width = 0.15f + 0.03f * static_cast<float>(k % 12)});
    }
    const auto add = [&](Scene& scene) {
        scene.dust = dust;
        scene.splinters = splinters;
    };
    check_picture("dust_and_splinters", plain, add);
    check_picture("dust_and_splinters_best_quality", best, add);
}
