#include "tools/bench/impacts.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include <time.h>

#include <benchmark/benchmark.h>
#include <glm/geometric.hpp>

#include "fracture/fracture.h"
#include "fracture/shapes/shapes.h"
#include "fracture/sites/sites.h"
#include "physics/cutting/destruction.h"
#include "physics/world/pieces.h"
#include "tools/bench/broken_bunny.h"
#include "tools/bench/memory_meter.h"
#include "tools/bench/samples.h"

namespace brittle::tools {

namespace {

using namespace brittle::physics;
using Clock = std::chrono::steady_clock;

constexpr auto frame_length = std::chrono::microseconds(8333);

double milliseconds(Clock::duration duration) {
    return std::chrono::duration<double, std::milli>(duration).count();
}

// CPU time of this thread: other work on the machine does not count.
double thread_milliseconds() {
    timespec now{};
    clock_gettime(CLOCK_THREAD_CPUTIME_ID, &now);
    return static_cast<double>(now.tv_sec) * 1e3 + static_cast<double>(now.tv_nsec) * 1e-6;
}

// Scaled to a longest side of 2 m.
fracture::TriangleMesh mesh_of(const std::string& name) {
    fracture::TriangleMesh mesh =
        name == "ball_328k" ? fracture::icosphere(7) : fracture::torus_knot(2, 3, 8192, 80); // knot_1311k
    const fracture::Box box = fracture::bounds(mesh);
    const double scale = 2.0 / std::max({box.size().x, box.size().y, box.size().z});
    for (glm::dvec3& p : mesh.positions) p = (p - box.centre()) * scale;
    return mesh;
}

struct Frames {
    std::vector<double> frame, update;

