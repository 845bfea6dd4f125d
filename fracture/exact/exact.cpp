#include "fracture/exact/exact.h"

#include <algorithm>
#include <chrono>
#include <cmath>

#include "fracture/exact/assemble.h"
#include "fracture/exact/bonds.h"
#include "fracture/exact/caps.h"
#include "fracture/exact/clip.h"
#include "fracture/exact/diagram.h"
#include "fracture/exact/edges.h"
#include "fracture/exact/islands.h"
#include "fracture/exact/scene.h"
#include "fracture/exact/slivers.h"
#include "fracture/exact/solid_grid.h"
#include "fracture/exact/surface.h"
#include "fracture/exact/triangle_sorter.h"
#include "fracture/exact/winding.h"

namespace brittle::fracture::exact {

struct Scratch::State {
    Threads threads{1};
    uint32_t requested_threads = 1;
    Scene scene;
    Surface surface;
    SolidGrid solid_grid;
    DiagramBuilder diagram_builder;
    VoronoiDiagram diagram;
    Frames frames;
    std::vector<SiteId> cell_of;
    std::vector<SiteId> cell_of_triangle;
    TriangleSorter triangle_sorter;
    EdgeCutter edge_cutter;
    TriangleCutter triangle_cutter;
    Cut cut;
    Winding winding;
    Capper capper;
    Assembler assembler;
    SliverCollapser slivers;
    IslandSplitter islands;
    BondFinder bonds;
    Statistics statistics;
};

Scratch::Scratch() : state_(std::make_unique<State>()) {}
Scratch::~Scratch() = default;
Scratch::Scratch(Scratch&&) noexcept = default;
Scratch& Scratch::operator=(Scratch&&) noexcept = default;

namespace {

// Times the phases, reports progress after each and checks for cancellation.
class PhaseClock {
  public:
    PhaseClock(const Settings& settings, const Threads& threads, Fragments& out)
        : settings_(settings), threads_(threads), out_(out) {
        out.timings.clear();
    }

    // Ends a phase. Throws Threads::Cancelled.
    void done(const char* phase, double share) {
        const auto now = std::chrono::steady_clock::now();
        out_.timings.push_back({phase, std::chrono::duration<double, std::milli>(now - last_).count()});
        if (settings_.progress) settings_.progress(share);
        threads_.poll();
        last_ = std::chrono::steady_clock::now();
    }

