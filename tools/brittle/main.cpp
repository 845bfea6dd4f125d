// The `brittle` program: parses the command line and calls the function of the command.

#include <cstdio>
#include <exception>
#include <new>
#include <string>
#include <string_view>

#include <CLI/CLI.hpp>

#include "fracture/io/text_cursor.h"
#include "tools/brittle/base/failure.h"
#include "tools/brittle/commands/command_line.h"

namespace brittle::tools {
namespace {

constexpr const char* description =
    "Brittle breaks triangle meshes into watertight pieces along Voronoi cells, in real time.\n\n"
    "First steps:\n"
    "  brittle demo shape:animal                        break a mesh in a window (Space)\n"
    "  brittle fracture bunny.obj -n 100 -o pieces.glb  write pieces for any engine that reads glTF\n"
    "  brittle render bunny.obj -n 50 -o fall_%04d.png  write pictures, without a display\n";

constexpr const char* exit_codes_help =
    "Exit codes: 0 success, 1 failure, 2 wrong command line, 3 input file missing or damaged,\n"
    "            4 mesh or sites cannot be fractured, 5 output not written,\n"
    "            6 no display, or no Vulkan device, or the device was lost,\n"
    "            7 slower than before (profile --compare), 8 state differs from the log (replay),\n"
    "            130 interrupted (Ctrl+C); no half-written file is left";

void add_commands(CLI::App& app, Run& run) {
    add_fracture(app, run);
    add_inspect(app, run);
    add_repair(app, run);
    add_render(app, run);
    add_replay(app, run);
    add_demo(app, run);
    add_profile(app, run);
}

// The message for a first word that is neither an option nor a command; empty for others.
std::string unknown_command(const CLI::App& app, int argc, char** argv) {
    if (argc < 2 || argv[1][0] == '-') return "";
    std::string known;
    for (const CLI::App* command : app.get_subcommands([](const CLI::App*) { return true; })) {
        if (command->get_name() == argv[1]) return "";
        known += (known.empty() ? "" : ", ") + command->get_name();
    }
    return "there is no command " + fracture::quoted(std::string_view(argv[1])) + "; the commands are: " + known;
}

int run(int argc, char** argv) {
    CLI::App app(description, "brittle");
    app.set_version_flag("--version", "brittle " BRITTLE_VERSION);
    app.require_subcommand(1);
    app.footer(exit_codes_help);
    Run command;
    add_commands(app, command);
    if (argc < 2) {
        std::fputs(app.help().c_str(), stderr);
        return exit_usage;
    }
    if (const std::string unknown = unknown_command(app, argc, argv); !unknown.empty())
        throw Failure(exit_usage, unknown);
    try {
        app.parse(argc, argv);
    } catch (const CLI::ParseError& e) {
        return app.exit(e) == 0 ? exit_success : exit_usage;
    }
    return command();
}

} // namespace
} // namespace brittle::tools

int main(int argc, char** argv) {
    try {
        return brittle::tools::run(argc, argv);
    } catch (const brittle::tools::Failure& failure) {
        std::fprintf(stderr, "brittle: %s\n", failure.what());
        return failure.code();
    } catch (const std::bad_alloc&) {
        std::fputs("brittle: out of memory; use a smaller mesh or fewer sites\n", stderr);
    } catch (const std::exception& e) {
        std::fprintf(stderr, "brittle: %s\n", e.what());
    }
    return brittle::tools::exit_failure;
}
