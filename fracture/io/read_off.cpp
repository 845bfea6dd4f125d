#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

#include <glm/geometric.hpp>

#include "fracture/io/colour.h"
#include "fracture/io/polygon.h"
#include "fracture/io/readers.h"
#include "fracture/io/text_cursor.h"

namespace brittle::fracture {
namespace {

// Blanks and line ends separate numbers; `#` starts a comment.
class OffReader {
  public:
    explicit OffReader(std::string_view text) : cursor_(text), size_(text.size()) {}

    Result<Model> read() {
        const std::string_view keyword = next();
        if (keyword != "OFF" && keyword != "COFF" && keyword != "NOFF" && keyword != "CNOFF")
            return malformed("the file begins with " + quoted(keyword) + "; OFF, COFF, NOFF or CNOFF can be read");
        has_colours_ = keyword.starts_with('C');
        has_normals_ = keyword.find('N') != keyword.npos;
        uint64_t vertices = 0, faces = 0, edges = 0;
        for (uint64_t* count : {&vertices, &faces, &edges}) {
            const auto number = whole(next());
            // A vertex or face takes at least two bytes of text.
            if (!number || *number > size_)
                return malformed("three counts are expected: vertices, faces and edges, none of more than the file has "
                                 "room for");
            *count = *number;
        }
        cursor_.next_line();
        for (uint64_t v = 0; v < vertices; ++v) {
            if (Result<void> done = read_vertex(v); !done) return done.error();
        }
        for (uint64_t f = 0; f < faces; ++f) {
            if (Result<void> done = read_face(f); !done) return done.error();
        }
        complete_corners(model_);
        return std::move(model_);
    }

  private:
    Error malformed(const std::string& what) const {
        return {Status::malformed_file, "line " + std::to_string(cursor_.line()) + ": " + what};
    }

    // Returns the next token outside comments, of this line or a later one.
    std::string_view next() {
        std::string_view token = cursor_.token_of_any_line();
        while (!token.empty() && token.front() == '#') {
            cursor_.next_line();
            token = cursor_.token_of_any_line();
        }
        return token;
    }

    static std::optional<uint64_t> whole(std::string_view token) {
        const std::optional<double> number = parse_number(token);
        if (!number || !(*number >= 0.0) || *number > 4e9 || *number != std::floor(*number)) return std::nullopt;
        return static_cast<uint64_t>(*number);
    }

    Result<void> read_vertex(uint64_t index) {
        glm::dvec3 position{0.0};
        for (int k = 0; k < 3; ++k) {
            const std::string_view token = next();
            const std::optional<double> value = parse_number(token);
            if (!value || !std::isfinite(*value))
                return malformed("vertex " + std::to_string(index) + " needs three finite coordinates, but number "
                                 + std::to_string(k + 1) + " of them is " + quoted(token));
            position[k] = *value;
        }
        model_.mesh.positions.push_back(position);
        attributes_.push_back(read_attributes());
        cursor_.next_line();
        return {};
    }

    // Reads normals and colours, as far as present.
    CornerAttributes read_attributes() {
        CornerAttributes attributes;
        if (has_normals_) {
            glm::dvec3 normal(0.0);
            for (int k = 0; k < 3; ++k) normal[k] = parse_number(cursor_.token()).value_or(0.0);
            const double length = glm::length(normal);
            if (length > 0.0 && std::isfinite(length)) attributes.normal = glm::vec3(normal / length);
        }
        if (!has_colours_) return attributes;
        glm::dvec4 colour(1.0);
        bool is_whole = true; // integers from 0 to 255, otherwise 0.0 to 1.0
        for (int k = 0; k < 4; ++k) {
            const std::string_view token = cursor_.token();
            const std::optional<double> value = parse_number(token);
            if (!value && k == 3) { // opacity is optional
                colour.w = is_whole ? 255.0 : 1.0;
                break;
            }
            if (!value || !(*value >= 0.0 && *value <= 255.0)) return attributes;
            is_whole = is_whole && token.find('.') == token.npos;
            colour[k] = *value;
        }
        if (is_whole) colour /= 255.0;
        for (int k = 0; k < 3; ++k) colour[k] = linear_of_srgb(std::min(colour[k], 1.0));
        attributes.colour = glm::vec4(colour);
        return attributes;
    }

    Result<void> read_face(uint64_t index) {
        const auto count = whole(next());
        if (!count || *count < 3 || *count > max_polygon_corners)
            return malformed("face " + std::to_string(index) + " must begin with its number of corners, 3 to "
                             + std::to_string(max_polygon_corners));
        corners_.clear();
        for (uint64_t k = 0; k < *count; ++k) {
            const std::string_view token = next();
            const auto corner = whole(token);
            if (!corner || *corner >= model_.mesh.positions.size())
                return malformed("face " + std::to_string(index) + " names vertex " + quoted(token) + "; there are "
                                 + std::to_string(model_.mesh.positions.size()) + ", counted from 0");
            corners_.push_back(static_cast<uint32_t>(*corner));
        }
        const auto triangles = splitter_.split(model_.mesh.positions, corners_);
        if (!triangles) return malformed(PolygonSplitter::too_tangled);
        for (const Triangle& t : *triangles)
            append_triangle(
                model_, {corners_[t.x], corners_[t.y], corners_[t.z]}, no_material,
                std::array{attributes_[corners_[t.x]], attributes_[corners_[t.y]], attributes_[corners_[t.z]]});
        cursor_.next_line(); // colours
        return {};
    }

    TextCursor cursor_;
    size_t size_;
    bool has_colours_ = false, has_normals_ = false;
    Model model_;
    std::vector<CornerAttributes> attributes_; // per vertex
    PolygonSplitter splitter_;
    std::vector<uint32_t> corners_;
};

} // namespace

Result<Model> read_off(std::string_view text) {
    if (const size_t zero = text.find('\0'); zero != text.npos)
        return Error{Status::malformed_file,
                     "byte " + std::to_string(zero) + " is 0: binary OFF is not read; export the mesh as text"};
    return OffReader(text).read();
}

} // namespace brittle::fracture
