// The options of WorldOptions: engine, bonds, anchors, shots, breaking at runtime, limits.
#include <vector>

#include "tools/brittle/commands/option_groups.h"
#include "tools/brittle/commands/option_values.h"

namespace brittle::tools {

namespace {

void add_engine_option(CLI::App& command, WorldOptions& world) {
    const auto set_engine = [&world](const std::string& name) {
        world.engine = name == "bullet" ? physics::EngineKind::bullet : physics::EngineKind::solver;
    };
    command
        .add_option_function<std::string>(
            "--physics", set_engine,
            "Physics engine. solver: Brittle's own. bullet: stock Bullet, a reference for comparison, which ignores "
            "--air-density.")
        ->check(CLI::IsMember({"solver", "bullet"}))
        ->type_name("NAME")
        ->default_str("solver");
}

void add_bond_options(CLI::App& command, WorldOptions& world) {
    command.add_flag("--bonded", world.bonded,
                     "Bond the pieces, so that they hold together until blows or loads break the bonds");
    command.add_flag("--anchored", world.anchored,
                     "Fix the parts that stand on the ground. Implies --bonded, except with --breakable.");
    command
        .add_option_function<std::vector<std::string>>(
            "--anchor",
            [&world](const std::vector<std::string>& anchors) {
                world.anchors.clear();
                for (const std::string& text : anchors) world.anchors.push_back(parse_anchor(text));
            },
            "Fix the part of the mesh within RADIUS of a point, metres from the middle of the mesh's foot, with the "
            "mesh 2 m long. Implies --bonded, except with --breakable. May be given several times.")
        ->type_name("X,Y,Z,RADIUS");
    command
        .add_option_function<std::vector<std::string>>(
            "--shot",
            [&world](const std::vector<std::string>& shots) {
                world.shots.clear();
                for (const std::string& text : shots) world.shots.push_back(parse_shot(text));
            },
            "Shoot a steel ball from a point at a velocity in m/s after SECONDS (0 if not given). Lengths are metres, "
            "with the mesh 2 m long above the origin of the ground. May be given several times.")
        ->type_name("X,Y,Z,VX,VY,VZ,RADIUS[,SECONDS]");
    command
        .add_option("--strength", world.strength,
                    "Strength of bonds and breakable pieces, as a multiple of the material's. 0.075 is stone laid in "
                    "weak mortar.")
        ->check(number_from(1e-6, 1e6))
        ->capture_default_str();
}

void add_breaking_options(CLI::App& command, WorldOptions& world) {
    command.add_flag("--breakable", world.breakable,
                     "Cut pieces again wherever they are hit hard enough. Without --bonded the mesh starts whole: a "
                     "blow cuts by the kind of --pattern, or along the diagram of --sites, fitted to the piece that is "
                     "hit; --anchored fixes the foot of the mesh.");
    command
        .add_option("--min-size", world.min_size,
                    "Minimum size of a piece cut by a blow: the cube root of its volume, metres")
        ->check(number_from(1e-4, 10.0))
        ->capture_default_str();
    command.add_option("--blow-pieces", world.blow_pieces, "Maximum number of pieces that one blow cuts from a piece")
        ->check(number_from(2, 1000))
        ->capture_default_str();
    command
        .add_option("--piece-limit", world.piece_limit,
                    "Maximum number of pieces in a breakable world, bonded or not. Debris beyond it is removed, first "
                    "outside the picture, then by size and age. With --bonded alone nothing is removed.")
        ->check(number_from(1, 1'000'000))
        ->capture_default_str();
}

void add_air_and_crowd_options(CLI::App& command, WorldOptions& world) {
    command
        .add_option("--air-density", world.air_density,
                    "Density of the air, which slows moving pieces, kg/m^3. 0 is a vacuum.")
        ->check(number_from(0.0, 1e4))
        ->capture_default_str();
    auto* max_colliding =
        command
            .add_option("--max-colliding", world.max_colliding,
                        "Maximum number of awake pieces that collide as hulls. Further pieces that break off touch "
                        "pieces of their size as ellipsoids. The limit keeps frames short; 0 removes it.")
            ->check(number_from(0, 1'000'000))
            ->capture_default_str();
    // The former name of --max-colliding. The empty group hides it from the help.
    command.add_option("--most-colliding", world.max_colliding)
        ->check(number_from(0, 1'000'000))
        ->excludes(max_colliding)
        ->group("");
    command
        .add_option("--height", world.height,
                    "Initial height of the mesh above the ground, metres. Ignored with --anchored.")
        ->check(number_from(0.0, 100.0))
        ->capture_default_str();
}

} // namespace

void add_world_options(CLI::App& command, WorldOptions& world) {
    start_group(command, "Physics");
    add_engine_option(command, world);
    add_bond_options(command, world);
    add_breaking_options(command, world);
    add_air_and_crowd_options(command, world);
}

} // namespace brittle::tools