    // One step a frame at 120 Hz; the main thread sleeps in between, as it would for the display.
    void run(World& world, Destruction& destruction) {
        const Clock::time_point start = Clock::now();
        world.step();
        const double stepped = thread_milliseconds();
        destruction.update(world);
        {
            const DestructionEvents events = destruction.take_events();
            benchmark::DoNotOptimize(events.added.data());
        }
        update.push_back(thread_milliseconds() - stepped);
        frame.push_back(milliseconds(Clock::now() - start));
        std::this_thread::sleep_until(start + frame_length);
    }
};

// A pile of 300 awake pieces.
bool add_pile(World& world) {
    const fracture::TriangleMesh heap = fracture::cube(1.0);
    const auto pieces = fracture::fracture(heap, fracture::uniform_sites(fracture::bounds(heap), 300, 1));
    return add_pieces(world, *pieces, {}, {.placement = {{0.0f, 0.6f, 0.0f}, {1, 0, 0, 0}}}).has_value();
}

// A thousand awake pieces beside two thousand that sleep.
bool add_crowd(World& world) {
    static const BrokenBunny broken(sites_for_1000);
    (void)add_sleepers(world);
    return broken.add_to(world, {0.0f, 0.3f, 0.0f});
}

constexpr float ball_speed = 5.0f;

// A ball half a metre before its impact, flying along a unit vector.
BodyId shoot_ball(World& world, const glm::vec3& at, const glm::vec3& along, double energy) {
    constexpr float radius = 0.2f;
    BodyDesc ball;
    ball.hull = collision_hull(fracture::icosphere(1, radius).positions, glm::dvec3(0.0), {.max_vertices = 42});
    ball.mass = static_cast<float>(2.0 * energy) / (ball_speed * ball_speed);
    ball.inertia = glm::mat3(0.4f * ball.mass * radius * radius);
    ball.pose.position = at - (radius + 0.5f) * along;
    ball.linear_velocity = ball_speed * along;
    return *world.add_body(ball);
}

// The material scaled so that an object just breaks under a ball of this energy. Granite bears two to forty times as
// much, and a ball that breaks it does more damage.
Material scaled_for(double energy, const Material& material, double volume, const fracture::Box& box) {
    const double force = std::cbrt(4.0 * energy * energy / static_cast<double>(ball_speed))
                         / static_cast<double>(impact_seconds); // equivalent impulse: contact_blows.h
    return scale_strength(material, static_cast<float>(0.8 * force / bearable_force(material, volume, box)));
}

// Largest distance from the point, in the object's coordinates, to a piece that came off: any but the largest.
double reach_of(const Destruction& destruction, const glm::dvec3& at) {
    std::vector<SolidPtr> solids;
    for (const PieceId piece : destruction.pieces()) solids.push_back(destruction.solid(piece));
    const auto rest = std::ranges::max_element(solids, {}, [](const SolidPtr& solid) { return solid->mass.volume; });
    double reach = 0.0;
    for (const SolidPtr& solid : solids)
        if (solid != *rest)
            for (const glm::vec3& p : solid->surface().positions)
                reach = std::max(reach, glm::distance(at, solid->mass.centre_of_mass + glm::dvec3(p)));
    return reach;
}

void run_impact(benchmark::State& state, const std::string& name) {
    constexpr double radius = 0.2; // a tenth of the size
    BreakableDesc desc;
    desc.solid = {.material = material_preset("stone")->material, .min_size = 0.005};
    const fracture::TriangleMesh mesh = mesh_of(name);
    const fracture::Box box = fracture::bounds(mesh);
    const double volume = fracture::mass_properties(mesh.positions, mesh.triangles).volume;
    const double energy = energy_of(radius, desc.solid.material, volume, desc.max_pieces);
    desc.solid.material = scaled_for(energy, desc.solid.material, volume, box);
    const Clock::time_point begin = Clock::now();
    const Result<SolidPtr> solid = make_solid(mesh, desc.solid);
    if (!solid) return state.SkipWithError(solid.error().message.c_str());
    state.counters["prepare"] = milliseconds(Clock::now() - begin);
    const glm::dvec3 at = *std::ranges::max_element(mesh.positions, {}, &glm::dvec3::x);
    desc.motion.placement.position = {-8.0f, static_cast<float>(-box.min.y), 0.0f};
    std::vector<double> waits, commits, before_all, after_all;
    for (auto _ : state) {
        World world;
        if (!add_crowd(world)) return state.SkipWithError("no crowd");
        Destruction destruction({.timing = Timing::when_ready});
        // A copy that only the destruction holds, so that its release counts.
        if (!destruction.add(world, std::make_shared<const SolidPiece>(**solid), desc))
            return state.SkipWithError("no body");
        Frames settle, before, during, after;
        for (int i = 0; i < 60; ++i) settle.run(world, destruction);
        for (int i = 0; i < 30; ++i) before.run(world, destruction);
        if (destruction.statistics().blows > 0) return state.SkipWithError("broke before");
        const Pose pose = world.pose(destruction.body(destruction.pieces()[0])); // the object may have rolled
        const glm::vec3 to_point(at - (*solid)->mass.centre_of_mass);
        shoot_ball(world, pose.position + pose.orientation * to_point, pose.orientation * glm::vec3(-1.0f, 0.0f, 0.0f),
                   energy);
        for (int i = 0; i < 30 && destruction.jobs_in_flight() == 0; ++i) during.run(world, destruction);
        const Clock::time_point contact = Clock::now();
        while (destruction.jobs_in_flight() > 0) during.run(world, destruction);
        waits.push_back(milliseconds(Clock::now() - contact));
        state.SetIterationTime(waits.back() * 1e-3);
        state.counters["pieces"] = static_cast<double>(destruction.pieces().size());
        state.counters["reach"] = reach_of(destruction, at);
        for (int i = 0; i < 30; ++i) after.run(world, destruction);
        if (destruction.statistics().breaks == 0) return state.SkipWithError("nothing broke");
        commits.push_back(longest(during.update));
        before_all.push_back(median(before.frame));
        after_all.push_back(median(after.frame));
        state.counters["failed"] = destruction.statistics().failed;
    }
    state.counters["triangles"] = static_cast<double>(mesh.triangles.size());
    state.counters["wait"] = median(waits);
    state.counters["commit"] = median(commits);
    state.counters["commit_max"] = longest(commits);
    state.counters["frame_before"] = median(before_all);
    state.counters["frame_after"] = median(after_all);
}

void run_thousand(benchmark::State& state, bool (*add_others)(World&)) {
    BreakableDesc desc;
    desc.solid = {.material = material_preset("stone")->material, .min_size = 0.01};
    desc.max_pieces = 34;
    const Result<SolidPtr> ball = make_solid(fracture::icosphere(3, 0.3), desc.solid);
    std::vector<double> before_all, longest_all, share_all, after_all;
    for (auto _ : state) {
        World world;
        if (!add_others(world)) return state.SkipWithError("no bodies");
        Destruction destruction({.timing = Timing::when_ready});
        for (int i = 0; i < 30; ++i) {
            desc.motion.placement.position = {-9.0f + 0.8f * static_cast<float>(i % 6), 0.31f,
                                              3.0f + 0.8f * static_cast<float>(i / 6)};
            if (!destruction.add(world, *ball, desc)) return state.SkipWithError("no body");
        }
        Frames settle, before, during, after;
        for (int i = 0; i < 60; ++i) settle.run(world, destruction);
        for (int i = 0; i < 30; ++i) before.run(world, destruction);
        for (const PieceId piece : destruction.pieces()) {
            const glm::vec3 top = world.pose(destruction.body(piece)).position + glm::vec3(0.0f, 0.3f, 0.0f);
            destruction.strike(world, piece, top, {0.0f, -1.0f, 0.0f}, 1e4);
        }
        const Clock::time_point blow = Clock::now();
        while (destruction.jobs_in_flight() > 0) during.run(world, destruction);
        state.SetIterationTime(milliseconds(Clock::now() - blow) * 1e-3);
        for (int i = 0; i < 40; ++i) after.run(world, destruction);
        before_all.push_back(median(before.frame));
        longest_all.push_back(longest(during.frame));
        share_all.push_back(longest(during.update));
        after_all.push_back(median(after.frame));
        state.counters["bodies"] = static_cast<double>(destruction.pieces().size());
        state.counters["frames"] = static_cast<double>(during.frame.size());
    }
    state.counters["before"] = median(before_all);
    state.counters["longest"] = median(longest_all);
    state.counters["share"] = median(share_all);
    state.counters["after"] = median(after_all);
}

void run_cycles(benchmark::State& state) {
    constexpr int cycles = 10'000, settled = 1'000;
    BreakableDesc desc;
    desc.solid = {.material = material_preset("stone")->material, .min_size = 0.1};
    const Result<SolidPtr> cube = make_solid(fracture::cube(1.0), desc.solid);
    for (auto _ : state) {
        World world(
            {.gravity = glm::vec3(0.0f), .ground_height = std::nullopt, .air_density = 0.0f, .sleeping = false});
        Destruction destruction({.latency = 1});
        uint64_t heap = 0, bodies = 0;
        for (int cycle = 0; cycle < cycles; ++cycle) {
            const Result<ObjectId> object = destruction.add(world, *cube, desc);
            destruction.strike(world, destruction.pieces()[0], {0.0f, 0.5f, 0.0f}, {0.0f, -1.0f, 0.0f}, 2e3);
            world.step();
            destruction.update(world);
            bodies += world.body_count();
            destruction.remove(world, *object);
            const DestructionEvents events = destruction.take_events();
            benchmark::DoNotOptimize(events.removed.data());
            if (cycle + 1 == settled) heap = heap_use().live;
        }
        state.counters["KB_growth"] = (static_cast<double>(heap_use().live) - static_cast<double>(heap)) / 1024.0;
        state.counters["bodies"] = static_cast<double>(bodies);
    }
}

} // namespace

void add_impact_benchmarks() {
    for (const std::string mesh : {"ball_328k", "knot_1311k"})
        benchmark::RegisterBenchmark(("impact/" + mesh).c_str(),
                                     [=](benchmark::State& state) { run_impact(state, mesh); })
            ->Unit(benchmark::kMillisecond)
            ->UseManualTime()
            ->Iterations(9);
    const std::pair<const char*, bool (*)(World&)> scenes[] = {{"impact/1000_bodies", add_pile},
                                                               {"impact/1000_in_crowd", add_crowd}};
    for (const auto& [name, add_others] : scenes)
        benchmark::RegisterBenchmark(
            name, [add_others = add_others](benchmark::State& state) { run_thousand(state, add_others); })
            ->Unit(benchmark::kMillisecond)
            ->UseManualTime()
            ->Iterations(3);
    benchmark::RegisterBenchmark("cycles/10000", run_cycles)->Unit(benchmark::kSecond)->Iterations(1);
}

} // namespace brittle::tools
