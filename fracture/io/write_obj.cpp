#include <algorithm>
#include <charconv>
#include <cmath>
#include <set>

#include "fracture/io/piece_surface.h"
#include "fracture/io/writers.h"

namespace brittle::fracture {
namespace {

// Most readers end an OBJ name at a blank.
std::string word(std::string name, const std::string& otherwise) {
    for (char& c : name)
        if (static_cast<unsigned char>(c) <= ' ') c = '_';
    return name.empty() ? otherwise : name;
}

class ObjWriter {
  public:
    explicit ObjWriter(const ExportJob& job) : job_(job), source_(job.options.source) {}

    Result<std::vector<OutputFile>> write() {
        name_materials();
        obj_ = "# Brittle " BRITTLE_VERSION "\n";
        if (!job_.options.single_file) obj_ += "mtllib " + job_.stem + ".mtl\n";
        for (const uint32_t p : job_.pieces) write_piece(p);
        if (!job_.options.single_file) write_library();
        files_.push_back({"", bytes_of(obj_)});
        return std::move(files_);
    }

  private:
    static std::vector<std::byte> bytes_of(const std::string& text) {
        const auto* const bytes = reinterpret_cast<const std::byte*>(text.data());
        return {bytes, bytes + text.size()};
    }

    // Appends the shortest digits that give the number again.
    static void append(std::string& text, double value) {
        char digits[32];
        text += ' ';
        text.append(digits, std::to_chars(digits, digits + sizeof digits, value).ptr);
    }
    static void append(std::string& text, float value) {
        char digits[32];
        text += ' ';
        text.append(digits, std::to_chars(digits, digits + sizeof digits, value).ptr);
    }

    // OBJ identifies materials by name, so each gets a unique one.
    void name_materials() {
        std::set<std::string> taken;
        const auto unique = [&](const Material& material, const std::string& otherwise) {
            const std::string name = word(material.name, otherwise);
            std::string free = name;
            for (int k = 2; !taken.insert(free).second; ++k) free = name + "_" + std::to_string(k);
            return free;
        };
        for (size_t m = 0; source_ && m < source_->materials.size(); ++m)
            names_.push_back(unique(source_->materials[m], "material_" + std::to_string(m)));
        exterior_ = static_cast<uint32_t>(names_.size());
        names_.push_back(unique(exterior_material(job_.options), "exterior"));
        interior_ = exterior_ + 1;
        names_.push_back(unique(interior_material(job_.options), "interior"));
    }

    void write_piece(uint32_t p) {
        const Piece& piece = job_.fragments.pieces[p];
        const auto positions = job_.fragments.positions_of(piece);
        obj_ += "o " + word(piece_name(job_.options, p), "piece") + "\n";
        for (const glm::dvec3& v : positions) {
            const glm::dvec3 at = placed(job_, p, v);
            obj_ += 'v';
            for (int k = 0; k < 3; ++k) append(obj_, at[k]);
            obj_ += '\n';
        }
        for (const DrawnPart& part : drawn_parts(job_.fragments, piece, surface_settings(job_))) {
            const bool has_uv = !part.uv[0].empty();
            for (const glm::vec2& at : part.uv[0]) {
                obj_ += "vt";
                append(obj_, at.x);
                append(obj_, 1.0f - at.y); // v points up in OBJ
                obj_ += '\n';
            }
            for (const glm::vec3& normal : part.normals) {
                const glm::vec3 n = turned(job_, p, normal);
                obj_ += "vn";
                for (int k = 0; k < 3; ++k) append(obj_, n[k]);
                obj_ += '\n';
            }
            const uint32_t material =
                part.interior ? interior_ : (part.material == no_material ? exterior_ : part.material);
            used_.insert(material);
            obj_ += "usemtl " + names_[material] + "\n";
            for (size_t k = 0; k < part.indices.size(); ++k) {
                const uint32_t corner = part.indices[k];
                obj_ += k % 3 == 0 ? "f " : " ";
                obj_ += std::to_string(first_vertex_ + part.vertices[corner]);
                obj_ += '/';
                if (has_uv) obj_ += std::to_string(first_uv_ + corner);
                obj_ += '/' + std::to_string(first_normal_ + corner);
                if (k % 3 == 2) obj_ += '\n';
            }
            if (has_uv) first_uv_ += part.vertices.size();
            first_normal_ += part.vertices.size();
        }
        first_vertex_ += positions.size();
    }

    void write_library() {
        std::string mtl = "# Brittle " BRITTLE_VERSION "\n";
        for (const uint32_t m : used_) {
            const Material material = m == interior_
                                          ? interior_material(job_.options)
                                          : (m == exterior_ ? exterior_material(job_.options) : source_->materials[m]);
            mtl += "newmtl " + names_[m] + "\nKd";
            for (int k = 0; k < 3; ++k) append(mtl, material.base_colour[k]);
            mtl += "\nKe";
            for (int k = 0; k < 3; ++k) append(mtl, material.emissive[k]);
            const double roughness = std::max(material.roughness, 1e-3); // see read_mtl.cpp
            mtl += "\nNs";
            append(mtl, std::min(2.0 / (roughness * roughness) - 2.0, 1000.0));
            mtl += "\nPr";
            append(mtl, material.roughness);
            mtl += "\nPm";
            append(mtl, material.metallic);
            mtl += "\nd";
            append(mtl, material.base_colour.w);
            mtl += '\n';
            if (m == interior_ && job_.options.interior_image)
                mtl += "map_Kd "
                       + file_of(*job_.options.interior_image, "_interior" + image_ending(*job_.options.interior_image))
                       + "\n";
            write_map(mtl, "map_Kd", material.base_colour_texture);
            write_map(mtl, "map_Ke", material.emissive_texture);
            write_map(mtl, "norm", material.normal_texture);
        }
        files_.push_back({".mtl", bytes_of(mtl)});
    }

    void write_map(std::string& mtl, const char* keyword, const std::optional<TextureUse>& use) {
        if (!use || !source_ || use->texture >= source_->textures.size()) return;
        const auto image = source_->textures[use->texture].image;
        if (!image || source_->images[*image].mime_type.empty()) return;
        mtl += keyword;
        mtl += " " + file_of(source_->images[*image], image_suffix(*image, source_->images[*image])) + "\n";
    }

    // Returns the name of an image file beside the mesh, which is written once.
    std::string file_of(const Image& image, const std::string& suffix) {
        if (image_files_.insert(suffix).second) files_.push_back({suffix, image.bytes});
        return job_.stem + suffix;
    }

    const ExportJob& job_;
    const Model* source_;
    std::vector<OutputFile> files_;
    std::string obj_;
    std::vector<std::string> names_; // per material: those of the source, then the two defaults
    uint32_t exterior_ = 0, interior_ = 0;
    std::set<uint32_t> used_;
    std::set<std::string> image_files_;
    size_t first_vertex_ = 1, first_uv_ = 1, first_normal_ = 1; // counted from 1
};

} // namespace

Result<std::vector<OutputFile>> write_obj(const ExportJob& job) {
    return ObjWriter(job).write();
}

} // namespace brittle::fracture
