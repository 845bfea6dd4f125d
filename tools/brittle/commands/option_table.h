// The commands and options of the program as data, for completion scripts and the manual page. The parser's own options
// are the source, so that both have all of them.
#pragma once

#include <string>
#include <vector>

#include <CLI/CLI.hpp>

namespace brittle::tools {

struct OptionEntry {
    std::vector<std::string> names{};   // "-n", "--pieces"; none: a positional
    std::string value{};                // what it takes, "FILE.json"; empty: a flag
    std::string range{};                // "1 to 1,000"; or empty
    std::string default_value{};        // or empty
    std::vector<std::string> choices{}; // all values, where they are words
    bool takes_file = false;
    bool takes_mesh = false; // a file, or shape:NAME
    bool repeats = false;
    bool required = false;
    std::string heading{}; // in the help
    std::string text{};    // whole sentences

    friend bool operator==(const OptionEntry&, const OptionEntry&) = default;
};

struct CommandEntry {
    std::string name{};
    std::string text{};
    std::string footer{}; // exit codes and examples; lines of examples begin with two blanks
    std::vector<OptionEntry> options{};
};

struct ExitText {
    int code;
    const char* text;
};

// The exit codes of the program (base/failure.h) for people.
inline constexpr ExitText exit_texts[] = {
    {0, "success"},
    {1, "failure"},
    {2, "wrong command line"},
    {3, "input file missing or damaged"},
    {4, "mesh or sites cannot be fractured"},
    {5, "output not written"},
    {6, "no display, or no Vulkan device, or the device was lost"},
    {7, "slower than before (profile --compare)"},
    {8, "state differs from the log (replay)"},
    {130, "interrupted (Ctrl+C); no half-written file is left"},
};

struct ProgramEntry {
    std::string text{}; // the description, in paragraphs
    std::vector<OptionEntry> options{};
    std::vector<CommandEntry> commands{};
};

// Returns the program's table, without hidden commands and options.
[[nodiscard]] ProgramEntry option_table(const CLI::App& app);

// Returns the first sentence, without its full stop.
[[nodiscard]] std::string first_sentence(const std::string& text);

} // namespace brittle::tools
