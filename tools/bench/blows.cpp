#include "tools/bench/blows.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <fstream>
#include <limits>
#include <memory>
#include <numbers>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include <benchmark/benchmark.h>
#include <glm/geometric.hpp>

#include "fracture/base/random.h"
#include "fracture/io/import.h"
#include "fracture/local/cluster_queries.h"
#include "fracture/shapes/shapes.h"
#include "physics/cutting/destruction.h"
#include "tools/bench/broken_bunny.h"
#include "tools/bench/memory_meter.h"
#include "tools/bench/samples.h"
#include "tools/brittle/stage/piece_drawing.h"

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

// The place of the surface that a ray towards the centre of mass meets first.
glm::dvec3 place_on(const SolidPiece& solid, uint64_t number) {
    fracture::Random random(number + 1);
    const double z = 2.0 * random.uniform() - 1.0;
    const double angle = 2.0 * std::numbers::pi * random.uniform(), r = std::sqrt(1.0 - z * z);
    const glm::dvec3 centre = solid.mass.centre_of_mass;
    const glm::dvec3 from =
        centre + 2.0 * double{solid.radius} * glm::dvec3(r * std::cos(angle), r * std::sin(angle), z);
    const std::optional<double> hit = fracture::first_hit(solid.clusters, from, centre);
    return fracture::nearest_on(solid.clusters, hit ? from + *hit * (centre - from) : from);
}

double milliseconds(Clock::duration duration) {
    return std::chrono::duration<double, std::milli>(duration).count();
}

// Times of blows, ms, and what is drawn anew after them.
struct Measured {
    std::vector<double> cut, draw, kilobytes;

    // Returns the largest piece; nothing if the cut failed.
    SolidPtr blow(const SolidPtr& solid, const std::shared_ptr<const BreakableDesc>& desc, const Case& which,
                  uint64_t number, std::vector<SolidPtr>* others = nullptr) {
        const PlannedCut planned = blow_to(solid, desc, place_on(*solid, number), 2.0 * which.share, number);
        const Clock::time_point start = Clock::now();
        Result<std::vector<SolidPtr>> pieces = carry_out(planned, {});
        const Clock::time_point made = Clock::now();
        if (!pieces) return nullptr;
        uint64_t bytes = 0;
        for (const SolidPtr& piece : *pieces) bytes += draw_piece(*piece, solid.get())->batch.bytes();
        cut.push_back(milliseconds(made - start));
        draw.push_back(milliseconds(Clock::now() - made));
        kilobytes.push_back(static_cast<double>(bytes) / 1000.0);
        const auto largest = std::ranges::max_element(*pieces, {}, [](const SolidPtr& p) { return p->mass.volume; });
        SolidPtr rest = std::move(*largest);
        pieces->erase(largest);
        if (others) others->insert(others->end(), pieces->begin(), pieces->end());
        return rest;
    }
};

// The median of blows to the whole object at several places, and of blows that follow each other, each at another place
// of what is left.
void run(benchmark::State& state, const Case& which) {
    auto desc = std::make_shared<BreakableDesc>();
    desc->solid = {.material = material_preset("stone")->material, .min_size = 0.01};
    desc->solid.rough.amount = which.roughness;
    desc->max_pieces = max_pieces;
    const fracture::TriangleMesh mesh = scaled(which.mesh());
    const size_t triangles = mesh.triangles.size();
    const uint64_t without_solid = heap_use().live;
    const Clock::time_point begin = Clock::now();
    Result<SolidPtr> whole = make_solid(mesh, desc->solid);
    if (!whole) return state.SkipWithError(whole.error().message.c_str());
    state.counters["prepare"] = milliseconds(Clock::now() - begin);
    state.counters["triangles"] = static_cast<double>(triangles);
    const auto unbroken = static_cast<double>(heap_use().live - without_solid);
    Measured first, later;
    std::vector<double> whole_mesh_cut;
    for (auto _ : state) {
        for (uint64_t k = 0; k < blows_in_a_row; ++k)
            if (!first.blow(*whole, desc, which, k)) return state.SkipWithError("a blow failed");
        for (uint64_t k = 0; k < 3 && triangles < 2'000'000; ++k) {
            auto without = std::make_shared<SolidPiece>(**whole);
            without->clusters = {};
            const PlannedCut cut = blow_to(without, desc, place_on(**whole, k), 2.0 * which.share, k);
            const Clock::time_point start = Clock::now();
            benchmark::DoNotOptimize(carry_out(cut, {}).has_value());
            whole_mesh_cut.push_back(milliseconds(Clock::now() - start));
        }
        SolidPtr solid = std::move(*whole);
        std::vector<SolidPtr> others;
        for (uint64_t k = 0; k < blows_in_a_row; ++k) {
            solid = later.blow(solid, desc, which, k, &others);
            if (!solid) return state.SkipWithError("a blow failed");
        }
        state.counters["memory"] = static_cast<double>(heap_use().live - without_solid) / unbroken;
        state.SetIterationTime(median(first.cut) * 1e-3);
    }
    if (!whole_mesh_cut.empty()) state.counters["whole"] = median(whole_mesh_cut);
    state.counters["first"] = median(first.cut);
    state.counters["first_max"] = longest(first.cut);
    state.counters["later"] = median(later.cut);
    state.counters["later_max"] = longest(later.cut);
    state.counters["draw"] = median(later.draw);
    state.counters["draw_max"] = longest(later.draw);
    state.counters["upload_kB"] = median(later.kilobytes);
    state.counters["upload_kB_max"] = longest(later.kilobytes);
}

} // namespace

void add_blow_benchmarks() {
    std::vector<Case> cases{{"ball_82k", ball<6>, 0.1, 0.0},
                            {"ball_328k", ball<7>, 0.1, 0.0},
                            {"ball_1311k", ball<8>, 0.1, 0.0},
                            {"ball_5243k", ball<9>, 0.1, 0.0},
                            {"ball_20972k", ball<10>, 0.1, 0.0},
                            {"ball_328k/small", ball<7>, 0.03, 0.0},
                            {"ball_328k/large", ball<7>, 0.2, 0.0},
                            {"ball_328k/rough", ball<7>, 0.1, 0.5},
                            {"ball_328k/as_many", ball<7>, 0.1 / 2, 0.0},
                            {"ball_1311k/as_many", ball<8>, 0.1 / 4, 0.0},
                            {"ball_5243k/as_many", ball<9>, 0.1 / 8, 0.0}};
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
