#include "tools/bench/world.h"

#include <algorithm>
#include <chrono>
#include <functional>
#include <numeric>
#include <optional>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include <benchmark/benchmark.h>

#include "fracture/fracture.h"
#include "fracture/shapes/shapes.h"
#include "fracture/sites/sites.h"
#include "physics/bonds/anchor.h"
#include "physics/bonds/structure.h"
#include "physics/material.h"
#include "tools/bench/broken_bunny.h"
#include "tools/bench/samples.h"

namespace brittle::tools {

namespace {

using namespace brittle::fracture;
using namespace brittle::physics;

// With few runs, some frame is disturbed in all of them, and the longest of the frames' least times is that frame.
constexpr int runs_of_add = 40;
constexpr float little_bunny = 0.15f; // m; a thousand pieces of it are debris by the world's default

double milliseconds_of(const auto& body) {
    const auto start = std::chrono::steady_clock::now();
    body();
    return std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - start).count();
}

std::vector<double> steps_of(
    World& world, int count, const std::function<void()>& after_step = [] {}) {
    std::vector<double> steps;
    for (int step = 0; step < count; ++step)
        steps.push_back(milliseconds_of([&] {
            world.step();
            after_step();
        }));
    return steps;
}

// The steps of the first second and a half: the fall of 30 cm, the impact and the spreading.
void run_drop(benchmark::State& state, uint32_t sites, const WorldSettings& settings, bool among_sleepers) {
    const BrokenBunny broken(sites);
    std::vector<double> medians, first, fall, impact, heap, most;
    double add = 0.0;
    size_t asleep = 0, awake = 0;
    for (auto _ : state) {
        World world(settings);
        asleep = among_sleepers ? add_sleepers(world) : 0;
        bool added = false;
        add = milliseconds_of([&] { added = broken.add_to(world, {0.0f, 0.3f, 0.0f}); });
        if (!added) return state.SkipWithError("no bodies");
        const std::vector<double> steps = steps_of(world, 180);
        const auto part = [&](int from, int to) {
            return median(std::vector<double>(steps.begin() + from, steps.begin() + to));
        };
        medians.push_back(median(steps));
        first.push_back(steps.front());
        fall.push_back(part(1, 30));
        impact.push_back(part(30, 90));
        heap.push_back(part(90, 180));
        most.push_back(longest(std::span(steps).subspan(1)));
        awake = world.awake_count();
        state.SetIterationTime(medians.back() * 1e-3);
    }
    state.counters["pieces"] = static_cast<double>(broken.pieces.pieces.size());
    state.counters["asleep"] = static_cast<double>(asleep);
    state.counters["awake"] = static_cast<double>(awake);
    state.counters["steps_a_second"] = 1e3 / median(medians);
    state.counters["low"] = *std::ranges::min_element(medians);
    state.counters["high"] = longest(medians);
    state.counters["first"] = median(first);
    state.counters["fall"] = median(fall);
    state.counters["impact"] = median(impact);
    state.counters["heap"] = median(heap);
    state.counters["most"] = median(most);
    state.counters["forms"] = broken.form_milliseconds;
    state.counters["add"] = add;
}

// Pieces that are added at once, before a step.
struct Loose {
    BrokenBunny broken;
    glm::vec3 at;
    [[nodiscard]] bool prepare(World&) const { return true; }
    [[nodiscard]] bool come(World& world) const { return broken.add_to(world, at); }
    void after_step(World&) const {}
    [[nodiscard]] bool all_there() const { return true; }
};

// Bonded pieces, held in the air by one of them, whose bonds all break before a step; they separate after it.
struct Apart {
    BrokenBunny broken;
    glm::vec3 at;
    PieceHulls hulls = collision_hulls(broken.pieces);
    std::optional<Structure> structure{};
    [[nodiscard]] bool prepare(World& world) {
        StructureDesc desc{.motion = {.placement = {at, {1.0f, 0.0f, 0.0f, 0.0f}}}, .hulls = hulls, .anchored = {0}};
        desc.wear.enabled = false;
        Result<Structure> made = Structure::create(world, broken.pieces, desc);
        if (made) structure = std::move(*made);
        return made.has_value();
    }
    [[nodiscard]] bool come(World&) {
        std::vector<uint32_t> bonds(structure->graph().bonds().size());
        std::iota(bonds.begin(), bonds.end(), 0u);
        structure->break_bonds(bonds);
        return true;
    }
    void after_step(World& world) { (void)structure->update(world); }
    [[nodiscard]] bool all_there() const { return structure->bodies().size() == structure->piece_count(); }
};

// Adds a thousand pieces in one frame, and runs the same without them. Every run has the same steps, so the least time
// of a step over the runs is its own: other work on the machine only adds to it. Medians, and single frames above all,
// include that other work.
template<class Newcomers>
void run_add(benchmark::State& state, const WorldSettings& settings, Newcomers newcomers) {
    const BrokenBunny there(sites_for_1000);
    std::vector<std::vector<double>> before, after, without;
    size_t asleep = 0, colliding = 0;
    bool added = true;
    const auto run = [&](bool come, std::vector<std::vector<double>>& frames) {
        World world(settings);
        asleep = add_sleepers(world);
        added = added && newcomers.prepare(world) && there.add_to(world, {0.0f, 0.3f, 0.0f});
        if (!added) return;
        const auto frames_of = [&](int count) { return steps_of(world, count, [&] { newcomers.after_step(world); }); };
        frames_of(60);
        before.push_back(frames_of(30));
        const double adding = milliseconds_of([&] { added = added && (!come || newcomers.come(world)); });
        frames.push_back(frames_of(1));
        frames.back().front() += adding;
        colliding = world.colliding_count();
        const std::vector<double> later = frames_of(119);
        frames.back().insert(frames.back().end(), later.begin(), later.end());
        added = added && (!come || newcomers.all_there());
    };
    std::vector<double> single, single_without; // by run
    for (auto _ : state) {
        run(false, without);
        run(true, after);
        if (!added) return state.SkipWithError("no bodies");
        state.SetIterationTime(longest(after.back()) * 1e-3);
        single.push_back(longest(after.back()) / median(before.back()));
        single_without.push_back(longest(without.back()) / median(before[before.size() - 2]));
    }
    const auto ratio = [&](std::span<const std::vector<double>> runs, const auto& statistic) {
        return longest(by_step(runs, statistic)) / median(by_step(before, statistic));
    };
    const std::vector<double> frames = by_step(after, least);
    state.counters["coming_pieces"] = static_cast<double>(newcomers.broken.pieces.pieces.size());
    state.counters["asleep"] = static_cast<double>(asleep);
    state.counters["colliding"] = static_cast<double>(colliding);
    state.counters["before"] = median(by_step(before, least));
    state.counters["first"] = frames.front();
    state.counters["longest"] = longest(frames);
    state.counters["after"] = median(frames);
    state.counters["ratio"] = ratio(after, least);
    state.counters["ratio_of_medians"] = ratio(after, median);
    state.counters["ratio_of_single_frames"] = median(single);
    state.counters["ratio_without"] = ratio(without, least);
    state.counters["ratio_of_medians_without"] = ratio(without, median);
    state.counters["ratio_of_single_frames_without"] = median(single_without);
}

// The scene tower_collapses.json without the program: half a second of rest, then five steel balls into the foot, and
// two seconds.
void run_tower(benchmark::State& state) {
    const Result<SiteList> sites = read_sites(BRITTLE_ASSETS "/sites/tower_bricks.txt");
    if (!sites) return state.SkipWithError("no sites");
    const TriangleMesh mesh = fracture::tower();
    const auto pieces = fracture::fracture(mesh, sites->sites);
    const physics::Material material =
        physics::scale_strength(material_preset("stone")->material, physics::flawed_strength); // as in the program
    const TriangleMesh ball = icosphere(1, 0.17);
    BodyDesc shot{.hull = collision_hull(ball.positions, glm::dvec3(0.0), {.max_vertices = 64}), .mass = 160.5f};
    shot.inertia = glm::mat3(0.4f * shot.mass * 0.17f * 0.17f);
    for (auto _ : state) {
        World world({.max_colliding = 1000}); // as in the scene
        auto tower = Structure::create(world, *pieces, {.material = material, .anchored = anchor_to_ground(*pieces)});
        if (!tower) return state.SkipWithError("no bodies");
        std::vector<double> unhit, hit;
        const auto run = [&](int steps, std::vector<double>& into) {
            for (int step = 0; step < steps; ++step)
                into.push_back(milliseconds_of([&] {
                    world.step();
                    tower->update(world);
                }));
        };
        run(60, unhit);
        for (const float aside : {0.0f, 0.22f, -0.22f, 0.44f, 0.0f}) {
            shot.pose.position = {-2.99f + 0.573f * aside, 0.3f, 1.83f + 0.819f * aside};
            shot.linear_velocity = {18.0f, 0.0f, -12.6f};
            (void)world.add_body(shot);
            run(15, hit);
        }
        run(240 - static_cast<int>(hit.size()), hit);
        state.SetIterationTime(median(hit) * 1e-3);
        state.counters["pieces"] = static_cast<double>(pieces->pieces.size());
        state.counters["bodies"] = static_cast<double>(world.body_count());
        state.counters["awake"] = static_cast<double>(world.awake_count());
        state.counters["unhit"] = median(unhit);
        state.counters["most"] = *std::max_element(hit.begin(), hit.end());
    }
}

} // namespace

