#include "tools/brittle/commands/option_table.h"

#include <map>
#include <sstream>

namespace brittle::tools {

namespace {

// The parser's names of values that have no name of their own.
const std::map<std::string, std::string> value_names{{"UINT", "N"}, {"INT", "N"}, {"FLOAT", "NUMBER"}};

std::vector<std::string> split(const std::string& list) {
    std::vector<std::string> words;
    std::istringstream stream(list);
    for (std::string word; std::getline(stream, word, ',');) words.push_back(word);
    return words;
}

// Reads the parser's "NAME:{auto,fast,best}" or "UINT:1 to 1,000".
void read_type(const std::string& type, OptionEntry& entry) {
    const size_t colon = type.find(':');
    entry.value = type.substr(0, colon);
    if (const auto named = value_names.find(entry.value); named != value_names.end()) entry.value = named->second;
    if (colon == std::string::npos) return;
    const std::string limit = type.substr(colon + 1);
    if (limit.starts_with('{') && limit.ends_with('}'))
        entry.choices = split(limit.substr(1, limit.size() - 2));
    else
        entry.range = limit;
}

OptionEntry entry_of(const CLI::Option& option) {
    OptionEntry entry;
    for (const std::string& name : option.get_snames()) entry.names.push_back("-" + name);
    for (const std::string& name : option.get_lnames()) entry.names.push_back("--" + name);
    entry.heading = option.get_group();
    entry.text = option.get_description();
    if (option.get_type_size() == 0) return entry; // a flag
    read_type(option.get_type_name(), entry);
    entry.default_value = option.get_default_str();
    entry.takes_mesh = entry.value == "MESH";
    // FILE, FILE.json, SET.glb, OLD.json
    entry.takes_file = entry.value.starts_with("FILE") || entry.value.find('.') != std::string::npos;
    entry.repeats = option.get_expected_max() == CLI::detail::expected_max_vector_size;
    entry.required = option.get_required();
    return entry;
}

std::vector<OptionEntry> entries_of(const CLI::App& app) {
    std::vector<OptionEntry> entries;
    for (const CLI::Option* option : app.get_options())
        if (!option->get_group().empty()) entries.push_back(entry_of(*option));
    return entries;
}

} // namespace

ProgramEntry option_table(const CLI::App& app) {
    ProgramEntry program{app.get_description(), entries_of(app)};
    for (const CLI::App* command : app.get_subcommands([](const CLI::App*) { return true; }))
        if (!command->get_group().empty())
            program.commands.push_back(
                {command->get_name(), command->get_description(), command->get_footer(), entries_of(*command)});
    return program;
}

std::string first_sentence(const std::string& text) {
    const size_t end = text.find(". ");
    std::string first = text.substr(0, end);
    if (first.ends_with('.')) first.pop_back();
    return first;
}

} // namespace brittle::tools
