// The files of tools/compare --physics: a scene of rigid bodies, and the poses that a peer makes of it.
// docs/benchmark-physics.md describes both. Right-handed, Y up, metres, kilograms, seconds, radians.
#pragma once

#include <array>
#include <cstdint>
#include <cstdio>
#include <fstream>
#include <stdexcept>
#include <string>
#include <string_view>
#include <vector>

namespace brittle::comparison {

using Numbers3 = std::array<double, 3>;
using Numbers4 = std::array<double, 4>;

// Position of the centre of mass; orientation as x, y, z, w, unit: body axes to world axes.
struct BodyPose {
    Numbers3 position{};
    Numbers4 orientation{0.0, 0.0, 0.0, 1.0};
};

// The frame of a body has its origin at the centre of mass, and its axes are the principal axes of inertia. Coefficients
// of friction and of restitution of two bodies that touch are multiplied.
struct BodyNumbers {
    double mass = 1.0;
    Numbers3 moments{}; // of inertia, kg m^2
    BodyPose pose{};
    Numbers3 velocity{}, angular_velocity{}; // world axes
    double friction = 0.0, restitution = 0.0;
};
struct RigidBody {
    bool fixed = false;
    BodyNumbers numbers{};
    std::vector<Numbers3> corners{}; // their convex hull is the solid; body axes
};

struct SceneNumbers {
    Numbers3 gravity{};
    double step = 0.0;
    double ground_friction = 0.0, ground_restitution = 0.0;
};
struct RigidScene {
    uint32_t steps = 0, steps_a_record = 1;
    bool ground = false; // y = 0, solid below
    unsigned threads = 1;
    SceneNumbers numbers{};
    std::vector<RigidBody> bodies{};
};

inline constexpr std::string_view scene_magic = "scene 1\n", poses_magic = "poses 1\n";

// Reads values of a file one after the other. Throws std::runtime_error that names the file.
struct FileReader {
    FileReader(std::string file, std::string_view magic)
        : name(std::move(file)), in(name, std::ios::binary | std::ios::ate) {
        if (!in) throw std::runtime_error(name + ": cannot be read");
        left = static_cast<uint64_t>(in.tellg());
        in.seekg(0);
        std::string begin(magic.size(), ' ');
        if (left < magic.size()) throw std::runtime_error(name + ": ends early; write it again");
        take(begin.data(), begin.size());
        if (begin != magic)
            throw std::runtime_error(name + ": does not begin with '" + std::string(magic.substr(0, magic.size() - 1))
                                     + "'; give the file that docs/benchmark-physics.md describes");
    }
    void take(void* to, uint64_t bytes) {
        if (bytes > left || !in.read(static_cast<char*>(to), static_cast<std::streamsize>(bytes)))
            throw std::runtime_error(name + ": ends early; write it again");
        left -= bytes;
    }
    std::string name;
    std::ifstream in;
    uint64_t left = 0; // bytes
};

inline RigidScene read_scene(const std::string& name) {
    FileReader file(name, scene_magic);
    std::array<uint32_t, 4> counts{};
    file.take(counts.data(), sizeof counts);
    RigidScene scene{.steps = counts[0], .steps_a_record = counts[1], .ground = counts[2] != 0};
    file.take(&scene.numbers, sizeof scene.numbers);
    if (!(scene.numbers.step > 0.0) || scene.steps_a_record == 0)
        throw std::runtime_error(name + ": the step and the steps of a record must be above 0");
    for (uint32_t k = 0; k < counts[3]; ++k) {
        RigidBody& body = scene.bodies.emplace_back();
        std::array<uint32_t, 2> sizes{};
        file.take(sizes.data(), sizeof sizes);
        file.take(&body.numbers, sizeof body.numbers);
        if (sizes[1] < 4 || sizes[1] * uint64_t{sizeof(Numbers3)} > file.left)
            throw std::runtime_error(name + ": body " + std::to_string(k) + " has " + std::to_string(sizes[1])
                                     + " corners; it needs 4, and no more than the file holds");
        body.fixed = sizes[0] != 0;
        body.corners.resize(sizes[1]);
        file.take(body.corners.data(), body.corners.size() * sizeof(Numbers3));
    }
    return scene;
}

// Records one after the other, each with the pose of each body. The first one is the start.
struct Trajectory {
    uint32_t bodies = 0, records = 0;
    std::vector<BodyPose> poses{};

    [[nodiscard]] const BodyPose& at(uint32_t record, size_t body) const {
        return poses[size_t{record} * bodies + body];
    }
};

// Writes to a temporary name and renames.
template<class Write>
void write_file(const std::string& name, std::string_view magic, const Write& write) {
    const std::string temporary = name + ".new";
    std::ofstream out(temporary, std::ios::binary);
    out << magic;
    write([&](const void* from, size_t bytes) {
        out.write(static_cast<const char*>(from), static_cast<std::streamsize>(bytes));
    });
    if (!out.flush()) throw std::runtime_error(temporary + ": cannot be written");
    out.close();
    if (std::rename(temporary.c_str(), name.c_str()) != 0) throw std::runtime_error(name + ": cannot be written");
}

inline void write_poses(const std::string& name, const Trajectory& trajectory) {
    write_file(name, poses_magic, [&](const auto& put) {
        const std::array<uint32_t, 2> counts{trajectory.bodies, trajectory.records};
        put(counts.data(), sizeof counts);
        put(trajectory.poses.data(), trajectory.poses.size() * sizeof(BodyPose));
    });
}

} // namespace brittle::comparison
