#include "tools/brittle/stage/mesh_looks.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <optional>
#include <utility>

#include <glm/common.hpp>
#include <nlohmann/json.hpp>

#include "engine/core/bitmap.h"
#include "fracture/io/colour.h"
#include "fracture/io/import.h"
#include "fracture/io/mesh_scene.h"
#include "fracture/io/text_cursor.h"
#include "fracture/pieces/attributes.h"
#include "tools/brittle/base/device_failure.h"
#include "tools/scenario/base/failure.h"

namespace brittle::tools {

namespace {

using fracture::Image;
using fracture::Model;
using fracture::TextureUse;

// A larger image is not decoded: 256 MiB of pixels.
constexpr uint64_t max_pixels = uint64_t{8192} * 8192;

engine::Wrap wrap_of(uint32_t gltf) {
    return gltf == 33071 ? engine::Wrap::clamp : (gltf == 33648 ? engine::Wrap::mirror : engine::Wrap::repeat);
}

// The KHR_texture_transform of a use of a texture: offset + rotation * scale * uv.
void read_transform(const std::string& extensions, engine::MaterialTexture& texture) {
    if (extensions.empty()) return;
    const auto json = nlohmann::json::parse(extensions, nullptr, false);
    const auto at = json.is_object() ? json.find("KHR_texture_transform") : json.end();
    if (at == json.end() || !at->is_object()) return;
    const auto number = [](const nlohmann::json& from, double otherwise) {
        const double value = from.is_number() ? from.get<double>() : otherwise;
        return static_cast<float>(std::isfinite(value) && std::abs(value) < 1e6 ? value : otherwise);
    };
    const auto pair = [&](const char* key, double otherwise) {
        const auto list = at->find(key);
        const bool is_pair = list != at->end() && list->is_array() && list->size() == 2;
        return is_pair ? glm::vec2(number((*list)[0], otherwise), number((*list)[1], otherwise))
                       : glm::vec2(static_cast<float>(otherwise));
    };
    const glm::vec2 scale = pair("scale", 1.0);
    const auto rotation = at->find("rotation");
    const float turn = rotation != at->end() ? number(*rotation, 0.0) : 0.0f;
    const float c = std::cos(turn), s = std::sin(turn);
    texture.turn = glm::mat2(c * scale.x, -s * scale.x, s * scale.y, c * scale.y); // columns
    texture.offset = pair("offset", 0.0);
}

// The textures of one stack, each image once.
class Layers {
  public:
    Layers(const Model& model, std::vector<std::string>& notes) : model_(model), notes_(notes) {}

    std::optional<engine::MaterialTexture> use(const std::optional<TextureUse>& use) {
        if (!use || use->texture >= model_.textures.size()) return std::nullopt;
        const fracture::Texture& texture = model_.textures[use->texture];
        if (!texture.image || *texture.image >= model_.images.size()) return std::nullopt;
        const Image& image = model_.images[*texture.image];
        const std::optional<uint32_t> layer = layer_of(image, "image " + std::to_string(*texture.image));
        if (!layer) return std::nullopt;
        engine::MaterialTexture made{
            .layer = *layer, .wrap_u = wrap_of(texture.wrap_s), .wrap_v = wrap_of(texture.wrap_t)};
        read_transform(use->extensions, made);
        return made;
    }

    std::optional<uint32_t> layer_of(const Image& image, const std::string& name) {
        const auto known = known_.find(&image);
        if (known != known_.end()) return known->second;
        std::optional<uint32_t>& layer = known_[&image];
        const std::string shown = image.name.empty() ? name : name + " " + fracture::quoted(image.name);
        if (image.mime_type.empty()) return layer; // the reader has a note about it
        if (image.mime_type != "image/png" && image.mime_type != "image/jpeg") {
            notes_.push_back(shown + " is drawn as a plain colour: pictures show PNG and JPEG textures, and this is "
                             + image.mime_type);
            return layer;
        }
        engine::Result<engine::Bitmap> decoded = engine::decode_image(image.bytes, max_pixels);
        if (!decoded) {
            notes_.push_back(shown + " is drawn as a plain colour: " + decoded.error().message);
            return layer;
        }
        layer = static_cast<uint32_t>(images_.size());
        images_.push_back(*std::move(decoded));
        return layer;
    }

    [[nodiscard]] engine::TextureStack stack(bool srgb) const {
        return engine::TextureStack::of(images_, {.srgb = srgb});
    }

