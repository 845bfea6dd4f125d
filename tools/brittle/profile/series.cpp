#include "tools/brittle/profile/series.h"

#include "tools/brittle/base/statistics.h"

namespace brittle::tools {

void Series::add(const std::string& name, double milliseconds) {
    for (auto& [known, samples] : series_) {
        if (known == name) return samples.push_back(milliseconds);
    }
    series_.push_back({name, {milliseconds}});
}

nlohmann::ordered_json Series::json() const {
    auto out = nlohmann::ordered_json::object();
    for (const auto& [name, samples] : series_) {
        const Statistics s = statistics(samples);
        out[name] = {{"min", s.min}, {"median", s.median}, {"p95", s.p95},
                     {"p99", s.p99}, {"max", s.max},       {"samples", samples.size()}};
    }
    return out;
}

} // namespace brittle::tools
