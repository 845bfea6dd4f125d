#include <charconv>
#include <cmath>
#include <limits>
#include <map>
#include <set>
#include <string>

#include <glm/geometric.hpp>

#include "fracture/io/colour.h"
#include "fracture/io/polygon.h"
#include "fracture/io/readers.h"
#include "fracture/io/text_cursor.h"

namespace brittle::fracture {
namespace {

class ObjReader {
  public:
    ObjReader(std::string_view text, Companions& companions) : cursor_(text), companions_(companions) {}

    Result<Model> read() {
        while (!cursor_.at_end()) {
            if (Result<void> done = read_line(cursor_.token()); !done) return done.error();
            cursor_.next_line();
        }
        if (highest_corner_ >= positions().size() && !faces_.empty()) {
            return malformed(highest_line_, "a face names vertex " + std::to_string(highest_corner_ + 1)
                                                + ", but the file has only " + std::to_string(positions().size())
                                                + " vertices; it is damaged or cut short");
        }
        if (Result<void> done = triangulate_faces(); !done) return done.error();
        complete_corners(model_);
        return std::move(model_);
    }

  private:
    struct Corner {
        uint32_t vertex, uv, normal; // no_index where the corner has none
    };
    struct Face {
        uint32_t corners;
        uint32_t material;
    };

    static Error malformed(size_t line, const std::string& what) {
        return {Status::malformed_file, "line " + std::to_string(line) + ": " + what};
    }

    std::vector<glm::dvec3>& positions() { return model_.mesh.positions; }

    Result<void> read_line(std::string_view keyword) {
        if (keyword == "v") return read_vertex();
        if (keyword == "f") return read_face();
        if (!companions_.wants_attributes()) return {};
        if (keyword == "vt") {
            const auto at = numbers<2>();
            uv_.emplace_back(at[0], 1.0f - at[1]); // v points up in OBJ
        } else if (keyword == "vn") {
            const auto n = numbers<3>();
            normals_.emplace_back(n[0], n[1], n[2]);
        } else if (keyword == "mtllib") {
            read_materials(cursor_.rest_of_line());
        } else if (keyword == "usemtl") {
            use_material(std::string(cursor_.rest_of_line()));
        }
        return {};
    }

    Result<void> read_vertex() {
        glm::dvec3 position{0.0};
        for (int k = 0; k < 3; ++k) {
            const std::string_view token = cursor_.token();
            const std::optional<double> value = parse_number(token);
            if (!value || !std::isfinite(*value)) {
                return malformed(cursor_.line(), "vertex " + std::to_string(positions().size() + 1)
                                                     + " needs three finite coordinates, but number "
                                                     + std::to_string(k + 1) + " of them is " + quoted(token));
            }
            position[k] = *value;
        }
        if (companions_.wants_attributes()) read_colour();
        positions().push_back(position);
        return {};
    }

    // Three more numbers are a colour; one more is a weight.
    void read_colour() {
        glm::dvec4 colour(1.0);
        for (int k = 0; k < 3; ++k) {
            const std::optional<double> value = parse_number(cursor_.token());
            if (!value || !(*value >= 0.0 && *value <= 1.0)) return;
            colour[k] = linear_of_srgb(*value);
        }
        colours_.resize(positions().size(), glm::vec4(1.0f));
        colours_.emplace_back(colour);
    }

    // The next numbers of the line, with zeros for missing and invalid ones.
    template<size_t count>
    std::array<float, count> numbers() {
        std::array<float, count> result{};
        for (float& value : result) {
            const auto number = static_cast<float>(parse_number(cursor_.token()).value_or(0.0));
            value = std::isfinite(number) ? number : 0.0f;
        }
        return result;
    }

    // Faces may refer to later vertices, so the upper limit is checked at the end.
    Result<void> read_face() {
        const size_t begin = corners_.size();
        for (std::string_view token = cursor_.token(); !token.empty(); token = cursor_.token()) {
            if (token.front() == '#') break;
            const char *at = token.data(), *const end = token.data() + token.size();
            const std::optional<uint32_t> vertex = index(at, end, positions().size());
            if (!vertex || (at != end && *at != '/')) {
                return malformed(cursor_.line(), "a face names vertex " + quoted(token) + "; "
                                                     + std::to_string(positions().size())
                                                     + " are known, counted from 1");
            }
            Corner corner{*vertex, no_index, no_index};
            if (at != end && companions_.wants_attributes()) {
                corner.uv = index(++at, end, uv_.size()).value_or(no_index);
                if (at != end && *at == '/') corner.normal = index(++at, end, normals_.size()).value_or(no_index);
            }
            if (corner.vertex >= highest_corner_) {
                highest_corner_ = corner.vertex;
                highest_line_ = cursor_.line();
            }
            corners_.push_back(corner);
        }
        const size_t size = corners_.size() - begin;
        if (size < 3 || size > max_polygon_corners) {
            return malformed(cursor_.line(), "a face has " + std::to_string(size) + " corners; between 3 and "
                                                 + std::to_string(max_polygon_corners) + " can be read");
        }
        faces_.push_back({static_cast<uint32_t>(size), material_});
        return {};
    }