void add_world_benchmarks() {
    const auto add = [](const std::string& name, int runs, const auto& run) {
        benchmark::RegisterBenchmark(name.c_str(), run)
            ->Unit(benchmark::kMillisecond)
            ->UseManualTime()
            ->Iterations(runs);
    };
    static const WorldSettings all_meet{.debris_size = 0.0f, .max_colliding = 0};
    const std::pair<const char*, WorldSettings> kinds[] = {
        {"meet", all_meet},
        {"alone", {.threads = 1, .debris_size = 0.0f, .max_colliding = 0}},
        {"default", {}},
        {"debris", {.debris_size = 1.0f}}};
    for (const auto& [kind, settings] : kinds) {
        const auto drop = [&add, name = std::string("world/") + kind + "/",
                           settings = settings](const std::string& what, uint32_t sites, int runs, bool sleepers) {
            add(name + what, runs, [=](benchmark::State& state) { run_drop(state, sites, settings, sleepers); });
        };
        drop("100", 150, 5, false);
        drop("300", 570, 5, false);
        drop("1000", sites_for_1000, 3, false);
        drop("3000", 8200, 1, false);
        drop("1000_of_3000", sites_for_1000, 1, true);
    }
    add("world/vacuum/1000", 3, [](benchmark::State& state) {
        run_drop(state, sites_for_1000, {.air_density = 0.0f, .debris_size = 0.0f, .max_colliding = 0}, false);
    });
    const auto add_more = [&add](const std::string& name, const WorldSettings& settings, float height,
                                 const glm::vec3& at) {
        add("world/add/" + name + "/1000_to_3000", runs_of_add, [=](benchmark::State& state) {
            run_add(state, settings, Loose{BrokenBunny(sites_for_1000, height), at});
        });
    };
    const glm::vec3 beside(-3.0f, 0.3f, 0.0f), above(0.0f, 1.0f, 0.0f);
    add_more("meet", all_meet, 1.0f, beside);
    add_more("default", {}, 1.0f, beside);
    add_more("onto", {}, 1.0f, above);
    add_more("small", {.max_colliding = 0}, little_bunny, beside);
    add("world/add/apart/1000_to_3000", runs_of_add, [=](benchmark::State& state) {
        run_add(state, WorldSettings{}, Apart{BrokenBunny(sites_for_1000), beside});
    });
    add("world/tower", 1, run_tower);
}

} // namespace brittle::tools
