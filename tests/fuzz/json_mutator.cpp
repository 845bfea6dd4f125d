#include "tests/fuzz/json_mutator.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <fstream>
#include <initializer_list>
#include <iterator>
#include <limits>
#include <utility>

namespace brittle::fuzz {

namespace {

constexpr int max_depth = 8;    // of generated values
constexpr size_t max_items = 6; // of a generated list, if its schema allows
constexpr uint64_t break_one_in = 40;

bool has_type(const Json& schema, const char* type) {
    const auto at = schema.find("type");
    return at != schema.end() && *at == type;
}

// Whether a value is of the schema's type, and has its constants and required keys.
bool may_fit(const Json& schema, const Json& value) {
    if (const auto constant = schema.find("const"); constant != schema.end()) return *constant == value;
    if (has_type(schema, "object") != value.is_object() || has_type(schema, "array") != value.is_array()) return false;
    if (!value.is_object()) return true;
    if (const auto required = schema.find("required"); required != schema.end())
        for (const Json& key : *required)
            if (!value.contains(key.get<std::string>())) return false;
    if (const auto properties = schema.find("properties"); properties != schema.end())
        for (const auto& [key, property] : properties->items())
            if (property.contains("const") && value.contains(key) && value[key] != property["const"]) return false;
    return true;
}

} // namespace

// SplitMix64.
class JsonMutator::Dice {
  public:
    explicit Dice(uint64_t seed) : state_(seed) {}

    uint64_t next() {
        uint64_t z = state_ += 0x9e3779b97f4a7c15;
        z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9;
        z = (z ^ (z >> 27)) * 0x94d049bb133111eb;
        return z ^ (z >> 31);
    }
    uint64_t below(uint64_t n) { return n == 0 ? 0 : next() % n; }
    bool one_in(uint64_t n) { return below(n) == 0; }
    double uniform() { return static_cast<double>(next() >> 11) * 0x1p-53; }
    template<class List>
    const auto& of(const List& list) {
        return *(std::begin(list) + static_cast<std::ptrdiff_t>(below(std::size(list))));
    }

