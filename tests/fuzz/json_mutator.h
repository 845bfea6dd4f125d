// Changes JSON as its schema allows, so that the fuzzer reaches what lies behind the reader: hardly any change of single
// bytes leaves a recipe that is read.
//
// Knows the keywords that Brittle's schemas use: $ref, type, const, enum, properties, required, items, minItems,
// maxItems, minimum, exclusiveMinimum, maximum, oneOf, anyOf. Of the others it keeps nothing, and one change in about
// forty breaks the schema on purpose. Equal seeds give equal results.
#pragma once

#include <cstdint>
#include <filesystem>
#include <map>
#include <string>
#include <vector>

#include <nlohmann/json.hpp>

namespace brittle::fuzz {

using Json = nlohmann::ordered_json;

class JsonMutator {
  public:
    // `folder` holds the schemas. `root` is one of them, or a schema with references to them.
    JsonMutator(const std::filesystem::path& folder, Json root);

    // Makes one to four changes. A text that is no JSON becomes a new value.
    [[nodiscard]] Json mutated(const Json& value, uint64_t seed) const;
    [[nodiscard]] Json generated(uint64_t seed) const;

  private:
    // A part of a schema, and the file to which its references "#/..." belong.
    struct Node {
        const Json* schema = nullptr;
        const Json* document = nullptr;
    };
    struct Place {
        Json* value = nullptr;
        Node node;
        std::string key; // the nearest one above
    };
    class Dice;

    [[nodiscard]] Node resolved(Node node) const;
    [[nodiscard]] Node branch_for(Node node, const Json* value, Dice& dice) const;
    [[nodiscard]] Json make(Node node, const std::string& key, int depth, Dice& dice) const;
    [[nodiscard]] static Json make_number(const Json& schema, bool whole, Dice& dice);
    [[nodiscard]] static Json make_text(const std::string& key, Dice& dice);
    void collect(Json& value, Node node, const std::string& key, std::vector<Place>& places, Dice& dice) const;
    void change(Json& value, Dice& dice) const;
    void change_object(const Place& place, Dice& dice) const;
    void change_list(const Place& place, Dice& dice) const;

    Json root_;
    std::map<std::string, Json> documents_; // by the name of the file
};

} // namespace brittle::fuzz
