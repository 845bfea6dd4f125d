// Runs of recipes and replays of their logs in the C interface.
#include <memory>
#include <optional>
#include <utility>

#include <glm/gtc/quaternion.hpp>

#include "bindings/c/events.h"
#include "bindings/c/scenario.h"
#include "tools/scenario/recipe/json_reader.h"
#include "tools/scenario/replay/action_json.h"
#include "tools/scenario/replay/player.h"
#include "tools/scenario/replay/recorder.h"
#include "tools/scenario/run/loaded_run.h"
#include "tools/scenario/run/simulation.h"

using namespace brittle;

struct brittle_run {
    explicit brittle_run(const tools::FractureOptions& options) : simulation(options.material), recorder(options) {}

    tools::LoadedRun loaded;
    tools::Simulation simulation;
    tools::Recorder recorder;
};

namespace brittle::c {

namespace {

const tools::PreparedObject& object_at(const brittle_run& run, uint32_t object) {
    const auto& all = run.loaded.objects();
    if (object >= all.size())
        refuse("there is no object " + std::to_string(object) + "; there are " + std::to_string(all.size()));
    return all[object];
}

std::unique_ptr<brittle_mesh> mesh_of(fracture::TriangleMesh triangles) {
    fracture::Model model;
    model.mesh = std::move(triangles);
    return std::unique_ptr<brittle_mesh>(new brittle_mesh{std::make_shared<const fracture::Model>(std::move(model))});
}

const tools::Input& input_of(const brittle_run& run, uint32_t object) {
    return run.loaded.of_scene() ? *run.loaded.scene.objects[object].input : run.loaded.input;
}

} // namespace

} // namespace brittle::c

using c::guarded_run;
using c::need;
using c::refuse;

