#include "tools/scenario/replay/action_json.h"

#include <limits>
#include <string>
#include <utility>

namespace brittle::tools {

namespace {

using Json = nlohmann::ordered_json;

// The fields of each kind of action, listed once for reading and writing: a codec receives name and value of each
// field.
template<class Codec>
void fields(Codec& codec, Shoot& a) {
    codec("from", a.from), codec("velocity", a.velocity), codec("radius", a.radius), codec("density", a.density);
}
template<class Codec>
void fields(Codec& codec, Damage& a) {
    codec("point", a.point), codec("radius", a.radius), codec("amount", a.amount);
}
template<class Codec>
void fields(Codec& codec, Saw& a) {
    codec("from", a.from), codec("to", a.to), codec("radius", a.radius), codec("amount", a.amount);
}
template<class Codec>
void fields(Codec& codec, Hammer& a) {
    codec("piece", a.piece), codec("point", a.point), codec("impulse", a.impulse);
}
template<class Codec>
void fields(Codec& codec, Release& a) {
    codec("pieces", a.pieces);
}
template<class Codec>
void fields(Codec& codec, Push& a) {
    codec("piece", a.piece), codec("point", a.point), codec("impulse", a.impulse);
}
template<class Codec>
void fields(Codec& codec, Grab& a) {
    codec("piece", a.piece), codec("point", a.point);
}
template<class Codec>
void fields(Codec& codec, Drag& a) {
    codec("to", a.to);
}
template<class Codec>
void fields(Codec&, LetGo&) {}
template<class Codec>
void fields(Codec& codec, Watch& a) {
    codec("eye", a.eye), codec("target", a.target), codec("fov", a.fov), codec("aspect", a.aspect);
}

// Names of actions, by index into Action.
constexpr const char* names[] = {"shoot", "damage", "saw",  "hammer", "release",
                                 "push",  "grab",   "drag", "let_go", "watch"};
static_assert(std::size(names) == std::variant_size_v<Action>);

struct Writer {
    Json json = Json::object();

    void operator()(const char* name, const glm::dvec3& v) { json[name] = {v.x, v.y, v.z}; }
    template<class Value>
    void operator()(const char* name, const Value& value) {
        json[name] = value;
    }
};

struct Reader {
    JsonReader& reader;

    const Json& required(const char* name) {
        const Json* value = reader.find(name);
        if (!value) throw reader.failure(name, "is missing");
        return *value;
    }
    void operator()(const char* name, glm::dvec3& v) { v = reader.vector_of(name, required(name)); }
    void operator()(const char* name, double& value) {
        required(name);
        reader.number(name, value, std::numeric_limits<double>::lowest(), std::numeric_limits<double>::max());
    }
    void operator()(const char* name, uint32_t& value) {
        value = static_cast<uint32_t>(reader.whole_of(name, required(name), 0, UINT32_MAX));
    }
    void operator()(const char* name, std::vector<uint32_t>& list) {
        const Json& json = required(name);
        if (!json.is_array()) reader.fail(name, "a list of pieces [0, 1, ...]", json);
        for (size_t k = 0; k < json.size(); ++k)
            list.push_back(static_cast<uint32_t>(
                reader.whole_of(std::string(name) + "/" + std::to_string(k), json[k], 0, UINT32_MAX)));
    }
};

template<size_t Kind = 0>
Action action_of_kind(size_t kind) {
    if constexpr (Kind + 1 < std::variant_size_v<Action>)
        if (kind != Kind) return action_of_kind<Kind + 1>(kind);
    return Action(std::in_place_index<Kind>);
}

} // namespace

void write_action(Json& object, const Action& action) {
    Writer writer;
    std::visit([&](auto one) { fields(writer, one); }, action);
    object[names[action.index()]] = std::move(writer.json);
}

std::optional<Action> read_action(const std::filesystem::path& where, JsonReader& reader, size_t piece_count) {
    std::optional<Action> action;
    for (size_t kind = 0; kind < std::size(names); ++kind) {
        const Json* json = reader.find(names[kind]);
        if (!json) continue;
        if (action) throw reader.failure(names[kind], "a line may hold only one action");
        JsonReader inner(where, *json, "/" + std::string(names[kind]));
        action = action_of_kind(kind);
        Reader codec{inner};
        std::visit([&](auto& one) { fields(codec, one); }, *action);
        inner.refuse_unknown_keys();
        const std::string fault = fault_of(*action, piece_count);
        if (!fault.empty()) throw inner.failure("", fault);
    }
    return action;
}

} // namespace brittle::tools
