#include "fracture/io/glb_materials.h"

#include <algorithm>
#include <array>
#include <iterator>
#include <optional>
#include <utility>

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

// The index in the file of an image or a texture of the source.
using IndexInFile = std::function<size_t(size_t)>;

// Replaces the indices that an extension has under a key at any depth. Those that name nothing stay.
void renumber(Json& json, const std::string& key, size_t count, const IndexInFile& index) {
    if (!json.is_structured()) return;
    for (const auto& [name, value] : json.items()) {
        if (name == key && json.is_object() && value.is_number_unsigned() && value.get<uint64_t>() < count)
            value = index(value.get<size_t>());
        else
            renumber(value, key, count, index);
    }
}

// Extensions are stored as the text of valid JSON. `key` names their indices, of which the source has `count`.
void put_extensions(Json& object, const std::string& text, const std::string& key, size_t count,
                    const IndexInFile& index, std::set<std::string>& used) {
    if (text.empty()) return;
    Json extensions = Json::parse(text, nullptr, false);
    if (!extensions.is_object()) return;
    for (const auto& [name, value] : extensions.items()) used.insert(name);
    renumber(extensions, key, count, index);
    object["extensions"] = std::move(extensions);
}

// The textures of a source, for its materials.
struct Textures {
    size_t count;
    IndexInFile index;
};

void put_use(Json& object, const char* key, const std::optional<TextureUse>& use, const char* strength,
             const Textures& textures, std::set<std::string>& used) {
    if (!use) return;
    Json json{{"index", use->texture < textures.count ? textures.index(use->texture) : size_t{use->texture}}};
    if (use->uv_set != 0) json["texCoord"] = use->uv_set;
    if (strength && use->strength != 1.0) json[strength] = use->strength;
    put_extensions(json, use->extensions, "index", textures.count, textures.index, used);
    object[key] = std::move(json);
}

Json material_json(const Material& material, const Textures& textures, std::set<std::string>& used) {
    Json pbr{{"baseColorFactor",
              {material.base_colour.x, material.base_colour.y, material.base_colour.z, material.base_colour.w}},
             {"metallicFactor", material.metallic},
             {"roughnessFactor", material.roughness}};
    put_use(pbr, "baseColorTexture", material.base_colour_texture, nullptr, textures, used);
    put_use(pbr, "metallicRoughnessTexture", material.metallic_roughness_texture, nullptr, textures, used);
    Json json = Json::object();
    if (!material.name.empty()) json["name"] = material.name;
    json["pbrMetallicRoughness"] = std::move(pbr);
    put_use(json, "normalTexture", material.normal_texture, "scale", textures, used);
    put_use(json, "occlusionTexture", material.occlusion_texture, "strength", textures, used);
    put_use(json, "emissiveTexture", material.emissive_texture, nullptr, textures, used);
    if (material.emissive != glm::dvec3(0.0))
        json["emissiveFactor"] = {material.emissive.x, material.emissive.y, material.emissive.z};
    if (material.alpha_mode == AlphaMode::mask) {
        json["alphaMode"] = "MASK";
        json["alphaCutoff"] = material.alpha_cutoff;
    }
    if (material.alpha_mode == AlphaMode::blend) json["alphaMode"] = "BLEND";
    json["doubleSided"] = material.double_sided;
    put_extensions(json, material.extensions, "index", textures.count, textures.index, used);
    return json;
}

// One of Brittle's own, without textures.
Json plain_material_json(const Material& material, std::set<std::string>& used) {
    return material_json(material, {0, [](size_t texture) { return texture; }}, used);
}

bool is_equal(const Image& a, const Image& b) {
    return &a == &b || (a.name == b.name && a.mime_type == b.mime_type && a.bytes == b.bytes);
}

constexpr size_t unknown = ~size_t{0};

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

size_t GlbMaterials::add_to_list(Json& list, Json value) const {
    const auto known = source_.is_first ? list.end() : std::find(list.begin(), list.end(), value);
    const auto at = static_cast<size_t>(known - list.begin());
    if (known == list.end()) list.push_back(std::move(value));
    return at;
}

