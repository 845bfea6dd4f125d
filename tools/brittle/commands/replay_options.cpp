#include <memory>

#include "tools/brittle/commands/command_line.h"
#include "tools/brittle/commands/option_groups.h"
#include "tools/brittle/commands/option_values.h"
#include "tools/scenario/recipe/piece_export.h"

namespace brittle::tools {

void add_replay(CLI::App& app, Run& run) {
    const auto command = std::make_shared<ReplayCommand>();
    CLI::App& replay =
        *app.add_subcommand("replay", "Repeat a recorded run without a display and compare the state after each step");
    start_group(replay, "Log");
    replay.add_option("log", command->log, "Log that --record wrote")->required()->type_name("FILE.log");
    start_group(replay, "Output");
    replay
        .add_option("--render", command->pictures,
                    "Name of pictures of the run. %04d stands for the number of the frame.")
        ->type_name("FILE_%04d.png");
    replay.add_option("--every", command->every, "Interval between the frames that are written, of 60 per second")
        ->check(number_from(1, 100'000))
        ->capture_default_str();
    replay.add_option("--video", command->video, "File for a video of the run, made by the program ffmpeg")
        ->type_name("FILE.mp4");
    const auto line = std::make_shared<ExportSettings>();
    add_state_export(replay, line->output, *line);
    // Pictures and videos may run past the last step of the log, so the state at their end is not that of the log.
    replay.get_option("--export")->excludes("--render")->excludes("--video");
    add_view_options(replay, command->view);
    add_threads_option(replay, command->threads);
    add_general_options(replay, nullptr);
    replay.footer("The exit code is 0 if all states equal the recorded ones, and 8 if one differs. --export writes "
                  "the pieces with the options of the recorded run, such as --hulls, unless the command line overrides "
                  "them.\n\n"
                  "Examples:\n"
                  "  brittle replay run.log\n"
                  "  brittle replay run.log --render run_%04d.png --every 2\n"
                  "  brittle replay run.log --export rubble.glb --quiet");
    command->pieces = [&replay, line](const FractureOptions& recipe) {
        if (replay.count("--name") > 0 && is_scene(recipe)) refuse_name_of_scene();
        const ExportSettings settings = overridden_export(recipe.exports, *line, given_options(replay));
        return settle_export(replay, settings, {.output = line->output}, "--export");
    };
    replay.callback([&run, command] { run = [command] { return run_replay(*command); }; });
}

} // namespace brittle::tools
