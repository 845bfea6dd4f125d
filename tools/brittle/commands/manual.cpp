#include "tools/brittle/commands/manual.h"

#include <algorithm>
#include <cctype>
#include <sstream>
#include <vector>

namespace brittle::tools {

namespace {

// Text that troff prints as it is: no character of it is a command, and hyphens are those of options.
std::string plain(const std::string& text) {
    std::string safe;
    for (const char c : text) {
        if (safe.empty() && (c == '.' || c == '\'')) safe = "\\&";
        if (c == '\\')
            safe += "\\e";
        else if (c == '-')
            safe += "\\-";
        else
            safe += c;
    }
    return safe;
}

std::string bold(const std::string& text) {
    return "\\fB" + plain(text) + "\\fR";
}

std::string italic(const std::string& text) {
    return "\\fI" + plain(text) + "\\fR";
}

std::string upper(std::string text) {
    std::ranges::transform(text, text.begin(), [](unsigned char c) { return static_cast<char>(std::toupper(c)); });
    return text;
}

// Paragraphs; lines that begin with two blanks stay lines.
std::string paragraphs(const std::string& text) {
    std::string page;
    std::istringstream stream(text);
    bool fixed = false;
    for (std::string line; std::getline(stream, line);) {
        const bool wants_fixed = line.starts_with("  ");
        if (wants_fixed != fixed) page += wants_fixed ? ".PP\n.nf\n.RS\n" : ".RE\n.fi\n";
        fixed = wants_fixed;
        if (line.empty())
            page += ".PP\n";
        else
            page += plain(fixed ? line.substr(2) : line) + "\n";
    }
    return page + (fixed ? ".RE\n.fi\n" : "");
}

std::string tagged(const OptionEntry& option) {
    std::string tag;
    for (const std::string& name : option.names) tag += (tag.empty() ? "" : ", ") + bold(name);
    if (option.names.empty()) return italic(option.value);
    return option.value.empty() ? tag : tag + " " + italic(option.value);
}

std::string joined(const std::vector<std::string>& words) {
    std::string text;
    for (const std::string& word : words) text += (text.empty() ? "" : ", ") + word;
    return text;
}

// What the help puts behind the name of an option.
std::string limits(const OptionEntry& option) {
    std::string text = option.choices.empty() ? option.range : joined(option.choices);
    if (!option.default_value.empty()) text += (text.empty() ? "default " : "; default ") + option.default_value;
    if (option.required) text += text.empty() ? "required" : "; required";
    if (option.repeats) text += text.empty() ? "several values" : "; several values";
    return text.empty() ? text : " (" + text + ")";
}

// A description that ends with a full stop, unless it names files.
std::string sentence(const std::string& text) {
    const bool ends = text.empty() || std::string("].)!?").find(text.back()) != std::string::npos;
    return text + (ends ? "" : ".");
}

std::string entry(const OptionEntry& option) {
    return ".TP\n" + tagged(option) + "\n" + plain(sentence(option.text) + limits(option)) + "\n";
}

std::vector<OptionEntry> under(const CommandEntry& command, const std::string& heading) {
    std::vector<OptionEntry> options;
    std::ranges::copy_if(command.options, std::back_inserter(options),
                         [&](const OptionEntry& option) { return option.heading == heading; });
    return options;
}

std::string synopsis(const CommandEntry& command) {
    std::string text = ".B brittle " + plain(command.name) + "\n[\\fIOPTION\\fR]...";
    for (const OptionEntry& option : command.options)
        if (option.names.empty())
            text += option.required ? " " + italic(option.value) : " [" + italic(option.value) + "]";
    return text + "\n";
}

// The options by headings. One whose options an earlier command has, too, refers to it.
std::string command_section(const ProgramEntry& program, const CommandEntry& command) {
    std::string page = ".SH BRITTLE " + upper(plain(command.name)) + "\n" + plain(sentence(command.text)) + "\n.PP\n"
                       + synopsis(command);
    std::vector<std::string> headings;
    for (const OptionEntry& option : command.options)
        if (std::ranges::find(headings, option.heading) == headings.end()) headings.push_back(option.heading);
    for (const std::string& heading : headings) {
        const std::vector<OptionEntry> options = under(command, heading);
        page += ".SS " + plain(heading) + "\n";
        const auto same = std::ranges::find_if(program.commands, [&](const CommandEntry& earlier) {
            return earlier.name == command.name || under(earlier, heading) == options;
        });
        if (same->name != command.name)
            page += "As of\n.BR \"brittle " + plain(same->name) + "\" .\n";
        else
            for (const OptionEntry& option : options) page += entry(option);
    }
    if (!command.footer.empty()) page += ".SS Notes\n" + paragraphs(command.footer);
    return page;
}

} // namespace

std::string manual_page(const ProgramEntry& program, const std::string& version) {
    std::string page = ".\\\" Written by `brittle help --man`.\n.TH BRITTLE 1 \"\" \"brittle " + plain(version)
                       + "\" \"User Commands\"\n.SH NAME\nbrittle \\- break triangle meshes into watertight pieces\n"
                         ".SH SYNOPSIS\n.B brittle\n\\fICOMMAND\\fR [\\fIOPTION\\fR]... [\\fIMESH\\fR]\n";
    page += ".SH DESCRIPTION\n" + paragraphs(program.text);
    page += ".SH COMMANDS\n";
    for (const CommandEntry& command : program.commands)
        page += ".TP\n" + bold(command.name) + "\n" + plain(sentence(command.text)) + "\n";
    page += ".TP\n" + bold("help") + " " + italic("COMMAND") + "\nPrint the help of a command.\n";
    page += ".SH OPTIONS\n";
    for (const OptionEntry& option : program.options) page += entry(option);
    for (const CommandEntry& command : program.commands) page += command_section(program, command);
    page += ".SH EXIT STATUS\n";
    for (const auto& [code, text] : exit_texts)
        page += ".TP\n" + bold(std::to_string(code)) + "\n" + plain(sentence(text)) + "\n";
    return page;
}

} // namespace brittle::tools
