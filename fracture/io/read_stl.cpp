#include <cctype>
#include <cmath>
#include <string>

#include "fracture/io/bytes.h"
#include "fracture/io/readers.h"
#include "fracture/io/stl_attribute.h"
#include "fracture/io/text_cursor.h"

namespace brittle::fracture {
namespace {

constexpr size_t header_size = 84; // 80 arbitrary bytes and the number of triangles
constexpr size_t record_size = 50; // normal, three corners, two bytes of attributes

std::string_view text_of(std::span<const std::byte> bytes) {
    return {reinterpret_cast<const char*>(bytes.data()), bytes.size()};
}

bool equals(std::string_view token, std::string_view lower_case) {
    if (token.size() != lower_case.size()) return false;
    for (size_t k = 0; k < token.size(); ++k) {
        if (std::tolower(static_cast<unsigned char>(token[k])) != lower_case[k]) return false;
    }
    return true;
}

class TextStlReader {
  public:
    explicit TextStlReader(std::string_view text) : cursor_(text) {}

    Result<TriangleMesh> read() {
        if (Result<void> done = expect("solid"); !done) return done.error();
        cursor_.next_line(); // skips the name of the solid
        while (true) {
            const std::string_view token = cursor_.token_of_any_line();
            if (equals(token, "facet")) {
                if (Result<void> done = read_facet(); !done) return done.error();
            } else if (equals(token, "endsolid")) {
                cursor_.next_line();
                const std::string_view next = cursor_.token_of_any_line();
                if (next.empty()) return std::move(mesh_);
                if (!equals(next, "solid")) return unexpected("'solid' or the end of the file", next);
                cursor_.next_line();
            } else {
                return unexpected("'facet' or 'endsolid'", token);
            }
        }
    }

  private:
    Error unexpected(const std::string& wanted, std::string_view found) const {
        return {Status::malformed_file,
                "line " + std::to_string(cursor_.line()) + ": " + wanted + " expected, but "
                    + (found.empty() ? "the file ends; it was cut short" : "found " + quoted(found))};
    }

    Result<void> expect(std::string_view word) {
        const std::string_view token = cursor_.token_of_any_line();
        if (!equals(token, word)) return unexpected(quoted(word), token);
        return {};
    }

    Result<void> read_facet() {
        if (Result<void> done = expect("normal"); !done) return done;
        // The corners give the normal; the stored one is often zero or nan.
        for (int k = 0; k < 3; ++k) cursor_.token_of_any_line();
        if (Result<void> done = expect("outer"); !done) return done;
        if (Result<void> done = expect("loop"); !done) return done;
        for (int corner = 0; corner < 3; ++corner) {
            if (Result<void> done = read_corner(); !done) return done;
        }
        if (Result<void> done = expect("endloop"); !done) return done;
        if (Result<void> done = expect("endfacet"); !done) return done;
        const auto end = static_cast<uint32_t>(mesh_.positions.size());
        mesh_.triangles.emplace_back(end - 3, end - 2, end - 1);
        return {};
    }

    Result<void> read_corner() {
        if (Result<void> done = expect("vertex"); !done) return done;
        glm::dvec3 position{0.0};
        for (int k = 0; k < 3; ++k) {
            const std::string_view token = cursor_.token_of_any_line();
            const std::optional<double> value = parse_number(token);
            if (!value || !std::isfinite(*value)) {
                return unexpected("a finite coordinate of triangle " + std::to_string(mesh_.triangles.size()), token);
            }
            position[k] = *value;
        }
        mesh_.positions.push_back(position);
        return {};
    }

    TextCursor cursor_;
    TriangleMesh mesh_;
};

Model read_binary(std::span<const std::byte> bytes, uint32_t count) {
    // Only a file of Brittle's has attributes of the meaning that stl_attribute.h describes.
    const bool has_points = text_of(bytes).starts_with(stl_head);
    Model model;
    TriangleMesh& mesh = model.mesh;
    mesh.positions.reserve(size_t{count} * 3);
    mesh.triangles.reserve(count);
    for (uint32_t t = 0; t < count; ++t) {
        for (uint32_t corner = 0; corner < 3; ++corner) {
            const size_t at = header_size + t * record_size + 12 * (corner + 1);
            const glm::dvec3 p{load<float>(bytes, at), load<float>(bytes, at + 4), load<float>(bytes, at + 8)};
            mesh.positions.push_back(p);
        }
        mesh.triangles.emplace_back(3 * t, 3 * t + 1, 3 * t + 2);
        if (!has_points) continue;
        const auto attribute = load<uint16_t>(bytes, header_size + t * record_size + 48);
        for (uint32_t corner = 0; corner < 3; ++corner) model.points.push_back(stl_rank(attribute, corner));
    }
    return model;
}

} // namespace

Result<Model> read_stl(std::span<const std::byte> bytes) {
    const std::string_view text = text_of(bytes);
    const uint32_t count = bytes.size() >= header_size ? load<uint32_t>(bytes, 80) : 0;
    const uint64_t promised = header_size + uint64_t{count} * record_size;
    if (bytes.size() >= header_size && bytes.size() == promised) return read_binary(bytes, count);

    const bool is_text = equals(TextCursor(text).token_of_any_line(), "solid") && text.find('\0') == text.npos;
    if (is_text) {
        Result<TriangleMesh> mesh = TextStlReader(text).read();
        if (!mesh) return mesh.error();
        Model model;
        model.mesh = *std::move(mesh);
        return model;
    }
    if (bytes.size() < header_size) {
        return Error{Status::malformed_file,
                     "neither text that starts with 'solid' nor a binary STL file, whose header "
                     "alone takes 84 bytes; this file has "
                         + std::to_string(bytes.size())};
    }
    return Error{Status::malformed_file, "as a binary STL file it promises " + std::to_string(count)
                                             + " triangles, which take " + std::to_string(promised)
                                             + " bytes, but it has " + std::to_string(bytes.size())
                                             + "; it was cut short or is damaged: copy or export it again"};
}

} // namespace brittle::fracture
