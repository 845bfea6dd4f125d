#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <functional>
#include <map>
#include <string>
#include <vector>

#include <glm/geometric.hpp>

#include "fracture/io/bytes.h"
#include "fracture/io/colour.h"
#include "fracture/io/polygon.h"
#include "fracture/io/readers.h"
#include "fracture/io/text_cursor.h"

namespace brittle::fracture {
namespace {

enum class Type { int8, uint8, int16, uint16, int32, uint32, float32, float64 };
enum class Encoding { text, little_endian, big_endian };

constexpr size_t size_of(Type type) {
    constexpr std::array<size_t, 8> sizes = {1, 1, 2, 2, 4, 4, 4, 8};
    return sizes[static_cast<size_t>(type)];
}

std::optional<Type> type_named(std::string_view name) {
    constexpr std::array<std::array<std::string_view, 2>, 8> names = {{{"char", "int8"},
                                                                       {"uchar", "uint8"},
                                                                       {"short", "int16"},
                                                                       {"ushort", "uint16"},
                                                                       {"int", "int32"},
                                                                       {"uint", "uint32"},
                                                                       {"float", "float32"},
                                                                       {"double", "float64"}}};
    for (size_t k = 0; k < names.size(); ++k)
        if (name == names[k][0] || name == names[k][1]) return static_cast<Type>(k);
    return std::nullopt;
}

constexpr size_t max_textures = 1000;

struct Property {
    std::string name;
    Type type = Type::float32;
    std::optional<Type> count; // type of the count of a list; none for a scalar
};

struct Element {
    std::string name;
    uint64_t count = 0;
    std::vector<Property> properties;
};

// Reads a sequence of numbers in any of the three encodings. After the end every number is 0 and `ended` is set.
class Numbers {
  public:
    Numbers(std::span<const std::byte> bytes, Encoding encoding, size_t first_line)
        : bytes_(bytes), encoding_(encoding), cursor_({reinterpret_cast<const char*>(bytes.data()), bytes.size()}),
          first_line_(first_line) {}

    double next(Type type) {
        if (encoding_ == Encoding::text) {
            const std::string_view token = cursor_.token_of_any_line();
            ended = ended || token.empty();
            const std::optional<double> number = parse_number(token);
            if (!number && bad.empty() && !token.empty()) bad = std::string(token);
            return number.value_or(0.0);
        }
        const size_t size = size_of(type);
        if (size > bytes_.size() - at_) {
            ended = true;
            return 0.0;
        }
        std::array<std::byte, 8> raw{};
        std::copy_n(bytes_.begin() + static_cast<std::ptrdiff_t>(at_), size, raw.begin());
        if (encoding_ == Encoding::big_endian)
            std::reverse(raw.begin(), raw.begin() + static_cast<std::ptrdiff_t>(size));
        at_ += size;
        return value(raw, type);
    }

    // The current place, for messages.
    [[nodiscard]] std::string place(size_t header_size) const {
        return encoding_ == Encoding::text ? "line " + std::to_string(first_line_ + cursor_.line() - 1)
                                           : "byte " + std::to_string(header_size + at_);
    }

    bool ended = false;
    std::string bad; // the first token that is not a number

  private:
    static double value(const std::array<std::byte, 8>& raw, Type type) {
        switch (type) {
        case Type::int8:
            return load<int8_t>(raw, 0);
        case Type::uint8:
            return load<uint8_t>(raw, 0);
        case Type::int16:
            return load<int16_t>(raw, 0);
        case Type::uint16:
            return load<uint16_t>(raw, 0);
        case Type::int32:
            return load<int32_t>(raw, 0);
        case Type::uint32:
            return load<uint32_t>(raw, 0);
        case Type::float32:
            return load<float>(raw, 0);
        case Type::float64:
            return load<double>(raw, 0);
        }
        return 0.0;
    }

