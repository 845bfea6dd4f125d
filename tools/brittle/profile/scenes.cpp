#include "tools/brittle/profile/scenes.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <thread>
#include <utility>

#include "tools/brittle/base/interrupt.h"
#include "tools/brittle/base/progress.h"
#include "tools/brittle/profile/timed_frames.h"
#include "tools/brittle/stage/loading.h"
#include "tools/brittle/stage/stage.h"

namespace brittle::tools {

namespace {

struct Started {
    LoadedScene scene{};
    std::vector<PreparedObject> objects{};
    int64_t begin = 0, read = 0, end = 0; // trace_clock(); the meshes were read at `read`
};

Started start(const Scenario& scenario, engine::Renderer* renderer) {
    const Host host = renderer ? drawing_host() : program_host();
    Started started{.begin = trace_clock()};
    started.scene = open_scene(scenario.fracture, host);
    started.read = trace_clock();
    started.objects = prepare_scene(started.scene, host, renderer ? payload_maker(*renderer) : DrawingMaker{});
    started.end = trace_clock();
    return started;
}

size_t pieces_of(const PreparedObject& object) {
    return std::max(object.bodies.solids.size(), object.bodies.hulls.size()); // one of both is empty
}

} // namespace

SceneTimes measure_starts(const Scenario& scenario, const ProfilePlan& plan, engine::Renderer* renderer, Trace* trace) {
    SceneTimes times;
    Progress progress("starting " + scenario.name);
    const uint32_t runs = plan.warm_up + plan.repeats;
    for (uint32_t run = 0; run < runs; ++run) {
        throw_if_interrupted();
        const Started started = start(scenario, renderer);
        const double milliseconds = milliseconds_between(started.begin, started.end);
        progress.update(static_cast<double>(run + 1) / runs);
        if (trace) {
            trace->add(Track::main, 1, "start", started.begin, started.end);
            trace->add(Track::main, 2, "read", started.begin, started.read);
            trace->add(Track::main, 2, "prepare", started.read, started.end);
        }
        if (run == 0) {
            times.first_milliseconds = milliseconds;
            times.objects = started.objects.size();
            times.notes = started.scene.notes;
            for (const LoadedObject& object : started.scene.objects)
                times.triangles += object.input->model.mesh.triangles.size();
            for (const PreparedObject& object : started.objects) times.pieces += pieces_of(object);
        }
        if (run < plan.warm_up) continue;
        times.start.add("read", milliseconds_between(started.begin, started.read));
        times.start.add("prepare", milliseconds_between(started.read, started.end));
        times.start.add("total", milliseconds);
    }
    return times;
}

SceneFrames measure_scene_frames(const Scenario& scenario, const ProfilePlan& plan, const ViewOptions& view,
                                 engine::Renderer& renderer, Trace* trace) {
    using Time = TimedFrames::Time;
    SceneFrames times;
    Started started = start(scenario, &renderer);
    Stage stage(renderer, started.scene.home);
    TimedFrames frames(stage, view, renderer, trace);
    Progress progress("rendering " + scenario.name);
    times.milliseconds.push_back(frames.draw(times.starting, Time::stands_still,
                                             [&] { stage.stand(std::move(started.objects), started.scene.world); }));
    for (uint32_t frame = 0; frame < plan.frames; ++frame) {
        times.milliseconds.push_back(frames.draw(times.standing, Time::stands_still));
        progress.update(0.5 * (frame + 1) / plan.frames);
    }
    times.playing_from = times.milliseconds.size();
    // At the pace of the scene's time: the threads that cut are as late, or in time, as in the window.
    auto due = std::chrono::steady_clock::now();
    for (uint32_t frame = 0; frame < plan.frames; ++frame) {
        std::this_thread::sleep_until(due);
        due += std::chrono::microseconds(std::llround(1e6 * TimedFrames::seconds));
        times.milliseconds.push_back(frames.draw(times.playing));
        progress.update(0.5 + 0.5 * (frame + 1) / plan.frames);
    }
    const Simulation& simulation = stage.simulation();
    times.pieces = simulation.piece_count();
    if (const physics::Destruction* destruction = simulation.destruction()) {
        times.cuts = destruction->statistics().commits;
        times.pieces = destruction->pieces().size();
    }
    return times;
}

} // namespace brittle::tools
