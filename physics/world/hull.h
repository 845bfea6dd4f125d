// The collision hull of a piece: a small convex point set that stays inside the piece's own convex hull.
//
// Bullet adds a collision margin outside a convex hull: two pieces that share a face would overlap by two
// margins at birth and push each other apart. So the hull's planes are moved inwards by the margin first, and
// hull + margin is inside the convex hull of the piece. Pieces of different Voronoi cells are therefore never in each
// other's way at birth: each lies in its cell, which is convex, and so does its hull. Two islands of one cell may be, and
// so may pieces from elsewhere; the world moves such pairs apart gently (WorldSettings::separation_speed).
//
// Points are relative to an origin that the caller names, usually the centre of mass. Metres. Thread-safe: no
// state.
//
//     CollisionHull hull = collision_hull(fragments.positions_of(piece), piece.mass.centre_of_mass);
#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <utility>
#include <vector>

#include <glm/vec3.hpp>

#include "fracture/mesh/mesh.h"
#include "fracture/pieces/fragments.h"
#include "physics/world/cross_section.h"

namespace brittle::physics {

struct HullSettings {
    // Upper bound on the vertices of a hull, at least 8. The cost of a pair of hulls grows linearly with it;
    // below about 16, pieces visibly rock on corners that they do not have.
    uint32_t max_vertices = 32;
    // Pieces whose longest extent is below this, m, have at most so many vertices, at least 8: nobody sees them rock.
    float crumb_size = 0.03f;
    uint32_t crumb_vertices = 12;
    // Collision margin as a fraction of the thinnest extent of the piece. The margin rounds sharp corners off
    // by a few times its size. Overlap beyond it takes Bullet's slow path. Clamped to 0.001 .. 0.45.
    float margin_fraction = 0.02f;
    // Upper bound of the margin in metres; at least a micrometre.
    float max_margin = 0.01f;
};

struct CollisionHull {
    std::vector<glm::vec3> points{}; // at least 4, not coplanar, relative to the origin
    float margin = 0.0f;             // metres, > 0; what Bullet adds around the points
    // What the air meets of it, margin included. Where it is not known it is found from the points when that becomes a body,
    // which takes longer than all else of it. Who turns the points by hand must turn its sides, too, or take them out.
    CrossSection section{};
};

// The reduced and shrunk convex hull of points, relative to origin. Where a bounded vertex count forces a
// choice, always the point is kept that sticks out farthest of those kept before, so the result is inside the
// full hull and little of that outside of the result: of pieces of a Voronoi fracture and 32 vertices half a hundredth of
// their length, 3 hundredths at worst, most of it corners that the margin rounds off.
//
// Degenerate input has a result too, as every piece needs a body: coplanar, collinear, coincident or no
// points give the corners of a thin box around them; only there may hull + margin reach outside, by a
// ten-thousandth of the extent (or a tenth of a millimetre where the extent is zero). Non-finite points are
// ignored: check before calling if that matters.
[[nodiscard]] CollisionHull collision_hull(std::span<const glm::dvec3> points, glm::dvec3 origin,
                                           const HullSettings& settings = {});

// One hull a piece of the fragments, in their order, each relative to the piece's centre of mass: nearly all of what making
// bodies costs, and all of it that may be done ahead and on any thread. Hulls are made side by side on so many threads
// (0: one a core); the result does not depend on it.
using PieceHulls = std::vector<std::shared_ptr<const CollisionHull>>;
[[nodiscard]] PieceHulls collision_hulls(const fracture::Fragments& fragments, const HullSettings& settings = {},
                                         uint32_t threads = 0);

// An edge of a hull: two indices into its points, the lower one first.
using HullEdge = std::pair<uint32_t, uint32_t>;

// The edges of the convex hull of points, each once, for drawing; those inside a flat face (below 3 degrees)
// are left out. Fewer than 4 points, or flat ones, may give none.
[[nodiscard]] std::vector<HullEdge> hull_edges(std::span<const glm::vec3> points);

// What the air meets of the convex hull of points; of those that span no volume, of the box around them.
[[nodiscard]] CrossSection cross_section(std::span<const glm::vec3> points);

// The convex hull of points as a closed mesh, triangles outwards. Fewer than 4 points, or flat ones, may give none.
[[nodiscard]] fracture::TriangleMesh hull_mesh(std::span<const glm::vec3> points);

} // namespace brittle::physics
