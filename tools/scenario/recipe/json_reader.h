// Reader of JSON files written by people. Messages name the place in the file, the expected and the actual value. All
// functions throw a Failure with exit_input.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <string>
#include <utility>
#include <vector>

#include <glm/vec3.hpp>
#include <nlohmann/json.hpp>

#include "tools/scenario/base/failure.h"

namespace brittle::tools {

// Parses a text of at most 64 nested brackets. `where` and `what` name it in messages ("run.log:7", "recipe").
[[nodiscard]] nlohmann::ordered_json parse_json(const std::filesystem::path& where, const std::string& text,
                                                const std::string& what);
// Reads and parses a file of at most `max_bytes` bytes. `what` names it in messages ("recipe").
[[nodiscard]] nlohmann::ordered_json read_json_file(const std::filesystem::path& file, const std::string& what,
                                                    size_t max_bytes);

// Returns the text of the JSON. Bytes of names that are not UTF-8 become U+FFFD, because JSON cannot hold them.
[[nodiscard]] std::string text_of(const nlohmann::ordered_json& json, int indent = -1);
// Returns whether text_of() keeps every byte of the text.
[[nodiscard]] bool is_utf8(const std::string& text);

// Returns a value as text for a message: shortened, with control characters escaped.
[[nodiscard]] std::string shown(const nlohmann::ordered_json& value);

// One object of the file. A missing key leaves its target unchanged. refuse_unknown_keys() refuses all keys that no
// call has read.
class JsonReader {
  public:
    // `path` leads to the object from the top of the file: "" or "/pattern". `file` and `json` must outlive the reader.
    JsonReader(const std::filesystem::path& file, const nlohmann::ordered_json& json, std::string path);

    [[nodiscard]] Failure failure(const std::string& key, const std::string& what) const;
    [[noreturn]] void fail(const std::string& key, const std::string& expected,
                           const nlohmann::ordered_json& found) const;

    // Returns the value of a key, or null.
    const nlohmann::ordered_json* find(const std::string& key);
    // Returns the name under which the object holds a renamed key: `former` if it is present, else `key`. Both at once
    // are a failure.
    [[nodiscard]] std::string renamed(const std::string& key, const std::string& former) const;

    void number(const std::string& key, double& target, double low, double high);
    void flag(const std::string& key, bool& target);
    void text(const std::string& key, std::string& target);
    void vector(const std::string& key, glm::dvec3& target);
    // Of the physics: places, velocities. Refuses numbers above physics::max_magnitude.
    void world_vector(const std::string& key, glm::dvec3& target);
    [[nodiscard]] glm::dvec3 vector_of(const std::string& key, const nlohmann::ordered_json& value) const;

    [[nodiscard]] double number_of(const std::string& key, const nlohmann::ordered_json& value, double low,
                                   double high) const;

    template<class Whole>
    void whole(const std::string& key, Whole& target, uint64_t low, uint64_t high) {
        if (const nlohmann::ordered_json* value = find(key))
            target = static_cast<Whole>(whole_of(key, *value, low, high));
    }
    [[nodiscard]] uint64_t whole_of(const std::string& key, const nlohmann::ordered_json& value, uint64_t low,
                                    uint64_t high) const;

    void refuse_unknown_keys() const;

  private:
    const std::filesystem::path& file_;
    const nlohmann::ordered_json& json_;
    std::string path_;
    std::vector<std::string> known_;
};

} // namespace brittle::tools
