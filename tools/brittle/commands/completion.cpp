#include "tools/brittle/commands/completion.h"

#include <string_view>

namespace brittle::tools {

namespace {

std::string joined(const std::vector<std::string>& words, const char* between = " ") {
    std::string text;
    for (const std::string& word : words) text += (text.empty() ? "" : between) + word;
    return text;
}

std::string with_prefix(const std::vector<std::string>& words, const std::string& prefix) {
    std::string text;
    for (const std::string& word : words) text += (text.empty() ? "" : " ") + prefix + word;
    return text;
}

std::string option_names(const std::vector<OptionEntry>& options) {
    std::string text;
    for (const OptionEntry& option : options)
        if (!option.names.empty()) text += (text.empty() ? "" : " ") + joined(option.names);
    return text;
}

std::string command_names(const ProgramEntry& program) {
    std::string text;
    for (const CommandEntry& command : program.commands) text += command.name + " ";
    return text + "help";
}

const OptionEntry* positional_of(const CommandEntry& command) {
    for (const OptionEntry& option : command.options)
        if (option.names.empty()) return &option;
    return nullptr;
}

// Replaces each character of `special` by a backslash and itself.
std::string escaped(const std::string& text, std::string_view special) {
    std::string safe;
    for (const char c : text) {
        if (special.find(c) != std::string_view::npos) safe += '\\';
        safe += c;
    }
    return safe;
}

// In single quotes, which hold everything but themselves, for zsh as for bash.
std::string quoted(const std::string& text) {
    std::string safe = "'";
    for (const char c : text) safe += c == '\'' ? std::string("'\\''") : std::string(1, c);
    return safe + "'";
}

// --- bash ---

// The case of an option's value.
std::string bash_case(const std::string& command, const OptionEntry& option) {
    std::string text = "    ";
    for (const std::string& name : option.names)
        text += (name == option.names.front() ? "" : " | ") + ("\"" + command + " " + name + "\"");
    text += ") ";
    if (!option.choices.empty())
        text += "candidates='" + joined(option.choices) + "'";
    else if (option.takes_file || option.takes_mesh)
        text += option.takes_mesh ? "files=1 candidates=$shapes" : "files=1";
    else
        text += "return 0";
    return text + " ;;\n";
}

constexpr const char* bash_head = R"(# Completion of brittle for bash, written by `brittle complete bash`.

_brittle() {
    # Bash breaks words at = and :, so they are taken from the line itself.
    local line=${COMP_LINE:0:COMP_POINT}
    local word=${line##*[[:space:]]} previous prefix='' candidates='' files='' count
    local -a words
    read -ra words <<< "$line"
    count=${#words[@]} # of the words before the one to complete
    [[ -n $word ]] && ((count -= 1))
    previous=${words[count - 1]}
    COMPREPLY=()
    if [[ $word == --*=* ]]; then # --option=value
        previous=${word%%=*}
        prefix=$previous=
        word=${word#*=}
    fi
)";

constexpr const char* bash_tail =
    R"(    [[ -n $candidates ]] && mapfile -t COMPREPLY < <(compgen -W "$candidates" -- "$word")
    if [[ -n $files ]]; then
        ((${#COMPREPLY[@]} == 0)) && compopt -o filenames 2> /dev/null
        mapfile -t -O ${#COMPREPLY[@]} COMPREPLY < <(compgen -f -- "$word")
    fi
    # Bash puts the words behind its last break.
    [[ -n $prefix && $COMP_WORDBREAKS != *=* ]] && COMPREPLY=("${COMPREPLY[@]/#/$prefix}")
    if [[ $word == *:* && $COMP_WORDBREAKS == *:* ]]; then
        prefix=${word%"${word##*:}"}
        COMPREPLY=("${COMPREPLY[@]#"$prefix"}")
    fi
    return 0
}

complete -F _brittle brittle
)";

} // namespace

std::string bash_completion(const ProgramEntry& program, const std::vector<std::string>& shapes) {
    std::string text = bash_head;
    text += "    local shapes='" + with_prefix(shapes, "shape:") + "'\n";
    text += "    local commands='" + command_names(program) + "'\n";
    text += "    case \"$((count > 1)) ${words[1]} $previous\" in\n";
    // The command itself, and what follows help.
    text += "    0*) candidates=\"$commands " + option_names(program.options) + "\" ;;\n";
    text += "    '1 help help') candidates=$commands ;;\n";
    text += "    '1 help '*) return 0 ;;\n";
    for (const CommandEntry& command : program.commands) {
        for (const OptionEntry& option : command.options)
            if (!option.names.empty() && !option.value.empty()) text += bash_case("1 " + command.name, option);
        text += "    '1 " + command.name + " '*)\n        [[ -n $prefix ]] && return 0\n";
        text += "        if [[ $word == -* ]]; then candidates='" + option_names(command.options) + "'\n";
        const OptionEntry* positional = positional_of(command);
        if (positional)
            text += std::string("        else files=1") + (positional->takes_mesh ? " candidates=$shapes" : "") + "\n";
        text += "        fi ;;\n";
    }
    return text + "    esac\n" + bash_tail;
}

// --- zsh ---

namespace {

std::string zsh_value(const OptionEntry& option) {
    const std::string name = escaped(option.value, ":");
    if (!option.choices.empty()) return ":" + name + ":(" + joined(option.choices) + ")";
    if (option.takes_mesh) return ":" + name + ":_brittle_mesh";
    return ":" + name + ":" + (option.takes_file ? "_files" : " ");
}

// An argument of _arguments.
std::string zsh_option(const OptionEntry& option) {
    const std::string value = option.value.empty() ? std::string() : zsh_value(option);
    if (option.names.empty()) return quoted("1" + value);
    const std::string text = "[" + escaped(first_sentence(option.text), "[]:\\") + "]";
    const auto spelled = [&](const std::string& name) {
        return option.value.empty() ? name : name + (name.starts_with("--") ? "=" : "+");
    };
    const std::string others = option.repeats ? "*" : "(" + joined(option.names) + ")";
    if (option.names.size() == 1) return quoted((option.repeats ? "*" : "") + spelled(option.names[0]) + text + value);
    std::string names;
    for (const std::string& name : option.names) names += (names.empty() ? "" : ",") + spelled(name);
    return quoted(others) + "{" + names + "}" + quoted(text + value);
}

} // namespace

std::string zsh_completion(const ProgramEntry& program, const std::vector<std::string>& shapes) {
    std::string text = "#compdef brittle\n# Completion of brittle for zsh, written by `brittle complete zsh`.\n\n";
    text += "_brittle_mesh() {\n    _alternative 'files:file:_files' 'shapes:built-in shape:compadd -- "
            + with_prefix(shapes, "shape:") + "'\n}\n\n";
    text += "_brittle() {\n    local curcontext=$curcontext state state_descr line\n    typeset -A opt_args\n"
            "    local -a commands\n    commands=(\n";
    for (const CommandEntry& command : program.commands)
        text += "        " + quoted(command.name + ":" + escaped(first_sentence(command.text), ":\\")) + "\n";
    text += "        'help:Print the help of a command'\n    )\n    _arguments -C \\\n";
    for (const OptionEntry& option : program.options) text += "        " + zsh_option(option) + " \\\n";
    text += "        '1: :->command' '*:: :->arguments'\n    case $state in\n";
    text += "    command) _describe -t commands command commands ;;\n    arguments)\n        case $words[1] in\n";
    text += "        help) _describe -t commands command commands ;;\n";
    for (const CommandEntry& command : program.commands) {
        text += "        " + command.name + ") _arguments";
        for (const OptionEntry& option : command.options) text += " \\\n            " + zsh_option(option);
        text += " ;;\n";
    }
    return text
           + "        esac ;;\n    esac\n}\n\n"
             "# The function itself when it completes for the first time, else the script was sourced.\n"
             "if [[ $funcstack[1] == _brittle ]]; then _brittle \"$@\"; else compdef _brittle brittle; fi\n";
}

// --- fish ---

namespace {

// In single quotes, as fish reads them.
std::string fish_quoted(const std::string& text) {
    return "'" + escaped(text, "'\\") + "'";
}

std::string fish_option(const OptionEntry& option) {
    std::string text;
    for (const std::string& name : option.names)
        text += name.starts_with("--") ? " -l " + name.substr(2) : " -s " + name.substr(1);
    if (option.takes_file || option.takes_mesh)
        text += " -r -F";
    else if (!option.value.empty())
        text += " -x";
    if (!option.choices.empty()) text += " -a " + fish_quoted(joined(option.choices));
    return text + " -d " + fish_quoted(first_sentence(option.text));
}

} // namespace

std::string fish_completion(const ProgramEntry& program, const std::vector<std::string>& shapes) {
    std::string text =
        "# Completion of brittle for fish, written by `brittle complete fish`.\n\ncomplete -c brittle -f\n";
    const std::string first = "complete -c brittle -n __fish_use_subcommand";
    for (const CommandEntry& command : program.commands)
        text += first + " -a " + command.name + " -d " + fish_quoted(first_sentence(command.text)) + "\n";
    text += first + " -a help -d 'Print the help of a command'\n";
    for (const OptionEntry& option : program.options) text += first + fish_option(option) + "\n";
    text += "complete -c brittle -n '__fish_seen_subcommand_from help' -a '" + command_names(program) + "'\n";
    for (const CommandEntry& command : program.commands) {
        const std::string of_command = "complete -c brittle -n '__fish_seen_subcommand_from " + command.name + "'";
        for (const OptionEntry& option : command.options) {
            if (!option.names.empty())
                text += of_command + fish_option(option) + "\n";
            else if (option.takes_mesh)
                text += of_command + " -F -a " + fish_quoted(with_prefix(shapes, "shape:")) + "\n";
            else
                text += of_command + " -F\n";
        }
    }
    return text;
}

} // namespace brittle::tools
