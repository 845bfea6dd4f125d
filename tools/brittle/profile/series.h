// Named series of milliseconds, in the order in which the names first appeared.
#pragma once

#include <string>
#include <utility>
#include <vector>

#include <nlohmann/json.hpp>

namespace brittle::tools {

class Series {
  public:
    void add(const std::string& name, double milliseconds);

    // {name: {min, median, p95, p99, max, samples}, ...}
    [[nodiscard]] nlohmann::ordered_json json() const;

  private:
    std::vector<std::pair<std::string, std::vector<double>>> series_;
};

// Returns the key of the series that a scenario is about: "start" for a scene, "fracture" for a mesh.
[[nodiscard]] inline const char* main_group(const nlohmann::ordered_json& scenario) {
    return scenario.contains("start") ? "start" : "fracture";
}

} // namespace brittle::tools
