// Benchmarks of fracture, by phase, with its memory.
//
//     build/release/bin/brittle_bench --benchmark_filter='fracture/bunny/.*'
//
// fracture/MESH/SITES/threads:N    steady state: workspace and output are reused
// first/MESH/SITES/threads:N       first fracture of a mesh, with a new workspace and output
// world/...                        steps of the world: world.h
// certify/..., check/...           the certificate of a result; the check that every fracture makes, and the full check
// impact/..., cycles/...           destruction at runtime: impacts.h
// blow/...                         the cuts of blows: blows.h
//
// Times are medians over the iterations, in milliseconds: `median`, and one counter a phase. `MB` is the size of input
// plus output, `memcpy` the time by that of copying as many bytes, `allocs` the allocations of one fracture in the
// steady state, `memory` the peak heap of the first fracture, input included, by the size of input plus output.
#include <algorithm>
#include <chrono>
#include <cstring>
#include <fstream>
#include <map>
#include <set>
#include <string>
#include <thread>
#include <vector>

#include <benchmark/benchmark.h>

#include "fracture/fracture.h"
#include "fracture/io/import.h"
#include "fracture/mesh/manifold_check.h"
#include "fracture/pieces/certificate.h"

#include "fracture/mesh/topology.h"
#include "fracture/shapes/shapes.h"
#include "fracture/sites/sites.h"
#include "tools/bench/blows.h"
#include "tools/bench/broken_bunny.h"
#include "tools/bench/impacts.h"
#include "tools/bench/memory_meter.h"
#include "tools/bench/samples.h"
#include "tools/bench/scene_steps.h"
#include "tools/bench/world.h"

