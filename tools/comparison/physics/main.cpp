// The scenes of tools/compare --physics, and the judge of what peers make of them.
//
//     compare_physics list                  a line a scene: name, title
//     compare_physics scene NAME FILE       writes the scene; prints its bodies, steps and seconds of a step
//     compare_physics judge NAME SCENE POSES    one line of JSON about a trajectory
//
// Exit 1 where a file cannot be read or written or there is no such scene, 2 for a wrong command line.
#include <iostream>
#include <string>
#include <vector>

#include "tools/comparison/physics/judge.h"
#include "tools/comparison/physics/scenes.h"

namespace brittle::comparison {

namespace {

int run(const std::vector<std::string>& words) {
    const std::string task = words.empty() ? "" : words[0];
    if (task == "list" && words.size() == 1) {
        for (const SceneInfo& info : scene_infos()) std::cout << info.name << '\t' << info.title << '\n';
        return 0;
    }
    if (task == "scene" && words.size() == 3) {
        const RigidScene scene = make_scene(scene_info(words[1]));
        write_scene(words[2], scene);
        std::cout << scene.bodies.size() << ' ' << scene.steps << ' ' << scene.numbers.step << std::endl;
        return 0;
    }
    if (task == "judge" && words.size() == 4) {
        const Judgement verdict = judge(scene_info(words[1]), read_scene(words[2]), read_poses(words[3]));
        std::cout << R"({"truth": ")" << verdict.truth << R"(", "result": ")" << verdict.result << R"(", "reason": ")"
                  << verdict.reason() << "\"}" << std::endl;
        return 0;
    }
    std::cerr << "usage: compare_physics list\n"
                 "       compare_physics scene NAME FILE\n"
                 "       compare_physics judge NAME SCENE POSES\n";
    return 2;
}

} // namespace

} // namespace brittle::comparison

int main(int count, char** words) {
    try {
        return brittle::comparison::run({words + 1, words + count});
    } catch (const std::exception& error) {
        std::cerr << "compare_physics: " << error.what() << '\n';
        return 1;
    }
}