  private:
    uint64_t state_;
};

JsonMutator::JsonMutator(const std::filesystem::path& folder, Json root) : root_(std::move(root)) {
    for (const auto& entry : std::filesystem::directory_iterator(folder)) {
        const std::string name = entry.path().filename().string();
        if (name.ends_with(".schema.json")) documents_[name] = Json::parse(std::ifstream(entry.path()));
    }
}

JsonMutator::Node JsonMutator::resolved(Node node) const {
    for (auto at = node.schema->find("$ref"); at != node.schema->end(); at = node.schema->find("$ref")) {
        const std::string reference = at->get<std::string>();
        const size_t hash = reference.find('#');
        if (const std::string file = reference.substr(0, hash); !file.empty()) node.document = &documents_.at(file);
        node.schema = hash == std::string::npos ? node.document
                                                : &node.document->at(Json::json_pointer(reference.substr(hash + 1)));
    }
    return node;
}

// Chooses among alternatives: the first that fits the value, or any where none does.
JsonMutator::Node JsonMutator::branch_for(Node node, const Json* value, Dice& dice) const {
    node = resolved(node);
    for (const char* keyword : {"oneOf", "anyOf"}) {
        const auto at = node.schema->find(keyword);
        if (at == node.schema->end() || node.schema->contains("properties")) continue;
        for (const Json& one : *at)
            if (const Node branch = resolved({&one, node.document}); value && may_fit(*branch.schema, *value))
                return branch_for(branch, value, dice);
        return branch_for({&dice.of(*at), node.document}, value, dice);
    }
    return node;
}

Json JsonMutator::make_number(const Json& schema, bool whole, Dice& dice) {
    const auto bound = [&](const char* keyword) { return schema.contains(keyword) ? &schema[keyword] : nullptr; };
    const Json *low = bound("minimum"), *high = bound("maximum");
    if (!low) low = bound("exclusiveMinimum");
    if (low && dice.one_in(12)) return *low;
    if (high && dice.one_in(12)) return *high;
    if (whole) {
        if (!high && dice.one_in(20)) return std::numeric_limits<uint64_t>::max();
        const uint64_t least = low ? low->get<uint64_t>() : 0;
        const uint64_t most = high ? high->get<uint64_t>() : std::numeric_limits<uint64_t>::max();
        return std::min(most, least + (dice.one_in(3) ? dice.below(100) : dice.below(5)));
    }
    constexpr double special[] = {0.0,  -0.0, 1.0, -1.0, 90.0, 1e-3, 1e-9,  5e-324, 1e-300,
                                  1e-7, 20.0, 1e3, -1e4, 1e9,  1e20, -1e30, 3e38,   -1e300};
    double number = dice.one_in(4) ? dice.of(special) : (dice.uniform() * 2.0 - 1.0) * (dice.one_in(4) ? 30.0 : 2.0);
    if (low && high && dice.one_in(3))
        number = low->get<double>() + dice.uniform() * (high->get<double>() - low->get<double>());
    if (low) number = std::max(number, low->get<double>());
    if (high) number = std::min(number, high->get<double>());
    return std::isfinite(number) ? number : 0.0;
}

Json JsonMutator::make_text(const std::string& key, Dice& dice) {
    static const std::vector<std::string> meshes = {
        "shape:cube",        "shape:cube",    "shape:icosphere:1",  "shape:torus:8",  "shape:hollow_sphere",
        "shape:pane",        "shape:wall",    "shape:table:5",      "shape:stairs:3", "shape:stack:3",
        "shape:pyramid:2",   "shape:vase:5",  "shape:card_house:1", "shape:animal:4", "shape:domino_spiral:3",
        "cube.obj",          "cube.glb",      "crate.glb",          "needle.obj",     "figure_eight.obj",
        "concave_prism.obj", "mirrored.gltf", "doubled_patch.obj",  "cube.off",       "matrix_and_rotation.gltf"};
    static const std::vector<std::string> names = {"a", "b", "cube", "cube 2", "*", "?", ""};
    static const std::vector<std::string> hashes = {"0000000000000000", "00112233445566ff"};
    static const std::vector<std::string> bodies = {"", "(1)", "(2)", "00ff", "aa07(2)"};
    static const std::vector<std::string> files = {"bunny_three.txt", "clip_steps.txt", "none.txt"};
    if (key == "mesh") return dice.of(meshes);
    if (key == "file") return dice.of(files);
    if (key == "hash" || key == "pieces_hash") return dice.of(hashes);
    if (key == "bodies") return dice.of(bodies);
    if (key == "end") return "finished";
    return dice.of(names);
}

Json JsonMutator::make(Node node, const std::string& key, int depth, Dice& dice) const {
    node = branch_for(node, nullptr, dice);
    const Json& schema = *node.schema;
    if (const auto constant = schema.find("const"); constant != schema.end()) return *constant;
    if (const auto words = schema.find("enum"); words != schema.end()) return dice.of(*words);
    if (has_type(schema, "boolean")) return dice.one_in(2);
    if (has_type(schema, "integer")) return make_number(schema, true, dice);
    if (has_type(schema, "number")) return make_number(schema, false, dice);
    if (has_type(schema, "string")) return make_text(key, dice);
    if (has_type(schema, "array")) {
        const size_t least = schema.value("minItems", size_t{0}), most = schema.value("maxItems", size_t{1000});
        const size_t count = std::min(most, least + (least == most ? 0 : dice.below(max_items - 1)));
        Json list = Json::array();
        for (size_t k = 0; k < count && depth < max_depth; ++k)
            list.push_back(make({&schema["items"], node.document}, key, depth + 1, dice));
        return list;
    }
    Json object = Json::object();
    const auto properties = schema.find("properties");
    if (properties == schema.end() || depth >= max_depth) return object;
    const Json required = schema.value("required", Json::array());
    for (const auto& [name, property] : properties->items())
        if (std::find(required.begin(), required.end(), name) != required.end() || dice.one_in(4))
            object[name] = make({&property, node.document}, name, depth + 1, dice);
    return object;
}

void JsonMutator::collect(Json& value, Node node, const std::string& key, std::vector<Place>& places,
                          Dice& dice) const {
    node = branch_for(node, &value, dice);
    places.push_back({&value, node, key});
    if (const auto items = node.schema->find("items"); items != node.schema->end() && value.is_array())
        for (Json& item : value) collect(item, {&*items, node.document}, key, places, dice);
    if (const auto properties = node.schema->find("properties"); properties != node.schema->end() && value.is_object())
        for (auto& [name, member] : value.items())
            if (const auto property = properties->find(name); property != properties->end())
                collect(member, {&*property, node.document}, name, places, dice);
}

void JsonMutator::change_object(const Place& place, Dice& dice) const {
    const auto properties = place.node.schema->find("properties");
    Json& object = *place.value;
    if (!object.empty() && dice.one_in(4)) {
        object.erase(std::next(object.begin(), static_cast<std::ptrdiff_t>(dice.below(object.size()))));
    } else if (properties != place.node.schema->end() && !properties->empty()) {
        auto property = properties->begin();
        std::advance(property, static_cast<std::ptrdiff_t>(dice.below(properties->size())));
        object[property.key()] = make({&*property, place.node.document}, property.key(), 0, dice);
    }
}

void JsonMutator::change_list(const Place& place, Dice& dice) const {
    Json& list = *place.value;
    const auto any = [&] { return list.begin() + static_cast<std::ptrdiff_t>(dice.below(list.size())); };
    const uint64_t way = dice.below(4);
    if (list.empty() || way == 0) {
        const Json one = make({&(*place.node.schema)["items"], place.node.document}, place.key, 0, dice);
        list.insert(list.begin() + static_cast<std::ptrdiff_t>(dice.below(list.size() + 1)), one);
    } else if (way == 1) {
        list.erase(any());
    } else if (way == 2) {
        const Json one = *any();
        list.insert(any(), one);
    } else {
        std::iter_swap(any(), any());
    }
}

void JsonMutator::change(Json& value, Dice& dice) const {
    std::vector<Place> places;
    collect(value, {&root_, &root_}, "", places, dice);
    const Place& place = dice.of(places);
    if (dice.one_in(break_one_in)) {
        const std::initializer_list<Json> others = {nullptr, -1, 1e39, "\x1b[31m", Json::array(), Json::object(), true};
        *place.value = dice.of(others);
    } else if (place.value->is_object() && dice.below(8) != 0) {
        change_object(place, dice);
    } else if (place.value->is_array() && place.node.schema->contains("items")
               && place.node.schema->value("minItems", 0) != place.node.schema->value("maxItems", 1)) {
        change_list(place, dice);
    } else if (&place != places.data()) {
        *place.value = make(place.node, place.key, 0, dice);
    }
}

Json JsonMutator::generated(uint64_t seed) const {
    Dice dice(seed);
    return make({&root_, &root_}, "", 0, dice);
}

Json JsonMutator::mutated(const Json& value, uint64_t seed) const {
    Dice dice(seed);
    Json changed = value;
    for (uint64_t k = dice.below(4) + 1; k > 0; --k) change(changed, dice);
    return changed;
}

} // namespace brittle::fuzz
