#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <string>

#include <glm/gtc/quaternion.hpp>
#include <glm/mat4x4.hpp>
#include <nlohmann/json.hpp>

#include "fracture/io/bytes.h"
#include "fracture/io/read_file.h"
#include "fracture/io/readers.h"

// The container and the JSON schema are those of the Khronos glTF 2.0 specification; section numbers are of
// it.

namespace brittle::fracture {
namespace {

using Json = nlohmann::json;
using Bytes = std::span<const std::byte>;

// Nodes may show one mesh many times, so a small file can unfold into any number of triangles.
constexpr size_t most_elements = 100'000'000; // vertices, and triangles
constexpr int deepest_json = 64;              // brackets; libraries recurse over them

Error malformed(const std::string& what) {
    return {Status::malformed_file, what};
}

std::string name_of(const char* list, uint64_t index) {
    return std::string(list) + "[" + std::to_string(index) + "]";
}

// The member of that name; null where there is none or the value is no object.
const Json* member(const Json& object, const char* key) {
    if (!object.is_object()) return nullptr;
    const auto found = object.find(key);
    return found == object.end() ? nullptr : &*found;
}

// A non-negative integer; fallback where the member is missing, nothing where it is something else.
std::optional<uint64_t> unsigned_member(const Json& object, const char* key,
                                        std::optional<uint64_t> fallback) {
    const Json* value = member(object, key);
    if (value == nullptr) return fallback;
    if (!value->is_number_unsigned()) return std::nullopt;
    return value->get<uint64_t>();
}

// Exactly count numbers; the fallback where the member is missing, nothing where it is something else.
template<size_t count>
std::optional<std::array<double, count>> numbers(const Json& object, const char* key,
                                                 std::array<double, count> fallback) {
    const Json* value = member(object, key);
    if (value == nullptr) return fallback;
    if (!value->is_array() || value->size() != count) return std::nullopt;
    for (size_t k = 0; k < count; ++k) {
        if (!(*value)[k].is_number()) return std::nullopt;
        fallback[k] = (*value)[k].template get<double>();
    }
    return fallback;
}

Result<std::vector<std::byte>> decode_base64(std::string_view text) {
    std::vector<std::byte> bytes;
    bytes.reserve(text.size() / 4 * 3);
    uint32_t window = 0;
    int bits = 0;
    for (const char c : text) {
        int digit = 0;
        if (c >= 'A' && c <= 'Z')
            digit = c - 'A';
        else if (c >= 'a' && c <= 'z')
            digit = c - 'a' + 26;
        else if (c >= '0' && c <= '9')
            digit = c - '0' + 52;
        else if (c == '+' || c == '-')
            digit = 62;
        else if (c == '/' || c == '_')
            digit = 63;
        else if (c == '=')
            break;
        else
            return malformed("a data: URI holds a character that is not base64");
        window = (window << 6 | static_cast<uint32_t>(digit)) & 0xffffff;
        bits += 6;
        if (bits < 8) continue;
        bits -= 8;
        bytes.push_back(static_cast<std::byte>(window >> bits & 0xff));
    }
    return bytes;
}

std::string percent_decoded(const std::string& text) {
    std::string result;
    for (size_t k = 0; k < text.size(); ++k) {
        const bool escape = text[k] == '%' && k + 2 < text.size()
                            && std::isxdigit(static_cast<unsigned char>(text[k + 1]))
                            && std::isxdigit(static_cast<unsigned char>(text[k + 2]));
        if (escape) {
            result += static_cast<char>(std::stoi(text.substr(k + 1, 2), nullptr, 16));
            k += 2;
        } else {
            result += text[k];
        }
    }
    return result;
}

// Section 3.6.2: a typed view of a buffer.
struct Accessor {
    uint64_t count = 0;
    uint32_t component_type = 0;
    bool normalized = false;
    uint64_t stride = 0;
    Bytes data; // empty: all zeros

    [[nodiscard]] double component(uint64_t element, uint64_t k) const {
        if (data.empty()) return 0.0;
        const size_t at = element * stride + k * size_of(component_type);
        switch (component_type) {
        case 5120:
            return scaled(load<int8_t>(data, at));
        case 5121:
            return scaled(load<uint8_t>(data, at));
        case 5122:
            return scaled(load<int16_t>(data, at));
        case 5123:
            return scaled(load<uint16_t>(data, at));
        case 5125:
            return load<uint32_t>(data, at);
        default:
            return load<float>(data, at);
        }
    }

