#include <cstdio>
#include <memory>
#include <optional>

#include "tools/brittle/commands.h"
#include "tools/brittle/failure.h"
#include "tools/brittle/film.h"
#include "tools/brittle/interrupt.h"
#include "tools/brittle/progress.h"
#include "tools/brittle/replay/player.h"
#include "tools/brittle/stage.h"
#include "tools/brittle/view.h"

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

// Without a device. Stops at the first difference.
void replay(const ReplayLog& log, Player& player, const fracture::Fragments& fragments) {
    Simulation simulation(log.recipe.material);
    simulation.observe(&player);
    follow(log, simulation);
    simulation.start(fragments, world_of(log.recipe));
    if (player.difference()) return;
    schedule(log, simulation);
    run_steps(simulation, player, log.states.size());
}

// Goes on after a difference, so that one can see what comes of it; but not with other pieces than the log is
// about.
void draw(const ReplayCommand& command, const ReplayLog& log, Player& player, const Input& input,
          const fracture::Fragments& fragments) {
    const std::unique_ptr<engine::Device> device = open_device(command.view);
    const auto renderer = must(engine::Renderer::create(*device, renderer_settings(command.view)));
    Stage stage(*renderer, input.model.mesh, log.recipe.material);
    stage.simulation().observe(&player);
    follow(log, stage.simulation());
    stage.stand(fragments, world_of(log.recipe));
    if (player.difference()) return;
    schedule(log, stage.simulation());
    Film film(*renderer, {.output = command.pictures, .every = command.every, .video = command.video}, log.recipe.picture, command.view,
              stage.home_bounds());
    Progress progress("rendering");
    for (uint32_t frame = 0;; ++frame) {
        throw_if_interrupted();
        if (frame > 0) stage.advance(film_frame_seconds);
        film.frame(stage, frame, player.done());
        if (player.done()) break;
        progress.update(static_cast<double>(stage.simulation().steps())
                        / static_cast<double>(log.states.size()));
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
    const Input input = placed_on_stage(load_input(log.recipe), log.recipe.world);
    const Broken broken = break_input(input, log.recipe);
    Player player(log);
    if (command.pictures.empty() && command.video.empty())
        replay(log, player, broken.fragments);
    else
        draw(command, log, player, input, broken.fragments);

    const size_t steps = log.states.size() - 1;
    if (const std::optional<Difference>& difference = player.difference()) {
        std::fflush(stdout);
        std::fprintf(stderr, "brittle: %s: step %llu of %zu differs: %s\n", command.log.c_str(),
                     static_cast<unsigned long long>(difference->step), steps, difference->what.c_str());
        if (const std::string other = other_build(log); !other.empty())
            std::fprintf(stderr,
                         "brittle: it was recorded with %s; states are equal on one build and machine only\n",
                         other.c_str());
        return exit_differs;
    }
    std::printf("%s: %zu steps, all equal; %zu actions, %s\n", command.log.c_str(), steps, log.actions.size(),
                log.end.c_str());
    return exit_success;
}

} // namespace brittle::tools
