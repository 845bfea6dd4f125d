// Help, completion scripts and the manual page. The scripts run in their shells where these are installed.
#include <doctest/doctest.h>

#include <algorithm>
#include <cstdlib>
#include <set>
#include <sstream>
#include <string>
#include <vector>

#include <CLI/CLI.hpp>
#include <sys/wait.h>

#include "tests/tools/support.h"
#include "tools/brittle/commands/command_line.h"
#include "tools/brittle/commands/completion.h"
#include "tools/brittle/commands/manual.h"
#include "tools/brittle/commands/option_table.h"

using namespace brittle::tools;
using namespace brittle::tools::test;

namespace {

// The program's parser, with everything that main() adds.
struct Program {
    Program() {
        for (const auto add :
             {add_fracture, add_inspect, add_repair, add_render, add_replay, add_demo, add_profile, add_complete})
            add(app, run);
        table = option_table(app);
    }
    CLI::App app{"Breaks.", "brittle"};
    Run run;
    ProgramEntry table;
};

// Returns the standard output and error of a shell's script, by the words of the shell.
std::string output_of(const Folder& folder, const std::string& shell, const std::string& script) {
    const std::string file = folder.write("script", script).string(), out = folder / "out";
    (void)std::system((shell + " " + file + " > " + out + " 2>&1").c_str());
    return read_text(out);
}

bool is_installed(const std::string& program) {
    return std::system(("command -v " + program + " > /dev/null 2>&1").c_str()) == 0;
}

std::vector<std::string> lines_of(const std::string& text) {
    std::vector<std::string> lines;
    std::istringstream stream(text);
    for (std::string line; std::getline(stream, line);) lines.push_back(line);
    return lines;
}

// A program of one command with every kind of option.
ProgramEntry small_program() {
    CommandEntry cut{"cut", "Cut a mesh: it's quick", "", {}};
    cut.options = {{.value = "MESH", .takes_mesh = true, .heading = "Mesh", .text = "The mesh. A file."},
                   {.names = {"-n", "--count"},
                    .value = "N",
                    .range = "1 to 9",
                    .default_value = "3",
                    .heading = "Cut",
                    .text = "Cuts"},
                   {.names = {"--kind"},
                    .value = "NAME",
                    .choices = {"fine", "rough"},
                    .heading = "Cut",
                    .text = "Kind [of cut]: it's one"},
                   {.names = {"--at"}, .value = "X,Y", .repeats = true, .heading = "Cut", .text = "Where. Often."},
                   {.names = {"-o", "--output"},
                    .value = "FILE",
                    .takes_file = true,
                    .required = true,
                    .heading = "Output",
                    .text = "File"},
                   {.names = {"-q", "--quiet"}, .heading = "Output", .text = "Tell nothing"}};
    return {"Cuts.", {{.names = {"-h", "--help"}, .text = "Help"}}, {cut}};
}

// The completions of a line by the script of the program itself.
std::vector<std::string> bash_completions(const Folder& folder, const std::string& line,
                                          const std::string& breaks = "") {
    const std::string script = "source <(" BRITTLE_PROGRAM " complete bash)\n" + breaks + "COMP_LINE='" + line
                               + "' COMP_POINT=" + std::to_string(line.size()) + "\ncd " + folder.path.string()
                               + "\n_brittle\nprintf '%s\\n' \"${COMPREPLY[@]}\"\n";
    const Folder place;
    std::vector<std::string> words = lines_of(output_of(place, "bash --norc", script));
    std::ranges::sort(words);
    return words;
}

} // namespace

TEST_CASE("every option has a heading, and every command examples that use its own options") {
    const Program program;
    size_t examples = 0;
    for (const CommandEntry& command : program.table.commands) {
        CAPTURE(command.name);
        std::set<std::string> names{"-"};
        for (const OptionEntry& option : command.options) {
            CAPTURE(option.text);
            CHECK(option.heading != "Options"); // the parser's default
            names.insert(option.names.begin(), option.names.end());
        }
        CHECK(command.options.back().names == std::vector<std::string>{"-h", "--help"});
        CHECK(command.footer.find("Examples:\n") != std::string::npos);
        for (const std::string& line : lines_of(command.footer)) {
            const size_t begin = line.find("brittle " + command.name + " ");
            if (!line.starts_with("  ") || begin == std::string::npos) continue;
            ++examples;
            std::istringstream words(line.substr(begin, line.find_first_of("|>&", begin) - begin));
            for (std::string word; words >> word;) {
                CAPTURE(word);
                if (word.starts_with("-")) CHECK(names.contains(word));
            }
        }
    }
    CHECK(examples > 20);
    const auto complete = std::ranges::find(program.table.commands, "complete", &CommandEntry::name);
    CHECK(complete == program.table.commands.end()); // hidden
    const Folder folder;
    const Outcome help = run_brittle(folder, "help render");
    for (const char* heading : {"Material and pattern:", "Physics:", "Pictures:", "General:"}) CHECK(help.has(heading));
    CHECK_FALSE(run_brittle(folder, "--help").has("complete"));
    CHECK(run_brittle(folder, "fracture -pieces 4").has("did you mean --pieces?"));
    CHECK(run_brittle(folder, "complete tcsh").exit_code == 2);
}