size_t GlbMaterials::image_of(size_t image) {
    size_t& at = source_.image_at[image];
    if (at != unknown) return at;
    const Image& own = (*source_.images)[image];
    const auto known = source_.is_first ? images_.end()
                                        : std::find_if(images_.begin(), images_.end(),
                                                       [&](const Image* other) { return is_equal(*other, own); });
    at = static_cast<size_t>(known - images_.begin());
    if (known == images_.end()) images_.push_back(&own);
    return at;
}

size_t GlbMaterials::texture_of(size_t texture) {
    size_t& at = source_.texture_at[texture];
    if (at != unknown) return at;
    const Texture& own = source_.model->textures[texture];
    Json json{{"sampler", sampler_of(own)}};
    const size_t images = source_.images->size();
    if (own.image) json["source"] = *own.image < images ? image_of(*own.image) : size_t{*own.image};
    put_extensions(
        json, own.extensions, "source", images, [this](size_t image) { return image_of(image); }, extensions_);
    return at = add_to_list(textures_, std::move(json));
}

size_t GlbMaterials::source_material_of(size_t material) {
    size_t& at = source_.material_at[material];
    if (at != unknown) return at;
    const Textures textures{source_.model->textures.size(), [this](size_t texture) { return texture_of(texture); }};
    return at = add_to_list(materials_, material_json(source_.model->materials[material], textures, extensions_));
}

void GlbMaterials::use_source(const ExportOptions& options) {
    source_ = {.is_first = own_.empty()};
    if (!options.source) return;
    const Model& model = *(source_.model = options.source);
    source_.images = options.images ? options.images : &model.images;
    source_.image_at.assign(source_.images->size(), unknown);
    source_.texture_at.assign(model.textures.size(), unknown);
    source_.material_at.assign(model.materials.size(), unknown);
    if (source_.is_first) {
        for (size_t k = 0; k < source_.images->size(); ++k) image_of(k);
        for (size_t k = 0; k < model.textures.size(); ++k) texture_of(k);
        for (size_t k = 0; k < model.materials.size(); ++k) source_material_of(k);
    } else {
        for (const uint32_t material : model.material_of)
            if (material < model.materials.size()) source_material_of(material);
    }
}

// Objects with one image share its texture.
size_t GlbMaterials::interior_texture(const Image& image) {
    for (const auto& [known, texture] : interior_textures_)
        if (is_equal(*known, image)) return texture;
    images_.push_back(&interior_images_.emplace_back(image));
    textures_.push_back({{"sampler", sampler_of({})}, {"source", images_.size() - 1}});
    interior_textures_.emplace_back(images_.back(), textures_.size() - 1);
    return textures_.size() - 1;
}

void GlbMaterials::use(const ExportOptions& options) {
    const std::vector<uint32_t> none;
    const auto& used = options.source ? options.source->material_of : none;
    const bool has_exterior = used.empty() || std::find(used.begin(), used.end(), no_material) != used.end();
    use_source(options);
    if (has_exterior) exterior_ = own_material(plain_material_json(exterior_material(options), extensions_));
    Json interior = plain_material_json(interior_material(options), extensions_);
    if (options.interior_image)
        interior["pbrMetallicRoughness"]["baseColorTexture"] = {{"index", interior_texture(*options.interior_image)}};
    interior_ = own_material(std::move(interior));
}

size_t GlbMaterials::own_material(Json material) {
    for (const size_t known : own_)
        if (materials_[known] == material) return known;
    materials_.push_back(std::move(material));
    own_.push_back(materials_.size() - 1);
    return own_.back();
}

size_t GlbMaterials::material_of(const DrawnPart& part) const {
    if (part.interior) return interior_;
    if (part.material == no_material) return exterior_;
    return part.material < source_.material_at.size() ? source_.material_at[part.material] : part.material;
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