    // An index counts from 1, or backwards from the last vertex so far. Moves `at` behind the index.
    static std::optional<uint32_t> index(const char*& at, const char* end, size_t known) {
        int64_t value = 0;
        const auto [stop, code] = std::from_chars(at, end, value);
        const auto count = static_cast<int64_t>(known);
        at = stop;
        if (code != std::errc{} || value == 0 || value < -count || value >= std::numeric_limits<uint32_t>::max())
            return std::nullopt;
        return static_cast<uint32_t>(value > 0 ? value - 1 : count + value);
    }

    void read_materials(std::string_view name) {
        const auto text = companions_.read(std::string(name));
        if (!text) return add_note(model_.notes, "materials: " + text.error().message);
        if (!libraries_.emplace(text->data()).second) return; // a library is read once, under any name
        read_mtl({reinterpret_cast<const char*>(text->data()), text->size()}, companions_, model_);
        for (uint32_t m = 0; m < model_.materials.size(); ++m) material_named_.emplace(model_.materials[m].name, m);
    }

    // A material without a library entry still differs from the others.
    void use_material(const std::string& name) {
        const auto known = material_named_.find(name);
        if (known != material_named_.end()) {
            material_ = known->second;
            return;
        }
        add_note(model_.notes,
                 "material " + quoted(std::string_view(name)) + " is in none of the libraries that the file names");
        material_ = static_cast<uint32_t>(model_.materials.size());
        material_named_.emplace(name, material_);
        model_.materials.push_back({.name = name});
    }

    Result<void> triangulate_faces() {
        PolygonSplitter splitter;
        std::vector<uint32_t> vertices;
        size_t begin = 0;
        for (const Face& face : faces_) {
            const std::span corners = std::span(corners_).subspan(begin, face.corners);
            vertices.clear();
            for (const Corner& corner : corners) vertices.push_back(corner.vertex);
            const auto triangles = splitter.split(positions(), vertices);
            if (!triangles) return Error{Status::malformed_file, PolygonSplitter::too_tangled};
            for (const Triangle& t : *triangles) {
                const Triangle of_mesh(vertices[t.x], vertices[t.y], vertices[t.z]);
                if (companions_.wants_attributes())
                    append_triangle(model_, of_mesh, face.material,
                                    std::array{attributes_of(corners[t.x]), attributes_of(corners[t.y]),
                                               attributes_of(corners[t.z])});
                else
                    model_.mesh.triangles.push_back(of_mesh);
            }
            begin += face.corners;
        }
        return {};
    }

    [[nodiscard]] CornerAttributes attributes_of(const Corner& corner) const {
        CornerAttributes result;
        if (corner.uv < uv_.size()) result.uv[0] = uv_[corner.uv];
        if (corner.normal < normals_.size()) {
            const float length = glm::length(normals_[corner.normal]);
            if (length > 0.0f) result.normal = normals_[corner.normal] / length;
        }
        if (corner.vertex < colours_.size()) result.colour = colours_[corner.vertex];
        return result;
    }

    TextCursor cursor_;
    Companions& companions_;
    Model model_;
    std::vector<Corner> corners_; // of all faces, one after the other
    std::vector<Face> faces_;
    std::vector<glm::vec2> uv_;
    std::vector<glm::vec3> normals_;
    std::vector<glm::vec4> colours_; // per vertex
    std::map<std::string, uint32_t> material_named_;
    std::set<const std::byte*> libraries_;
    uint32_t material_ = no_material;
    uint32_t highest_corner_ = 0;
    size_t highest_line_ = 0;
};

} // namespace

Result<Model> read_obj(std::string_view text, Companions& companions) {
    if (const size_t zero = text.find('\0'); zero != text.npos) {
        return Error{Status::malformed_file,
                     "byte " + std::to_string(zero) + " is 0: this is a binary file, not OBJ text"};
    }
    return ObjReader(text, companions).read();
}

} // namespace brittle::fracture