    std::span<const std::byte> bytes_;
    Encoding encoding_;
    size_t at_ = 0;
    TextCursor cursor_;
    size_t first_line_;
};

// Reads the properties of a vertex besides its position.
class VertexAttributes {
  public:
    void set(const Property& property, double value) {
        constexpr std::array<std::string_view, 13> names = {"nx", "ny", "nz", "red", "green",     "blue",     "alpha",
                                                            "s",  "t",  "u",  "v",   "texture_u", "texture_v"};
        const auto at = static_cast<size_t>(std::find(names.begin(), names.end(), property.name) - names.begin());
        if (at == names.size() || !std::isfinite(value)) return;
        if (at < 3) {
            normal_[static_cast<int>(at)] = value;
            has_normal_ = true;
        } else if (at < 7) {
            const bool is_share = property.type == Type::float32 || property.type == Type::float64;
            const double share =
                std::clamp(is_share ? value : value / (size_of(property.type) == 2 ? 65535.0 : 255.0), 0.0, 1.0);
            colour_[static_cast<int>(at) - 3] = at == 6 ? share : linear_of_srgb(share);
            has_colour_ = true;
        } else {
            uv_[at % 2 == 0 ? 1 : 0] = value;
            has_uv_ = true;
        }
    }

    [[nodiscard]] CornerAttributes finish() const {
        CornerAttributes attributes;
        const double length = glm::length(normal_);
        if (has_normal_ && length > 0.0) attributes.normal = glm::vec3(normal_ / length);
        if (has_colour_) attributes.colour = glm::vec4(colour_);
        if (has_uv_) attributes.uv[0] = glm::vec2(uv_[0], 1.0 - uv_[1]); // v points up in PLY
        return attributes;
    }

  private:
    glm::dvec3 normal_{0.0};
    glm::dvec4 colour_{1.0};
    glm::dvec2 uv_{0.0};
    bool has_normal_ = false, has_colour_ = false, has_uv_ = false;
};

class PlyReader {
  public:
    PlyReader(std::span<const std::byte> bytes, Companions& companions) : bytes_(bytes), companions_(companions) {}

    Result<Model> read() {
        if (Result<void> done = read_header(); !done) return done.error();
        Numbers numbers(bytes_.subspan(header_size_), encoding_, header_lines_ + 1);
        for (const Element& element : elements_) {
            if (Result<void> done = read_element(element, numbers); !done) return done.error();
        }
        complete_corners(model_);
        if (model_.points.size() != model_.mesh.positions.size()) model_.points.clear();
        return std::move(model_);
    }

  private:
    static Error malformed(const std::string& where, const std::string& what) {
        return {Status::malformed_file, where + ": " + what};
    }

    // Returns one line of the header, without its end; nothing at the end of the file.
    std::optional<std::string_view> header_line() {
        const std::string_view text(reinterpret_cast<const char*>(bytes_.data()), bytes_.size());
        const size_t end = text.find('\n', header_size_);
        if (end == text.npos) return std::nullopt;
        std::string_view line = text.substr(header_size_, end - header_size_);
        header_size_ = end + 1;
        ++header_lines_;
        if (!line.empty() && line.back() == '\r') line.remove_suffix(1);
        return line;
    }

