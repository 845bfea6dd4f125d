#include "tools/bench/scene_steps.h"

#include <chrono>
#include <cmath>
#include <functional>
#include <string>
#include <vector>

#include <benchmark/benchmark.h>

#include "tools/bench/samples.h"
#include "tools/bench/scenes.h"

namespace brittle::tools {

namespace {

using Drive = std::function<void(physics::World&)>; // before each step

void run_scene(benchmark::State& state, const Scene& scene, double seconds, const Drive& drive) {
    std::vector<std::vector<double>> runs;
    size_t contacts = 0;
    for (auto _ : state) {
        physics::World world(scene.settings);
        if (!world.add_bodies(scene.bodies)) return state.SkipWithError("no bodies");
        std::vector<double>& times = runs.emplace_back();
        for (long step = std::lround(seconds / static_cast<double>(scene.settings.step)); step > 0; --step) {
            const auto start = std::chrono::steady_clock::now();
            if (drive) drive(world);
            world.step();
            times.push_back(
                std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - start).count());
        }
        contacts = world.contact_count();
        state.SetIterationTime(median(times) * 1e-3);
    }
    const std::vector<double> steps = by_step(runs, median);
    state.counters["bodies"] = static_cast<double>(scene.bodies.size());
    state.counters["contacts"] = static_cast<double>(contacts);
    state.counters["median"] = median(steps);
    state.counters["p95"] = percentile_95(steps);
    state.counters["longest"] = longest(steps);
}

} // namespace

void add_scene_benchmarks() {
    const auto add = [](const std::string& name, int runs, double seconds, const std::function<Scene()>& make,
                        const Drive& drive = {}) {
        benchmark::RegisterBenchmark(("scene/" + name).c_str(),
                                     [=](benchmark::State& state) { run_scene(state, make(), seconds, drive); })
            ->Unit(benchmark::kMillisecond)
            ->UseManualTime()
            ->Iterations(runs);
    };
    add("pyramid", 3, 3.0, [] { return pyramid(50, 0.5); });
    add("dominoes", 5, 3.0, [] { return dominoes({.count = 200}); });
    add("cards", 5, 3.0, [] { return card_house(4); });
    add("convex_pile", 3, 5.0, convex_pile);
    add("junkyard", 3, 5.0, junkyard, [](physics::World& world) { stir(world, world.bodies().back()); });
    add("pyramids", 3, 5.0, many_pyramids);
}

} // namespace brittle::tools