    // Bytes of a component; 0 for an unknown type.
    static uint64_t size_of(uint64_t component_type) {
        switch (component_type) {
        case 5120:
        case 5121:
            return 1;
        case 5122:
        case 5123:
            return 2;
        case 5125:
        case 5126:
            return 4;
        default:
            return 0;
        }
    }

  private:
    // KHR_mesh_quantization: fixed point, with both -max - 1 and -max standing for -1.
    template<class T>
    [[nodiscard]] double scaled(T value) const {
        if (!normalized) return value;
        return std::max(static_cast<double>(value) / std::numeric_limits<T>::max(), -1.0);
    }
};

class GltfReader {
  public:
    GltfReader(Json document, Bytes binary_chunk, std::filesystem::path folder)
        : document_(std::move(document)), binary_chunk_(binary_chunk), folder_(std::move(folder)) {}

    Result<TriangleMesh> read() {
        if (Result<void> done = check_extensions(); !done) return done.error();
        Result<std::vector<uint64_t>> roots = root_nodes();
        if (!roots) return roots.error();
        if (Result<void> done = read_nodes(*roots); !done) return done.error();
        return std::move(mesh_);
    }

  private:
    // The element of a top-level list.
    Result<const Json*> element(const char* list, std::optional<uint64_t> index) const {
        const Json* values = member(document_, list);
        if (!index || values == nullptr || !values->is_array() || *index >= values->size()
            || !(*values)[*index].is_object()) {
            return malformed((index ? name_of(list, *index) : "an index into " + std::string(list))
                             + " is missing or of the wrong type");
        }
        return &(*values)[*index];
    }

    // A required extension may change what geometry means; only those that cannot are let through.
    Result<void> check_extensions() const {
        const Json* required = member(document_, "extensionsRequired");
        if (required == nullptr) return {};
        for (const Json& entry : *required) {
            const std::string name = entry.is_string() ? entry.get<std::string>() : entry.dump();
            const bool harmless = name == "KHR_mesh_quantization" || name.starts_with("KHR_materials_")
                                  || name.starts_with("KHR_texture_") || name.starts_with("EXT_texture_")
                                  || name.starts_with("KHR_lights_");
            if (harmless) continue;
            return malformed("needs the glTF extension " + name
                             + ", which is not read; export without compression and extensions");
        }
        return {};
    }

    Result<std::vector<uint64_t>> root_nodes() const {
        const Json* nodes = member(document_, "nodes");
        const size_t count = nodes != nullptr && nodes->is_array() ? nodes->size() : 0;
        if (member(document_, "scenes") != nullptr) {
            const Result<const Json*> scene = element("scenes", unsigned_member(document_, "scene", 0));
            if (!scene) return scene.error();
            return indices_of(**scene, "nodes");
        }
        // Without a scene: all nodes that are no one's child.
        std::vector<bool> is_child(count, false);
        for (size_t n = 0; n < count; ++n) {
            const Result<std::vector<uint64_t>> children = indices_of((*nodes)[n], "children");
            if (!children) return children.error();
            for (const uint64_t child : *children) {
                if (child < count) is_child[child] = true;
            }
        }
        std::vector<uint64_t> roots;
        for (size_t n = 0; n < count; ++n) {
            if (!is_child[n]) roots.push_back(n);
        }
        return roots;
    }

    static Result<std::vector<uint64_t>> indices_of(const Json& object, const char* key) {
        std::vector<uint64_t> result;
        const Json* values = member(object, key);
        if (values == nullptr) return result;
        for (const Json& value : *values) {
            if (!value.is_number_unsigned())
                return malformed(std::string(key) + " holds something else than indices");
            result.push_back(value.get<uint64_t>());
        }
        return result;
    }

