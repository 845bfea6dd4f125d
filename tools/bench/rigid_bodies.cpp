// Measures how rigid bodies bear load, slide, bounce and pile up, beside the truth, as a table in Markdown.
//
//     build/release/bin/rigid_bodies                           # all, half a minute
//     build/release/bin/rigid_bodies --only arch --only cards  # rows whose name contains one of these
//     build/release/bin/rigid_bodies --engine bullet           # the same scenes with stock Bullet
//
// A row says "pass" or "MISS" where the truth gives a bound, and nothing where it is a time. A MISS is a result: the exit
// status is 0 unless an option is wrong, no row has the name, or a scene cannot be built. Times mean something only on an
// idle machine.
#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <exception>
#include <functional>
#include <limits>
#include <map>
#include <numbers>
#include <optional>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include <CLI/CLI.hpp>
#include <glm/geometric.hpp>
#include <glm/gtc/quaternion.hpp>

#include "tools/bench/bounds.h"
#include "tools/bench/broken_bunny.h"
#include "tools/bench/overlap.h"
#include "tools/bench/samples.h"
#include "tools/bench/scenes.h"
#include "tools/bench/theory.h"

namespace brittle::tools {

namespace {

using namespace brittle::physics;

struct Options {
    std::vector<std::string> only;
    EngineKind engine = EngineKind::solver;
    std::optional<double> seconds;
    std::optional<double> step;
    uint32_t threads = 2;
    std::optional<uint32_t> substeps;
    bool large = false;
};

struct Outcome {
    std::string result, truth;
    std::optional<bool> pass{};
};

struct Row {
    std::string name;
    std::function<Outcome(const Options&)> run;
};

template<class... Values>
std::string text(const char* format, Values... values) {
    std::array<char, 200> buffer{};
    std::snprintf(buffer.data(), buffer.size(), format, values...);
    return buffer.data();
}

// A world with the bodies of a scene.
struct Run {
    World world;
    std::vector<BodyId> bodies;
    double seconds;

    Run(const Scene& scene, const Options& options, double default_seconds)
        : world(settings_for(scene.settings, options)), bodies(add(scene.bodies)),
          seconds(options.seconds.value_or(default_seconds)) {}

    static WorldSettings settings_for(WorldSettings settings, const Options& options) {
        settings.engine = options.engine;
        settings.threads = options.threads;
        if (options.substeps) settings.solver_substeps = *options.substeps;
        if (options.step) settings.step = static_cast<float>(*options.step);
        return settings;
    }
    std::vector<BodyId> add(const std::vector<BodyDesc>& descs) {
        const Result<std::vector<BodyId>> added = world.add_bodies(descs);
        if (!added) throw std::runtime_error(added.error().message);
        return *added;
    }
    [[nodiscard]] double time() const { return static_cast<double>(world.steps_taken()) * step_seconds(); }
    [[nodiscard]] double step_seconds() const { return static_cast<double>(world.settings().step); }
    // Returns the milliseconds of each step. Ends early when go_on() returns false.
    std::vector<double> steps(
        double duration, const std::function<bool()>& go_on = [] { return true; }) {
        std::vector<double> times;
        for (long step = std::lround(duration / step_seconds()); step > 0; --step) {
            const auto start = std::chrono::steady_clock::now();
            world.step();
            times.push_back(
                std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - start).count());
            if (!go_on()) break;
        }
        return times;
    }
    [[nodiscard]] glm::dvec3 place(size_t body) const { return glm::dvec3(world.pose(bodies[body]).position); }
};

// How far bodies have moved from their first places. They have fallen when one has moved by more than `fall`.
struct Drift {
    std::vector<glm::dvec3> places;
    double fall;
    double aside = 0.0, down = 0.0, up = 0.0; // m, greatest over bodies and steps

