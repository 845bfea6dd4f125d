// Brittle's part of `tools/compare --guard`: runs one case at each line of its input and prints how long its phases took.
// The same file is compiled against an earlier commit, so it uses few functions of the libraries.
//
//     echo ball | guard_probe          phase=MILLISECONDS ..., one line
//     guard_probe --list               the cases
//
// One thread does all work. Phases of a fracture are the library's own, by the wall clock. All other times are processor
// time of the process, which other work on the machine hardly changes.
#include <ctime>
#include <functional>
#include <iostream>
#include <map>
#include <stdexcept>
#include <string>
#include <vector>

#include "fracture/fracture.h"
#include "fracture/shapes/shapes.h"
#include "fracture/sites/sites.h"
#include "physics/cutting/destruction.h"
#include "physics/material.h"
#include "physics/world/pieces.h"
#include "physics/world/world.h"

namespace {

using namespace brittle;

double processor_milliseconds() {
    timespec now{};
    clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &now);
    return static_cast<double>(now.tv_sec) * 1e3 + static_cast<double>(now.tv_nsec) * 1e-6;
}

struct Times {
    std::vector<std::pair<std::string, double>> phases;

    void take(const std::string& phase, const std::function<void()>& work) {
        const double begin = processor_milliseconds();
        work();
        phases.emplace_back(phase, processor_milliseconds() - begin);
    }
};

template<class T>
T& checked(T&& result) {
    if (!result) throw std::runtime_error(result.error().message);
    return result;
}

// A fracture whose workspace and output are kept.
struct Fracture {
    fracture::TriangleMesh mesh;
    std::vector<glm::dvec3> sites;
    fracture::Settings settings{.threads = 1};
    fracture::Workspace workspace;
    fracture::Fragments pieces;

    Fracture(fracture::TriangleMesh solid, uint32_t count, double rough = 0.0)
        : mesh(std::move(solid)), sites(fracture::uniform_sites(fracture::bounds(mesh), count, 1)) {
        settings.rough.amount = rough;
    }

    Times run() {
        Times times;
        times.take("total", [&] { checked(fracture::fracture(mesh, sites, settings, workspace, pieces)); });
        for (const fracture::Milliseconds& phase : pieces.timings)
            times.phases.emplace_back(phase.phase, phase.milliseconds);
        return times;
    }
};

// A cube in 200 pieces that falls 2 m and becomes a heap.
Times fall() {
    static Fracture cube(fracture::cube(1.0), 200);
    if (cube.pieces.pieces.empty()) (void)cube.run();
    physics::World world({.threads = 1});
    Times times;
    times.take("bodies", [&] {
        checked(physics::add_pieces(world, cube.pieces, {}, {.placement = {{0.0f, 2.5f, 0.0f}, {1, 0, 0, 0}}}));
    });
    const auto steps = [&](const std::string& phase, int count) {
        times.take(phase, [&] {
            for (int step = 0; step < count; ++step) world.step();
        });
    };
    steps("fall", 75);
    steps("impact", 30);
    steps("heap", 60);
    return times;
}

// A ball that a blow breaks: the cut, hulls and masses, and the steps until they are committed.
Times blow() {
    physics::BreakableDesc desc;
    desc.solid = {.material = physics::material_preset("stone")->material, .min_size = 0.01};
    desc.max_pieces = 34;
    Times times;
    physics::SolidPtr ball;
    times.take("solid", [&] { ball = *checked(physics::make_solid(fracture::icosphere(5, 0.3), desc.solid)); });
    physics::World world({.threads = 1, .ground_height = {}});
    physics::Destruction destruction; // update() waits for a cut that is due
    checked(destruction.add(world, ball, desc));
    destruction.strike(world, destruction.pieces()[0], {0.0f, 0.3f, 0.0f}, {0.0f, -1.0f, 0.0f}, 1e4);
    times.take("blow", [&] {
        for (int step = 0; step < 1000 && (step == 0 || destruction.jobs_in_flight() > 0); ++step) {
            world.step();
            destruction.update(world);
        }
    });
    if (destruction.statistics().breaks == 0) throw std::runtime_error("the blow breaks nothing");
    return times;
}

} // namespace

int main(int count, char**) {
    Fracture ball(fracture::icosphere(6), 100), statue(fracture::statue(96), 1000),
        lattice(fracture::lattice_cube(48), 1), rough(fracture::statue(64), 30, 0.5);
    lattice.sites.clear(); // bisectors through vertices and along edges
    for (int k = 0; k < 64; ++k) lattice.sites.push_back(glm::dvec3(k % 4, k / 4 % 4, k / 16) * 0.5 - glm::dvec3(0.75));
    const std::map<std::string, std::function<Times()>> cases{
        {"ball", [&] { return ball.run(); }},
        {"statue", [&] { return statue.run(); }},
        {"lattice", [&] { return lattice.run(); }},
        {"rough", [&] { return rough.run(); }},
        {"fall", fall},
        {"blow", blow},
    };
    if (count > 1) {
        for (const auto& [name, run] : cases) std::cout << name << '\n';
        return 0;
    }
    for (std::string line; std::getline(std::cin, line);) {
        try {
            const Times times = cases.at(line)();
            for (const auto& [phase, milliseconds] : times.phases) std::cout << phase << '=' << milliseconds << ' ';
            std::cout << std::endl;
        } catch (const std::exception& error) {
            std::cout << "failed " << error.what() << std::endl;
        }
    }
    return 0;
}
