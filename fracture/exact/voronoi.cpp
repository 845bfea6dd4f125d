#include "fracture/exact/voronoi.h"

#include <algorithm>
#include <cmath>
#include <string>

#include "fracture/exact/diagram.h"
#include "fracture/exact/scene.h"

namespace brittle::fracture {

Result<VoronoiDiagram> voronoi_diagram(std::span<const glm::dvec3> sites, const Box& box, uint32_t threads,
                                       std::span<const double> weights) {
    const glm::dvec3 size = box.size();
    for (int k = 0; k < 3; ++k) {
        if (!std::isfinite(box.min[k]) || !std::isfinite(box.max[k]) || !(size[k] > 0.0) || !std::isfinite(size[k])) {
            return Error{Status::invalid_setting,
                         "the box of a Voronoi diagram must be finite and have a positive volume"};
        }
    }
    const double to_scene = exact::unit_scale(std::max({size.x, size.y, size.z}));
    std::vector<glm::dvec3> scaled;
    if (auto done = exact::scale_sites(sites, to_scene, scaled); !done) return done.error();
    std::vector<double> scaled_weights;
    if (!weights.empty() && weights.size() != sites.size())
        return Error{Status::invalid_setting, "there are " + std::to_string(weights.size()) + " weights for "
                                                  + std::to_string(sites.size()) + " sites"};
    if (auto done = exact::scale_weights(weights, to_scene, scaled_weights); !done) return done.error();
    const exact::Diagram problem{scaled, {box.min * to_scene, box.max * to_scene}, scaled_weights};
    Threads pool(threads);
    exact::DiagramBuilder builder;
    VoronoiDiagram diagram;
    builder.build(problem, pool, nullptr, diagram);
    for (VoronoiDiagram::Vertex& v : diagram.vertices) v.position /= to_scene;
    return diagram;
}

} // namespace brittle::fracture