    Drift(const Run& run, double fallen) : fall(fallen) {
        for (size_t i = 0; i < run.bodies.size(); ++i) places.push_back(run.place(i));
    }
    // Returns whether they stand.
    bool look(const Run& run) {
        for (size_t i = 0; i < places.size(); ++i) {
            const glm::dvec3 way = run.place(i) - places[i];
            if (!std::isfinite(glm::dot(way, way))) aside = std::numeric_limits<double>::infinity();
            aside = std::max(aside, std::hypot(way.x, way.z));
            down = std::max(down, -way.y);
            up = std::max(up, way.y);
        }
        return stands();
    }
    [[nodiscard]] double most() const { return std::max({aside, down, up}); }
    [[nodiscard]] bool stands() const { return most() < fall; }
    [[nodiscard]] std::string words(const Run& run) const {
        if (!stands()) return text("FALLS within %.2f s", run.time());
        return text("stands %g s, %.2f mm aside, %.2f down, %.2f up", run.time(), 1e3 * aside, 1e3 * down, 1e3 * up);
    }
};

Outcome run_standing(Scene scene, const Options& options, bool sleeping, double fall, double seconds = 30.0) {
    scene.settings.sleeping = sleeping;
    Run run(scene, options, seconds);
    Drift drift(run, fall);
    run.steps(run.seconds, [&] { return drift.look(run); });
    return {drift.words(run), "stands, at most 5 mm", drift.most() <= max_drift};
}

Outcome run_arch(const Options& options, double thickness) {
    Run run(arch(thickness), options, 30.0);
    Drift drift(run, arch_fall);
    run.steps(run.seconds, [&] { return drift.look(run); });
    const double limit = min_arch_thickness(arch_stones);
    std::string truth = text("%s: at least %.4f stands", thickness >= limit ? "stands" : "falls", limit);
    const bool sure = thickness >= surely_stands || thickness <= surely_falls;
    return {drift.words(run), std::move(truth),
            sure ? std::optional(drift.stands() == (thickness >= limit)) : std::nullopt};
}

Outcome run_slope(const Options& options, double friction, double degrees, bool sleeping) {
    const double angle = std::atan(friction) + degrees * std::numbers::pi / 180.0;
    Scene scene = slope(angle, friction);
    scene.settings.sleeping = sleeping;
    Run run(scene, options, 6.0);
    const glm::dvec3 from = run.place(0);
    run.steps(run.seconds);
    const double way = glm::length(run.place(0) - from);
    const double theory =
        0.5 * earth_gravity * (std::sin(angle) - friction * std::cos(angle)) * run.seconds * run.seconds;
    if (degrees < 0.0) return {text("%.2f mm in %g s", 1e3 * way, run.seconds), "rests, below 5 mm", way < max_drift};
    return {text("%.3f m in %g s", way, run.seconds), text("slides %.3f m, within 10 %%", theory),
            std::abs(way / theory - 1.0) <= max_speed_error};
}

Outcome run_bounce(const Options& options, Dropped what, bool on_slab, double restitution) {
    constexpr double height = 1.0;
    Run run(drop(what, restitution, on_slab, height), options, 4.0);
    const double start = run.place(0).y, touch = start - height;
    double before = 0.0, after = 0.0, top = 0.0; // greatest speeds, m/s, and height, m
    run.steps(run.seconds, [&] {
        const auto speed = static_cast<double>(run.world.linear_velocity(run.bodies[0]).y);
        if (after == 0.0) before = std::max(before, -speed);
        after = std::max(after, speed);
        if (after > 0.0) top = std::max(top, run.place(0).y - touch);
        return after == 0.0 || speed > 0.0;
    });
    const double by_speed = before > 0.0 ? after / before : 0.0, by_height = std::sqrt(top / height);
    const bool right = std::abs(by_speed - restitution) <= max_restitution_error
                       && std::abs(by_height - restitution) <= max_restitution_error;
    return {text("%.3f by speed, %.3f by height", by_speed, by_height), text("%g, within 0.03", restitution), right};
}

Outcome run_dominoes(const Options& options) {
    const Dominoes row;
    Run run(dominoes(row), options, 3.0);
    std::vector<double> times(run.bodies.size(), -1.0);
    double now = 0.0;
    run.steps(run.seconds, [&] {
        now += run.step_seconds();
        for (size_t i = 0; i < times.size(); ++i)
            if (times[i] < 0.0
                && std::abs(run.world.pose(run.bodies[i]).orientation.w) < static_cast<float>(tilted_cosine))
                times[i] = now;
        return times.back() < 0.0;
    });
    const double root = std::sqrt(earth_gravity * row.height), theory = domino_wave_speed(row) / root;
    constexpr size_t from = first_timed_domino, to = last_timed_domino;
    const std::string truth = text("%.2f within 10 %%: van Leeuwen 2010, friction %g", theory, row.friction);
    if (times[from] < 0.0 || times[to] < 0.0) return {"the wave dies", truth, false};
    const double speed = static_cast<double>(to - from) * (row.gap + row.thickness) / (times[to] - times[from]) / root;
    return {text("%.2f", speed), truth, std::abs(speed / theory - 1.0) <= max_speed_error};
}

Outcome run_dzhanibekov(const Options& options) {
    Run run(dzhanibekov(), options, 60.0);
    const double start = run.world.mechanics().kinetic;
    double furthest = 0.0;
    int flips = 0;
    bool upright = true;
    run.steps(run.seconds, [&] {
        furthest = std::max(furthest, std::abs(run.world.mechanics().kinetic / start - 1.0));
        const glm::vec3 axis = run.world.pose(run.bodies[0]).orientation * glm::vec3(0.0f, 0.0f, 1.0f);
        if ((axis.z > 0.0f) != upright) ++flips;
        upright = axis.z > 0.0f;
        return true;
    });
    const double end = run.world.mechanics().kinetic / start - 1.0;
    return {text("%+.4f %% after %g s, at most %.4f %%, %d flips", 100.0 * end, run.seconds, 100.0 * furthest, flips),
            "0 %, within 0.1 %, and it flips", furthest <= 1e-3 && flips > 1};
}

Outcome run_fall(const Options& options) {
    Scene scene;
    scene.settings.air_density = 0.0f;
    scene.settings.ground_height = {};
    add_box(scene, glm::dvec3(0.2), glm::dvec3(0.0));
    Run run(scene, options, 10.0);
    run.steps(run.seconds);
    const double depth = -run.place(0).y, theory = 0.5 * earth_gravity * run.seconds * run.seconds;
    return {text("%.3f m in %g s, %+.4f m", depth, run.seconds, depth - theory), text("%.3f m, within 1 mm", theory),
            std::abs(depth - theory) <= 1e-3};
}

Outcome run_pile(const Options& options, uint32_t sites) {
    const BrokenBunny broken(sites);
    const PieceHulls hulls = collision_hulls(broken.pieces);
    Run run(Scene{}, options, 10.0);
    if (!broken.add_to(run.world, {0.0f, 0.3f, 0.0f}))
        throw std::runtime_error("a piece of the bunny was rejected as a body");
    run.steps(run.seconds);
    std::vector<HullFeatures> features;
    std::vector<Pose> poses;
    double top = 0.0, reach = 0.0;
    for (size_t i = 0; i < hulls.size(); ++i) {
        features.push_back(features_of(*hulls[i]));
        poses.push_back(run.world.pose(run.world.bodies()[i]));
        top = std::max(top, static_cast<double>(poses.back().position.y));
        reach += std::hypot(poses.back().position.x, poses.back().position.z) / static_cast<double>(hulls.size());
    }
    const std::vector<double> depths = overlaps(features, poses);
    const double most = 1e3 * longest(depths), p95 = 1e3 * percentile_95(depths);
    return {text("%zu pieces, %zu overlaps, max %.2f mm, p95 %.2f mm, top %.2f m, mean distance %.2f m", hulls.size(),
                 depths.size(), most, p95, top, reach),
            "0; at most 4.9 / 1.0 mm",
            std::isfinite(reach) && most <= 1e3 * max_overlap && p95 <= 1e3 * max_overlap_p95};
}

std::string times_text(const std::vector<double>& times) {
    return text("median %.2f ms, p95 %.2f ms a step", median(times), percentile_95(times));
}

// Bunnies of `sites` each, one above the other, all of whose pieces meet. Steps in which nothing is awake do not count.
Outcome run_heap(const Options& options, uint32_t sites, int bunnies) {
    const BrokenBunny broken(sites);
    Scene scene;
    scene.settings.sleeping = true;
    Run run(scene, options, 10.0);
    for (int i = 0; i < bunnies; ++i)
        if (!broken.add_to(run.world, {0.2f * static_cast<float>(i), 0.3f + 1.1f * static_cast<float>(i), 0.0f}))
            throw std::runtime_error("a piece of the bunny was rejected as a body");
    size_t contacts = 0;
    const std::vector<double> times = run.steps(run.seconds, [&] {
        contacts = std::max(contacts, run.world.contact_count());
        return run.world.awake_count() > 0;
    });
    return {text("%zu pieces, ", run.world.body_count()) + times_text(times) + text(" in %.1f s, ", run.time())
                + text("at most %zu contact points", contacts),
            "a time"};
}

// How a pile of `sites` lies: by the defaults, with their limit on bodies that collide, beside one in which all meet.
Outcome run_rubble(const Options& options, uint32_t sites) {
    const BrokenBunny broken(sites);
    std::vector<HullFeatures> features;
    for (const auto& hull : collision_hulls(broken.pieces)) features.push_back(features_of(*hull));
    struct Pile {
        double radius = 0.0, inside = 0.0; // m; share of pieces more than a fifth inside another
        std::vector<double> times{};
    };
    const auto pile_of = [&](const WorldSettings& settings) {
        Run run(Scene{.settings = settings}, options, 5.0);
        Pile pile;
        if (!broken.add_to(run.world, {0.0f, 0.3f, 0.0f}))
            throw std::runtime_error("a piece of the bunny was rejected as a body");
        pile.times = run.steps(run.seconds);
        std::vector<Pose> poses;
        std::vector<double> reach;
        for (const BodyId body : run.world.bodies()) {
            poses.push_back(run.world.pose(body));
            reach.push_back(std::hypot(poses.back().position.x, poses.back().position.z));
        }
        pile.radius = percentile_95(reach);
        for (const double share : shares_inside(features, poses))
            if (share > max_share_inside) pile.inside += 1.0 / static_cast<double>(poses.size());
        return pile;
    };
    const Pile pile = pile_of({.sleeping = false});
    const Pile meeting = pile_of({.debris_size = 0.0f, .max_colliding = 0, .sleeping = false});
    return {text("%zu pieces, %.1f %% more than a fifth inside another, radius %.2f m, ", features.size(),
                 100.0 * pile.inside, pile.radius)
                + times_text(pile.times) + text("; all meet: %.1f %%, %.2f m, ", 100.0 * meeting.inside, meeting.radius)
                + times_text(meeting.times),
            "no piece more than a fifth inside another, radius within 10 % of where all meet",
            pile.inside == 0.0 && std::abs(pile.radius / meeting.radius - 1.0) <= 0.1};
}

// A scene of thousands of bodies; `before_step` moves those that something drives.
Outcome run_large(const Options& options, const Scene& scene, const std::function<void(Run&)>& before_step) {
    Run run(scene, options, 10.0);
    before_step(run);
    const std::vector<double> times = run.steps(run.seconds, [&] {
        before_step(run);
        return true;
    });
    return {text("%zu bodies, ", run.bodies.size()) + times_text(times) + text(" in %g s", run.time()), "a time"};
}

Outcome run_pyramid(const Options& options) {
    Run run(pyramid(50, 0.5), options, 10.0);
    Drift drift(run, 0.25);
    const std::vector<double> times = run.steps(run.seconds, [&] { return drift.look(run); });
    return {text("%zu bodies, ", run.bodies.size()) + drift.words(run) + ", " + times_text(times),
            "stands, at most 5 mm", drift.most() <= max_drift};
}

std::vector<Row> all_rows(bool large) {
    std::vector<Row> rows;
    const auto add = [&rows](std::string name, std::function<Outcome(const Options&)> run) {
        rows.push_back({std::move(name), std::move(run)});
    };
    for (const double edge : {1.0, 0.1}) {
        for (const int count : {10, 20, 50})
            add(text("stack of %d, %g m, awake", count, edge), [=](const Options& options) {
                return run_standing(stack(count, edge), options, false, stack_fall * edge);
            });
        add(text("stack of 20, %g m, sleeping on", edge),
            [=](const Options& options) { return run_standing(stack(20, edge), options, true, stack_fall * edge); });
        for (const double ratio : {10.0, 100.0})
            add(text("5 boxes under %g x their mass, %g m, awake", ratio, edge), [=](const Options& options) {
                return run_standing(loaded_stack(5, edge, ratio), options, false, stack_fall * edge);
            });
    }
    for (const int levels : {1, 2, 3, 4})
        add(text("cards: house of %d level%s, awake", levels, levels == 1 ? "" : "s"),
            [=](const Options& options) { return run_standing(card_house(levels), options, false, card_fall); });
    for (const double thickness : {0.07, 0.09, 0.10, 0.11, 0.13, 0.15, 0.20})
        add(text("arch t/R %.2f, awake", thickness),
            [=](const Options& options) { return run_arch(options, thickness); });
    add("pyramid of 50 rows, awake", run_pyramid);
    for (const double friction : {0.3, 0.5, 0.8})
        for (const double degrees : {-0.5, 0.5})
            for (const bool sleeping : {false, true})
                add(text("slope mu %g, %+g degrees, %s", friction, degrees, sleeping ? "sleeping on" : "awake"),
                    [=](const Options& options) { return run_slope(options, friction, degrees, sleeping); });
    for (const auto& [what, name] : {std::pair(Dropped::ball, "ball"), std::pair(Dropped::cube, "cube")})
        for (const bool on_slab : {false, true})
            for (const double restitution : {0.3, 0.5, 0.9})
                add(text("bounce of a %s on the %s, e %g", name, on_slab ? "slab" : "ground", restitution),
                    [what = what, on_slab, restitution](const Options& options) {
                        return run_bounce(options, what, on_slab, restitution);
                    });
    add("dominoes, speed / sqrt(g h)", run_dominoes);
    add("Dzhanibekov, energy", run_dzhanibekov);
    add("free fall", run_fall);
    add("pile of 300, overlap, awake", [](const Options& options) { return run_pile(options, 570); });
    add("heap of 1,013, all meet", [](const Options& options) { return run_heap(options, sites_for_1000, 1); });
    add("heap of 2,973, all meet", [](const Options& options) { return run_heap(options, 8200, 1); });
    add("heap of two bunnies, all meet", [](const Options& options) { return run_heap(options, 1000, 2); });
    add("rubble of 2,973, defaults, awake", [](const Options& options) { return run_rubble(options, 8200); });
    if (!large) return rows;
    add("large: rubble of 20,000, defaults, awake", [](const Options& options) { return run_rubble(options, 66000); });
    add("large: convex pile", [](const Options& options) { return run_large(options, convex_pile(), [](Run&) {}); });
    add("large: junkyard", [](const Options& options) {
        return run_large(options, junkyard(), [](Run& run) { stir(run.world, run.bodies.back()); });
    });
    add("large: pyramids", [](const Options& options) { return run_large(options, many_pyramids(), [](Run&) {}); });
    return rows;
}

// Returns false, and says so, if no row is chosen.
bool print_table(const Options& options) {
    std::vector<Row> rows = all_rows(options.large);
    std::erase_if(rows, [&](const Row& row) {
        return !options.only.empty() && std::ranges::none_of(options.only, [&](const std::string& part) {
            return row.name.find(part) != std::string::npos;
        });
    });
    if (rows.empty()) {
        std::fprintf(stderr, "rigid_bodies: no row has a name with any of these parts; the rows are:\n");
        for (const Row& row : all_rows(true)) std::fprintf(stderr, "  %s\n", row.name.c_str());
        std::fprintf(stderr, "Rows that begin with \"large\" need --large.\n");
        return false;
    }
    std::printf("| test | result | truth | |\n|---|---|---|---|\n");
    int passed = 0, missed = 0;
    for (const Row& row : rows) {
        const Outcome outcome = row.run(options);
        const char* verdict = !outcome.pass ? "" : *outcome.pass ? "pass" : "MISS";
        std::printf("| %s | %s | %s | %s |\n", row.name.c_str(), outcome.result.c_str(), outcome.truth.c_str(),
                    verdict);
        std::fflush(stdout);
        if (outcome.pass) ++(*outcome.pass ? passed : missed);
    }
    std::printf("\n%d pass, %d MISS\n", passed, missed);
    return true;
}

} // namespace

} // namespace brittle::tools

