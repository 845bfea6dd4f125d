// A glTF document: its JSON and the content of its buffers. Internal to read_gltf().
//
// Container and JSON schema follow the Khronos glTF 2.0 specification; section numbers refer to it.
#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <deque>
#include <limits>
#include <map>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include <nlohmann/json.hpp>

#include "fracture/base/error.h"
#include "fracture/io/bytes.h"
#include "fracture/io/companions.h"

namespace brittle::fracture::gltf {

using Json = nlohmann::json;
using Bytes = std::span<const std::byte>;

// Limits on the size of a scene: nodes may use one mesh many times, so a small file could give any number of vertices.
inline constexpr uint64_t max_elements = 100'000'000; // the limit for vertices, and for triangles
inline constexpr uint64_t free_elements = 1'000'000;  // the limit for a small file,
inline constexpr uint64_t elements_per_byte = 50; // which grows by this for each byte; a mesh used once has at most 1

[[nodiscard]] Error malformed(const std::string& what);
[[nodiscard]] std::string name_of(const char* list, uint64_t index);

// The member with this name; null where there is none or the value is not an object.
[[nodiscard]] const Json* member(const Json& object, const char* key);

// A non-negative integer. The fallback where the member is missing, nothing where it has another type.
[[nodiscard]] std::optional<uint64_t> unsigned_member(const Json& object, const char* key,
                                                      std::optional<uint64_t> fallback);

// Exactly `count` numbers. The fallback where the member is missing, nothing where it has another type.
template<size_t count>
[[nodiscard]] std::optional<std::array<double, count>> numbers(const Json& object, const char* key,
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

// Section 3.6.2: a typed view of a buffer.
struct Accessor {
    uint64_t count = 0;
    uint32_t component_type = 0;
    bool normalized = false;
    uint64_t stride = 0;
    Bytes data{}; // empty: all zeros

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

    // The number of bytes of a component; 0 for an unknown type.
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
    // KHR_mesh_quantization: fixed point, where both -max - 1 and -max stand for -1.
    template<class T>
    [[nodiscard]] double scaled(T value) const {
        if (!normalized) return value;
        return std::max(static_cast<double>(value) / std::numeric_limits<T>::max(), -1.0);
    }
};

class Document {
  public:
    // Opens the bytes of a .gltf or .glb file. The bytes and the companions outlive the document.
    [[nodiscard]] static Result<Document> open(Bytes file, Companions& companions);

    [[nodiscard]] const Json& json() const { return json_; }
    [[nodiscard]] Companions& companions() const { return *companions_; }
    // The number of bytes in the file and in the companion files read so far.
    [[nodiscard]] uint64_t size() const { return size_ + companions_->size(); }

    // The element of a top-level list with this index.
    [[nodiscard]] Result<const Json*> element(const char* list, std::optional<uint64_t> index) const;
    // An accessor of type SCALAR, VEC2, VEC3 or VEC4, with all its elements inside its buffer.
    [[nodiscard]] Result<Accessor> accessor(std::optional<uint64_t> index, std::string_view type);
    [[nodiscard]] Result<Bytes> bytes_of_view(const Json& view);
    // The bytes of a data: URI, or of a file in the folder or below. Valid as long as the document.
    [[nodiscard]] Result<Bytes> bytes_of_uri(const std::string& uri);

  private:
    Document(Json json, Bytes binary_chunk, Companions& companions, uint64_t size)
        : json_(std::move(json)), binary_chunk_(binary_chunk), companions_(&companions), size_(size) {}

    [[nodiscard]] Result<Bytes> bytes_of_buffer(uint64_t index);
    [[nodiscard]] Result<Bytes> view_of(const Json& owner, const std::string& name);
    [[nodiscard]] Result<void> apply_sparse(const Json& sparse, const std::string& name, uint64_t element_size,
                                            Accessor& accessor);

    Json json_;
    Bytes binary_chunk_;
    Companions* companions_;
    uint64_t size_;
    std::map<uint64_t, Bytes> buffers_;
    std::map<uint64_t, Accessor> sparse_;
    uint64_t sparse_bytes_ = 0;
    std::deque<std::vector<std::byte>> decoded_; // owns the bytes of data: URIs and sparse accessors
};

} // namespace brittle::fracture::gltf
