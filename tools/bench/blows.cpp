#include "tools/bench/blows.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <fstream>
#include <limits>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include <benchmark/benchmark.h>
#include <glm/geometric.hpp>

#include "fracture/io/import.h"
#include "fracture/shapes/shapes.h"
#include "physics/cutting/destruction.h"
#include "tools/bench/broken_bunny.h"
#include "tools/bench/samples.h"

namespace brittle::tools {

namespace {

using namespace brittle::physics;
using Clock = std::chrono::steady_clock;

constexpr uint64_t blows_in_a_row = 10;
constexpr uint32_t max_pieces = 24;

struct Case {
    const char* name;
    fracture::TriangleMesh (*mesh)();
    double share;     // radius of the damage by the size of the object
    double roughness; // of the cuts
};

// To a longest side of 2 m.
fracture::TriangleMesh scaled(fracture::TriangleMesh mesh) {
    const fracture::Box box = fracture::bounds(mesh);
    const double scale = 2.0 / std::max({box.size().x, box.size().y, box.size().z});
    for (glm::dvec3& p : mesh.positions) p = (p - box.centre()) * scale;
    return mesh;
}

template<uint32_t subdivisions>
fracture::TriangleMesh ball() {
    return fracture::icosphere(subdivisions);
}

fracture::TriangleMesh bunny() {
    return *fracture::import_mesh(bunny_file);
}

PlannedCut blow_to(const SolidPtr& solid, const std::shared_ptr<const BreakableDesc>& desc, const glm::dvec3& point,
                   double radius, uint64_t seed) {
    const Material& material = desc->solid.material;
    const double energy = energy_of(radius, material, solid->mass.volume, desc->max_pieces);
    const Blow blow{point, glm::normalize(solid->mass.centre_of_mass - point), energy,
                    std::numeric_limits<double>::max()};
    const Damage damage = damage_of(blow, material, solid->mass.volume, {desc->max_pieces, 0.0, 0.0});
    return {solid, desc, blow, damage, seed, glm::dvec3(0.0)};
}

glm::dvec3 place_on(const SolidPiece& solid, uint64_t number) {
    return solid.surface().mesh.positions[(number * 7919 + 101) * 104'729 % solid.surface().mesh.positions.size()];
}

double milliseconds(Clock::duration duration) {
    return std::chrono::duration<double, std::milli>(duration).count();
}

// The median of blows to the whole object at several places, and of the blows that follow each other, each at another
// place of what is left.
void run(benchmark::State& state, const Case& which) {
    auto desc = std::make_shared<BreakableDesc>();
    desc->solid = {.material = material_preset("stone")->material, .min_size = 0.01};
    desc->solid.rough.amount = which.roughness;
    desc->max_pieces = max_pieces;
    const fracture::TriangleMesh mesh = scaled(which.mesh());
    const Clock::time_point begin = Clock::now();
    const Result<SolidPtr> whole = make_solid(mesh, desc->solid);
    if (!whole) return state.SkipWithError(whole.error().message.c_str());
    state.counters["prepare"] = milliseconds(Clock::now() - begin);
    state.counters["triangles"] = static_cast<double>(mesh.triangles.size());
    std::vector<double> first, later;
    for (auto _ : state) {
        SolidPtr solid = *whole;
        for (uint64_t k = 0; k < blows_in_a_row; ++k) {
            for (const bool to_whole : {true, false}) {
                const SolidPtr& struck = to_whole ? *whole : solid;
                const PlannedCut cut = blow_to(struck, desc, place_on(*struck, k), 2.0 * which.share, k);
                const Clock::time_point start = Clock::now();
                const Result<std::vector<SolidPtr>> pieces = carry_out(cut, {});
                (to_whole ? first : later).push_back(milliseconds(Clock::now() - start));
                if (!pieces) return state.SkipWithError(pieces.error().message.c_str());
                if (!to_whole)
                    solid = *std::ranges::max_element(*pieces, {}, [](const SolidPtr& p) { return p->mass.volume; });
            }
        }
        state.SetIterationTime(median(first) * 1e-3);
    }
    if (mesh.triangles.size() < 2'000'000) {
        auto without = std::make_shared<SolidPiece>(**whole);
        without->clusters = {};
        std::vector<double> times;
        for (uint64_t k = 0; k < 3; ++k) {
            const PlannedCut cut = blow_to(without, desc, place_on(*without, k), 2.0 * which.share, k);
            const Clock::time_point start = Clock::now();
            benchmark::DoNotOptimize(carry_out(cut, {}).has_value());
            times.push_back(milliseconds(Clock::now() - start));
        }
        state.counters["whole"] = median(times);
    }
    state.counters["first"] = median(first);
    state.counters["first_max"] = longest(first);
    state.counters["later"] = median(later);
    state.counters["later_max"] = longest(later);
}

} // namespace

void add_blow_benchmarks() {
    std::vector<Case> cases{{"ball_82k", ball<6>, 0.1, 0.0},        {"ball_328k", ball<7>, 0.1, 0.0},
                            {"ball_1311k", ball<8>, 0.1, 0.0},      {"ball_5243k", ball<9>, 0.1, 0.0},
                            {"ball_20972k", ball<10>, 0.1, 0.0},    {"ball_328k/small", ball<7>, 0.03, 0.0},
                            {"ball_328k/large", ball<7>, 0.2, 0.0}, {"ball_328k/rough", ball<7>, 0.1, 0.5}};
    if (std::ifstream(bunny_file).good()) {
        cases.insert(cases.begin(), {"bunny/rough", bunny, 0.1, 0.5});
        cases.insert(cases.begin(), {"bunny", bunny, 0.1, 0.0});
    }
    for (const Case& one : cases)
        benchmark::RegisterBenchmark((std::string("blow/") + one.name).c_str(),
                                     [=](benchmark::State& state) { run(state, one); })
            ->Unit(benchmark::kMillisecond)
            ->UseManualTime()
            ->Iterations(1);
}

} // namespace brittle::tools
