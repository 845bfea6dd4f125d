#include <algorithm>
#include <cmath>
#include <optional>
#include <span>
#include <string>
#include <unordered_map>
#include <vector>

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

// The images of the base colours, as MeshLab refers to them: a comment each in the header, and their number at each face.
class Textures {
  public:
    explicit Textures(const Model* source) : source_(source) {
        for (size_t m = 0; source_ && m < source_->materials.size(); ++m) number_of_.push_back(add(m));
    }

    [[nodiscard]] bool empty() const { return images_.empty(); }
    // -1 for a part without texture.
    [[nodiscard]] int32_t number_of(const DrawnPart& part) const {
        return part.interior || part.material >= number_of_.size() ? -1 : number_of_[part.material];
    }
    // The set of texture coordinates that the texture of a part uses.
    [[nodiscard]] const std::vector<glm::vec2>& uv_of(const DrawnPart& part) const {
        const auto& use = part.interior || part.material >= number_of_.size()
                              ? std::nullopt
                              : source_->materials[part.material].base_colour_texture;
        const auto& chosen = part.uv[use && use->uv_set == 1 ? 1 : 0];
        return chosen.empty() ? part.uv[0] : chosen;
    }
    // Adds the comments to the header and the files to the output.
    void write(const std::string& stem, std::string& header, std::vector<OutputFile>& files) const {
        for (const uint32_t i : images_) {
            const Image& image = source_->images[i];
            const std::string suffix = image_suffix(i, image);
            header += "comment TextureFile " + stem + suffix + "\n";
            files.push_back({suffix, image.bytes});
        }
    }

  private:
    int32_t add(size_t material) {
        const std::optional<TextureUse>& use = source_->materials[material].base_colour_texture;
        if (!use || use->texture >= source_->textures.size()) return -1;
        const std::optional<uint32_t> image = source_->textures[use->texture].image;
        if (!image || source_->images[*image].mime_type.empty()) return -1;
        const auto known = std::find(images_.begin(), images_.end(), *image);
        const auto number = static_cast<int32_t>(known - images_.begin());
        if (known == images_.end()) images_.push_back(*image);
        return number;
    }

    const Model* source_;
    std::vector<uint32_t> images_;   // into Model::images
    std::vector<int32_t> number_of_; // per material: into images_, or -1
};

class PlyWriter {
  public:
    explicit PlyWriter(const ExportJob& job)
        : job_(job), source_(job.options.source), has_colours_(source_ && !source_->colours.empty()),
          has_uv_(source_ && !(source_->uv[0].empty() && source_->uv[1].empty())),
          textures_(has_uv_ ? source_ : nullptr),
          colour_of_cuts_(bytes_of(glm::vec4(interior_material(job.options).base_colour))) {}

    Result<std::vector<OutputFile>> write() {
        if (!has_colours_ && !has_uv_) reserve();
        for (const uint32_t p : job_.pieces) {
            if (has_colours_ || has_uv_)
                add_parts(p);
            else
                add_plain(p);
            if (vertex_count_ > UINT32_MAX || uint64_t{vertices_.size()} + faces_.size() > (uint64_t{1} << 32))
                return Error{Status::write_failed, "the pieces take over 4 GiB; use fewer sites or one file per piece"};
        }
        std::vector<OutputFile> files;
        const std::string header = header_with(files);
        const auto head = std::as_bytes(std::span(header));
        vertices_.insert(vertices_.begin(), head.begin(), head.end());
        vertices_.insert(vertices_.end(), faces_.begin(), faces_.end());
        files.push_back({"", std::move(vertices_)});
        return files;
    }

  private:
    // Of a large file, growing buffers and a copy of them would take several times the memory.
    void reserve() {
        constexpr size_t vertex_size = 3 * sizeof(double), face_size = 1 + 3 * sizeof(uint32_t) + sizeof(uint32_t) + 1;
        constexpr size_t max_header = 1000;
        size_t all_vertices = 0, all_faces = 0;
        for (const uint32_t p : job_.pieces) {
            all_vertices += job_.fragments.pieces[p].vertices.size();
            all_faces += job_.fragments.pieces[p].triangles.size();
        }
        faces_.reserve(all_faces * face_size);
        vertices_.reserve(max_header + all_vertices * vertex_size + all_faces * face_size);
    }

    void add_plain(uint32_t p) {
        const Piece& piece = job_.fragments.pieces[p];
        const uint32_t base = add_vertices(p);
        const auto triangles = job_.fragments.triangles_of(piece);
        for (uint32_t t = 0; t < triangles.size(); ++t) {
            start_face(triangles[t] + base);
            end_face(p, t >= piece.exterior_triangles);
        }
    }