    // Depth first, in the order of the file, without recursion: chains of nodes can be as long as the file.
    Result<void> read_nodes(const std::vector<uint64_t>& roots) {
        struct Visit {
            uint64_t node;
            glm::dmat4 parent;
        };
        std::vector<Visit> stack;
        for (auto root = roots.rbegin(); root != roots.rend(); ++root)
            stack.push_back({*root, glm::dmat4(1.0)});
        std::vector<bool> seen(member(document_, "nodes") != nullptr ? document_["nodes"].size() : 0, false);
        while (!stack.empty()) {
            const Visit visit = stack.back();
            stack.pop_back();
            const Result<const Json*> node = element("nodes", visit.node);
            if (!node) return node.error();
            if (seen[visit.node]) {
                return malformed(name_of("nodes", visit.node) + " is reached twice; nodes must form trees");
            }
            seen[visit.node] = true;

            const Result<glm::dmat4> local = transform_of(**node, visit.node);
            if (!local) return local.error();
            const glm::dmat4 world = visit.parent * *local;
            if (member(**node, "mesh") != nullptr) {
                const std::optional<uint64_t> mesh = unsigned_member(**node, "mesh", std::nullopt);
                if (Result<void> done = read_mesh(mesh, world); !done) return done;
            }
            const Result<std::vector<uint64_t>> children = indices_of(**node, "children");
            if (!children) return children.error();
            for (auto child = children->rbegin(); child != children->rend(); ++child)
                stack.push_back({*child, world});
        }
        return {};
    }

    static Result<glm::dmat4> transform_of(const Json& node, uint64_t index) {
        const auto matrix = numbers<16>(node, "matrix", {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1});
        const auto t = numbers<3>(node, "translation", {0, 0, 0});
        const auto r = numbers<4>(node, "rotation", {0, 0, 0, 1});
        const auto s = numbers<3>(node, "scale", {1, 1, 1});
        if (!matrix || !t || !r || !s) return malformed(name_of("nodes", index) + " has a damaged transform");
        if (member(node, "matrix") != nullptr) {
            glm::dmat4 result;
            for (int k = 0; k < 16; ++k) result[k / 4][k % 4] = (*matrix)[static_cast<size_t>(k)];
            return result;
        }
        const glm::dquat rotation((*r)[3], (*r)[0], (*r)[1], (*r)[2]);
        glm::dmat4 result(glm::mat3_cast(rotation) * glm::dmat3((*s)[0], 0, 0, 0, (*s)[1], 0, 0, 0, (*s)[2]));
        result[3] = glm::dvec4((*t)[0], (*t)[1], (*t)[2], 1.0);
        return result;
    }

    Result<void> read_mesh(std::optional<uint64_t> index, const glm::dmat4& world) {
        const Result<const Json*> mesh = element("meshes", index);
        if (!mesh) return mesh.error();
        const Json* primitives = member(**mesh, "primitives");
        if (primitives == nullptr) return {};
        uint64_t number = 0;
        for (const Json& primitive : *primitives) {
            const Result<void> done = read_primitive(primitive, world);
            if (!done) {
                return malformed(name_of("meshes", *index) + "." + name_of("primitives", number) + ": "
                                 + done.error().message);
            }
            ++number;
        }
        return {};
    }

    Result<void> read_primitive(const Json& primitive, const glm::dmat4& world) {
        const std::optional<uint64_t> mode = unsigned_member(primitive, "mode", 4);
        if (!mode || *mode > 6) return malformed("its mode is none of 0 to 6");
        const Json* attributes = member(primitive, "attributes");
        if (*mode < 4 || attributes == nullptr || member(*attributes, "POSITION") == nullptr) return {};

        const Result<Accessor> positions =
            accessor(unsigned_member(*attributes, "POSITION", std::nullopt), "VEC3");
        if (!positions) return positions.error();
        std::vector<uint32_t> corners;
        if (member(primitive, "indices") != nullptr) {
            const Result<Accessor> indices =
                accessor(unsigned_member(primitive, "indices", std::nullopt), "SCALAR");
            if (!indices) return indices.error();
            for (uint64_t k = 0; k < indices->count; ++k) {
                const double corner = indices->component(k, 0);
                if (!(corner >= 0.0 && corner < static_cast<double>(positions->count))) {
                    return malformed("index " + std::to_string(k) + " names vertex "
                                     + std::to_string(static_cast<int64_t>(corner)) + " of "
                                     + std::to_string(positions->count));
                }
                corners.push_back(static_cast<uint32_t>(corner));
            }
        } else {
            corners.resize(positions->count);
            for (uint32_t k = 0; k < corners.size(); ++k) corners[k] = k;
        }
        if (mesh_.positions.size() + positions->count > most_elements
            || mesh_.triangles.size() + corners.size() > most_elements) {
            return malformed(
                "with it the file holds over 100 million vertices or triangles; simplify the mesh");
        }
        return append(*positions, corners, *mode, world);
    }

