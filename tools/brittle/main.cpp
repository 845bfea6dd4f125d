// The `brittle` program: parses the command line and calls the function of the command.

#include <algorithm>
#include <cerrno>
#include <cstddef>
#include <cstdio>
#include <cstring>
#include <exception>
#include <new>
#include <numeric>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include <CLI/CLI.hpp>

#include "fracture/io/text_cursor.h"
#include "tools/brittle/commands/command_line.h"
#include "tools/brittle/commands/manual.h"
#include "tools/brittle/commands/option_table.h"
#include "tools/scenario/base/failure.h"

namespace brittle::tools {
namespace {

constexpr const char* description =
    "Brittle breaks triangle meshes into watertight pieces along Voronoi cells, in real time.\n\n"
    "First steps:\n"
    "  brittle demo shape:animal                        break a mesh in a window (Space)\n"
    "  brittle fracture bunny.obj -n 100 -o pieces.glb  write pieces for any engine that reads glTF\n"
    "  brittle render bunny.obj -n 50 -o fall_%04d.png  write pictures, without a display\n";

std::string footer() {
    std::string text =
        "brittle help COMMAND lists the options of a command; brittle help --man prints the manual page.\n\n"
        "Exit codes:";
    for (const auto& [code, meaning] : exit_texts) {
        char line[120];
        std::snprintf(line, sizeof line, "\n  %3d  %s", code, meaning);
        text += line;
    }
    return text;
}

void add_commands(CLI::App& app, Run& run) {
    add_fracture(app, run);
    add_inspect(app, run);
    add_repair(app, run);
    add_render(app, run);
    add_replay(app, run);
    add_demo(app, run);
    add_profile(app, run);
    add_complete(app, run);
}

// Levenshtein's distance: the fewest letters to insert, remove or replace.
size_t distance(std::string_view a, std::string_view b) {
    std::vector<size_t> row(b.size() + 1);
    std::iota(row.begin(), row.end(), size_t{0});
    for (size_t i = 0; i < a.size(); ++i) {
        size_t diagonal = std::exchange(row[0], i + 1);
        for (size_t j = 0; j < b.size(); ++j) {
            const size_t replaced = diagonal + (a[i] == b[j] ? 0 : 1);
            diagonal = row[j + 1];
            row[j + 1] = std::min({replaced, diagonal + 1, row[j] + 1});
        }
    }
    return row.back();
}

// "; did you mean X?", where one of the names is like the given one.
std::string suggestion(std::string_view given, std::span<const std::string> names) {
    const std::string* best = nullptr;
    size_t least = 1 + given.size() / 3;
    for (const std::string& name : names)
        if (const size_t far = distance(given, name); far <= least && (!best || far < least)) {
            best = &name;
            least = far;
        }
    return best ? "; did you mean " + *best + "?" : "";
}

// Refuses a first word that is neither an option nor a command, before CLI11 misses an argument of another one.
const CLI::App* command_of(const CLI::App& app, std::span<const std::string> words) {
    if (words.empty() || words[0].starts_with('-')) return nullptr;
    std::string known;
    std::vector<std::string> names{"help"};
    for (const CLI::App* command : app.get_subcommands([](const CLI::App*) { return true; })) {
        if (command->get_name() == words[0]) return command;
        if (command->get_group().empty()) continue; // hidden
        known += (known.empty() ? "" : ", ") + command->get_name();
        names.push_back(command->get_name());
    }
    const std::string meant = suggestion(words[0], names);
    throw Failure(exit_usage, "there is no command " + fracture::quoted(std::string_view(words[0]))
                                  + (meant.empty() ? "; the commands are: " + known : meant));
}

// Refuses options that the command does not have.
void check_options(const CLI::App& command, std::span<const std::string> words) {
    std::vector<std::string> names;
    for (const CLI::Option* option : command.get_options({}))
        for (const std::string& name : option->get_lnames()) names.push_back("--" + name);
    for (const std::string& word : words) {
        if (word == "--") return;
        const std::string name = word.substr(0, word.find('='));
        if (name.size() > 2 && std::find(names.begin(), names.end(), "-" + name) != names.end())
            throw Failure(exit_usage, "brittle " + command.get_name() + " has no option "
                                          + fracture::quoted(std::string_view(name)) + "; did you mean -" + name + "?");
        if (!name.starts_with("--") || std::find(names.begin(), names.end(), name) != names.end()) continue;
        const std::string meant = suggestion(name, names);
        throw Failure(exit_usage,
                      "brittle " + command.get_name() + " has no option " + fracture::quoted(std::string_view(name))
                          + (meant.empty() ? "; brittle help " + command.get_name() + " lists them" : meant));
    }
}

// Throws a Failure where not all of standard output was written.
int finish_output() {
    if (std::fflush(stdout) != 0 || std::ferror(stdout) != 0)
        throw Failure(exit_output, std::string("standard output: cannot be written: ") + std::strerror(errno));
    return exit_success;
}

int run(int argc, char** argv) {
    CLI::App app(description, "brittle");
    app.set_version_flag("-V,--version", "brittle " BRITTLE_VERSION);
    app.require_subcommand(1);
    app.footer(footer());
    Run command;
    add_commands(app, command);
    std::vector<std::string> words(argv + std::min(argc, 1), argv + argc);
    if (words.empty()) {
        std::fputs(app.help().c_str(), stderr);
        return exit_usage;
    }
    if (words[0] == "help") { // brittle help COMMAND is brittle COMMAND --help
        words.erase(words.begin());
        if (words == std::vector<std::string>{"--man"}) {
            std::fputs(manual_page(option_table(app), BRITTLE_VERSION).c_str(), stdout);
            return finish_output();
        }
        words.emplace_back("--help");
    }
    if (const CLI::App* chosen = command_of(app, words)) check_options(*chosen, std::span(words).subspan(1));
    try {
        std::reverse(words.begin(), words.end()); // as CLI11 takes them
        app.parse(words);
    } catch (const CLI::ParseError& e) {
        return app.exit(e) == 0 ? exit_success : exit_usage;
    }
    const int code = command();
    finish_output();
    return code;
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
