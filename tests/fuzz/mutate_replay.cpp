// Replay logs, changed by their schema: a list of lines. Steps are numbered anew, so that most logs are read.
#include <sstream>
#include <utility>

#include "tests/fuzz/mutate.h"

using namespace brittle::fuzz;

namespace {

Json lines_of(const std::string& text) {
    Json lines = Json::array();
    std::istringstream stream(text);
    for (std::string line; std::getline(stream, line);)
        if (Json json = Json::parse(line, nullptr, false); json.is_object()) lines.push_back(std::move(json));
    return lines;
}

// One header first, a state before the first step, the end last, and steps that count up.
Json in_order(const Json& lines, const JsonMutator& mutator, uint64_t seed) {
    Json ordered = Json::array(), header, rest = Json::array();
    const Json first_state = {{"step", 0}, {"hash", "0000000000000000"}, {"bodies", ""}};
    for (const Json& line : lines) {
        if (line.contains("brittle_log"))
            header = line;
        else if (!line.contains("end"))
            rest.push_back(line);
    }
    while (!header.is_object() || !header.contains("brittle_log")) {
        const Json made = mutator.generated(seed++);
        for (const Json& line : made)
            if (line.is_object() && line.contains("brittle_log")) header = line;
    }
    ordered.push_back(header);
    uint64_t states = 0;
    for (Json& line : rest) {
        if (states == 0 && !line.contains("step")) {
            ordered.push_back(first_state);
            states = 1;
        }
        if (line.contains("step"))
            line["step"] = states++;
        else
            line["after"] = states - 1;
        ordered.push_back(line);
    }
    if (states == 0) ordered.push_back(first_state);
    ordered.push_back({{"end", "finished"}, {"steps", states == 0 ? 0 : states - 1}});
    return ordered;
}

} // namespace

extern "C" size_t LLVMFuzzerCustomMutator(uint8_t* data, size_t size, size_t max_size, unsigned seed) {
    static const JsonMutator mutator(BRITTLE_ASSETS, {{"type", "array"}, {"items", {{"$ref", "replay.schema.json"}}}});
    if (seed % bytes_one_in == 0) return LLVMFuzzerMutate(data, size, max_size);
    const Json before = lines_of({reinterpret_cast<const char*>(data), size});
    Json after = before.empty() ? mutator.generated(seed) : mutator.mutated(before, seed);
    if (!after.is_array()) after = Json::array({after});
    for (Json& line : after)
        if (!line.is_object()) line = Json::object();
    if (seed % unordered_one_in != 0) after = in_order(after, mutator, seed);
    std::string text;
    for (const Json& line : after) text += text_of(line) + "\n";
    return written(text, data, size, max_size);
}
