#include "fracture/io/gltf_document.h"
#include "fracture/io/text_cursor.h"

#include <cctype>
#include <cstring>

namespace brittle::fracture::gltf {
namespace {

constexpr int max_json_depth = 64; // brackets; JSON libraries recurse over them

// The maximum number of elements of an accessor without data, which are all zero.
constexpr uint64_t max_empty_elements = 1'000'000;

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
            return malformed("a data: URI contains a character that is not base64");
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

// Limits on the memory of sparse accessors, which are expanded; several may use the same buffer view.
constexpr uint64_t max_sparse_bytes = uint64_t{1} << 30;
constexpr uint64_t free_sparse_bytes = uint64_t{16} << 20; // the limit for a small file,
constexpr uint64_t sparse_bytes_per_byte = 50;             // which grows by this for each byte

struct Container {
    Bytes json;
    Bytes binary;
};

// Section 4.4: a header of twelve bytes, then chunks of length, type and content.
Result<Container> open_glb(Bytes bytes) {
    if (bytes.size() < 20) return malformed("a GLB file of " + std::to_string(bytes.size()) + " bytes was cut short");
    const auto version = load<uint32_t>(bytes, 4);
    const auto length = load<uint32_t>(bytes, 8);
    if (version != 2) return malformed("glTF version " + std::to_string(version) + "; only 2 is read, export it anew");
    if (length > bytes.size()) {
        return malformed("its header promises " + std::to_string(length) + " bytes, but the file has "
                         + std::to_string(bytes.size()) + "; it was cut short");
    }
    Container result;
    size_t at = 12;
    for (int chunk = 0; chunk < 2 && at + 8 <= length; ++chunk) {
        const auto size = load<uint32_t>(bytes, at);
        const auto kind = load<uint32_t>(bytes, at + 4);
        if (size > length - at - 8) return malformed("chunk " + std::to_string(chunk) + " is longer than the file");
        if (chunk == 0 && kind != 0x4E4F534A) return malformed("its first chunk is not JSON");
        if (chunk == 0)
            result.json = bytes.subspan(at + 8, size);
        else if (kind == 0x004E4942)
            result.binary = bytes.subspan(at + 8, size);
        at += 8 + size;
    }
    return result;
}

uint64_t components_of(std::string_view type) {
    if (type == "SCALAR") return 1;
    return static_cast<uint64_t>(type.back() - '0'); // VEC2, VEC3, VEC4
}

} // namespace

Error malformed(const std::string& what) {
    return {Status::malformed_file, what};
}

std::string name_of(const char* list, uint64_t index) {
    return std::string(list) + "[" + std::to_string(index) + "]";
}

const Json* member(const Json& object, const char* key) {
    if (!object.is_object()) return nullptr;
    const auto found = object.find(key);
    return found == object.end() ? nullptr : &*found;
}

std::optional<uint64_t> unsigned_member(const Json& object, const char* key, std::optional<uint64_t> fallback) {
    const Json* value = member(object, key);
    if (value == nullptr) return fallback;
    if (!value->is_number_unsigned()) return std::nullopt;
    return value->get<uint64_t>();
}

Result<Document> Document::open(Bytes bytes, Companions& companions) {
    Container container{bytes, {}};
    if (bytes.size() >= 4 && load<uint32_t>(bytes, 0) == 0x46546C67) {
        const Result<Container> opened = open_glb(bytes);
        if (!opened) return opened.error();
        container = *opened;
    }
    const char* const text = reinterpret_cast<const char*>(container.json.data());
    bool too_deep = false;
    const auto keep = [&](int depth, Json::parse_event_t, Json&) {
        too_deep = too_deep || depth > max_json_depth;
        return depth <= max_json_depth;
    };
    Json document = Json::parse(text, text + container.json.size(), keep, false);
    if (too_deep) return malformed("its JSON is nested over 64 levels deep");
    if (document.is_discarded() || !document.is_object()) {
        return malformed("neither a GLB file nor glTF: the JSON cannot be read; it was cut short or is damaged");
    }
    if (const Json* asset = member(document, "asset"); asset != nullptr) {
        const Json* version = member(*asset, "version");
        if (version != nullptr && version->is_string() && !version->get_ref<const std::string&>().starts_with("2"))
            return malformed("glTF version " + printable(version->get_ref<const std::string&>())
                             + "; only 2 is read, export it anew");
    }
    return Document(std::move(document), container.binary, companions, bytes.size());
}

Result<const Json*> Document::element(const char* list, std::optional<uint64_t> index) const {
    const Json* values = member(json_, list);
    if (!index || values == nullptr || !values->is_array() || *index >= values->size()
        || !(*values)[*index].is_object()) {
        return malformed((index ? name_of(list, *index) : "an index into " + std::string(list))
                         + " is missing or of the wrong type");
    }
    return &(*values)[*index];
}

Result<Bytes> Document::view_of(const Json& owner, const std::string& name) {
    const Result<const Json*> view = element("bufferViews", unsigned_member(owner, "bufferView", std::nullopt));
    if (!view) return view.error();
    Result<Bytes> bytes = bytes_of_view(**view);
    if (!bytes) return malformed(name + ": " + bytes.error().message);
    return bytes;
}

Result<Accessor> Document::accessor(std::optional<uint64_t> index, std::string_view type) {
    const Result<const Json*> found = element("accessors", index);
    if (!found) return found.error();
    const Json& json = **found;
    const std::string name = name_of("accessors", *index);
    const std::optional<uint64_t> count = unsigned_member(json, "count", std::nullopt);
    const std::optional<uint64_t> component_type = unsigned_member(json, "componentType", std::nullopt);
    const std::optional<uint64_t> offset = unsigned_member(json, "byteOffset", 0);
    const Json* type_found = member(json, "type");
    if (!count || !component_type || !offset || Accessor::size_of(*component_type) == 0 || type_found == nullptr
        || *type_found != type) {
        return malformed(name + " has a damaged count, byteOffset or componentType, or is not of type "
                         + std::string(type));
    }
    if (*count > max_elements)
        return malformed(name + " has " + std::to_string(*count) + " elements; over 100 million are not read");
    const Json* normalized = member(json, "normalized");
    const uint64_t element_size = Accessor::size_of(*component_type) * components_of(type);
    Accessor result{*count, static_cast<uint32_t>(*component_type), normalized != nullptr && *normalized == true,
                    element_size};
    if (*count > 0 && member(json, "bufferView") != nullptr) {
        const Result<Bytes> bytes = view_of(json, name);
        if (!bytes) return bytes.error();
        const Json& view = json_["bufferViews"][json["bufferView"].get<uint64_t>()];
        const std::optional<uint64_t> stride = unsigned_member(view, "byteStride", element_size);
        // Strides are at most 252, so the products below cannot overflow.
        if (!stride || *stride < element_size || *stride > 252) return malformed(name + " has a damaged byteStride");
        if (*offset > bytes->size() || (*count - 1) * *stride + element_size > bytes->size() - *offset) {
            return malformed(name + " has " + std::to_string(*count) + " elements, but its buffer view of "
                             + std::to_string(bytes->size()) + " bytes is too short for them");
        }
        result.stride = *stride;
        result.data = bytes->subspan(*offset);
    } else if (*count > max_empty_elements) {
        return malformed(name + " has " + std::to_string(*count) + " elements but no data");
    }
    const Json* sparse = member(json, "sparse");
    if (sparse == nullptr || *count == 0) return result;
    if (const auto known = sparse_.find(*index); known != sparse_.end()) return known->second;
    if (Result<void> done = apply_sparse(*sparse, name, element_size, result); !done) return done.error();
    sparse_.emplace(*index, result);
    return result;
}

// Section 3.6.2.3: replaces the values of some elements.
Result<void> Document::apply_sparse(const Json& sparse, const std::string& name, uint64_t element_size,
                                    Accessor& accessor) {
    const Json *indices = member(sparse, "indices"), *values = member(sparse, "values");
    const std::optional<uint64_t> count = unsigned_member(sparse, "count", std::nullopt);
    if (!count || indices == nullptr || values == nullptr || *count > accessor.count)
        return malformed(name + " has a damaged sparse part");
    const std::optional<uint64_t> index_type = unsigned_member(*indices, "componentType", std::nullopt);
    const std::optional<uint64_t> index_offset = unsigned_member(*indices, "byteOffset", 0);
    const std::optional<uint64_t> value_offset = unsigned_member(*values, "byteOffset", 0);
    const uint64_t index_size = index_type ? Accessor::size_of(*index_type) : 0;
    if (index_size == 0 || !index_offset || !value_offset) return malformed(name + " has a damaged sparse part");
    const Result<Bytes> index_bytes = view_of(*indices, name), value_bytes = view_of(*values, name);
    if (!index_bytes) return index_bytes.error();
    if (!value_bytes) return value_bytes.error();
    const auto holds = [&](const Bytes& bytes, uint64_t offset, uint64_t size) {
        return offset <= bytes.size() && *count * size <= bytes.size() - offset;
    };
    if (!holds(*index_bytes, *index_offset, index_size) || !holds(*value_bytes, *value_offset, element_size))
        return malformed(name + " has a sparse part of " + std::to_string(*count)
                         + " elements, for which its buffer views are too short");

    sparse_bytes_ += accessor.count * element_size;
    const uint64_t most = std::min(max_sparse_bytes, free_sparse_bytes + sparse_bytes_per_byte * size());
    if (sparse_bytes_ > most)
        return malformed("its sparse accessors take over " + std::to_string(most)
                         + " bytes, the limit for a file of its size");
    std::vector<std::byte>& dense = decoded_.emplace_back(accessor.count * element_size);
    for (uint64_t k = 0; k < accessor.count && !accessor.data.empty(); ++k)
        std::memcpy(dense.data() + k * element_size, accessor.data.data() + k * accessor.stride, element_size);
    const Accessor index{*count, static_cast<uint32_t>(*index_type), false, index_size,
                         index_bytes->subspan(*index_offset)};
    for (uint64_t k = 0; k < *count; ++k) {
        const double at = index.component(k, 0);
        if (!(at >= 0.0 && at < static_cast<double>(accessor.count)))
            return malformed(name + " has a sparse index beyond its count");
        std::memcpy(dense.data() + static_cast<uint64_t>(at) * element_size,
                    value_bytes->data() + *value_offset + k * element_size, element_size);
    }
    accessor.stride = element_size;
    accessor.data = dense;
    return {};
}

Result<Bytes> Document::bytes_of_view(const Json& view) {
    const std::optional<uint64_t> offset = unsigned_member(view, "byteOffset", 0);
    const std::optional<uint64_t> length = unsigned_member(view, "byteLength", std::nullopt);
    const std::optional<uint64_t> buffer = unsigned_member(view, "buffer", std::nullopt);
    if (!offset || !length || !buffer) return malformed("its buffer view is damaged");
    const Result<Bytes> bytes = bytes_of_buffer(*buffer);
    if (!bytes) return bytes;
    if (*offset > bytes->size() || *length > bytes->size() - *offset) {
        return malformed("its buffer view ends at byte " + std::to_string(*offset) + " + " + std::to_string(*length)
                         + " of a buffer of " + std::to_string(bytes->size())
                         + "; the file was cut short or is damaged");
    }
    return bytes->subspan(*offset, *length);
}

Result<Bytes> Document::bytes_of_buffer(uint64_t index) {
    if (const auto known = buffers_.find(index); known != buffers_.end()) return known->second;
    const Result<const Json*> buffer = element("buffers", index);
    if (!buffer) return buffer.error();
    const Json* uri = member(**buffer, "uri");
    if (uri == nullptr && index == 0 && !binary_chunk_.empty()) return binary_chunk_;
    if (uri == nullptr || !uri->is_string()) return malformed(name_of("buffers", index) + " has no data");
    Result<Bytes> bytes = bytes_of_uri(uri->get<std::string>());
    if (bytes) buffers_.emplace(index, *bytes);
    return bytes;
}

Result<Bytes> Document::bytes_of_uri(const std::string& uri) {
    if (!uri.starts_with("data:")) return companions_->read(percent_decoded(uri));
    const size_t comma = uri.find(";base64,");
    if (comma == uri.npos) return malformed("a data: URI is not base64");
    Result<std::vector<std::byte>> bytes = decode_base64(std::string_view(uri).substr(comma + 8));
    if (!bytes) return bytes.error();
    return Bytes(decoded_.emplace_back(std::move(*bytes)));
}

} // namespace brittle::fracture::gltf