extern "C" {

brittle_status brittle_run_start(const brittle_recipe* recipe, const brittle_load_settings* settings, brittle_run** out,
                                 brittle_error* error) {
    return guarded_run(error, [&] {
        need(out, "out");
        const c::Caller caller(settings);
        const tools::FractureOptions options = caller.options_of(need(recipe, "recipe"));
        auto run = std::make_unique<brittle_run>(options);
        run->loaded = tools::load_run(options, caller.host, false, caller.progress);
        run->simulation.observe(&run->recorder);
        run->loaded.start(run->simulation, caller.host, caller.progress);
        *out = run.release();
    });
}

void brittle_run_free(brittle_run* run) {
    const c::JsonMemory memory; // a run that was not finished writes its log
    delete run;
}

brittle_status brittle_run_notes(const brittle_run* run, brittle_text** out, brittle_error* error) {
    return guarded_run(error, [&] {
        need(out, "out");
        std::string lines;
        for (const std::string& note : need(run, "run").loaded.scene.notes) lines += note + "\n";
        *out = new brittle_text{std::move(lines)};
    });
}

brittle_status brittle_run_act(brittle_run* run, const char* action, brittle_error* error) {
    return guarded_run(error, [&] {
        tools::Simulation& simulation = need(run, "run").simulation;
        const std::filesystem::path where("action");
        const nlohmann::ordered_json json = tools::parse_json(where, c::read_text(action, "action"), "action");
        tools::JsonReader reader(where, json, "");
        const std::optional<tools::Action> read = tools::read_action(where, reader, simulation.number_count());
        reader.refuse_unknown_keys();
        if (!read) refuse("action names none of the actions of a replay log, such as \"shoot\" and \"hammer\"");
        simulation.apply(*read);
    });
}

brittle_status brittle_run_step(brittle_run* run, uint32_t steps, brittle_error* error) {
    return guarded_run(error, [&] {
        tools::Simulation& simulation = need(run, "run").simulation;
        for (uint32_t k = 0; k < steps; ++k) simulation.step();
    });
}

brittle_status brittle_run_time(const brittle_run* run, uint64_t* steps, double* step_seconds, brittle_error* error) {
    return guarded_run(error, [&] {
        const tools::Simulation& simulation = need(run, "run").simulation;
        if (steps) *steps = simulation.steps();
        if (step_seconds) *step_seconds = static_cast<double>(simulation.world().settings().step);
    });
}

brittle_status brittle_run_state_hash(const brittle_run* run, uint64_t* out, brittle_error* error) {
    return guarded_run(error, [&] {
        need(out, "out");
        *out = need(run, "run").simulation.state_hash();
    });
}

brittle_status brittle_run_transforms(const brittle_run* run, brittle_transform* out, uint64_t capacity,
                                      uint64_t* count, brittle_error* error) {
    return guarded_run(error, [&] {
        const tools::Simulation& simulation = need(run, "run").simulation;
        const physics::Destruction* const destruction = simulation.destruction();
        c::Transforms transforms =
            destruction ? c::Transforms(*destruction, out, capacity) : c::Transforms(out, capacity);
        simulation.visit_poses(1.0f, 0, [&](uint32_t slot, const physics::Pose& pose) { transforms.add(slot, pose); });
        if (count) *count = transforms.count();
    });
}

brittle_status brittle_run_balls(const brittle_run* run, brittle_ball* out, uint64_t capacity, uint64_t* count,
                                 brittle_error* error) {
    return guarded_run(error, [&] {
        const tools::Simulation& simulation = need(run, "run").simulation;
        const auto balls = simulation.balls();
        for (uint64_t k = 0; out && k < std::min<uint64_t>(capacity, balls.size()); ++k) {
            c::put(simulation.world().pose(balls[k].body), out[k].position, out[k].orientation);
            out[k].radius = balls[k].radius;
        }
        if (count) *count = balls.size();
    });
}

brittle_status brittle_run_events(brittle_run* run, brittle_events** out, brittle_error* error) {
    return guarded_run(error, [&] {
        need(out, "out");
        *out = c::events_of(need(run, "run").simulation.take_events());
    });
}

brittle_status brittle_run_object_count(const brittle_run* run, uint32_t* out, brittle_error* error) {
    return guarded_run(error, [&] {
        need(out, "out");
        *out = static_cast<uint32_t>(need(run, "run").loaded.objects().size());
    });
}

brittle_status brittle_run_object_get(const brittle_run* run, uint32_t object, brittle_run_object* out,
                                      brittle_error* error) {
    return guarded_run(error, [&] {
        const tools::PreparedObject& one = c::object_at(need(run, "run"), object);
        brittle_run_object made{};
        made.struct_size = sizeof made;
        made.is_fixed = one.fixed() ? 1 : 0;
        made.name = one.name.c_str();
        made.material = one.material.c_str();
        c::put(one.placement, made.position, made.orientation);
        made.piece_count = one.fixed() ? 1 : static_cast<uint32_t>(one.fragments->pieces.size());
        c::write_struct(made, out, "out");
    });
}

brittle_status brittle_run_object_pieces(const brittle_run* run, uint32_t object, brittle_pieces** out,
                                         brittle_error* error) {
    return guarded_run(error, [&] {
        need(out, "out");
        const tools::PreparedObject& one = c::object_at(need(run, "run"), object);
        if (one.fixed()) refuse("object " + std::to_string(object) + " is fixed, and a surface without pieces");
        const tools::Input& input = c::input_of(*run, object);
        auto pieces = std::make_unique<brittle_pieces>();
        fracture::Model model;
        model.mesh = input.model.mesh;
        pieces->source = std::make_shared<const fracture::Model>(std::move(model));
        pieces->sites = input.sites;
        pieces->fragments = *one.fragments;
        *out = pieces.release();
    });
}

brittle_status brittle_run_object_mesh(const brittle_run* run, uint32_t object, brittle_mesh** out,
                                       brittle_error* error) {
    return guarded_run(error, [&] {
        need(out, "out");
        const tools::PreparedObject& one = c::object_at(need(run, "run"), object);
        *out = c::mesh_of(one.fixed() ? *one.surface : c::input_of(*run, object).model.mesh).release();
    });
}

brittle_status brittle_run_save_log(const brittle_run* run, const char* path, brittle_error* error) {
    return guarded_run(error, [&] { need(run, "run").recorder.save(c::read_path(path, "path")); });
}

brittle_status brittle_replay(const char* path, const brittle_load_settings* settings, brittle_replay_result* out,
                              brittle_error* error) {
    return guarded_run(error, [&] {
        need(out, "out");
        const std::string file = c::read_file_name(path, "path");
        const c::Caller caller(settings);
        tools::ReplayLog log = tools::read_replay_log(file);
        log.recipe.threads = caller.threads;
        tools::LoadedRun run = tools::load_run(log.recipe, caller.host);
        tools::Player player(log);
        tools::Simulation simulation(log.recipe.material);
        simulation.observe(&player);
        tools::follow(log, simulation);
        run.start(simulation, caller.host);
        if (!player.difference()) tools::schedule(log, simulation); // actions name pieces of the log
        while (!player.done() && !player.difference()) {
            tools::throw_if_cancelled(caller.host);
            simulation.step();
            if (caller.progress)
                caller.progress(static_cast<double>(simulation.steps()) / static_cast<double>(log.states.size()));
        }
        brittle_replay_result made{};
        made.struct_size = sizeof made;
        made.is_equal = player.difference() ? 0 : 1;
        made.steps = log.states.size() - 1;
        made.actions = log.actions.size();
        made.state_hash = simulation.state_hash();
        if (player.difference()) {
            made.first_difference = player.difference()->step;
            std::string what = player.difference()->what;
            if (const std::string other = tools::other_build(log); !other.empty())
                what += "; it was recorded with " + other + ", and states are equal on one build and machine only";
            what.resize(std::min(what.size(), sizeof made.difference - 1));
            std::copy(what.begin(), what.end(), made.difference);
        }
        c::write_struct(made, out, "out");
    });
}

} // extern "C"
