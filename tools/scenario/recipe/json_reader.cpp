#include "tools/scenario/recipe/json_reader.h"

#include <algorithm>
#include <cerrno>
#include <cmath>
#include <cstring>
#include <fstream>

#include "fracture/io/text_cursor.h"
#include "physics/world/magnitude.h"

namespace brittle::tools {

namespace {

using Json = nlohmann::ordered_json;

constexpr int max_depth = 64; // brackets; the JSON library recurses over them when it writes

} // namespace

Json parse_json(const std::filesystem::path& where, const std::string& text, const std::string& what) {
    bool too_deep = false;
    const auto keep = [&](int depth, Json::parse_event_t, Json&) {
        too_deep = too_deep || depth > max_depth;
        return depth <= max_depth;
    };
    Json json;
    try {
        json = Json::parse(text, keep);
    } catch (const nlohmann::json::exception& e) {
        // The text is "[name of the exception] reason" and quotes the last token, which may be the whole file.
        std::string why = e.what();
        if (const size_t name = why.find("] "); name != std::string::npos) why.erase(0, name + 2);
        why.resize(std::min<size_t>(why.size(), 300));
        if (!too_deep) throw Failure(exit_input, where.string() + ": the JSON cannot be read: " + why);
    }
    if (too_deep) throw Failure(exit_input, where.string() + ": nested too deeply for a " + what);
    return json;
}

Json read_json_file(const std::filesystem::path& file, const std::string& what, size_t max_bytes) {
    std::ifstream stream(file, std::ios::binary);
    if (!stream)
        throw Failure(exit_input, file.string() + ": the " + what + " cannot be read: " + std::strerror(errno));
    std::string text;
    for (char c = 0; text.size() <= max_bytes && stream.get(c);) text.push_back(c);
    if (text.size() > max_bytes)
        throw Failure(exit_input,
                      file.string() + ": the " + what + " is larger than " + std::to_string(max_bytes >> 20) + " MiB");
    return parse_json(file, text, what);
}

std::string text_of(const Json& json, int indent) {
    return json.dump(indent, ' ', false, Json::error_handler_t::replace);
}

bool is_utf8(const std::string& text) {
    return text_of(text) == Json(text).dump(-1, ' ', false, Json::error_handler_t::ignore);
}

std::string shown(const Json& value) {
    constexpr size_t max_length = 60;
    const std::string text = value.dump();
    return text.size() > max_length ? text.substr(0, max_length - 3) + "..." : text;
}

JsonReader::JsonReader(const std::filesystem::path& file, const Json& json, std::string path)
    : file_(file), json_(json), path_(std::move(path)) {
    if (!json.is_object()) fail("", "an object { }", json);
}

Failure JsonReader::failure(const std::string& key, const std::string& what) const {
    const std::string place = path_ + (key.empty() ? "" : "/" + key);
    return {exit_input, file_.string() + ": " + (place.empty() ? "" : place + ": ") + what};
}

void JsonReader::fail(const std::string& key, const std::string& expected, const Json& found) const {
    throw failure(key, "expected " + expected + ", found " + shown(found));
}

const Json* JsonReader::find(const std::string& key) {
    if (std::find(known_.begin(), known_.end(), key) == known_.end()) known_.push_back(key);
    const auto at = json_.find(key);
    return at == json_.end() ? nullptr : &*at;
}

std::string JsonReader::renamed(const std::string& key, const std::string& former) const {
    if (!json_.contains(former)) return key;
    if (json_.contains(key)) throw failure(former, "is the former name of " + key + "; give only one of the two");
    return former;
}

void JsonReader::number(const std::string& key, double& target, double low, double high) {
    if (const Json* value = find(key)) target = number_of(key, *value, low, high);
}

double JsonReader::number_of(const std::string& key, const Json& value, double low, double high) const {
    if (!value.is_number() || !(value.get<double>() >= low) || !(value.get<double>() <= high))
        fail(key, "a number from " + Json(low).dump() + " to " + Json(high).dump(), value);
    return value.get<double>();
}

uint64_t JsonReader::whole_of(const std::string& key, const Json& value, uint64_t low, uint64_t high) const {
    if (!value.is_number_unsigned() || value.get<uint64_t>() < low || value.get<uint64_t>() > high)
        fail(key, "a whole number from " + std::to_string(low) + " to " + std::to_string(high), value);
    return value.get<uint64_t>();
}

void JsonReader::flag(const std::string& key, bool& target) {
    const Json* value = find(key);
    if (!value) return;
    if (!value->is_boolean()) fail(key, "true or false", *value);
    target = value->get<bool>();
}

void JsonReader::text(const std::string& key, std::string& target) {
    const Json* value = find(key);
    if (!value) return;
    if (!value->is_string()) fail(key, "text in quotes", *value);
    target = value->get<std::string>();
}

void JsonReader::vector(const std::string& key, glm::dvec3& target) {
    if (const Json* value = find(key)) target = vector_of(key, *value);
}

void JsonReader::world_vector(const std::string& key, glm::dvec3& target) {
    constexpr auto largest = static_cast<double>(physics::max_magnitude);
    const Json* value = find(key);
    if (!value) return;
    target = vector_of(key, *value);
    for (int axis = 0; axis < 3; ++axis)
        static_cast<void>(
            number_of(key + "/" + std::to_string(axis), (*value)[static_cast<size_t>(axis)], -largest, largest));
}

glm::dvec3 JsonReader::vector_of(const std::string& key, const Json& value) const {
    const auto is_number = [](const Json& v) { return v.is_number() && std::isfinite(v.get<double>()); };
    if (!value.is_array() || value.size() != 3 || !std::all_of(value.begin(), value.end(), is_number))
        fail(key, "three numbers [x, y, z]", value);
    return {value[0].get<double>(), value[1].get<double>(), value[2].get<double>()};
}

void JsonReader::refuse_unknown_keys() const {
    for (const auto& [key, value] : json_.items()) {
        if (std::find(known_.begin(), known_.end(), key) != known_.end()) continue;
        std::string list;
        for (const std::string& known : known_) list += (list.empty() ? "" : ", ") + known;
        throw failure(fracture::printable(key), "unknown key; the keys are: " + list);
    }
}

} // namespace brittle::tools