  private:
    const Settings& settings_;
    const Threads& threads_;
    Fragments& out_;
    std::chrono::steady_clock::time_point last_ = std::chrono::steady_clock::now();
};

Error not_closed() {
    return {Status::invalid_mesh, "the cuts of a closed surface do not close: this is a bug in Brittle; please "
                                  "report the mesh and the sites"};
}

// The bins of the grid that tells which cells lie outside the solid; 0 where it costs more than the cells.
uint32_t bins_of_grid(size_t sites, size_t triangles, bool weighted) {
    constexpr size_t min_sites = 100;
    constexpr size_t max_triangles_per_site = 150;
    constexpr double bins_per_cell = 2.5;
    if (weighted || sites < min_sites || triangles > max_triangles_per_site * sites) return 0;
    return static_cast<uint32_t>(std::clamp(bins_per_cell * std::cbrt(static_cast<double>(sites)), 8.0, 128.0));
}

// The phases. Throws Threads::Cancelled.
Result<void> run_phases(const TriangleMesh& mesh, std::span<const glm::dvec3> sites, const Settings& settings,
                        const CapLattice& lattice, Scratch::State& s, Fragments& out) {
    s.statistics = {};
    PredicateStats& stats = s.statistics.predicates;
    PhaseClock clock(settings, s.threads, out);

    s.threads.name_step("prepare");
    if (auto ok = make_scene(mesh, sites, settings.weights, s.threads, s.scene); !ok) return ok;
    const Diagram problem = s.scene.diagram();
    if (auto ok = s.surface.inspect(mesh, s.threads); !ok) return ok;
    Classifier* const classifier = settings.weights.empty() ? settings.classifier : nullptr; // not weighted
    bool guessed = classifier && classifier->start({s.scene.positions, mesh.triangles, s.scene.sites, s.scene.box});
    clock.done("prepare", 0.05);

    s.threads.name_step("cells");
    const uint32_t bins = bins_of_grid(sites.size(), mesh.triangles.size(), !settings.weights.empty());
    if (bins != 0) s.solid_grid.build(s.scene.positions, mesh.triangles, problem.box, bins, s.threads);
    s.diagram_builder.build(problem, s.threads, bins != 0 ? &s.solid_grid : nullptr, s.diagram);
    s.frames.build(problem, s.diagram, s.threads);
    stats += s.diagram_builder.stats();
    clock.done("cells", 0.3);

    s.threads.name_step("classify");
    s.cell_of.resize(mesh.positions.size());
    s.cell_of_triangle.resize(mesh.triangles.size());
    guessed = guessed && classifier->finish(s.cell_of, s.cell_of_triangle);
    classify(problem, s.diagram, s.frames, s.diagram_builder.tree(), s.scene.positions, guessed, s.threads, s.cell_of,
             stats);
    s.triangle_sorter.run({s.surface, mesh.triangles, s.cell_of, static_cast<uint32_t>(sites.size())}, guessed,
                          s.threads, s.cell_of_triangle, s.cut);
    clock.done("classify", 0.4);

    s.threads.name_step("cut edges");
    s.edge_cutter.run(s.scene, s.diagram, s.frames, mesh.triangles, s.cell_of, s.threads, s.cut, stats);
    s.threads.name_step("cut triangles");
    s.triangle_cutter.run(s.scene, s.diagram, s.frames, mesh.triangles, s.cell_of, s.threads, s.cut, stats);
    clock.done("clip", 0.6);

    s.threads.name_step("winding");
    s.winding.compute(s.scene, s.diagram, mesh.triangles, s.cut, s.threads, stats);
    s.threads.name_step("caps");
    const bool closed = s.capper.run(s.scene, s.diagram, s.winding, mesh.triangles, lattice, s.cut, s.threads);
    s.statistics.forced_ears = s.capper.forced_ears();
    if (!closed) return not_closed();
    clock.done("caps", 0.75);

    s.threads.name_step("assemble");
    const Assembler::Input input{mesh,
                                 s.scene,
                                 s.surface,
                                 s.diagram,
                                 s.cell_of,
                                 s.cell_of_triangle,
                                 s.triangle_sorter.whole_triangles(),
                                 s.cut,
                                 s.capper.chunks()};
    s.assembler.run(input, s.threads, out);
    clock.done("assemble", 0.85);

    s.threads.name_step("slivers");
    s.slivers.run(input, s.assembler.cells(), s.threads, out);
    s.statistics.slivers = s.slivers.found();
    s.statistics.slivers_left = s.slivers.left();
    clock.done("slivers", 0.9);

    s.threads.name_step("islands");
    s.islands.run(input, s.assembler.cells(), s.threads, out);
    s.bonds.run(s.scene.sites, out);
    clock.done("islands", 1.0);
    return {};
}

} // namespace

Statistics statistics(const Scratch& scratch) {
    return scratch.state().statistics;
}

const Cut& cut(const Scratch& scratch) {
    return scratch.state().cut;
}

const Scene& scene(const Scratch& scratch) {
    return scratch.state().scene;
}

Result<void> fracture_exact(const TriangleMesh& mesh, std::span<const glm::dvec3> sites, const Settings& settings,
                            Scratch& scratch, Fragments& out, const CapLattice& lattice) {
    Scratch::State& s = scratch.state();
    if (s.requested_threads != settings.threads) {
        s.threads = Threads(settings.threads);
        s.requested_threads = settings.threads;
    }
    s.threads.log_to(settings.work_log);
    s.threads.cancel_by(settings.cancelled);
    try {
        return run_phases(mesh, sites, settings, lattice, s, out);
    } catch (const Threads::Cancelled&) {
        return Error{Status::cancelled, "the fracture was cancelled"};
    }
}

Result<Fragments> fracture_exact(const TriangleMesh& mesh, std::span<const glm::dvec3> sites,
                                 const Settings& settings) {
    Scratch scratch;
    Fragments fragments;
    if (auto ok = fracture_exact(mesh, sites, settings, scratch, fragments); !ok) return ok.error();
    return fragments;
}

} // namespace brittle::fracture::exact
