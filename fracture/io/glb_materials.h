// Writes the materials, textures and images of a GLB file: those of the source with unchanged indices, then Brittle's
// own.
#pragma once

#include <cstddef>
#include <functional>
#include <set>
#include <string>
#include <vector>

#include <nlohmann/json.hpp>

#include "fracture/io/export.h"
#include "fracture/io/piece_surface.h"

namespace brittle::fracture {

class GlbMaterials {
  public:
    explicit GlbMaterials(const ExportOptions& options);

    // The index of the material of the part.
    [[nodiscard]] size_t material_of(const DrawnPart& part);

    // Adds the lists to the document. `add_view` stores the bytes of an image in the file and returns the index of its
    // buffer view.
    void add_to(nlohmann::ordered_json& document, std::set<std::string>& extensions_used,
                const std::function<size_t(std::vector<std::byte>)>& add_view) const;

  private:
    const ExportOptions& options_;
    size_t source_materials_;
    bool has_exterior_; // some part of the exterior may have no source material
};

} // namespace brittle::fracture
