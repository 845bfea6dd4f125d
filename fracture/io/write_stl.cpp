#include <cmath>
#include <cstring>

#include <glm/geometric.hpp>

#include "fracture/io/bytes.h"
#include "fracture/io/writers.h"

namespace brittle::fracture {

// Binary: 80 bytes of text, a count, then normal, three corners and two attribute bytes per triangle, which are 1 in
// the interior.
Result<std::vector<OutputFile>> write_stl(const ExportJob& job) {
    std::vector<std::byte> bytes(80);
    const std::string_view head = "Brittle " BRITTLE_VERSION; // must not begin with "solid"
    std::memcpy(bytes.data(), head.data(), head.size());
    uint64_t count = 0;
    for (const uint32_t p : job.pieces) count += job.fragments.pieces[p].triangles.size();
    if (84 + 50 * count > (uint64_t{1} << 32))
        return Error{Status::write_failed, "the pieces take over 4 GiB; use fewer sites or one file per piece"};
    append(bytes, static_cast<uint32_t>(count));
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
            append(bytes, static_cast<uint16_t>(t >= piece.exterior_triangles ? 1 : 0));
        }
    }
    return std::vector<OutputFile>{{"", std::move(bytes)}};
}

} // namespace brittle::fracture
