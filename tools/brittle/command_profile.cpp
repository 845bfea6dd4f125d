#include <cstdio>
#include <fstream>
#include <span>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include <nlohmann/json.hpp>

#include "engine/compute/gpu_classifier.h"
#include "fracture/io/atomic_file.h"
#include "tools/brittle/commands.h"
#include "tools/brittle/failure.h"
#include "tools/brittle/interrupt.h"
#include "tools/brittle/progress.h"
#include "tools/brittle/recipe.h"
#include "tools/brittle/stage.h"
#include "tools/brittle/statistics.h"
#include "tools/brittle/stopwatch.h"
#include "tools/brittle/view.h"

namespace brittle::tools {

namespace {

constexpr double frame_seconds = 1.0 / 60.0;

// Named series of milliseconds, in the order in which the names first came up.
class Series {
  public:
    void add(const std::string& name, double milliseconds) {
        for (auto& [known, samples] : series_) {
            if (known == name) return samples.push_back(milliseconds);
        }
        series_.push_back({name, {milliseconds}});
    }

    [[nodiscard]] nlohmann::ordered_json json() const {
        nlohmann::ordered_json out;
        for (const auto& [name, samples] : series_) {
            const Statistics s = statistics(samples);
            out[name] = {{"median", s.median}, {"p95", s.p95}, {"max", s.max}, {"samples", samples.size()}};
        }
        return out;
    }

