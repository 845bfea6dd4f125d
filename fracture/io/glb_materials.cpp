#include "fracture/io/glb_materials.h"

#include <algorithm>
#include <array>

#include "fracture/io/writers.h"

namespace brittle::fracture {
namespace {

using Json = nlohmann::ordered_json;

// Replaces images that could not be read, so that indices stay valid: one white pixel.
constexpr std::array<unsigned char, 69> white_png = {
    0x89, 0x50, 0x4e, 0x47, 0x0d, 0x0a, 0x1a, 0x0a, 0x00, 0x00, 0x00, 0x0d, 0x49, 0x48, 0x44, 0x52, 0x00, 0x00,
    0x00, 0x01, 0x00, 0x00, 0x00, 0x01, 0x08, 0x02, 0x00, 0x00, 0x00, 0x90, 0x77, 0x53, 0xde, 0x00, 0x00, 0x00,
    0x0c, 0x49, 0x44, 0x41, 0x54, 0x78, 0xda, 0x63, 0xf8, 0xff, 0xff, 0x3f, 0x00, 0x05, 0xfe, 0x02, 0xfe, 0x33,
    0x12, 0x95, 0x14, 0x00, 0x00, 0x00, 0x00, 0x49, 0x45, 0x4e, 0x44, 0xae, 0x42, 0x60, 0x82};

// Extensions are stored as the text of valid JSON.
void put_extensions(Json& object, const std::string& text, std::set<std::string>& used) {
    if (text.empty()) return;
    Json extensions = Json::parse(text, nullptr, false);
    if (!extensions.is_object()) return;
    for (const auto& [name, value] : extensions.items()) used.insert(name);
    object["extensions"] = std::move(extensions);
}

void put_use(Json& object, const char* key, const std::optional<TextureUse>& use, const char* strength,
             std::set<std::string>& used) {
    if (!use) return;
    Json json{{"index", use->texture}};
    if (use->uv_set != 0) json["texCoord"] = use->uv_set;
    if (strength && use->strength != 1.0) json[strength] = use->strength;
    put_extensions(json, use->extensions, used);
    object[key] = std::move(json);
}

Json material_json(const Material& material, std::set<std::string>& used) {
    Json pbr{{"baseColorFactor",
              {material.base_colour.x, material.base_colour.y, material.base_colour.z, material.base_colour.w}},
             {"metallicFactor", material.metallic},
             {"roughnessFactor", material.roughness}};
    put_use(pbr, "baseColorTexture", material.base_colour_texture, nullptr, used);
    put_use(pbr, "metallicRoughnessTexture", material.metallic_roughness_texture, nullptr, used);
    Json json = Json::object();
    if (!material.name.empty()) json["name"] = material.name;
    json["pbrMetallicRoughness"] = std::move(pbr);
    put_use(json, "normalTexture", material.normal_texture, "scale", used);
    put_use(json, "occlusionTexture", material.occlusion_texture, "strength", used);
    put_use(json, "emissiveTexture", material.emissive_texture, nullptr, used);
    if (material.emissive != glm::dvec3(0.0))
        json["emissiveFactor"] = {material.emissive.x, material.emissive.y, material.emissive.z};
    if (material.alpha_mode == AlphaMode::mask) {
        json["alphaMode"] = "MASK";
        json["alphaCutoff"] = material.alpha_cutoff;
    }
    if (material.alpha_mode == AlphaMode::blend) json["alphaMode"] = "BLEND";
    json["doubleSided"] = material.double_sided;
    put_extensions(json, material.extensions, used);
    return json;
}

Json image_json(const Image& image, const std::function<size_t(std::vector<std::byte>)>& add_view) {
    Json json = Json::object();
    if (!image.name.empty()) json["name"] = image.name;
    if (image.mime_type.empty()) {
        const auto* const bytes = reinterpret_cast<const std::byte*>(white_png.data());
        json["mimeType"] = "image/png";
        json["bufferView"] = add_view({bytes, bytes + white_png.size()});
    } else {
        json["mimeType"] = image.mime_type;
        json["bufferView"] = add_view(image.bytes);
    }
    return json;
}

} // namespace

size_t GlbMaterials::sampler_of(const Texture& texture) {
    Json json{{"wrapS", texture.wrap_s}, {"wrapT", texture.wrap_t}};
    if (texture.min_filter != 0) json["minFilter"] = texture.min_filter;
    if (texture.mag_filter != 0) json["magFilter"] = texture.mag_filter;
    const auto known = std::find(samplers_.begin(), samplers_.end(), json);
    if (known == samplers_.end()) {
        samplers_.push_back(std::move(json));
        return samplers_.size() - 1;
    }
    return static_cast<size_t>(known - samplers_.begin());
}

// Objects with one image share its texture.
size_t GlbMaterials::interior_texture(const Image& image) {
    const auto is_equal = [&](const Image* other) {
        return other->name == image.name && other->mime_type == image.mime_type && other->bytes == image.bytes;
    };
    const auto known =
        std::find_if(images_.end() - static_cast<std::ptrdiff_t>(interior_images_.size()), images_.end(), is_equal);
    const auto number = static_cast<size_t>(known - images_.begin());
    if (known == images_.end()) {
        images_.push_back(&interior_images_.emplace_back(image));
        textures_.push_back({{"sampler", sampler_of({})}, {"source", number}});
    }
    return textures_.size() - (images_.size() - number); // each of these images has one texture, in the same order
}

void GlbMaterials::use(const ExportOptions& options) {
    const std::vector<uint32_t> none;
    const auto& used = options.source ? options.source->material_of : none;
    has_exterior_ = used.empty() || std::find(used.begin(), used.end(), no_material) != used.end();
    if (const Model* source = options.source) {
        for (const Material& material : source->materials) materials_.push_back(material_json(material, extensions_));
        for (const Image& image : source->images) images_.push_back(&image);
        for (const Texture& texture : source->textures) {
            Json json{{"sampler", sampler_of(texture)}};
            if (texture.image) json["source"] = *texture.image;
            put_extensions(json, texture.extensions, extensions_);
            textures_.push_back(std::move(json));
        }
    }
    Json own = Json::array();
    if (has_exterior_) own.push_back(material_json(exterior_material(options), extensions_));
    Json& interior = own.emplace_back(material_json(interior_material(options), extensions_));
    if (options.interior_image)
        interior["pbrMetallicRoughness"]["baseColorTexture"] = {{"index", interior_texture(*options.interior_image)}};
    const auto known = std::ranges::find(own_, own, &Own::materials);
    first_own_ = known != own_.end() ? known->first : materials_.size();
    if (known != own_.end()) return;
    for (const Json& material : own) materials_.push_back(material);
    own_.push_back({std::move(own), first_own_});
}

size_t GlbMaterials::material_of(const DrawnPart& part) const {
    if (part.interior) return first_own_ + (has_exterior_ ? 1 : 0);
    return part.material == no_material ? first_own_ : part.material;
}

void GlbMaterials::add_to(Json& document, std::set<std::string>& used,
                          const std::function<size_t(std::vector<std::byte>)>& add_view) const {
    used.insert(extensions_.begin(), extensions_.end());
    Json images = Json::array();
    for (const Image* image : images_) images.push_back(image_json(*image, add_view));
    document["materials"] = materials_;
    if (!textures_.empty()) document["textures"] = textures_;
    if (!images.empty()) document["images"] = std::move(images);
    if (!samplers_.empty()) document["samplers"] = samplers_;
}

} // namespace brittle::fracture
