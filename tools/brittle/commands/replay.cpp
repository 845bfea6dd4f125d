#include <cstdio>
#include <memory>
#include <optional>
#include <utility>

#include "tools/brittle/base/console.h"
#include "tools/brittle/base/device_failure.h"
#include "tools/brittle/base/interrupt.h"
#include "tools/brittle/base/progress.h"
#include "tools/brittle/commands/commands.h"
#include "tools/brittle/commands/report.h"
#include "tools/brittle/pictures/film.h"
#include "tools/brittle/pictures/view.h"
#include "tools/brittle/stage/loading.h"
#include "tools/brittle/stage/stage.h"
#include "tools/scenario/base/failure.h"
#include "tools/scenario/replay/player.h"
#include "tools/scenario/run/loaded_run.h"
#include "tools/scenario/run/state_export.h"

namespace brittle::tools {

namespace {

void run_steps(Simulation& simulation, const Player& player, uint64_t steps) {
    Progress progress("replaying");
    while (!player.done() && !player.difference()) {
        throw_if_interrupted();
        simulation.step();
        progress.update(static_cast<double>(simulation.steps()) / static_cast<double>(steps));
    }
}

// The run of a log, and what the command line asks of it.
struct Replayed {
    const ReplayCommand& command;
    const ReplayLog& log;
    ExportSettings pieces;
    LoadedRun run;
};

Replayed load(const ReplayCommand& command, const ReplayLog& log) {
    ExportSettings pieces = command.pieces(log.recipe);
    check_export_of_scene(log.recipe, pieces);
    const bool exports = !pieces.output.empty();
    const bool draws = !command.pictures.empty() || !command.video.empty();
    const InterruptDeadline deadline; // nothing is lost yet
    return {command, log, std::move(pieces),
            load_run(log.recipe, draws ? drawing_host() : program_host(),
                     exports || (draws && wants_looks(log.recipe.picture)))};
}

// Writes the pieces, unless the run differed from the log.
void write_pieces_of(const Replayed& replayed, const Player& player, const Simulation& simulation) {
    const ExportSettings& pieces = replayed.pieces;
    const LoadedRun& run = replayed.run;
    if (pieces.output.empty() || player.difference()) return;
    if (run.of_scene()) {
        const size_t written = write_scene_state(pieces, pieces_as(pieces.as), run.scene, simulation);
        print_report("%s: %s\n", run.name().c_str(), written_text(written, {pieces.output}).c_str());
        return;
    }
    const Snapshot state = snapshot(simulation, run.fragments);
    const auto files = write_state(pieces, pieces_as(pieces.as), run.recipe, run.source, state);
    print_report("%s: %s\n", run.source.name.c_str(), written_text(state.pieces.size(), files).c_str());
    print_split_note(pieces, files);
}

// Replays without a device and stops at the first difference.
void replay(Replayed& replayed, Player& player) {
    const ReplayLog& log = replayed.log;
    Simulation simulation(log.recipe.material);
    simulation.observe(&player);
    follow(log, simulation);
    replayed.run.start(simulation, program_host());
    if (player.difference()) return;
    schedule(log, simulation);
    run_steps(simulation, player, log.states.size());
    write_pieces_of(replayed, player, simulation);
}

// Replays and draws. Goes on after a difference, so that its consequences are visible, except if the initial pieces
// differ from the log's.
void draw(Replayed& replayed, Player& player) {
    const ReplayCommand& command = replayed.command;
    const ReplayLog& log = replayed.log;
    LoadedRun& run = replayed.run;
    const std::unique_ptr<engine::Device> device = open_device(command.view);
    const auto renderer = must(engine::Renderer::create(*device, film_settings(command.view)));
    std::optional<Stage> owner;
    if (run.of_scene())
        owner.emplace(*renderer, run.scene.home);
    else
        owner.emplace(*renderer, run.input.model.mesh, log.recipe.material,
                      looks_for(run.source.model, run.input.model.mesh, log.recipe.picture, run.source.model.notes));
    Stage& stage = *owner;
    stage.colour_by(log.recipe.picture.colours);
    stage.dust(log.recipe.picture.dust);
    stage.simulation().observe(&player);
    follow(log, stage.simulation());
    if (run.of_scene())
        stage.stand(prepare_scene(run.scene, drawing_host(), payload_maker(*renderer)), run.scene.world);
    else
        stage.stand(*run.fragments, run.world);
    if (player.difference()) return;
    schedule(log, stage.simulation());
    Film film(*renderer, {.output = command.pictures, .every = command.every, .video = command.video},
              log.recipe.picture, command.view, stage.home_bounds());
    Progress progress("rendering");
    for (uint32_t frame = 0;; ++frame) {
        throw_if_interrupted();
        if (frame > 0) stage.advance(film_frame_seconds);
        film.frame(stage, frame, player.done());
        if (player.done()) break;
        progress.update(static_cast<double>(stage.simulation().steps()) / static_cast<double>(log.states.size()));
    }
    film.finish();
    print_report("%s: %s on %s\n", run.name().c_str(), film.summary().c_str(), device->info().name.c_str());
    check_validation(*device);
}

} // namespace

int run_replay(const ReplayCommand& command) {
    check_film({.output = command.pictures, .every = command.every, .video = command.video});
    catch_interrupts();
    ReplayLog log = read_replay_log(command.log);
    log.recipe.threads = command.threads;
    Replayed run = load(command, log);
    Player player(log);
    if (command.pictures.empty() && command.video.empty())
        replay(run, player);
    else
        draw(run, player);

    const size_t steps = log.states.size() - 1;
    if (const std::optional<Difference>& difference = player.difference()) {
        std::fflush(stdout);
        std::fprintf(stderr, "brittle: %s: step %llu of %zu differs: %s\n", command.log.c_str(),
                     static_cast<unsigned long long>(difference->step), steps, difference->what.c_str());
        if (const std::string other = other_build(log); !other.empty())
            std::fprintf(stderr, "brittle: it was recorded with %s; states are equal on one build and machine only\n",
                         other.c_str());
        return exit_differs;
    }
    print_report("%s: %zu steps, all equal; %zu actions, %s\n", command.log.c_str(), steps, log.actions.size(),
                 log.end.c_str());
    return exit_success;
}

} // namespace brittle::tools
