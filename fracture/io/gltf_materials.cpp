#include "fracture/io/gltf_materials.h"

#include <cmath>

#include <glm/common.hpp>

namespace brittle::fracture::gltf {
namespace {

// The maximum number of materials, textures and images: more than any scene has. Each takes memory, whatever its size
// in the file.
constexpr size_t max_entries = 100'000;

const Json& list_of(const Json& document, const char* name) {
    static const Json nothing = Json::array();
    const Json* list = member(document, name);
    return list != nullptr && list->is_array() && list->size() <= max_entries ? *list : nothing;
}

std::string text_of(const Json& object, const char* key) {
    const Json* value = member(object, key);
    return value != nullptr && value->is_string() ? value->get<std::string>() : std::string();
}

double number_of(const Json& object, const char* key, double otherwise, double most = 1.0) {
    const Json* value = member(object, key);
    if (value == nullptr || !value->is_number()) return otherwise;
    const double number = value->get<double>();
    return number >= 0.0 && number <= most ? number : otherwise;
}

std::string extensions_of(const Json& object) {
    const Json* value = member(object, "extensions");
    if (value == nullptr || !value->is_object() || value->empty()) return {};
    return value->dump(-1, ' ', false, Json::error_handler_t::replace);
}

class MaterialReader {
  public:
    MaterialReader(Document& document, Model& model) : document_(document), model_(model) {}

    void read() {
        for (const Json& image : list_of(document_.json(), "images")) model_.images.push_back(read_image(image));
        for (const Json& texture : list_of(document_.json(), "textures"))
            model_.textures.push_back(read_texture(texture));
        for (const Json& material : list_of(document_.json(), "materials"))
            model_.materials.push_back(read_material(material));
    }

  private:
    Image read_image(const Json& json) {
        Image image{.name = text_of(json, "name")};
        const auto number = std::to_string(model_.images.size());
        Result<Bytes> bytes = Bytes();
        if (const Json* uri = member(json, "uri"); uri != nullptr && uri->is_string()) {
            bytes = document_.bytes_of_uri(uri->get<std::string>());
        } else {
            const Result<const Json*> view =
                document_.element("bufferViews", unsigned_member(json, "bufferView", std::nullopt));
            bytes = view ? document_.bytes_of_view(**view) : Result<Bytes>(view.error());
        }
        if (!bytes) {
            add_note(model_.notes, "image " + number + ": " + bytes.error().message);
            return image;
        }
        image.mime_type = image_type(*bytes);
        if (image.mime_type.empty()) {
            add_note(model_.notes, "image " + number + " is not a PNG, JPEG, WebP or KTX2 image");
            return image;
        }
        kept_ += bytes->size();
        if (kept_ > copies * document_.size()) {
            add_note(model_.notes, "image " + number + ": left out, because the images use the same bytes too often");
            image.mime_type.clear();
            return image;
        }
        image.bytes.assign(bytes->begin(), bytes->end());
        return image;
    }

    Texture read_texture(const Json& json) {
        Texture texture;
        const auto source = unsigned_member(json, "source", std::nullopt);
        if (source && *source < model_.images.size()) texture.image = static_cast<uint32_t>(*source);
        texture.extensions = extensions_of(json);
        const Result<const Json*> sampler =
            document_.element("samplers", unsigned_member(json, "sampler", std::nullopt));
        if (!sampler) return texture;
        const auto one_of = [&](const char* key, uint32_t otherwise, std::initializer_list<uint32_t> values) {
            const auto value = unsigned_member(**sampler, key, otherwise);
            for (const uint32_t allowed : values)
                if (value == allowed) return allowed;
            return otherwise;
        };
        texture.wrap_s = one_of("wrapS", 10497, {33071, 33648, 10497});
        texture.wrap_t = one_of("wrapT", 10497, {33071, 33648, 10497});
        texture.mag_filter = one_of("magFilter", 0, {9728, 9729});
        texture.min_filter = one_of("minFilter", 0, {9728, 9729, 9984, 9985, 9986, 9987});
        return texture;
    }

    [[nodiscard]] std::optional<TextureUse> use_of(const Json& object, const char* key, const char* strength) const {
        const Json* json = member(object, key);
        if (json == nullptr) return std::nullopt;
        const auto index = unsigned_member(*json, "index", std::nullopt);
        if (!index || *index >= model_.textures.size()) return std::nullopt;
        TextureUse use{.texture = static_cast<uint32_t>(*index)};
        const auto set = unsigned_member(*json, "texCoord", 0);
        use.uv_set = set == 1u ? 1 : 0;
        if (strength) use.strength = number_of(*json, strength, 1.0, 1e6);
        use.extensions = extensions_of(*json);
        return use;
    }

    [[nodiscard]] Material read_material(const Json& json) const {
        Material material{.name = text_of(json, "name")};
        if (const Json* pbr = member(json, "pbrMetallicRoughness")) {
            const auto colour = numbers<4>(*pbr, "baseColorFactor", {1, 1, 1, 1});
            if (colour) material.base_colour = {(*colour)[0], (*colour)[1], (*colour)[2], (*colour)[3]};
            material.base_colour = glm::clamp(material.base_colour, 0.0, 1.0);
            material.metallic = number_of(*pbr, "metallicFactor", 1.0);
            material.roughness = number_of(*pbr, "roughnessFactor", 1.0);
            material.base_colour_texture = use_of(*pbr, "baseColorTexture", nullptr);
            material.metallic_roughness_texture = use_of(*pbr, "metallicRoughnessTexture", nullptr);
        } else {
            material.metallic = 1.0; // the defaults of an empty object
        }
        if (const auto emissive = numbers<3>(json, "emissiveFactor", {0, 0, 0}))
            material.emissive = glm::clamp(glm::dvec3((*emissive)[0], (*emissive)[1], (*emissive)[2]), 0.0, 1.0);
        material.normal_texture = use_of(json, "normalTexture", "scale");
        material.occlusion_texture = use_of(json, "occlusionTexture", "strength");
        if (material.occlusion_texture)
            material.occlusion_texture->strength = std::min(material.occlusion_texture->strength, 1.0);
        material.emissive_texture = use_of(json, "emissiveTexture", nullptr);
        const std::string mode = text_of(json, "alphaMode");
        material.alpha_mode =
            mode == "MASK" ? AlphaMode::mask : (mode == "BLEND" ? AlphaMode::blend : AlphaMode::opaque);
        material.alpha_cutoff = number_of(json, "alphaCutoff", 0.5, 1e6);
        const Json* double_sided = member(json, "doubleSided");
        material.double_sided = double_sided != nullptr && *double_sided == true;
        material.extensions = extensions_of(json);
        return material;
    }

    // Images may share a file or overlapping views. Together they take at most this many times the bytes read.
    static constexpr uint64_t copies = 4;

    Document& document_;
    Model& model_;
    uint64_t kept_ = 0;
};

} // namespace

void read_materials(Document& document, Model& model) {
    MaterialReader(document, model).read();
}

} // namespace brittle::fracture::gltf
