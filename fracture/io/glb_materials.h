// Writes the materials, textures and images of a GLB file: those of the source with unchanged indices, then Brittle's
// own. Several objects share a file if their sources have no materials, textures or images.
#pragma once

#include <cstddef>
#include <functional>
#include <list>
#include <set>
#include <string>
#include <vector>

#include <nlohmann/json.hpp>

#include "fracture/io/export.h"
#include "fracture/io/piece_surface.h"

namespace brittle::fracture {

class GlbMaterials {
  public:
    // Sets whose materials those of the next parts are. The source outlives this object.
    void use(const ExportOptions& options);

    // The index of the material of the part.
    [[nodiscard]] size_t material_of(const DrawnPart& part) const;

    // Adds the lists to the document. `add_view` stores the bytes of an image in the file and returns the index of its
    // buffer view.
    void add_to(nlohmann::ordered_json& document, std::set<std::string>& extensions_used,
                const std::function<size_t(std::vector<std::byte>)>& add_view) const;

  private:
    using Json = nlohmann::ordered_json;
    size_t sampler_of(const Texture& texture);
    size_t interior_texture(const Image& image);

    // Materials of Brittle's own that objects share: where an exterior may have no source material it, then the interior.
    struct Own {
        Json materials;
        size_t first; // index in the file
    };

    std::vector<Own> own_;
    size_t first_own_ = 0;      // of the object in use
    bool has_exterior_ = false; // some part of the exterior may have no source material
    Json materials_ = Json::array(), textures_ = Json::array(), samplers_ = Json::array();
    std::vector<const Image*> images_;
    std::list<Image> interior_images_;
    std::set<std::string> extensions_;
};

} // namespace brittle::fracture
