// The interface of tools/compare --physics for peers in C++. docs/benchmark-physics.md describes protocol and files.
//
//     struct Simulation {
//         Simulation(const RigidScene& scene, const std::vector<std::string>& words); // what is not measured
//         void step();                                                                // what is measured
//         BodyPose pose(size_t body) const;
//     };
//     int main(int count, char** words) { return serve_physics<Simulation>(count, words, "Peer 1.2"); }
#pragma once

#include <algorithm>
#include <chrono>
#include <exception>
#include <iostream>
#include <stdexcept>
#include <string>
#include <vector>

#include "tools/comparison/adapters/rigid_scene.h"

namespace brittle::comparison {

// Called as: ADAPTER SCENE THREADS [WORD...]. Answers the lines of its standard input until that ends.
template<class Simulation>
int serve_physics(int count, char** words, const std::string& version) {
    if (count < 3) {
        std::cerr << "usage: " << words[0] << " SCENE THREADS, see docs/benchmark-physics.md\n";
        return 2;
    }
    RigidScene scene;
    const std::vector<std::string> own(words + 3, words + count);
    try {
        scene = read_scene(words[1]);
        scene.threads = static_cast<unsigned>(std::stoul(words[2]));
    } catch (const std::exception& error) {
        std::cout << "failed " << error.what() << std::endl;
        return 1;
    }
    std::cout << "ready " << version << std::endl;
    Trajectory trajectory;
    for (std::string line; std::getline(std::cin, line);) {
        try {
            if (line == "run") {
                Simulation simulation(scene, own);
                trajectory = {.bodies = static_cast<uint32_t>(scene.bodies.size())};
                const auto record = [&] {
                    for (size_t k = 0; k < scene.bodies.size(); ++k) trajectory.poses.push_back(simulation.pose(k));
                    ++trajectory.records;
                };
                record();
                std::vector<double> times;
                for (uint32_t step = 1; step <= scene.steps; ++step) {
                    const auto begin = std::chrono::steady_clock::now();
                    simulation.step();
                    const std::chrono::duration<double, std::milli> time = std::chrono::steady_clock::now() - begin;
                    times.push_back(time.count());
                    if (step % scene.steps_a_record == 0) record();
                }
                std::ranges::sort(times);
                const auto share = [&](size_t percent) {
                    return times.empty() ? 0.0 : times[(times.size() * percent + 99) / 100 - 1];
                };
                std::cout << "done " << share(50) << ' ' << share(95) << ' ' << share(100) << std::endl;
            } else if (line.starts_with("write ")) {
                write_poses(line.substr(6), trajectory);
                std::cout << "written" << std::endl;
            }
        } catch (const std::exception& error) {
            std::cout << "failed " << error.what() << std::endl;
        }
    }
    return 0;
}

} // namespace brittle::comparison
