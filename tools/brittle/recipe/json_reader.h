// Reads JSON files that people write, with messages that say where and what was expected. Throws a Failure with
// exit_input everywhere.
//
//     const auto json = read_json_file(file, "recipe", 1 << 20);
//     JsonReader reader(file, json, "");
//     reader.whole("count", count, 1, 1'000'000);
//     reader.refuse_unknown_keys();
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <string>
#include <utility>
#include <vector>

#include <glm/vec3.hpp>
#include <nlohmann/json.hpp>

#include "tools/brittle/base/failure.h"

namespace brittle::tools {

// The text; `where` and `what` name it in messages ("run.log:7", "recipe"); no more than 64 brackets deep.
[[nodiscard]] nlohmann::ordered_json parse_json(const std::filesystem::path& where, const std::string& text,
                                                const std::string& what);
// The whole file. `what` names it in messages ("recipe"); no more than `longest` bytes.
[[nodiscard]] nlohmann::ordered_json read_json_file(const std::filesystem::path& file, const std::string& what,
                                                    size_t longest);

// A value for a message: short, without what a terminal would obey.
[[nodiscard]] std::string shown(const nlohmann::ordered_json& value);

// One object of the file. A key that is missing leaves the target as it is; keys that nobody asked for are unknown.
class JsonReader {
  public:
    // `path` leads to the object from the top of the file: "" or "/pattern". Keeps references to all three.
    JsonReader(const std::filesystem::path& file, const nlohmann::ordered_json& json, std::string path);

    [[nodiscard]] Failure failure(const std::string& key, const std::string& what) const;
    [[noreturn]] void fail(const std::string& key, const std::string& expected,
                           const nlohmann::ordered_json& found) const;

    // The value of a key, or null.
    const nlohmann::ordered_json* find(const std::string& key);
    // The name under which the object holds a renamed key: `former` where it is present, else `key`. Both at once are a
    // failure.
    [[nodiscard]] std::string renamed(const std::string& key, const std::string& former) const;

    void number(const std::string& key, double& target, double low, double high);
    void flag(const std::string& key, bool& target);
    void text(const std::string& key, std::string& target);
    void vector(const std::string& key, glm::dvec3& target);
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