int main(int argc, char** argv) {
    using namespace brittle::tools;
    Options options;
    CLI::App app{"Rigid bodies beside the truth: a table in Markdown"};
    app.add_option("--only", options.only, "only rows whose name contains this; may be repeated");
    const std::map<std::string, brittle::physics::EngineKind> engines{{"solver", brittle::physics::EngineKind::solver},
                                                                      {"bullet", brittle::physics::EngineKind::bullet}};
    app.add_option("--engine", options.engine, "solver or bullet")->transform(CLI::CheckedTransformer(engines));
    app.add_option("--seconds", options.seconds, "simulated, in place of each row's own")->check(CLI::PositiveNumber);
    app.add_option("--step", options.step, "s, in place of 1/120")->check(CLI::Range(1e-4, 0.1));
    app.add_option("--threads", options.threads, "of a step; 0: one a core");
    app.add_option("--substeps", options.substeps, "of the solver")->check(CLI::Range(1, 10000));
    app.add_flag("--large", options.large, "also heaps of 5,000 to 20,000 bodies, which take minutes");
    CLI11_PARSE(app, argc, argv);
    try {
        return print_table(options) ? 0 : 2;
    } catch (const std::exception& failure) {
        std::fprintf(stderr, "rigid_bodies: %s\n", failure.what());
        return 1;
    }
}