  private:
    std::vector<std::pair<std::string, std::vector<double>>> series_;
};

// One frame as the demo makes it: physics, then draw and read back.
void measure_frame(Series& series, Stage& stage, engine::Renderer& renderer, const engine::Camera& camera,
                   const ViewOptions& view) {
    const Stopwatch frame;
    const Stopwatch physics;
    throw_if_interrupted();
    stage.advance(frame_seconds);
    const double physics_milliseconds = physics.milliseconds();
    engine::Scene scene = stage.scene();
    scene.camera = camera;
    (void)must(renderer.render(scene, {view.width, view.height}));
    series.add("frame", frame.milliseconds());
    series.add("physics", physics_milliseconds);
    for (const engine::PassTime& pass : renderer.timings()) series.add("pass " + pass.name, pass.milliseconds);
}

nlohmann::ordered_json profile_fracture(const ProfileCommand& command, const Input& input,
                                        fracture::Certificate& certificate) {
    Series series;
    std::unique_ptr<engine::Device> device;
    std::unique_ptr<engine::GpuClassifier> classifier;
    if (command.classify_on_device) {
        device = open_device(command.view);
        classifier = must(engine::GpuClassifier::create(*device));
    }
    Progress progress("fracturing " + input.name);
    for (uint32_t repeat = 0; repeat <= command.repeats; ++repeat) {
        const Broken broken = break_input(input, command.fracture, {}, classifier.get());
        if (classifier && !classifier->error().empty()) throw Failure(exit_environment, classifier->error());
        certificate = broken.certificate;
        progress.update(static_cast<double>(repeat + 1) / (command.repeats + 1));
        if (repeat == 0) continue; // warm-up
        for (const fracture::Milliseconds& t : broken.fragments.timings) series.add(t.phase, t.milliseconds);
        series.add("total", broken.milliseconds);
        if (!classifier) continue;
        for (const engine::PassTime& pass : classifier->timings()) series.add("pass " + pass.name, pass.milliseconds);
    }
    if (device) check_validation(*device);
    return series.json();
}

nlohmann::ordered_json profile_frames(const ProfileCommand& command, const Input& input, std::string& device_name) {
    const std::unique_ptr<engine::Device> device = open_device(command.view);
    device_name = device->info().name + ", " + device->info().driver;
    const auto renderer = must(engine::Renderer::create(*device));
    Stage stage(*renderer, input.model.mesh, command.fracture.material);
    const float aspect = static_cast<float>(command.view.width) / static_cast<float>(command.view.height);
    const engine::Camera camera = engine::look_at_bounds(stage_view(stage.home_bounds()), 0.55f, 0.3f, aspect);

    Progress progress("rendering");
    Series whole;
    Series falling;
    Series commit;
    must(renderer->warm_up());
    for (uint32_t frame = 0; frame <= command.frames; ++frame) {
        Series warm_up;
        measure_frame(frame == 0 ? warm_up : whole, stage, *renderer, camera, command.view);
        progress.update(0.5 * frame / command.frames);
    }
    const Broken broken = break_input(input, command.fracture);
    const Stopwatch stopwatch;
    stage.shatter(broken.fragments);
    commit.add("bodies and upload", stopwatch.milliseconds());
    measure_frame(commit, stage, *renderer, camera, command.view);
    for (uint32_t frame = 0; frame < command.frames; ++frame) {
        measure_frame(falling, stage, *renderer, camera, command.view);
        progress.update(0.5 + 0.5 * frame / command.frames);
    }
    check_validation(*device);
    return {{"whole", whole.json()}, {"first after the fracture", commit.json()}, {"falling", falling.json()}};
}

std::string processor_name() {
    std::ifstream file("/proc/cpuinfo");
    for (std::string line; std::getline(file, line);) {
        if (line.starts_with("model name")) return line.substr(line.find(':') + 2);
    }
    return "unknown processor";
}

void print_rows(const char* title, const nlohmann::ordered_json& rows) {
    std::printf("\n%-36s %10s %10s %10s\n", title, "median", "p95", "max");
    for (const auto& [name, s] : rows.items()) {
        std::printf("  %-34s %10.2f %10.2f %10.2f\n", name.c_str(), s["median"].get<double>(), s["p95"].get<double>(),
                    s["max"].get<double>());
    }
}

void print_table(const nlohmann::ordered_json& profile) {
    std::printf("%s: %zu triangles, %zu sites, %u pieces, %s\n", profile["mesh"].get<std::string>().c_str(),
                profile["triangles"].get<size_t>(), profile["sites"].get<size_t>(), profile["pieces"].get<unsigned>(),
                profile["closed"].get<bool>() ? "all closed" : "NOT ALL CLOSED");
    std::printf("%s, %u hardware threads; milliseconds\n", profile["machine"]["processor"].get<std::string>().c_str(),
                profile["machine"]["hardware_threads"].get<unsigned>());
    print_rows("fracture", profile["fracture"]);
    if (!profile.contains("frames")) return;
    std::printf("\nframes of %s on %s\n", profile["size"].get<std::string>().c_str(),
                profile["machine"]["device"].get<std::string>().c_str());
    for (const auto& [name, rows] : profile["frames"].items()) print_rows(name.c_str(), rows);
}

} // namespace

int run_profile(const ProfileCommand& command) {
    catch_interrupts();
    const Input input = placed_on_stage(load_input(command.fracture));
    fracture::Certificate certificate;
    nlohmann::ordered_json profile{{"mesh", input.name},
                                   {"triangles", input.model.mesh.triangles.size()},
                                   {"sites", input.sites.size()},
                                   {"size", std::to_string(command.view.width) + "x" +
                                                std::to_string(command.view.height)},
                                   {"recipe", nlohmann::ordered_json::parse(recipe_json(command.fracture))},
                                   {"machine",
                                    {{"processor", processor_name()},
                                     {"hardware_threads", std::thread::hardware_concurrency()},
                                     {"threads", command.fracture.threads}}},
                                   {"classify", command.classify_on_device ? "gpu" : "cpu"}};
    profile["fracture"] = profile_fracture(command, input, certificate);
    profile["pieces"] = certificate.pieces;
    profile["closed"] = certificate.closed;
    if (command.frames > 0) {
        std::string device;
        profile["frames"] = profile_frames(command, input, device);
        profile["machine"]["device"] = device;
    }
    const std::string json = profile.dump(2) + "\n";
    if (!command.output.empty()) {
        must(fracture::write_file_atomically(command.output, std::as_bytes(std::span(json))));
    }
    if (command.json) {
        std::fputs(json.c_str(), stdout);
    } else {
        print_table(profile);
    }
    return exit_success;
}

} // namespace brittle::tools
