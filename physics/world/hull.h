// The collision hull of a piece: a small convex point set inside the piece's own convex hull.
//
// The collision margin adds a shell around a convex hull: two pieces that share a face would overlap by two margins at
// birth and push each other apart. The hull's planes are therefore moved inwards by the margin, so that hull + margin
// lies inside the convex hull of the piece. Pieces of different Voronoi cells never overlap at birth: each lies in its
// cell, which is convex, and so does its hull. Rough pieces reach a little into each other's cells; their hulls are cut
// along the mean plane of each contact (contact_planes()). Two islands of one cell, and pieces from elsewhere, may
// overlap; the world separates such pairs slowly (WorldSettings::separation_speed).
//
// Points are relative to an origin that the caller passes, usually the centre of mass. Metres. Pure functions;
// thread-safe.
//
//     CollisionHull hull = collision_hull(fragments.positions_of(piece), piece.mass.centre_of_mass);
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <utility>
#include <vector>

#include <glm/gtc/quaternion.hpp>
#include <glm/vec3.hpp>

#include "fracture/mesh/mesh.h"
#include "fracture/pieces/fragments.h"
#include "physics/world/cross_section.h"

namespace brittle::physics {

// A plane that a hull must not pass: normal . x <= distance, with x in the coordinates of the points, m.
struct HullPlane {
    glm::dvec3 normal{0.0}; // unit
    double distance = 0.0;
};

struct HullSettings {
    // Upper bound of a hull's vertex count, at least 8. The cost of a pair of hulls grows linearly with it. Below
    // about 16, pieces visibly rock on corners that they lack.
    uint32_t max_vertices = 32;
    // Pieces with a longest extent below crumb_size, m, get at most crumb_vertices vertices, at least 8: their rocking
    // is invisible.
    float crumb_size = 0.03f;
    uint32_t crumb_vertices = 12;
    // Collision margin as a fraction of the thinnest extent of the piece, clamped to 0.001 .. 0.45. The margin rounds
    // sharp corners off by a few times its size. An overlap beyond it takes the slow path of the narrow phase.
    float margin_fraction = 0.02f;
    // Upper bound of the margin, m; at least a micrometre.
    float max_margin = 0.01f;
    // The hull is cut along these planes, except where that would take more than a quarter of its length. The caller
    // keeps them; collision_hulls() sets its own.
    std::span<const HullPlane> planes{};
};

// The faces of a convex hull: convex polygons, each a loop of indices into the points, counter-clockwise seen from
// outside. Contacts between two hulls are clipped from their faces.
struct HullFaces {
    std::vector<uint16_t> corners{}; // of all faces, face by face
    std::vector<uint16_t> ends{};    // by face: the end of its corners; the next face begins there

    [[nodiscard]] size_t count() const { return ends.size(); }
    [[nodiscard]] size_t begin_of(size_t face) const { return face == 0 ? 0 : ends[face - 1]; }
    [[nodiscard]] std::span<const uint16_t> of(size_t face) const {
        return std::span(corners).subspan(begin_of(face), ends[face] - begin_of(face));
    }
};

struct SurfaceFacet; // surface_parts.h

struct CollisionHull {
    std::vector<glm::vec3> points{}; // at least 4, not coplanar, relative to the origin
    float margin = 0.0f;             // m, > 0; thickness of the collision shell around the points
    // If empty, they are computed from the points when the hull becomes a body, which takes longer than the rest of
    // that. They stay valid when the points are moved, rotated or scaled together.
    HullFaces faces{};
    // Shadow area for air drag, margin included. If empty, it is computed from the points when the hull becomes a
    // body, which takes longer than the rest of that. Code that transforms the points must transform the sides or
    // clear them.
    CrossSection section{};
    std::shared_ptr<const SurfaceFacet> facet{}; // null for the hull of a solid
};

// Returns the reduced and shrunk convex hull of points, relative to origin. Where max_vertices forces a choice, the
// next vertex is always the point farthest outside the hull of the chosen ones, so the result lies inside the full
// hull. Pieces of a Voronoi fracture at 32 vertices lose half a hundredth of their length, 3 hundredths at worst,
// mostly corners that the margin rounds off.
//
// Degenerate input has a result too, as every piece needs a body: coplanar, collinear, coincident or no points give
// the corners of a thin box around them. Only there may hull + margin reach outside, by a ten-thousandth of the extent
// (a tenth of a millimetre where the extent is zero). Non-finite points are ignored: check before calling if that
// matters.
[[nodiscard]] CollisionHull collision_hull(std::span<const glm::dvec3> points, glm::dvec3 origin,
                                           const HullSettings& settings = {});

// Returns what of a hull lies behind a plane, in the hull's coordinates and with its margin: hull + margin stays behind
// the plane. Corners away from the plane stay where they are, so a hull that is cut many times does not shrink. Nothing
// where no more than a flake is left.
[[nodiscard]] std::optional<CollisionHull> cut_hull(const CollisionHull& hull, const HullPlane& plane,
                                                    const HullSettings& settings = {});

// Returns the hull of a solid, turned about the origin of its points.
[[nodiscard]] CollisionHull turned(const CollisionHull& hull, const glm::dquat& turn);

// Returns, per piece, the mean plane of each of its contacts. The hulls of two pieces with a contact, cut along these
// planes, do not overlap. Those of flat cuts cut nothing off. A bond to a missing piece or without area gives no plane.
[[nodiscard]] std::vector<std::vector<HullPlane>> contact_planes(const fracture::Fragments& fragments);

// Returns one hull per piece, in the order of the fragments, relative to the piece's centre of mass, and cut along the
// planes of its contacts. This is nearly the whole cost of making bodies and may run ahead of time on any thread. It
// uses `threads` threads (0: one a core); the result does not depend on their number.
using PieceHulls = std::vector<std::shared_ptr<const CollisionHull>>;
[[nodiscard]] PieceHulls collision_hulls(const fracture::Fragments& fragments, const HullSettings& settings = {},
                                         uint32_t threads = 0);

// An edge of a hull: two indices into its points, the lower one first.
using HullEdge = std::pair<uint32_t, uint32_t>;

// Returns the edges of the convex hull of points, each once, for drawing. Edges between faces that enclose less than 3
// degrees are left out. Fewer than 4 points, or coplanar ones, may give none.
[[nodiscard]] std::vector<HullEdge> hull_edges(std::span<const glm::vec3> points);

// Returns the faces of the convex hull of points. Faces that enclose less than 3 degrees with a larger one, and lie in
// its plane to 2 thousandths of the hull's extent, belong to that face; corners in the middle of a straight edge are
// left out. Fewer than 4 points, coplanar ones, or more than 65,535, give none.
[[nodiscard]] HullFaces hull_faces(std::span<const glm::vec3> points);

// Returns the planes of a hull's faces, moved outwards by `beyond`; `offset` moves all. Faces without area have none.
[[nodiscard]] std::vector<HullPlane> face_planes(const CollisionHull& hull, double beyond, const glm::dvec3& offset);

// Returns the cross section of the convex hull of points, or of their bounding box if they span no volume.
[[nodiscard]] CrossSection cross_section(std::span<const glm::vec3> points);

} // namespace brittle::physics
