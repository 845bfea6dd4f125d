#include <algorithm>
#include <cmath>
#include <cstring>
#include <string>
#include <tuple>
#include <vector>

#include <glm/geometric.hpp>

#include "fracture/io/bytes.h"
#include "fracture/io/stl_attribute.h"
#include "fracture/io/writers.h"

namespace brittle::fracture {

namespace {

// Returns the rank of each vertex, in the order of the pieces, among those at its position in single precision.
std::vector<uint32_t> ranks_of(const ExportJob& job) {
    struct Place {
        glm::vec3 at;
        uint32_t vertex;
    };
    std::vector<Place> places;
    for (const uint32_t p : job.pieces)
        for (const glm::dvec3& v : job.fragments.positions_of(job.fragments.pieces[p]))
            places.push_back({glm::vec3(placed(job, p, v)) + 0.0f, static_cast<uint32_t>(places.size())}); // no -0
    std::sort(places.begin(), places.end(), [](const Place& a, const Place& b) {
        return std::tie(a.at.x, a.at.y, a.at.z, a.vertex) < std::tie(b.at.x, b.at.y, b.at.z, b.vertex);
    });
    std::vector<uint32_t> ranks(places.size(), 0);
    for (size_t k = 1; k < places.size(); ++k)
        if (places[k].at == places[k - 1].at) ranks[places[k].vertex] = ranks[places[k - 1].vertex] + 1;
    return ranks;
}

} // namespace

// Binary: 80 bytes of text, a count, then normal, three corners and two attribute bytes per triangle (stl_attribute.h).
Result<std::vector<OutputFile>> write_stl(const ExportJob& job) {
    std::vector<std::byte> bytes(80);
    const std::string head = std::string(stl_head) + BRITTLE_VERSION; // must not begin with "solid"
    std::memcpy(bytes.data(), head.data(), head.size());
    uint64_t count = 0;
    for (const uint32_t p : job.pieces) count += job.fragments.pieces[p].triangles.size();
    if (84 + 50 * count > (uint64_t{1} << 32))
        return Error{Status::write_failed, "the pieces take over 4 GiB; use fewer sites or one file per piece"};
    append(bytes, static_cast<uint32_t>(count));
    const std::vector<uint32_t> ranks = ranks_of(job);
    size_t first = 0; // vertex of the piece
    for (const uint32_t p : job.pieces) {
        const Piece& piece = job.fragments.pieces[p];
        const auto positions = job.fragments.positions_of(piece);
        const auto triangles = job.fragments.triangles_of(piece);
        for (uint32_t t = 0; t < triangles.size(); ++t) {
            const glm::dvec3 a = placed(job, p, positions[triangles[t].x]),
                             b = placed(job, p, positions[triangles[t].y]),
                             c = placed(job, p, positions[triangles[t].z]);
            const glm::dvec3 normal = glm::cross(b - a, c - a);
            const double length = glm::length(normal);
            for (const glm::vec3& v :
                 {glm::vec3(length > 0.0 ? normal / length : normal), glm::vec3(a), glm::vec3(b), glm::vec3(c)}) {
                if (!std::isfinite(v.x + v.y + v.z))
                    return Error{Status::write_failed,
                                 piece_name(job.options, p)
                                     + " has a coordinate that does not fit a 32-bit float; scale "
                                       "the mesh down"};
                append(bytes, v);
            }
            append(bytes, stl_attribute(t >= piece.exterior_triangles, ranks[first + triangles[t].x],
                                        ranks[first + triangles[t].y], ranks[first + triangles[t].z]));
        }
        first += positions.size();
    }
    return std::vector<OutputFile>{{"", std::move(bytes)}};
}

} // namespace brittle::fracture
