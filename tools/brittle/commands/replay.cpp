#include <cstdio>
#include <memory>
#include <optional>

#include "tools/brittle/base/failure.h"
#include "tools/brittle/base/interrupt.h"
#include "tools/brittle/base/progress.h"
#include "tools/brittle/commands/commands.h"
#include "tools/brittle/pictures/film.h"
#include "tools/brittle/pictures/view.h"
#include "tools/brittle/replay/player.h"
#include "tools/brittle/run/stage.h"
#include "tools/brittle/run/state_export.h"

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

struct Run {
    const ReplayCommand& command;
    const ReplayLog& log;
    const Input& source; // mesh in the coordinates of its file
    std::shared_ptr<const fracture::Fragments> fragments;
    WorldOptions world;
};

// Writes the pieces, unless the run differed from the log.
void write_pieces_of(const Run& run, const Player& player, const Simulation& simulation) {
    const StateExport& pieces = run.command.pieces;
    if (pieces.files.output.empty() || player.difference()) return;
    const Snapshot state = snapshot(simulation, run.fragments);
    const auto files = write_state(pieces.files, pieces_as(pieces.as), run.log.recipe, run.source, state);
    std::printf("%s: %s\n", run.source.name.c_str(), written_text(state.pieces.size(), files).c_str());
}

// Replays without a device and stops at the first difference.
void replay(const Run& run, Player& player) {
    Simulation simulation(run.log.recipe.material);
    simulation.observe(&player);
    follow(run.log, simulation);
    simulation.start(*run.fragments, run.world);
    if (player.difference()) return;
    schedule(run.log, simulation);
    run_steps(simulation, player, run.log.states.size());
    write_pieces_of(run, player, simulation);
}

// Replays and draws. Goes on after a difference, so that its consequences are visible, except if the initial pieces
// differ from the log's.
void draw(const Run& run, Player& player, const Input& input) {
    const ReplayCommand& command = run.command;
    const ReplayLog& log = run.log;
    const std::unique_ptr<engine::Device> device = open_device(command.view);
    const auto renderer = must(engine::Renderer::create(*device, film_settings(command.view)));
    Stage stage(*renderer, input.model.mesh, log.recipe.material);
    stage.simulation().observe(&player);
    follow(log, stage.simulation());
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
    std::printf("%s: %s on %s\n", input.name.c_str(), film.summary().c_str(), device->info().name.c_str());
    check_validation(*device);
}

} // namespace

int run_replay(const ReplayCommand& command) {
    check_film({.output = command.pictures, .every = command.every, .video = command.video});
    catch_interrupts();
    ReplayLog log = read_replay_log(command.log);
    log.recipe.threads = command.threads;
    const Input source = load_input(log.recipe, !command.pieces.files.output.empty());
    const Input input = placed_on_stage(source, log.recipe.world);
    const Run run{command, log, source,
                  std::make_shared<const fracture::Fragments>(break_input(input, log.recipe).fragments),
                  world_of(log.recipe, input.scale)};
    Player player(log);
    if (command.pictures.empty() && command.video.empty())
        replay(run, player);
    else
        draw(run, player, input);

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
    std::printf("%s: %zu steps, all equal; %zu actions, %s\n", command.log.c_str(), steps, log.actions.size(),
                log.end.c_str());
    return exit_success;
}

} // namespace brittle::tools
