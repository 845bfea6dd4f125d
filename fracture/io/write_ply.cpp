#include <algorithm>
#include <cmath>
#include <optional>
#include <span>
#include <unordered_map>

#include "fracture/io/bytes.h"
#include "fracture/io/colour.h"
#include "fracture/io/piece_surface.h"
#include "fracture/io/writers.h"

namespace brittle::fracture {
namespace {

// Red in the lowest byte, in sRGB.
uint32_t bytes_of(const glm::vec4& colour) {
    uint32_t result = 0;
    for (int k = 0; k < 4; ++k) {
        const double share = std::clamp(static_cast<double>(colour[k]), 0.0, 1.0);
        result |= static_cast<uint32_t>(std::lround(255.0 * (k < 3 ? srgb_of_linear(share) : share))) << 8 * k;
    }
    return result;
}

struct ColouredPoint {
    uint32_t colour; // as bytes_of() gives it
    uint32_t number; // equal for all colours of a vertex
};

} // namespace

// Vertices with 64-bit coordinates, one for each vertex of a piece, or one for each of its colours, with the number of
// the vertex as `point`. Faces have the properties `piece` and `interior`.
Result<std::vector<OutputFile>> write_ply(const ExportJob& job) {
    const Model* const source = job.options.source;
    const bool has_colours = source && !source->colours.empty();
    const uint32_t of_cuts = bytes_of(glm::vec4(interior_material(job.options).base_colour));
    std::vector<std::byte> vertices, faces;
    uint64_t vertex_count = 0, face_count = 0;
    if (!has_colours) { // of a large file, growing buffers and a copy of them would take several times the memory
        constexpr size_t vertex_size = 3 * sizeof(double), face_size = 1 + 3 * sizeof(uint32_t) + sizeof(uint32_t) + 1;
        constexpr size_t max_header = 1000;
        size_t all_vertices = 0, all_faces = 0;
        for (const uint32_t p : job.pieces) {
            all_vertices += job.fragments.pieces[p].vertices.size();
            all_faces += job.fragments.pieces[p].triangles.size();
        }
        faces.reserve(all_faces * face_size);
        vertices.reserve(max_header + all_vertices * vertex_size + all_faces * face_size);
    }
    const auto add_vertex = [&](const glm::dvec3& p, const std::optional<ColouredPoint>& point) {
        for (int k = 0; k < 3; ++k) append(vertices, p[k]);
        if (point) append(vertices, point->colour);
        if (point) append(vertices, point->number);
        return static_cast<uint32_t>(vertex_count++);
    };
    const auto add_face = [&](const Triangle& t, uint32_t piece, bool interior) {
        append(faces, uint8_t{3});
        for (int k = 0; k < 3; ++k) append(faces, t[k]);
        append(faces, piece);
        append(faces, static_cast<uint8_t>(interior));
        ++face_count;
    };
    for (const uint32_t p : job.pieces) {
        const Piece& piece = job.fragments.pieces[p];
        const auto positions = job.fragments.positions_of(piece);
        if (has_colours) {
            std::unordered_map<uint64_t, uint32_t> written; // key: vertex and colour
            for (const DrawnPart& part : drawn_parts(job.fragments, piece, {.source = source})) {
                const auto vertex = [&](size_t k) {
                    const uint32_t corner = part.indices[k], v = part.vertices[corner];
                    const uint32_t colour = part.interior ? of_cuts : bytes_of(part.colours[corner]);
                    const auto [known, is_new] = written.emplace(uint64_t{v} << 32 | colour, 0);
                    const ColouredPoint point{colour, piece.vertices.begin + v};
                    if (is_new) known->second = add_vertex(placed(job, p, positions[v]), point);
                    return known->second;
                };
                for (size_t k = 0; k < part.indices.size(); k += 3)
                    add_face({vertex(k), vertex(k + 1), vertex(k + 2)}, p, part.interior);
            }
        } else {
            const auto base = static_cast<uint32_t>(vertex_count);
            for (const glm::dvec3& v : positions) add_vertex(placed(job, p, v), std::nullopt);
            const auto triangles = job.fragments.triangles_of(piece);
            for (uint32_t t = 0; t < triangles.size(); ++t)
                add_face(triangles[t] + base, p, t >= piece.exterior_triangles);
        }
        if (vertex_count > UINT32_MAX || uint64_t{vertices.size()} + faces.size() > (uint64_t{1} << 32))
            return Error{Status::write_failed, "the pieces take over 4 GiB; use fewer sites or one file per piece"};
    }
    std::string header = "ply\nformat binary_little_endian 1.0\ncomment Brittle " BRITTLE_VERSION "\nelement vertex "
                         + std::to_string(vertex_count) + "\nproperty double x\nproperty double y\nproperty double z\n";
    if (has_colours)
        header += "property uchar red\nproperty uchar green\nproperty uchar blue\nproperty uchar alpha\n"
                  "property uint point\n";
    header += "element face " + std::to_string(face_count)
              + "\nproperty list uchar uint vertex_indices\nproperty uint piece\nproperty uchar interior\nend_header\n";
    const auto head = std::as_bytes(std::span(header));
    vertices.insert(vertices.begin(), head.begin(), head.end());
    vertices.insert(vertices.end(), faces.begin(), faces.end());
    return std::vector<OutputFile>{{"", std::move(vertices)}};
}

} // namespace brittle::fracture