    void add_parts(uint32_t p) {
        const Piece& piece = job_.fragments.pieces[p];
        const uint32_t base = has_colours_ ? 0 : add_vertices(p);
        std::unordered_map<uint64_t, uint32_t> written; // key: vertex and colour
        SurfaceSettings settings{.source = source_};
        if (has_uv_) settings = surface_settings(job_);
        settings.outside = nullptr; // the depths of rough cuts are not written
        for (const DrawnPart& part : drawn_parts(job_.fragments, piece, settings)) {
            const std::vector<glm::vec2>& uv = textures_.uv_of(part);
            const int32_t texture = textures_.number_of(part);
            const auto vertex = [&](size_t k) {
                const uint32_t corner = part.indices[k], v = part.vertices[corner];
                if (!has_colours_) return base + v;
                const uint32_t colour = part.interior ? colour_of_cuts_ : bytes_of(part.colours[corner]);
                const auto known = written.emplace(uint64_t{v} << 32 | colour, 0);
                if (known.second) known.first->second = add_point(p, v, colour);
                return known.first->second;
            };
            for (size_t k = 0; k < part.indices.size(); k += 3) {
                start_face({vertex(k), vertex(k + 1), vertex(k + 2)});
                if (has_uv_) {
                    append(faces_, uint8_t{6});
                    for (size_t c = k; c < k + 3; ++c) {
                        const glm::vec2 at = uv.empty() ? glm::vec2(0.0f) : uv[part.indices[c]];
                        append(faces_, at.x);
                        append(faces_, 1.0f - at.y); // v points up in PLY
                    }
                }
                if (!textures_.empty()) append(faces_, texture);
                end_face(p, part.interior);
            }
        }
    }

    // Adds the vertices of a piece without colours. Returns the number of the first one.
    uint32_t add_vertices(uint32_t p) {
        const auto base = static_cast<uint32_t>(vertex_count_);
        for (const glm::dvec3& v : job_.fragments.positions_of(job_.fragments.pieces[p]))
            add_vertex(placed(job_, p, v));
        return base;
    }

    uint32_t add_vertex(const glm::dvec3& at) {
        for (int k = 0; k < 3; ++k) append(vertices_, at[k]);
        return static_cast<uint32_t>(vertex_count_++);
    }

    // Adds a colour of a vertex, with a number that is equal for all colours of it.
    uint32_t add_point(uint32_t p, uint32_t v, uint32_t colour) {
        const Piece& piece = job_.fragments.pieces[p];
        const uint32_t index = add_vertex(placed(job_, p, job_.fragments.positions_of(piece)[v]));
        append(vertices_, colour);
        append(vertices_, piece.vertices.begin + v);
        return index;
    }

    void start_face(const Triangle& t) {
        append(faces_, uint8_t{3});
        for (int k = 0; k < 3; ++k) append(faces_, t[k]);
    }

    void end_face(uint32_t piece, bool interior) {
        append(faces_, piece);
        append(faces_, static_cast<uint8_t>(interior));
        ++face_count_;
    }

    std::string header_with(std::vector<OutputFile>& files) const {
        std::string header = "ply\nformat binary_little_endian 1.0\ncomment Brittle " BRITTLE_VERSION "\n";
        textures_.write(job_.stem, header, files);
        header += "element vertex " + std::to_string(vertex_count_)
                  + "\nproperty double x\nproperty double y\nproperty double z\n";
        if (has_colours_)
            header += "property uchar red\nproperty uchar green\nproperty uchar blue\nproperty uchar alpha\n"
                      "property uint point\n";
        header += "element face " + std::to_string(face_count_) + "\nproperty list uchar uint vertex_indices\n";
        if (has_uv_) header += "property list uchar float texcoord\n";
        if (!textures_.empty()) header += "property int texnumber\n";
        return header + "property uint piece\nproperty uchar interior\nend_header\n";
    }

    const ExportJob& job_;
    const Model* source_;
    bool has_colours_, has_uv_;
    Textures textures_;
    uint32_t colour_of_cuts_; // as bytes_of() gives it
    std::vector<std::byte> vertices_, faces_;
    uint64_t vertex_count_ = 0, face_count_ = 0;
};

} // namespace

// Vertices with 64-bit coordinates, one for each vertex of a piece, or one for each of its colours, with the number of
// the vertex as `point`. Faces have the properties `piece` and `interior`; where the source has texture coordinates, the
// list `texcoord` with those of their corners, and `texnumber`, the index of a comment TextureFile or -1. So vertices
// stay shared where the texture has a seam.
Result<std::vector<OutputFile>> write_ply(const ExportJob& job) {
    return PlyWriter(job).write();
}

} // namespace brittle::fracture
