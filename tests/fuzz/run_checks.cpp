#include "tests/fuzz/run_checks.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <filesystem>
#include <string>
#include <string_view>

#include <glm/common.hpp>

#include "fracture/pieces/certificate.h"
#include "tests/fuzz/oracle.h"
#include "tools/scenario/base/failure.h"
#include "tools/scenario/run/loaded_run.h"

namespace brittle::fuzz {

namespace {

using tools::FractureOptions;
using tools::SceneObject;

constexpr uint32_t max_sites = 40;

// Shapes whose number is the edge of a lattice, or a number of halvings, grow fast with it; statues are slow.
bool is_small(std::string_view shape) {
    const size_t colon = shape.rfind(':');
    uint32_t number = 0;
    const bool numbered =
        std::from_chars(shape.data() + colon + 1, shape.data() + shape.size(), number).ec == std::errc{};
    const auto is = [&](std::string_view name) { return shape.starts_with("shape:" + std::string(name)); };
    if (is("statue") || is("lattice_cube") || is("menger_sponge") || is("torus_knot")) return false;
    if (is("animal") || is("torus") || is("tower") || is("arch")) return numbered && number <= 12;
    if (is("icosphere")) return numbered && number <= 2;
    if (is("domino_spiral") || is("pyramid") || is("stack") || is("card_house")) return numbered && number <= 4;
    return !numbered || number <= 16;
}

void name_in(const std::filesystem::path& folder, std::string& file) {
    if (!file.empty()) file = (folder / std::filesystem::path(file).filename()).string();
}

void bound_vector(glm::dvec3& v, double low, double high) {
    v = glm::clamp(v, glm::dvec3(low), glm::dvec3(high));
}

void bound(tools::WorldOptions& world) {
    world.shots.resize(std::min<size_t>(world.shots.size(), 4));
    for (tools::Shot& shot : world.shots) shot.time = std::min(shot.time, 0.1);
    world.joints.resize(std::min<size_t>(world.joints.size(), 6));
    for (tools::JointOptions& joint : world.joints) joint.links = std::min(joint.links, 8u);
    world.anchors.resize(std::min<size_t>(world.anchors.size(), 6));
    world.blow_pieces = std::min(world.blow_pieces, 12u);
    world.piece_limit = std::min(world.piece_limit, 300u);
    world.min_size = std::max(world.min_size, 0.15); // a ball of several metres grinds all to this size
    bound_vector(world.bond.brick, 0.1, 10.0);
}

bool bound_mesh(std::string& mesh) {
    if (mesh.starts_with("shape:")) return is_small(mesh);
    name_in(BRITTLE_CORPUS "/meshes", mesh);
    return true;
}

// Of a mesh and its fracture.
bool bound_fracture(FractureOptions& options) {
    options.threads = 1;
    name_in(BRITTLE_ASSETS "/sites", options.sites_file);
    options.pattern.count = std::min(options.pattern.count, max_sites);
    options.pattern.cells_per_piece = std::min(options.pattern.cells_per_piece, 4u);
    options.pattern.piece_size = options.pattern.piece_size > 0.0 ? std::max(options.pattern.piece_size, 0.6) : 0.0;
    options.points.resize(std::min<size_t>(options.points.size(), max_sites));
    if (options.automatic) options.automatic->scale = std::max(options.automatic->scale, 4.0);
    options.strikes.resize(std::min<size_t>(options.strikes.size(), 2));
    for (tools::Strike& strike : options.strikes) strike.pieces = std::min(strike.pieces, 12u);
    options.rough.detail = std::min(options.rough.detail, 2u);
    if (options.rough.wavelength > 0.0) options.rough.wavelength = std::max(options.rough.wavelength, 0.5);
    bound(options.world);
    return bound_mesh(options.mesh);
}

void check_pieces(const tools::LoadedRun& run) {
    if (run.of_scene()) return;
    const fracture::Certificate certificate = fracture::certify(run.input.model.mesh, *run.fragments, 1);
    require(certificate.closed || run.recipe.algorithm != fracture::Algorithm::exact, "a piece is open");
    require(certificate.volume_error <= fracture::max_volume_error, "the pieces do not have the volume of the mesh");
}

void check_state(const tools::Simulation& simulation) {
    const auto finite = [](const glm::vec3& v) {
        return std::isfinite(v.x) && std::isfinite(v.y) && std::isfinite(v.z);
    };
    const physics::World& world = simulation.world();
    for (const physics::BodyId body : world.bodies()) {
        const physics::Pose pose = world.pose(body);
        const glm::quat& q = pose.orientation;
        require(finite(pose.position) && std::isfinite(q.x + q.y + q.z + q.w), "a body at no place");
        require(finite(world.linear_velocity(body)) && finite(world.angular_velocity(body)), "a body of no speed");
    }
}

} // namespace

bool bound(FractureOptions& options) {
    bool small = bound_fracture(options);
    if (!options.level.mesh.empty()) name_in(BRITTLE_CORPUS "/meshes", options.level.mesh);
    for (tools::LevelRule& rule : options.level.rules) small = bound_fracture(rule.then.recipe) && small;
    options.objects.resize(std::min<size_t>(options.objects.size(), 4));
    for (SceneObject& object : options.objects) {
        small = bound_fracture(object.recipe) && small;
        // Bumps are as wide as a part of the object: one that is long and thin has millions.
        if (!(object.recipe.rough.amount > 0.0)) continue;
        bound_vector(object.placement.shear, -1.0, 1.0);
        for (int axis = 0; axis < 3; ++axis) {
            double& scale = object.placement.scale[axis];
            scale = std::copysign(std::clamp(std::abs(scale), 0.3, 3.0), scale);
        }
    }
    return small;
}

bool run_or_fail(const std::function<void()>& run) {
    try {
        run();
    } catch (const tools::Failure& failure) {
        require(failure.code() == tools::exit_input || failure.code() == tools::exit_mesh
                    || failure.code() == tools::exit_usage,
                failure.what());
        check_message(failure.what(), true);
        return false;
    }
    return true;
}

void run(const FractureOptions& options, tools::Simulation& simulation, uint64_t steps,
         const std::function<void()>& started) {
    tools::LoadedRun run = tools::load_run(options);
    check_pieces(run);
    run.start(simulation);
    if (started) started();
    check_state(simulation);
    for (uint64_t step = 0; step < steps; ++step) {
        simulation.step();
        static_cast<void>(simulation.take_events());
        check_state(simulation);
    }
}

} // namespace brittle::fuzz