TEST_CASE("bash completes commands, options, words, files and shapes") {
    const Folder folder;
    folder.write("mesh one.obj", "");
    folder.write("other.glb", "");
    using Words = std::vector<std::string>;
    CHECK(bash_completions(folder, "brittle fr") == Words{"fracture"});
    CHECK(bash_completions(folder, "brittle re") == Words{"render", "repair", "replay"});
    CHECK(bash_completions(folder, "brittle --v") == Words{"--version"});
    CHECK(bash_completions(folder, "brittle help pro") == Words{"profile"});
    CHECK(bash_completions(folder, "brittle fracture --pat") == Words{"--pattern"});
    CHECK(bash_completions(folder, "brittle fracture --pattern ra") == Words{"radial"});
    CHECK(bash_completions(folder, "brittle fracture --pattern=ra") == Words{"radial"});
    CHECK(bash_completions(folder, "brittle fracture --pattern=ra", "COMP_WORDBREAKS=' '\n")
          == Words{"--pattern=radial"});
    CHECK(bash_completions(folder, "brittle fracture --material gl") == Words{"glass"});
    CHECK(bash_completions(folder, "brittle demo --quality ") == Words{"auto", "best", "fast"});
    CHECK(bash_completions(folder, "brittle fracture -o o") == Words{"other.glb"});
    CHECK(bash_completions(folder, "brittle fracture mes") == Words{"mesh one.obj"});
    CHECK(bash_completions(folder, "brittle fracture shape:anim") == Words{"animal"}); // behind the break at :
    CHECK(bash_completions(folder, "brittle fracture shape:anim", "COMP_WORDBREAKS=' '\n") == Words{"shape:animal"});
    CHECK(bash_completions(folder, "brittle replay o") == Words{"other.glb"});
    CHECK(bash_completions(folder, "brittle replay shap") == Words{""});  // a log, no shape
    CHECK(bash_completions(folder, "brittle fracture -n ") == Words{""}); // a number
    CHECK(bash_completions(folder, "brittle fracture --nothing=") == Words{""});
    // All options of a command, those of the parser.
    const Program program;
    std::vector<std::string> names;
    for (const CommandEntry& command : program.table.commands)
        if (command.name == "render")
            for (const OptionEntry& option : command.options)
                names.insert(names.end(), option.names.begin(), option.names.end());
    std::ranges::sort(names);
    CHECK(names.size() > 60);
    CHECK(bash_completions(folder, "brittle render -") == names);
}

TEST_CASE("the completion script of zsh is as expected, and zsh reads that of the program") {
    const std::string expected = R"(#compdef brittle
# Completion of brittle for zsh, written by `brittle complete zsh`.

_brittle_mesh() {
    _alternative 'files:file:_files' 'shapes:built-in shape:compadd -- shape:cube'
}

_brittle() {
    local curcontext=$curcontext state state_descr line
    typeset -A opt_args
    local -a commands
    commands=(
        'cut:Cut a mesh\: it'\''s quick'
        'help:Print the help of a command'
    )
    _arguments -C \
        '(-h --help)'{-h,--help}'[Help]' \
        '1: :->command' '*:: :->arguments'
    case $state in
    command) _describe -t commands command commands ;;
    arguments)
        case $words[1] in
        help) _describe -t commands command commands ;;
        cut) _arguments \
            '1:MESH:_brittle_mesh' \
            '(-n --count)'{-n+,--count=}'[Cuts]:N: ' \
            '--kind=[Kind \[of cut\]\: it'\''s one]:NAME:(fine rough)' \
            '*--at=[Where]:X,Y: ' \
            '(-o --output)'{-o+,--output=}'[File]:FILE:_files' \
            '(-q --quiet)'{-q,--quiet}'[Tell nothing]' ;;
        esac ;;
    esac
}