    Result<void> append(const Accessor& positions, const std::vector<uint32_t>& corners, uint64_t mode,
                        const glm::dmat4& world) {
        const auto base = static_cast<uint32_t>(mesh_.positions.size());
        for (uint64_t v = 0; v < positions.count; ++v) {
            const glm::dvec4 local(positions.component(v, 0), positions.component(v, 1),
                                   positions.component(v, 2), 1.0);
            mesh_.positions.emplace_back(world * local);
        }
        // A mirroring transform turns every triangle inside out; section 3.7.4.
        const bool mirrored = glm::determinant(glm::dmat3(world)) < 0.0;
        const auto add = [&](size_t a, size_t b, size_t c) {
            if (mirrored) std::swap(b, c);
            mesh_.triangles.emplace_back(base + corners[a], base + corners[b], base + corners[c]);
        };
        if (mode == 4) {
            if (corners.size() % 3 != 0) {
                return malformed("it has " + std::to_string(corners.size())
                                 + " corners, which is no multiple of three");
            }
            for (size_t k = 0; k < corners.size(); k += 3) add(k, k + 1, k + 2);
        } else {
            for (size_t k = 0; k + 2 < corners.size(); ++k) {
                if (mode == 6)
                    add(0, k + 1, k + 2); // a fan
                else
                    add(k, k + 1 + k % 2, k + 2 - k % 2); // a strip turns at every step
            }
        }
        return {};
    }

    // Finds the accessor and checks that all its elements lie inside its buffer.
    Result<Accessor> accessor(std::optional<uint64_t> index, const char* type) {
        const Result<const Json*> found = element("accessors", index);
        if (!found) return found.error();
        const Json& json = **found;
        const std::string name = name_of("accessors", *index);
        const std::optional<uint64_t> count = unsigned_member(json, "count", std::nullopt);
        const std::optional<uint64_t> component_type = unsigned_member(json, "componentType", std::nullopt);
        const std::optional<uint64_t> offset = unsigned_member(json, "byteOffset", 0);
        const Json* type_found = member(json, "type");
        if (!count || !component_type || !offset || Accessor::size_of(*component_type) == 0
            || type_found == nullptr || *type_found != type) {
            return malformed(name + " has a damaged count, byteOffset or componentType, or is not of type "
                             + type);
        }
        if (member(json, "sparse") != nullptr) {
            return malformed(name + " is sparse, which is not read; export without sparse accessors");
        }
        if (*count > most_elements) {
            return malformed(name + " has " + std::to_string(*count)
                             + " elements; over 100 million are not read");
        }
        const Json* normalized = member(json, "normalized");
        const uint64_t element_size =
            Accessor::size_of(*component_type) * (std::string_view(type) == "VEC3" ? 3 : 1);
        Accessor result{*count,
                        static_cast<uint32_t>(*component_type),
                        normalized != nullptr && *normalized == true,
                        element_size,
                        {}};
        if (member(json, "bufferView") == nullptr || *count == 0) return result;

        const Result<const Json*> view =
            element("bufferViews", unsigned_member(json, "bufferView", std::nullopt));
        if (!view) return view.error();
        const Result<Bytes> bytes = bytes_of_view(**view);
        if (!bytes) return malformed(name + ": " + bytes.error().message);
        const std::optional<uint64_t> stride = unsigned_member(**view, "byteStride", element_size);
        // Strides are at most 252, so nothing below can overflow.
        if (!stride || *stride < element_size || *stride > 252)
            return malformed(name + " has a damaged byteStride");
        if (*offset > bytes->size() || (*count - 1) * *stride + element_size > bytes->size() - *offset) {
            return malformed(name + " has " + std::to_string(*count) + " elements, but its buffer view of "
                             + std::to_string(bytes->size()) + " bytes is too short for them");
        }
        result.stride = *stride;
        result.data = bytes->subspan(*offset);
        return result;
    }

    Result<Bytes> bytes_of_view(const Json& view) {
        const std::optional<uint64_t> offset = unsigned_member(view, "byteOffset", 0);
        const std::optional<uint64_t> length = unsigned_member(view, "byteLength", std::nullopt);
        const std::optional<uint64_t> buffer = unsigned_member(view, "buffer", std::nullopt);
        if (!offset || !length || !buffer) return malformed("its buffer view is damaged");
        const Result<Bytes> bytes = bytes_of_buffer(*buffer);
        if (!bytes) return bytes;
        if (*offset > bytes->size() || *length > bytes->size() - *offset) {
            return malformed("its buffer view ends at byte " + std::to_string(*offset) + " + "
                             + std::to_string(*length) + " of a buffer of " + std::to_string(bytes->size())
                             + "; the file was cut short or is damaged");
        }
        return bytes->subspan(*offset, *length);
    }

