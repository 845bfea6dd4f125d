// Materials, textures and images of a GLB file: those of the source one for one, then what Brittle adds.
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

class GlbLooks {
  public:
    explicit GlbLooks(const ExportOptions& options);

    // The index of the material that the part is drawn with.
    [[nodiscard]] size_t material_of(const DrawnPart& part);

    // Writes the lists. `add_view` puts the bytes of an image into the file and gives the number of its buffer view.
    void add_to(nlohmann::ordered_json& document, std::set<std::string>& extensions_used,
                const std::function<size_t(std::vector<std::byte>)>& add_view) const;

  private:
    const ExportOptions& options_;
    size_t source_materials_;
    bool has_exterior_; // parts of the exterior may have none of the source's
};

} // namespace brittle::fracture