# The function itself when it completes for the first time, else the script was sourced.
if [[ $funcstack[1] == _brittle ]]; then _brittle "$@"; else compdef _brittle brittle; fi
)";
    CHECK(zsh_completion(small_program(), {"cube"}) == expected);
    if (!is_installed("zsh")) {
        MESSAGE("skipped: no zsh");
        return;
    }
    const Folder folder;
    REQUIRE(std::system((BRITTLE_PROGRAM " complete zsh > " + (folder / "_brittle")).c_str()) == 0);
    CHECK(output_of(folder, "zsh -f -n", read_text(folder / "_brittle")).empty());
    // A shell on a terminal of its own, which completes a line on Tab.
    const auto completed = [&](const std::string& line) {
        const std::string script =
            "zmodload zsh/zpty\n"
            "zpty shell 'zsh -f -i'\n"
            "zpty -w shell 'PS1=; fpath=("
            + folder.path.string() + " $fpath); autoload -Uz compinit; compinit -u -d " + (folder / "dump")
            + "; print rea\"\"dy'\n"
              "zpty -m -r shell output '*ready*2004h*'\n" // the line editor has switched bracketed paste on
              "zpty -w -n shell \""
            + line
            + "\"$'\\t'\"--end\"\n"
              "zpty -m -r shell output '*--end*'\n"
              "print -r -- $output\n";
        return output_of(folder, "timeout 20 zsh -f", script);
    };
    CHECK(completed("brittle frac").find("brittle fracture") != std::string::npos);
    CHECK(completed("brittle fracture --patt").find("--pattern") != std::string::npos);
    CHECK(completed("brittle fracture --pattern radi").find("radial") != std::string::npos);
}

TEST_CASE("the completion script of fish is as expected, and fish completes by that of the program") {
    const std::string expected = R"(# Completion of brittle for fish, written by `brittle complete fish`.

complete -c brittle -f
complete -c brittle -n __fish_use_subcommand -a cut -d 'Cut a mesh: it\'s quick'
complete -c brittle -n __fish_use_subcommand -a help -d 'Print the help of a command'
complete -c brittle -n __fish_use_subcommand -s h -l help -d 'Help'
complete -c brittle -n '__fish_seen_subcommand_from help' -a 'cut help'
complete -c brittle -n '__fish_seen_subcommand_from cut' -F -a 'shape:cube'
complete -c brittle -n '__fish_seen_subcommand_from cut' -s n -l count -x -d 'Cuts'
complete -c brittle -n '__fish_seen_subcommand_from cut' -l kind -x -a 'fine rough' -d 'Kind [of cut]: it\'s one'
complete -c brittle -n '__fish_seen_subcommand_from cut' -l at -x -d 'Where'
complete -c brittle -n '__fish_seen_subcommand_from cut' -s o -l output -r -F -d 'File'
complete -c brittle -n '__fish_seen_subcommand_from cut' -s q -l quiet -d 'Tell nothing'
)";
    CHECK(fish_completion(small_program(), {"cube"}) == expected);
    if (!is_installed("fish")) {
        MESSAGE("skipped: no fish");
        return;
    }
    const Folder folder;
    folder.write("mesh.obj", "");
    const auto completed = [&](const std::string& line) {
        return output_of(folder, "fish --no-config",
                         "cd " + folder.path.string() + "\n" BRITTLE_PROGRAM " complete fish | source\ncomplete -C '"
                             + line + "'\n");
    };
    CHECK(completed("brittle frac").starts_with("fracture\t"));
    CHECK(completed("brittle fracture --patt").starts_with("--pattern"));
    CHECK(completed("brittle fracture --pattern radi").starts_with("radial"));
    CHECK(completed("brittle fracture shape:tor").find("shape:torus") != std::string::npos);
    CHECK(completed("brittle fracture me").find("mesh.obj") != std::string::npos);
}

TEST_CASE("the manual page has every option, and groff formats it without a warning") {
    const Folder folder;
    const Program program;
    const Outcome page = run_brittle(folder, "help --man");
    CHECK(page.exit_code == 0);
    CHECK(page.output.find(".TH BRITTLE 1 ") != std::string::npos);
    for (const CommandEntry& command : program.table.commands)
        for (const OptionEntry& option : command.options)
            for (std::string name : option.names) {
                CAPTURE(name);
                for (size_t at = 0; (at = name.find('-', at)) != std::string::npos; at += 2) name.insert(at, "\\");
                CHECK(page.has("\\fB" + name + "\\fR"));
            }
    // Text that troff would take for commands stays text.
    ProgramEntry small = small_program();
    small.commands[0].options[0].text = ".so /etc/passwd \\fB";
    CHECK(manual_page(small, "1").find("\n\\&.so /etc/passwd \\efB") != std::string::npos);
    if (!is_installed("groff")) {
        MESSAGE("skipped: no groff");
        return;
    }
    CHECK(output_of(folder, "groff -man -ww -z -Tutf8", page.output).empty());
    const std::string shown = output_of(folder, "groff -man -Tascii -P-c -P-b -P-u", page.output);
    for (const char* words : {"BRITTLE FRACTURE", "-n, --pieces N", "EXIT STATUS", "Examples:"})
        CHECK(shown.find(words) != std::string::npos);
}