    Result<Bytes> bytes_of_buffer(uint64_t index) {
        const auto loaded = loaded_.find(index);
        if (loaded != loaded_.end()) return Bytes(loaded->second);
        const Result<const Json*> buffer = element("buffers", index);
        if (!buffer) return buffer.error();
        const Json* uri = member(**buffer, "uri");
        if (uri == nullptr && index == 0 && !binary_chunk_.empty()) return binary_chunk_;
        if (uri == nullptr || !uri->is_string()) return malformed(name_of("buffers", index) + " has no data");

        Result<std::vector<std::byte>> bytes = load_uri(uri->get<std::string>());
        if (!bytes) return bytes.error();
        return Bytes(loaded_.emplace(index, std::move(*bytes)).first->second);
    }

    Result<std::vector<std::byte>> load_uri(const std::string& uri) const {
        if (uri.starts_with("data:")) {
            const size_t comma = uri.find(";base64,");
            if (comma == uri.npos) return malformed("a data: URI is not base64");
            return decode_base64(std::string_view(uri).substr(comma + 8));
        }
        const std::filesystem::path file = std::filesystem::path(percent_decoded(uri)).lexically_normal();
        const bool below = file.is_relative() && !file.empty() && *file.begin() != "..";
        if (!below || uri.find("://") != uri.npos) {
            return malformed("its buffer '" + uri.substr(0, 80) + "' is not a file below its own folder");
        }
        return read_file(folder_ / file);
    }

    Json document_;
    Bytes binary_chunk_;
    std::filesystem::path folder_;
    std::map<uint64_t, std::vector<std::byte>> loaded_; // buffers from URIs
    TriangleMesh mesh_;
};

struct Container {
    Bytes json;
    Bytes binary;
};

// Section 4.4: a head of twelve bytes, then chunks of length, kind and content.
Result<Container> open_glb(Bytes bytes) {
    if (bytes.size() < 20)
        return malformed("a GLB file of " + std::to_string(bytes.size()) + " bytes was cut short");
    const auto version = load<uint32_t>(bytes, 4);
    const auto length = load<uint32_t>(bytes, 8);
    if (version != 2)
        return malformed("glTF version " + std::to_string(version) + "; only 2 is read, export it anew");
    if (length > bytes.size()) {
        return malformed("its head promises " + std::to_string(length) + " bytes, but the file has "
                         + std::to_string(bytes.size()) + "; it was cut short");
    }
    Container result;
    size_t at = 12;
    for (int chunk = 0; chunk < 2 && at + 8 <= length; ++chunk) {
        const auto size = load<uint32_t>(bytes, at);
        const auto kind = load<uint32_t>(bytes, at + 4);
        if (size > length - at - 8)
            return malformed("chunk " + std::to_string(chunk) + " is longer than the file");
        if (chunk == 0 && kind != 0x4E4F534A) return malformed("its first chunk is not JSON");
        if (chunk == 0)
            result.json = bytes.subspan(at + 8, size);
        else if (kind == 0x004E4942)
            result.binary = bytes.subspan(at + 8, size);
        at += 8 + size;
    }
    return result;
}

} // namespace

Result<TriangleMesh> read_gltf(std::span<const std::byte> bytes, const std::filesystem::path& folder) {
    Container container{bytes, {}};
    if (bytes.size() >= 4 && load<uint32_t>(bytes, 0) == 0x46546C67) {
        const Result<Container> opened = open_glb(bytes);
        if (!opened) return opened.error();
        container = *opened;
    }
    const char* const text = reinterpret_cast<const char*>(container.json.data());
    bool too_deep = false;
    const auto keep = [&](int depth, Json::parse_event_t, Json&) {
        too_deep = too_deep || depth > deepest_json;
        return depth <= deepest_json;
    };
    Json document = Json::parse(text, text + container.json.size(), keep, false);
    if (too_deep) return malformed("its JSON is nested over 64 levels deep");
    if (document.is_discarded() || !document.is_object()) {
        return malformed(
            "neither a GLB file nor glTF: the JSON cannot be read; it was cut short or is damaged");
    }
    return GltfReader(std::move(document), container.binary, folder).read();
}

} // namespace brittle::fracture
