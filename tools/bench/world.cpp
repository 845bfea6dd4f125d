#include "tools/bench/world.h"

#include <algorithm>
#include <chrono>
#include <fstream>
#include <string>
#include <vector>

#include <benchmark/benchmark.h>

#include "fracture/fracture.h"
#include "fracture/io/import.h"
#include "fracture/shapes.h"
#include "fracture/sites.h"
#include "physics/material.h"
#include "physics/pieces.h"
#include "physics/structure.h"

namespace brittle::tools {

namespace {

using namespace brittle::fracture;
using namespace brittle::physics;

constexpr const char* bunny_file = "/usr/share/glmark2/models/bunny.obj"; // assets/SOURCES.md
constexpr uint32_t sites_for_2000 = 5000;                                 // of the bunny

// A metre high, standing on the ground.
TriangleMesh bunny() {
    TriangleMesh mesh = std::ifstream(bunny_file).good() ? *import_mesh(bunny_file) : icosphere(6);
    const Box box = bounds(mesh);
    const double longest = std::max({box.size().x, box.size().y, box.size().z});
    for (glm::dvec3& p : mesh.positions)
        p = (p - glm::dvec3(box.centre().x, box.min.y, box.centre().z)) / longest;
    return mesh;
}

Fragments broken_bunny(uint32_t sites) {
    static const TriangleMesh mesh = bunny();
    return *fracture::fracture(mesh, uniform_sites(bounds(mesh), sites, 1));
}

double median(std::vector<double> samples) {
    const auto middle = samples.begin() + static_cast<std::ptrdiff_t>(samples.size() / 2);
    std::nth_element(samples.begin(), middle, samples.end());
    return *middle;
}

double milliseconds_of(const auto& body) {
    const auto start = std::chrono::steady_clock::now();
    body();
    return std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - start).count();
}

// The steps of the first second and a half after the break: the fall of 30 cm, the impact and the spreading.
void run_drop(benchmark::State& state, uint32_t sites, float debris_size, bool among_sleepers) {
    const Fragments pieces = broken_bunny(sites);
    PieceHulls hulls;
    const double hull_milliseconds = milliseconds_of([&] { hulls = collision_hulls(pieces); });
    World world({.debris_size = debris_size});
    if (among_sleepers) {
        const Fragments others = broken_bunny(sites_for_2000);
        if (!add_pieces(world, others, {}, {.placement = {{5.0f, 0.0f, 0.0f}, {1.0f, 0.0f, 0.0f, 0.0f}}}))
            return state.SkipWithError("no bodies");
        for (int step = 0; step < 3600 && world.awake_count() > 0; ++step) world.step();
    }
    const size_t asleep = world.body_count() - world.awake_count();
    double add = 0.0;
    std::vector<double> steps;
    for (auto _ : state) {
        bool added = false;
        add = milliseconds_of([&] {
            added = add_pieces(world, pieces, {},
                               {.placement = {{0.0f, 0.3f, 0.0f}, {1.0f, 0.0f, 0.0f, 0.0f}}}, hulls)
                        .has_value();
        });
        if (!added) return state.SkipWithError("no bodies");
        for (int step = 0; step < 180; ++step) steps.push_back(milliseconds_of([&] { world.step(); }));
        state.SetIterationTime(median(steps) * 1e-3);
    }
    state.counters["pieces"] = static_cast<double>(pieces.pieces.size());
    state.counters["asleep"] = static_cast<double>(asleep);
    state.counters["awake"] = static_cast<double>(world.awake_count());
    state.counters["first"] = steps.front();
    state.counters["most"] = *std::max_element(steps.begin() + 1, steps.end());
    state.counters["hulls"] = hull_milliseconds;
    state.counters["add"] = add;
}

// The scene tower_collapses.json without its program: half a second unhit, then two balls into the foot and two seconds.
void run_tower(benchmark::State& state) {
    const Result<SiteList> sites = read_sites(BRITTLE_ASSETS "/sites/tower_bricks.txt");
    if (!sites) return state.SkipWithError("no sites");
    const TriangleMesh mesh = fracture::tower();
    const auto pieces = fracture::fracture(mesh, sites->sites);
    physics::Material material = material_preset("stone")->material;
    for (float* strength : {&material.tensile, &material.compressive, &material.shear}) *strength *= 0.1f; // as the program
    const TriangleMesh ball = icosphere(2, 0.17);
    BodyDesc shot{.hull = collision_hull(ball.positions, glm::dvec3(0.0), {.max_vertices = 64}), .continuous = true, .mass = 53.5f};
    shot.inertia = glm::mat3(0.4f * shot.mass * 0.17f * 0.17f);
    for (auto _ : state) {
        World world;
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
        for (const float aside : {0.0f, 0.2f}) {
            shot.pose.position = {-2.99f + aside, 0.3f, 1.83f + aside};
            shot.linear_velocity = {18.0f, 0.0f, -12.6f};
            (void)world.add_body(shot);
            run(15, hit);
        }
        run(210, hit);
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
    const auto add = [](const std::string& name, uint32_t sites, float debris_size, bool among_sleepers) {
        benchmark::RegisterBenchmark(
            name.c_str(),
            [=](benchmark::State& state) { run_drop(state, sites, debris_size, among_sleepers); })
            ->Unit(benchmark::kMillisecond)
            ->UseManualTime()
            ->Iterations(1);
    };
    for (const auto& [count, sites] :
         {std::pair(100, 150u), std::pair(300, 570u), std::pair(1000, 2400u), std::pair(3000, 8200u)}) {
        add("world/bunny/" + std::to_string(count), sites, 0.0f, false);
        add("world/debris/" + std::to_string(count), sites, 1.0f, false);
    }
    benchmark::RegisterBenchmark("world/tower", run_tower)->Unit(benchmark::kMillisecond)->UseManualTime()->Iterations(1);
    add("world/bunny/1000_of_3000", 2400, 0.0f, true);
    add("world/debris/1000_of_3000", 2400, 1.0f, true);
}

} // namespace brittle::tools
