// Files of sites.
#include <cmath>

#include "fracture/sites/sites.h"
#include "tests/fuzz/oracle.h"

using namespace brittle;

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
    const fuzz::MemoryFile file(data, size);
    const fuzz::TimeGuard guard;
    const auto sites = fracture::read_sites(file.path());
    if (!sites) {
        fuzz::check_message(sites.error().message);
        return 0;
    }
    fuzz::require(!sites->empty() && sites->size() <= size, "as many sites as the file has room for");
    for (const glm::dvec3& p : *sites)
        fuzz::require(std::isfinite(p.x) && std::isfinite(p.y) && std::isfinite(p.z), "a site that is not finite");
    return 0;
}