    Result<void> read_header() {
        const auto first = header_line();
        if (!first || *first != "ply") return malformed("line 1", "a PLY file begins with a line 'ply'");
        bool has_format = false;
        for (;;) {
            const auto line = header_line();
            if (!line) return malformed("line " + std::to_string(header_lines_ + 1), "the header has no 'end_header'");
            const auto wrong = [&](const std::string& what) {
                return malformed("line " + std::to_string(header_lines_), what + " in " + quoted(*line));
            };
            TextCursor cursor(*line);
            const std::string_view word = cursor.token();
            if (word == "end_header") break;
            if (word == "format") {
                const std::string_view name = cursor.token();
                if (name == "ascii")
                    encoding_ = Encoding::text;
                else if (name == "binary_little_endian")
                    encoding_ = Encoding::little_endian;
                else if (name == "binary_big_endian")
                    encoding_ = Encoding::big_endian;
                else
                    return wrong("an unknown format");
                has_format = true;
            } else if (word == "comment") {
                if (cursor.token() == "TextureFile") texture_files_.emplace_back(cursor.rest_of_line());
            } else if (word == "element") {
                Element element{std::string(cursor.token()), 0, {}};
                const std::optional<double> count = parse_number(cursor.token());
                if (!count || !(*count >= 0.0) || *count > 4e9) return wrong("an invalid count of elements");
                element.count = static_cast<uint64_t>(*count);
                elements_.push_back(std::move(element));
            } else if (word == "property") {
                if (elements_.empty()) return wrong("a property before any element");
                std::optional<Property> property = read_property(cursor);
                if (!property) return wrong("an unknown type");
                elements_.back().properties.push_back(std::move(*property));
            }
        }
        if (!has_format) return malformed("line " + std::to_string(header_lines_), "the header has no format");
        return {};
    }

    static std::optional<Property> read_property(TextCursor& cursor) {
        Property property;
        std::string_view type = cursor.token();
        if (type == "list") {
            property.count = type_named(cursor.token());
            if (!property.count) return std::nullopt;
            type = cursor.token();
        }
        const auto known = type_named(type);
        if (!known) return std::nullopt;
        property.type = *known;
        property.name = std::string(cursor.token());
        return property;
    }

    Result<void> read_element(const Element& element, Numbers& numbers) {
        const auto place_of = [&](uint64_t k) {
            return numbers.place(header_size_) + ", " + printable(element.name) + " " + std::to_string(k);
        };
        if (element.properties.empty()) return {};
        if (element.name == "face" && companions_.wants_attributes()) read_textures();
        const bool is_vertex = element.name == "vertex";
        for (uint64_t k = 0; k < element.count; ++k) {
            glm::dvec3 position(0.0);
            VertexAttributes attributes;
            corners_.clear();
            uv_of_corners_.clear();
            texture_ = 0;
            for (const Property& property : element.properties) {
                if (!property.count) {
                    const double value = numbers.next(property.type);
                    if (property.name == "x") position.x = value;
                    if (property.name == "y") position.y = value;
                    if (property.name == "z") position.z = value;
                    if (is_vertex && property.name == "point" && property.type == Type::uint32)
                        model_.points.push_back(static_cast<uint32_t>(value));
                    if (is_vertex && companions_.wants_attributes()) attributes.set(property, value);
                    if (property.name == "texnumber") // -1: without texture
                        texture_ = value >= 0.0 && value < 1e6 ? static_cast<uint32_t>(value) : no_material;
                } else if (Result<void> done = read_list(element, property, numbers, [&] { return place_of(k); });
                           !done) {
                    return done;
                }
            }
            if (numbers.ended) return cut_short(place_of(k));
            if (!numbers.bad.empty())
                return malformed(place_of(k),
                                 "a number is expected, but found " + quoted(std::string_view(numbers.bad)));
            if (is_vertex) {
                model_.mesh.positions.push_back(position);
                if (companions_.wants_attributes()) attributes_.push_back(attributes.finish());
            }
            if (corners_.empty()) continue;
            if (!append_face()) return malformed(place_of(k), PolygonSplitter::too_tangled);
        }
        return {};
    }

