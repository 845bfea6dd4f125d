#include <algorithm>
#include <cmath>
#include <map>

#include "fracture/io/readers.h"
#include "fracture/io/text_cursor.h"

namespace brittle::fracture {
namespace {

// A fault in a material gives a note, never an error: the mesh matters more.
class MtlReader {
  public:
    MtlReader(std::string_view text, Companions& companions, Model& model)
        : cursor_(text), companions_(companions), model_(model) {}

    void read() {
        const size_t first = model_.materials.size();
        while (!cursor_.at_end()) {
            const std::string_view keyword = cursor_.token();
            if (keyword == "newmtl") {
                model_.materials.push_back({.name = std::string(cursor_.rest_of_line())});
                has_material_ = true;
            } else if (has_material_) {
                read_property(keyword, model_.materials.back());
            }
            cursor_.next_line();
        }
        for (size_t k = first; k < model_.materials.size(); ++k) set_alpha_mode(model_.materials[k]);
    }

  private:
    // Nobody models what cannot be seen: MeshLab writes Tr 1 for a surface that is opaque.
    void set_alpha_mode(Material& material) {
        if (material.base_colour.w == 0.0) {
            add_note(model_.notes, "the material " + fracture::quoted(material.name)
                                       + " is fully transparent (d 0, or Tr 1); it is taken as opaque");
            material.base_colour.w = 1.0;
        }
        if (material.base_colour.w < 1.0) material.alpha_mode = AlphaMode::blend;
    }

    // Colours are linear, the convention of the modelling programs that write them.
    void read_property(std::string_view keyword, Material& material) {
        if (keyword == "Kd") {
            const glm::dvec3 colour = read_colour();
            material.base_colour = {colour, material.base_colour.w};
        } else if (keyword == "Ke") {
            material.emissive = read_colour();
        } else if (keyword == "d") {
            material.base_colour.w = read_share(material.base_colour.w);
        } else if (keyword == "Tr") {
            material.base_colour.w = 1.0 - read_share(1.0 - material.base_colour.w);
        } else if (keyword == "Ns") { // a Phong exponent; converted to the roughness of a lobe of equal width
            const double exponent = std::clamp(parse_number(cursor_.token()).value_or(0.0), 0.0, 1e6);
            material.roughness = std::sqrt(2.0 / (exponent + 2.0));
        } else if (keyword == "Pr") {
            material.roughness = read_share(material.roughness);
        } else if (keyword == "Pm") {
            material.metallic = read_share(material.metallic);
        } else if (keyword == "map_Kd") {
            material.base_colour_texture = read_texture();
        } else if (keyword == "map_Ke") {
            material.emissive_texture = read_texture();
            if (material.emissive == glm::dvec3(0.0)) material.emissive = glm::dvec3(1.0);
        } else if (keyword == "norm") {
            material.normal_texture = read_texture();
        }
    }

    double read_share(double otherwise) {
        const double value = parse_number(cursor_.token()).value_or(otherwise);
        return value >= 0.0 && value <= 1.0 ? value : otherwise;
    }

    glm::dvec3 read_colour() {
        glm::dvec3 colour(0.0);
        for (int k = 0; k < 3; ++k) colour[k] = read_share(k > 0 ? colour[k - 1] : 1.0);
        return colour;
    }

    // Options precede the name, each a word with a dash and its values. The name may contain blanks.
    std::optional<TextureUse> read_texture() {
        std::string_view name = cursor_.rest_of_line();
        double strength = 1.0;
        while (name.starts_with('-')) {
            TextCursor words(name);
            const std::string_view option = words.token();
            const auto next = [&] {
                words.token();
                return words.rest_of_line();
            };
            const size_t most = option == "-o" || option == "-s" || option == "-t" ? 3 : (option == "-mm" ? 2 : 1);
            name = words.rest_of_line();
            if (option == "-bm") strength = parse_number(TextCursor(name).token()).value_or(1.0);
            for (size_t k = 0; k < most; ++k) {
                if (k > 0 && !parse_number(TextCursor(name).token())) break; // the second and third value are optional
                name = next();
            }
        }
        if (name.empty()) return std::nullopt;
        const auto [known, is_new] = texture_named_.emplace(name, static_cast<uint32_t>(model_.textures.size()));
        if (is_new) {
            const auto bytes = companions_.read(std::string(name));
            const std::string type = bytes ? image_type(*bytes) : std::string();
            if (type.empty()) {
                add_note(model_.notes, "texture: "
                                           + (bytes ? quoted(name) + " is not a PNG or JPEG image and is left out"
                                                    : bytes.error().message));
                texture_named_.erase(known);
                return std::nullopt;
            }
            const auto next = static_cast<uint32_t>(model_.images.size());
            const auto [image, is_new_image] = image_at_.emplace(bytes->data(), next);
            model_.textures.push_back({.image = image->second});
            if (is_new_image)
                model_.images.push_back(
                    {std::filesystem::path(name).stem().string(), type, {bytes->begin(), bytes->end()}});
        }
        return TextureUse{.texture = known->second, .strength = strength};
    }

    TextCursor cursor_;
    Companions& companions_;
    Model& model_;
    std::map<std::string, uint32_t, std::less<>> texture_named_;
    std::map<const std::byte*, uint32_t> image_at_; // by content: a file can have several names, a.png and ./a.png
    bool has_material_ = false;
};

} // namespace

void read_mtl(std::string_view text, Companions& companions, Model& model) {
    MtlReader(text, companions, model).read();
}

} // namespace brittle::fracture
