// Oracles for mesh tests, written apart from the code under test and as plainly as can be.
#pragma once

#include <filesystem>
#include <map>
#include <span>
#include <string>
#include <utility>

#include <glm/geometric.hpp>
#include <unistd.h>

#include "fracture/mesh.h"

namespace brittle::fracture::test {

// Every edge is used as often in one direction as in the other, and at most once.
inline bool is_closed(std::span<const Triangle> triangles) {
    std::map<std::pair<uint32_t, uint32_t>, int> uses;
    for (const Triangle& t : triangles) {
        for (int k = 0; k < 3; ++k) ++uses[{t[k], t[(k + 1) % 3]}];
    }
    for (const auto& [edge, count] : uses) {
        const auto twin = uses.find({edge.second, edge.first});
        if (count != 1 || twin == uses.end() || twin->second != 1) return false;
    }
    return !triangles.empty();
}

inline double signed_volume(const TriangleMesh& mesh) {
    double six_volumes = 0.0;
    for (const Triangle& t : mesh.triangles) {
        six_volumes += glm::dot(mesh.positions[t.x], glm::cross(mesh.positions[t.y], mesh.positions[t.z]));
    }
    return six_volumes / 6.0;
}

// An empty folder that goes away with the object.
class TemporaryFolder {
  public:
    TemporaryFolder() {
        std::string pattern = (std::filesystem::temp_directory_path() / "brittle_test_XXXXXX").string();
        path_ = ::mkdtemp(pattern.data());
    }
    TemporaryFolder(const TemporaryFolder&) = delete;
    TemporaryFolder& operator=(const TemporaryFolder&) = delete;
    ~TemporaryFolder() {
        std::error_code ignored;
        std::filesystem::remove_all(path_, ignored);
    }

    [[nodiscard]] const std::filesystem::path& path() const { return path_; }
    // Number of entries in it.
    [[nodiscard]] size_t size() const {
        size_t count = 0;
        for ([[maybe_unused]] const auto& entry : std::filesystem::directory_iterator(path_)) ++count;
        return count;
    }

  private:
    std::filesystem::path path_;
};

} // namespace brittle::fracture::test