    Result<void> read_list(const Element& element, const Property& property, Numbers& numbers,
                           const std::function<std::string()>& place) {
        const double count = numbers.next(*property.count);
        const bool is_face =
            element.name == "face" && (property.name == "vertex_indices" || property.name == "vertex_index");
        const bool is_uv = element.name == "face" && property.name == "texcoord" && companions_.wants_attributes();
        // A face may have several lists.
        const bool is_too_long = count + static_cast<double>(corners_.size()) > max_polygon_corners;
        if (!(count >= 0.0) || (is_face && (count < 3.0 || is_too_long)))
            return numbers.ended ? cut_short(place())
                                 : malformed(place(), "a list of " + written(count) + " numbers; a face has 3 to "
                                                          + std::to_string(max_polygon_corners));
        const auto known = static_cast<double>(model_.mesh.positions.size());
        for (double m = 0.0; m < count && !numbers.ended; m += 1.0) {
            const double value = numbers.next(property.type);
            if (is_uv && uv_of_corners_.size() < 2 * max_polygon_corners)
                uv_of_corners_.push_back(std::isfinite(value) ? static_cast<float>(value) : 0.0f);
            if (!is_face) continue;
            if (!(value >= 0.0) || value != std::floor(value) || value >= known) {
                if (numbers.ended) break;
                return malformed(place(), "it names vertex " + written(value) + "; there are "
                                              + std::to_string(model_.mesh.positions.size())
                                              + " before it, counted from 0");
            }
            corners_.push_back(static_cast<uint32_t>(value));
        }
        return {};
    }

    // Returns false where the polygons of the file cross themselves too often.
    bool append_face() {
        const auto triangles = splitter_.split(model_.mesh.positions, corners_);
        if (!triangles) return false;
        const bool has_uv = uv_of_corners_.size() == 2 * corners_.size();
        const auto attributes_of = [&](uint32_t k) {
            CornerAttributes result = corners_[k] < attributes_.size() ? attributes_[corners_[k]] : CornerAttributes{};
            if (has_uv) result.uv[0] = glm::vec2(uv_of_corners_[2 * k], 1.0f - uv_of_corners_[2 * k + 1]);
            return result;
        };
        const uint32_t material = texture_ < model_.materials.size() ? texture_ : no_material;
        for (const Triangle& t : *triangles) {
            const Triangle of_mesh(corners_[t.x], corners_[t.y], corners_[t.z]);
            if (companions_.wants_attributes())
                append_triangle(model_, of_mesh, material,
                                std::array{attributes_of(t.x), attributes_of(t.y), attributes_of(t.z)});
            else
                model_.mesh.triangles.push_back(of_mesh);
        }
        return true;
    }

    // Adds one material for each texture in a comment, the convention of MeshLab.
    void read_textures() {
        if (texture_files_.size() > max_textures) texture_files_.resize(max_textures);
        std::map<const std::byte*, uint32_t> image_at; // by content: a file may occur again
        for (const std::string& name : texture_files_) {
            Material material{.name = name};
            const auto bytes = companions_.read(name);
            const std::string type = bytes ? image_type(*bytes) : std::string();
            if (type.empty()) {
                add_note(model_.notes,
                         "texture: "
                             + (bytes ? quoted(std::string_view(name)) + " is not an image that can be kept"
                                      : bytes.error().message));
            } else {
                material.base_colour_texture = TextureUse{.texture = static_cast<uint32_t>(model_.textures.size())};
                const auto next = static_cast<uint32_t>(model_.images.size());
                const auto [image, is_new_image] = image_at.emplace(bytes->data(), next);
                model_.textures.push_back({.image = image->second});
                if (is_new_image) model_.images.push_back({name, type, {bytes->begin(), bytes->end()}});
            }
            model_.materials.push_back(std::move(material));
        }
        texture_files_.clear();
    }

    static Error cut_short(const std::string& where) {
        return malformed(where, "the file ends before the content that its header promises; it was cut short");
    }

    std::span<const std::byte> bytes_;
    size_t header_size_ = 0, header_lines_ = 0;
    Encoding encoding_ = Encoding::text;
    std::vector<Element> elements_;
    Companions& companions_;
    Model model_;
    std::vector<CornerAttributes> attributes_; // per vertex
    std::vector<std::string> texture_files_;
    PolygonSplitter splitter_;
    // Of the current face.
    std::vector<uint32_t> corners_;
    std::vector<float> uv_of_corners_;
    uint32_t texture_ = 0;
};

} // namespace

Result<Model> read_ply(std::span<const std::byte> bytes, Companions& companions) {
    return PlyReader(bytes, companions).read();
}

} // namespace brittle::fracture
