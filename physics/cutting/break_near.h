// Breaks a large solid where a blow reaches it, and leaves the rest alone.
//
// Only the triangles near the blow are cut (fracture/local/local_cut.h). The rest keeps its other clusters, and the
// hulls that the blow does not reach (remaining_parts.h). Its mass follows from the exchanged triangles.
#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <span>
#include <vector>

#include <glm/vec3.hpp>

#include "physics/cutting/solid_piece.h"

namespace brittle::physics {

// The result of break_solid(), for a solid with clusters. Nothing where the whole solid must be cut: it has no
// clusters, the cells reach over most of it, or it falls apart far from the blow. The wavelength of rough cuts must not
// be 0.
[[nodiscard]] std::optional<std::vector<SolidPtr>>
break_near(const SolidPiece& solid, std::span<const glm::dvec3> sites, std::span<const uint32_t> groups,
           const fracture::Roughness& rough, const SolidSettings& settings, const std::function<bool()>& cancelled,
           CrackBudget* budget);

} // namespace brittle::physics
