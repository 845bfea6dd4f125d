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

} // namespace brittle::tools
