// Writes the materials, textures and images of a GLB file: those of the source with unchanged indices, then Brittle's
// own. Of several objects, the sources of all but the first add what their triangles use, unless it is already there.
#pragma once

#include <cstddef>
#include <functional>
#include <list>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include <nlohmann/json.hpp>

#include "fracture/io/export.h"
#include "fracture/io/piece_surface.h"

namespace brittle::fracture {

class GlbMaterials {
  public:
    // Sets whose materials those of the next parts are. The images of the source outlive this object.
    void use(const ExportOptions& options);

    // The index of the material of the part.
    [[nodiscard]] size_t material_of(const DrawnPart& part) const;

    // Adds the lists to the document. `add_view` stores the bytes of an image in the file and returns the index of its
    // buffer view.
    void add_to(nlohmann::ordered_json& document, std::set<std::string>& extensions_used,
                const std::function<size_t(std::vector<std::byte>)>& add_view) const;

  private:
    using Json = nlohmann::ordered_json;
    // The source in use. Lists by the indices of the source: the index in the file, or `unknown`.
    struct Source {
        const Model* model = nullptr;
        const std::vector<Image>* images = nullptr;
        bool is_first = false; // keeps its indices
        std::vector<size_t> image_at{}, texture_at{}, material_at{};
    };
    size_t image_of(size_t image);
    size_t texture_of(size_t texture);
    size_t source_material_of(size_t material);
    // Returns the index of the value, which is appended where the list does not have it; the first source appends all.
    size_t add_to_list(Json& list, Json value) const;
    void use_source(const ExportOptions& options);
    size_t sampler_of(const Texture& texture);
    size_t interior_texture(const Image& image);

    // Returns the index of a material of Brittle's own, which objects share.
    size_t own_material(Json material);

    std::vector<size_t> own_{}; // indices in the file of Brittle's own materials
    // Of the object in use: where a part of the exterior has no source material, and of the interior.
    size_t exterior_ = 0, interior_ = 0;
    Json materials_ = Json::array(), textures_ = Json::array(), samplers_ = Json::array();
    std::vector<const Image*> images_;
    std::list<Image> interior_images_;
    std::vector<std::pair<const Image*, size_t>> interior_textures_;
    Source source_;
    std::set<std::string> extensions_;
};

} // namespace brittle::fracture
