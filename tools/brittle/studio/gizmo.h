// The gizmo on the selected objects of a scene: arrows that move, rings that turn, handles that scale. Computes handles
// on the screen, and the placements of objects while the mouse drags a handle. Pixels count from the top left.
//
//     if (auto handle = gizmo_handle_at(pixel, gizmo_shape(mode, frame, view)))
//         drag.emplace(*handle, frame, pixel, view);
//     each frame: placement = drag->place(before, drag->change(cursor, view, snaps));
//
// A drag counts from where it began, so that steps do not add up their rounding.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include <glm/mat3x3.hpp>
#include <glm/vec2.hpp>
#include <glm/vec3.hpp>

#include "tools/brittle/studio/viewport.h"
#include "tools/scenario/recipe/placement.h"

namespace brittle::tools {

enum class GizmoMode { move, turn, scale };

struct GizmoHandle {
    GizmoMode mode = GizmoMode::move;
    int axis = 0; // 0, 1, 2; 3: the handle in the middle, which moves in the plane of the view, or scales evenly

    friend bool operator==(const GizmoHandle&, const GizmoHandle&) = default;
};

struct GizmoFrame {
    glm::dvec3 centre{0.0};
    glm::dmat3 axes{1.0}; // unit columns; those of the world, but a single object is scaled along its own
    bool own = false;     // the axes are an object's own
};

// Steps while Ctrl is held.
inline constexpr double move_step = 0.1, turn_step = 15.0, scale_step = 0.1; // m, degrees, factor

// A handle as drawn: a line of two points for an axis, of one for the middle, or a ring, of which half is behind.
struct GizmoLine {
    GizmoHandle handle;
    std::vector<glm::vec2> points;
};
// Empty where the centre is behind the eye. `turn` has no handle in the middle.
[[nodiscard]] std::vector<GizmoLine> gizmo_shape(GizmoMode mode, const GizmoFrame& frame, const Viewport& view);
[[nodiscard]] std::optional<GizmoHandle> gizmo_handle_at(glm::vec2 pixel, const std::vector<GizmoLine>& shape);

// The nearest point of an axis, with a unit direction, to a ray; `at` where they are parallel.
[[nodiscard]] glm::dvec3 on_axis(const Ray& ray, const glm::dvec3& at, const glm::dvec3& axis);
// The intersection of a ray with the plane through a point that faces the eye; the point itself where there is none.
[[nodiscard]] glm::dvec3 on_view_plane(const Ray& ray, const glm::dvec3& through, const Viewport& view);

// What a drag does in all.
struct GizmoChange {
    glm::dvec3 move{0.0};   // m
    double turn = 0.0;      // degrees
    glm::dvec3 factor{1.0}; // along the axes of the frame
};

class GizmoDrag {
  public:
    GizmoDrag(const GizmoHandle& handle, const GizmoFrame& frame, glm::vec2 pixel, const Viewport& view);

    [[nodiscard]] GizmoChange change(glm::vec2 cursor, const Viewport& view, bool snaps) const;
    [[nodiscard]] ObjectPlacement place(const ObjectPlacement& before, const GizmoChange& change) const;
    [[nodiscard]] std::string text(const GizmoChange& change) const; // for people: "0.30 m", "15\u00b0", "x 1.20"
    [[nodiscard]] const GizmoHandle& handle() const { return handle_; }

  private:
    GizmoHandle handle_;
    GizmoFrame frame_;
    glm::vec2 pressed_;
    glm::dvec3 start_{0.0};     // the point that was pressed, on the axis or the plane
    glm::vec2 way_{1.0f, 0.0f}; // pixels across the screen for a factor of 2, or for a radian
};

// The placement turned about an axis of the world through a point. Angles that can be added are added.
[[nodiscard]] ObjectPlacement turned(const ObjectPlacement& placement, int axis, double degrees,
                                     const glm::dvec3& about);
// The placement with its own scale multiplied; `about` keeps its place.
[[nodiscard]] ObjectPlacement scaled(const ObjectPlacement& placement, const glm::dvec3& factor,
                                     const glm::dvec3& about);
// The placement stretched along the axes of the world, with shear where it is turned; nothing where a scale would leave
// its limits.
[[nodiscard]] std::optional<ObjectPlacement> stretched(const ObjectPlacement& placement, const glm::dvec3& factor,
                                                       const glm::dvec3& about);

} // namespace brittle::tools