namespace brittle::tools {

namespace {

using namespace brittle::fracture;

TriangleMesh make_mesh(const std::string& name) {
    if (name == "bunny") return *import_mesh(bunny_file);
    if (name == "ball_82k") return icosphere(6);
    if (name == "ball_20k") return icosphere(5);
    if (name == "ball_328k") return icosphere(7);
    return torus_knot(2, 3, 8192, 80); // knot_1311k
}

// Made at its first use.
const TriangleMesh& mesh_of(const std::string& name) {
    static std::map<std::string, TriangleMesh> meshes;
    const auto [at, is_new] = meshes.try_emplace(name);
    if (is_new) at->second = make_mesh(name);
    return at->second;
}

enum class Pattern {
    uniform,
    clustered // nine of ten sites lie within a hundredth of the box's size around one point of the surface
};

std::vector<glm::dvec3> make_sites(const TriangleMesh& mesh, uint32_t count, Pattern pattern) {
    const Box box = bounds(mesh);
    std::vector<glm::dvec3> sites = uniform_sites(box, count, 1);
    if (pattern == Pattern::uniform) return sites;
    const glm::dvec3 impact = mesh.positions[mesh.positions.size() / 3];
    for (size_t i = 0; i < sites.size(); ++i)
        if (i % 10 != 0) sites[i] = impact + (sites[i] - box.centre()) * 0.01;
    return sites;
}

template<class T>
uint64_t bytes_of(const std::vector<T>& array) {
    return array.size() * sizeof(T);
}

uint64_t bytes_of(const TriangleMesh& mesh) {
    return bytes_of(mesh.positions) + bytes_of(mesh.triangles);
}

uint64_t bytes_of(const Fragments& f) {
    return bytes_of(f.positions) + bytes_of(f.triangles) + bytes_of(f.triangle_source) + bytes_of(f.vertex_point)
           + bytes_of(f.pieces) + bytes_of(f.bonds);
}

template<class Body>
double milliseconds_of(const Body& body) {
    const auto start = std::chrono::steady_clock::now();
    body();
    return std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - start).count();
}

double memcpy_milliseconds(uint64_t bytes) {
    std::vector<char> from(bytes, 1), to(bytes);
    std::vector<double> samples;
    for (int round = 0; round < 9; ++round) {
        samples.push_back(milliseconds_of([&] {
            std::memcpy(to.data(), from.data(), bytes);
            benchmark::ClobberMemory();
        }));
    }
    return median(samples);
}

struct Case {
    std::string mesh;
    uint32_t sites;
    Pattern pattern;
    uint32_t threads;
};

// Peak heap of one fracture with a new workspace and output, by the size of input plus output.
double memory_of_first(const Case& c, const std::vector<glm::dvec3>& sites) {
    const TriangleMesh& mesh = mesh_of(c.mesh);
    const uint64_t before = heap_use().live;
    reset_heap_peak();
    const Result<Fragments> fragments = fracture::fracture(mesh, sites, {.threads = c.threads});
    const uint64_t used = heap_use().peak - before + bytes_of(mesh);
    return fragments ? static_cast<double>(used) / static_cast<double>(bytes_of(mesh) + bytes_of(*fragments)) : 0.0;
}

void run_fracture(benchmark::State& state, const Case& c, bool first_time) {
    const TriangleMesh& mesh = mesh_of(c.mesh);
    const std::vector<glm::dvec3> sites = make_sites(mesh, c.sites, c.pattern);
    const Settings settings{.threads = c.threads};
    state.counters["memory"] = memory_of_first(c, sites);

    Workspace workspace;
    Fragments out;
    uint64_t allocations = 0;
    std::vector<double> total;
    std::map<std::string, std::vector<double>> phases;
    const auto cut = [&] {
        if (first_time) {
            workspace = Workspace();
            out = Fragments();
        }
        const uint64_t before = heap_use().allocations;
        const double milliseconds = milliseconds_of([&] {
            if (const auto done = fracture::fracture(mesh, sites, settings, workspace, out); !done)
                state.SkipWithError(done.error().message.c_str());
        });
        allocations = heap_use().allocations - before;
        return milliseconds;
    };
    for (int warm_up = 0; warm_up < 2; ++warm_up) (void)cut();
    for (auto _ : state) {
        const double milliseconds = cut();
        state.SetIterationTime(milliseconds * 1e-3);
        total.push_back(milliseconds);
        for (const Milliseconds& t : out.timings) phases[t.phase].push_back(t.milliseconds);
    }
    if (total.empty()) return;
    const uint64_t bytes = bytes_of(mesh) + bytes_of(out);
    state.counters["median"] = median(total);
    for (const auto& [phase, samples] : phases) state.counters[phase] = median(samples);
    state.counters["pieces"] = static_cast<double>(out.pieces.size());
    state.counters["MB"] = static_cast<double>(bytes) * 1e-6;
    state.counters["memcpy"] = median(total) / memcpy_milliseconds(bytes);
    state.counters["allocs"] = static_cast<double>(allocations);
}

// Rough cuts in turn with flat ones; `detail` as in Roughness.
void run_rough(benchmark::State& state, const Case& c, uint32_t detail) {
    const TriangleMesh& mesh = mesh_of(c.mesh);
    const std::vector<glm::dvec3> sites = make_sites(mesh, c.sites, c.pattern);
    Settings flat{.threads = c.threads}, rough = flat;
    rough.rough = {.amount = 0.5, .detail = detail};
    Workspace workspace;
    Fragments out;
    const auto cut = [&](const Settings& settings) {
        return milliseconds_of([&] {
            if (const auto done = fracture::fracture(mesh, sites, settings, workspace, out); !done)
                state.SkipWithError(done.error().message.c_str());
        });
    };
    for (const Settings& settings : {flat, rough, flat, rough}) (void)cut(settings);
    std::vector<double> of_flat, of_rough;
    for (auto _ : state) {
        of_flat.push_back(cut(flat));
        of_rough.push_back(cut(rough));
        state.SetIterationTime(of_rough.back() * 1e-3);
    }
    if (of_rough.empty()) return;
    state.counters["median"] = median(of_rough);
    state.counters["flat"] = median(of_flat);
    state.counters["times_flat"] = median(of_rough) / median(of_flat);
    state.counters["added"] = static_cast<double>(out.rough_triangles);
    state.counters["triangles"] = static_cast<double>(out.triangles.size());
}

void run_certify(benchmark::State& state, const Case& c) {
    const TriangleMesh& mesh = mesh_of(c.mesh);
    const auto fragments = fracture::fracture(mesh, make_sites(mesh, c.sites, c.pattern));
    Certificate certificate;
    for (auto _ : state) certificate = certify(mesh, *fragments);
    if (!certificate.closed) state.SkipWithError("pieces are open");
}

void run_quick_check(benchmark::State& state, const std::string& name, uint32_t thread_count) {
    const TriangleMesh& mesh = mesh_of(name);
    Threads threads(thread_count);
    ManifoldCheck check;
    bool sound = true;
    for (auto _ : state) sound = sound && check.run(mesh.positions.size(), mesh.triangles, threads);
    if (!sound) state.SkipWithError("the mesh is not manifold");
}

void run_full_check(benchmark::State& state, const std::string& name) {
    const TriangleMesh& mesh = mesh_of(name);
    for (auto _ : state) benchmark::DoNotOptimize(check_topology(mesh.positions.size(), mesh.triangles));
}

void add_fracture(const Case& c) {
    const std::string name = c.mesh + '/' + std::to_string(c.sites)
                             + (c.pattern == Pattern::clustered ? "_clustered" : "")
                             + "/threads:" + std::to_string(c.threads);
    for (const bool first : {false, true}) {
        benchmark::RegisterBenchmark(((first ? "first/" : "fracture/") + name).c_str(),
                                     [=](benchmark::State& state) { run_fracture(state, c, first); })
            ->Unit(benchmark::kMillisecond)
            ->UseManualTime();
    }
}

void add_rough(const Case& c) {
    for (const uint32_t detail : {1u, 2u, 3u}) {
        benchmark::RegisterBenchmark(("rough/" + c.mesh + '/' + std::to_string(c.sites)
                                      + "/threads:" + std::to_string(c.threads) + "/detail:" + std::to_string(detail))
                                         .c_str(),
                                     [=](benchmark::State& state) { run_rough(state, c, detail); })
            ->Unit(benchmark::kMillisecond)
            ->UseManualTime();
    }
}

void add_all() {
    const bool has_bunny = std::ifstream(bunny_file).good();
    const std::vector<std::string> meshes{has_bunny ? "bunny" : "ball_82k", "ball_20k", "ball_328k", "knot_1311k"};
    const std::set<uint32_t> thread_counts{1, 2, std::max(1u, std::thread::hardware_concurrency())};
    for (const std::string& mesh : meshes) {
        for (const uint32_t sites : {10u, 100u, 1000u, 10000u})
            for (const uint32_t threads : thread_counts) add_fracture({mesh, sites, Pattern::uniform, threads});
    }
    for (const uint32_t sites : {1000u, 10000u})
        for (const uint32_t threads : thread_counts) add_fracture({meshes[0], sites, Pattern::clustered, threads});
    for (const std::string& mesh : {meshes[0], std::string("ball_20k")}) add_rough({mesh, 100, Pattern::uniform, 2});
    for (const std::string& mesh : meshes) {
        benchmark::RegisterBenchmark(("check/full/" + mesh).c_str(), [=](benchmark::State& state) {
            run_full_check(state, mesh);
        })->Unit(benchmark::kMillisecond);
        for (const uint32_t threads : thread_counts) {
            benchmark::RegisterBenchmark(("check/quick/" + mesh + "/threads:" + std::to_string(threads)).c_str(),
                                         [=](benchmark::State& state) { run_quick_check(state, mesh, threads); })
                ->Unit(benchmark::kMillisecond)
                ->UseRealTime();
        }
    }
    for (const uint32_t sites : {10u, 100u, 1000u}) {
        benchmark::RegisterBenchmark(("certify/" + meshes[0] + '/' + std::to_string(sites)).c_str(),
                                     [=](benchmark::State& state) {
                                         run_certify(state, {meshes[0], sites, Pattern::uniform, 0});
                                     })
            ->Unit(benchmark::kMillisecond)
            ->UseRealTime();
    }
}

} // namespace

} // namespace brittle::tools

int main(int argc, char** argv) {
    brittle::tools::add_all();
    brittle::tools::add_impact_benchmarks();
    brittle::tools::add_blow_benchmarks();
    brittle::tools::add_world_benchmarks();
    brittle::tools::add_scene_benchmarks();
    benchmark::Initialize(&argc, argv);
    if (benchmark::ReportUnrecognizedArguments(argc, argv)) return 1;
    benchmark::RunSpecifiedBenchmarks();
    benchmark::Shutdown();
    return 0;
}