  private:
    const Model& model_;
    std::vector<std::string>& notes_;
    std::map<const Image*, std::optional<uint32_t>> known_;
    std::vector<engine::Bitmap> images_;
};

engine::Opacity opacity_of(fracture::AlphaMode mode) {
    switch (mode) {
    case fracture::AlphaMode::opaque:
        return engine::Opacity::opaque;
    case fracture::AlphaMode::mask:
        return engine::Opacity::mask;
    case fracture::AlphaMode::blend:
        return engine::Opacity::blend;
    }
    return engine::Opacity::opaque;
}

// Returns the colour with channels of 0 to 1; those that are no number become 1.
glm::vec4 sound(glm::vec4 colour) {
    for (int k = 0; k < 4; ++k) colour[k] = std::isfinite(colour[k]) ? glm::clamp(colour[k], 0.0f, 1.0f) : 1.0f;
    return colour;
}

// sRGB with opacity.
uint32_t packed(const glm::vec4& linear) {
    const auto byte = [](float value) { return static_cast<uint32_t>(std::lround(255.0f * value)); };
    const auto srgb = [&](float value) { return byte(static_cast<float>(fracture::srgb_of_linear(double{value}))); };
    return srgb(linear.x) | srgb(linear.y) << 8 | srgb(linear.z) << 16 | byte(linear.w) << 24;
}

void turn_corners(auto& list) {
    for (size_t t = 0; t + 2 < list.size(); t += 3) std::swap(list[t + 1], list[t + 2]);
}

} // namespace

std::shared_ptr<const engine::MaterialSet> materials_of(const Model& model, std::vector<std::string>& notes,
                                                        const Image* cuts) {
    const bool of_mesh = has_looks(model);
    if (!of_mesh && !cuts) return nullptr;
    auto set = std::make_shared<engine::MaterialSet>();
    Layers base(model, notes), normals(model, notes);
    if (of_mesh) {
        for (const fracture::Material& material : model.materials) {
            engine::MeshMaterial made{.colour = material.base_colour,
                                      .opacity = opacity_of(material.alpha_mode),
                                      .cutoff = static_cast<float>(material.alpha_cutoff),
                                      .base_colour = base.use(material.base_colour_texture),
                                      .normal_map = normals.use(material.normal_texture)};
            if (material.normal_texture) made.normal_scale = static_cast<float>(material.normal_texture->strength);
            if (made.opacity == engine::Opacity::opaque) made.colour.w = 1.0f;
            set->materials.push_back(made);
        }
        set->materials.emplace_back(); // of vertex colours without a material
    }
    if (cuts) set->cuts = base.layer_of(*cuts, "the texture of fracture surfaces");
    set->base_colours = base.stack(true);
    set->normal_maps = normals.stack(false);
    return set;
}

std::shared_ptr<const MeshLooks> looks_of(const Model& model, const fracture::TriangleMesh& mesh,
                                          std::shared_ptr<const engine::MaterialSet> materials, bool turned) {
    if (!materials) return nullptr;
    auto looks = std::make_shared<MeshLooks>();
    looks->of_mesh = has_looks(model);
    looks->materials = std::move(materials);
    if (!looks->of_mesh) return looks;
    looks->mesh = mesh;
    looks->uv = model.uv;
    for (const glm::vec4& colour : model.colours) looks->colours.push_back(sound(colour));
    looks->material_of = model.material_of;
    if (turned) {
        for (auto& set : looks->uv) turn_corners(set);
        turn_corners(looks->colours);
    }
    for (const fracture::Material& material : model.materials) {
        const std::optional<TextureUse>& of =
            material.base_colour_texture ? material.base_colour_texture : material.normal_texture;
        looks->uv_set.push_back(of ? static_cast<uint8_t>(of->uv_set) : 0);
    }
    return looks;
}

std::array<engine::CornerLook, 3> MeshLooks::corners(uint32_t triangle, const std::array<glm::dvec3, 3>& points) const {
    std::array<engine::CornerLook, 3> made{};
    const uint32_t material = material_of.empty() ? fracture::no_material : material_of[triangle];
    if (material == fracture::no_material && colours.empty()) return made;
    const auto shown = static_cast<uint32_t>(material == fracture::no_material ? uv_set.size() : material);
    const auto& coordinates = uv[shown < uv_set.size() ? uv_set[shown] : 0];
    const fracture::Triangle& t = mesh.triangles[triangle];
    const std::array<glm::dvec3, 3> at{mesh.positions[t.x], mesh.positions[t.y], mesh.positions[t.z]};
    const bool is_plain = coordinates.empty() && colours.empty();
    for (size_t k = 0; k < 3; ++k) {
        made[k].material = 1 + shown;
        if (is_plain) continue;
        const glm::vec3 share(fracture::barycentrics(at, points[k]));
        const auto mixed = [&]<class T>(const std::vector<T>& list) {
            const T* of = &list[3 * size_t{triangle}];
            return share.x * of[0] + share.y * of[1] + share.z * of[2];
        };
        if (!coordinates.empty()) made[k].uv = mixed(coordinates);
        if (!colours.empty()) made[k].colour = packed(sound(mixed(colours)));
    }
    return made;
}

bool wants_looks(const PictureOptions& picture) {
    return picture.colours != PieceColours::pieces;
}

std::optional<Image> interior_image(const PictureOptions& picture) {
    if (picture.interior_texture.empty()) return std::nullopt;
    return must(fracture::read_image(picture.interior_texture));
}

std::shared_ptr<const MeshLooks> looks_for(const Model& model, const fracture::TriangleMesh& on_stage,
                                           const PictureOptions& picture, std::vector<std::string>& notes) {
    const std::optional<Image> cuts = interior_image(picture);
    if (!wants_looks(picture)) return nullptr;
    return looks_of(model, on_stage, materials_of(model, notes, cuts ? &*cuts : nullptr));
}

bool shows_materials(PieceColours colours, bool has_materials) {
    return colours == PieceColours::materials || (colours == PieceColours::automatic && has_materials);
}

} // namespace brittle::tools
