#include <charconv>
#include <cmath>
#include <limits>
#include <string>

#include "fracture/io/polygon.h"
#include "fracture/io/readers.h"
#include "fracture/io/text_cursor.h"

namespace brittle::fracture {
namespace {

class ObjReader {
  public:
    explicit ObjReader(std::string_view text) : cursor_(text) {}

    Result<TriangleMesh> read() {
        while (!cursor_.at_end()) {
            const std::string_view keyword = cursor_.token();
            if (keyword == "v") {
                if (Result<void> done = read_vertex(); !done) return done.error();
            } else if (keyword == "f") {
                if (Result<void> done = read_face(); !done) return done.error();
            }
            cursor_.next_line();
        }
        if (highest_corner_ >= mesh_.positions.size() && !sizes_.empty()) {
            return malformed(highest_line_, "a face names vertex " + std::to_string(highest_corner_ + 1)
                                                + ", but the file has only "
                                                + std::to_string(mesh_.positions.size())
                                                + " vertices; it is damaged or cut short");
        }
        triangulate_faces();
        return std::move(mesh_);
    }

  private:
    static Error malformed(size_t line, const std::string& what) {
        return {Status::malformed_file, "line " + std::to_string(line) + ": " + what};
    }

    Result<void> read_vertex() {
        glm::dvec3 position{0.0};
        for (int k = 0; k < 3; ++k) {
            const std::string_view token = cursor_.token();
            const std::optional<double> value = parse_number(token);
            if (!value || !std::isfinite(*value)) {
                return malformed(cursor_.line(), "vertex " + std::to_string(mesh_.positions.size() + 1)
                                                     + " needs three finite coordinates, but number "
                                                     + std::to_string(k + 1) + " of them is "
                                                     + quoted(token));
            }
            position[k] = *value;
        }
        mesh_.positions.push_back(position);
        return {};
    }

    // Faces may name vertices that come later in the file, so the upper end is checked when all are known.
    Result<void> read_face() {
        const size_t begin = corners_.size();
        for (std::string_view token = cursor_.token(); !token.empty(); token = cursor_.token()) {
            if (token.front() == '#') break;
            int64_t index = 0;
            const char* const end = token.data() + token.size();
            const auto [stop, code] = std::from_chars(token.data(), end, index);
            const auto count = static_cast<int64_t>(mesh_.positions.size());
            if (code != std::errc{} || (stop != end && *stop != '/') || index == 0 || index < -count
                || index > std::numeric_limits<uint32_t>::max()) {
                return malformed(cursor_.line(), "a face names vertex " + quoted(token) + "; "
                                                     + std::to_string(count) + " are known, counted from 1");
            }
            const auto corner = static_cast<uint32_t>(index > 0 ? index - 1 : count + index);
            if (corner >= highest_corner_) {
                highest_corner_ = corner;
                highest_line_ = cursor_.line();
            }
            corners_.push_back(corner);
        }
        const size_t size = corners_.size() - begin;
        if (size < 3 || size > most_polygon_corners) {
            return malformed(cursor_.line(), "a face has " + std::to_string(size) + " corners; between 3 and "
                                                 + std::to_string(most_polygon_corners) + " can be read");
        }
        sizes_.push_back(static_cast<uint32_t>(size));
        return {};
    }

    void triangulate_faces() {
        mesh_.triangles.reserve(corners_.size() - 2 * sizes_.size());
        size_t begin = 0;
        for (const uint32_t size : sizes_) {
            append_polygon(mesh_, std::span(corners_).subspan(begin, size));
            begin += size;
        }
    }

    TextCursor cursor_;
    TriangleMesh mesh_;
    std::vector<uint32_t> corners_; // of all faces, one after the other
    std::vector<uint32_t> sizes_;   // corners of each face
    uint32_t highest_corner_ = 0;
    size_t highest_line_ = 0;
};

} // namespace

Result<TriangleMesh> read_obj(std::string_view text) {
    if (const size_t zero = text.find('\0'); zero != text.npos) {
        return Error{Status::malformed_file,
                     "byte " + std::to_string(zero) + " is 0: this is a binary file, not OBJ text"};
    }
    return ObjReader(text).read();
}

} // namespace brittle::fracture
