// Fuzzes the reader of site files.
#include <cmath>

#include "fracture/sites/sites.h"
#include "tests/fuzz/oracle.h"

using namespace brittle;

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
    const fuzz::MemoryFile file(data, size);
    const fuzz::TimeGuard guard;
    const auto list = fracture::read_sites(file.path());
    if (!list) {
        fuzz::check_message(list.error().message);
        return 0;
    }
    const auto& [sites, weights] = *list;
    fuzz::require(!sites.empty() && sites.size() <= size, "as many sites as the file has room for");
    for (const glm::dvec3& p : sites)
        fuzz::require(std::isfinite(p.x) && std::isfinite(p.y) && std::isfinite(p.z), "a site that is not finite");
    fuzz::require(weights.empty() || weights.size() == sites.size(), "a weight for each site, or none");
    for (const double weight : weights) fuzz::require(weight >= 0.0, "a negative weight");
    return 0;
}
