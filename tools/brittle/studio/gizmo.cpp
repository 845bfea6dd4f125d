#include "tools/brittle/studio/gizmo.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <numbers>

#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <glm/gtc/matrix_transform.hpp>
#include <glm/matrix.hpp>
#include <glm/trigonometric.hpp>

namespace brittle::tools {

namespace {

constexpr float axis_length = 64.0f; // pixels
constexpr float ring_radius = 70.0f; // pixels
constexpr float axis_reach = 7.0f;   // pixels beside a handle
constexpr float middle_reach = 11.0f;
constexpr int ring_points = 64;
constexpr double facing = 0.85;     // cosine of the angle between axis and eye below which half of a ring is drawn
constexpr float min_way = 0.3f;     // share of a ring's radius: least motion of its point on the screen for a radian
constexpr double min_factor = 0.01; // of one drag
constexpr double place_steps = 1e9; // per metre: places are rounded, so that recipes stay legible

double rounded(double value, double step) {
    return std::round(value / step) * step;
}

glm::dvec3 tidy(const glm::dvec3& place) {
    return glm::round(place * place_steps) / place_steps + 0.0; // no -0
}

float distance_to_segment(glm::vec2 p, glm::vec2 a, glm::vec2 b) {
    const glm::vec2 along = b - a;
    const float length = glm::dot(along, along);
    const float t = length > 0.0f ? std::clamp(glm::dot(p - a, along) / length, 0.0f, 1.0f) : 0.0f;
    return glm::distance(p, a + t * along);
}

// The half of a ring that is near the eye; all of a ring that faces the eye.
std::vector<glm::vec2> ring_of(const GizmoFrame& frame, int axis, double radius, const Viewport& view) {
    const glm::dvec3 &u = frame.axes[(axis + 1) % 3], &v = frame.axes[(axis + 2) % 3];
    const glm::dvec3 to_eye = glm::dvec3(view.camera().eye) - frame.centre;
    const double towards = std::atan2(glm::dot(to_eye, v), glm::dot(to_eye, u));
    const bool faces = std::abs(glm::dot(to_eye, frame.axes[axis])) > facing * glm::length(to_eye);
    const int count = faces ? ring_points : ring_points / 2;
    std::vector<glm::vec2> points;
    for (int k = 0; k <= count; ++k) {
        const double angle = towards + 2.0 * std::numbers::pi * (k - count / 2) / ring_points;
        const glm::dvec3 at = frame.centre + radius * (std::cos(angle) * u + std::sin(angle) * v);
        if (const auto pixel = view.pixel(glm::vec3(at))) points.push_back(*pixel);
    }
    return points;
}

glm::dmat4 affine(const ObjectPlacement& placement) {
    glm::dmat4 whole(linear_part(placement));
    whole[3] = glm::dvec4(placement.translation, 1.0);
    return whole;
}

} // namespace

glm::dvec3 on_view_plane(const Ray& ray, const glm::dvec3& through, const Viewport& view) {
    const glm::dvec3 normal(view.forward());
    const double along = glm::dot(ray.direction, normal);
    return along > 1e-6 ? ray.from + glm::dot(through - ray.from, normal) / along * ray.direction : through;
}

glm::dvec3 on_axis(const Ray& ray, const glm::dvec3& at, const glm::dvec3& axis) {
    const glm::dvec3 to = at - ray.from;
    const double b = glm::dot(axis, ray.direction), d = 1.0 - b * b;
    if (d < 1e-6) return at; // the ray is parallel to the axis
    return at + (b * glm::dot(ray.direction, to) - glm::dot(axis, to)) / d * axis;
}

std::vector<GizmoLine> gizmo_shape(GizmoMode mode, const GizmoFrame& frame, const Viewport& view) {
    std::vector<GizmoLine> shape;
    const glm::vec3 centre(frame.centre);
    const auto from = view.pixel(centre);
    if (!from) return shape;
    const double metres = 1.0 / static_cast<double>(view.pixels_a_metre(centre));
    for (int axis = 0; axis < 3; ++axis) {
        if (mode == GizmoMode::turn) {
            shape.push_back({{mode, axis}, ring_of(frame, axis, double{ring_radius} * metres, view)});
        } else if (const auto to =
                       view.pixel(glm::vec3(frame.centre + double{axis_length} * metres * frame.axes[axis]))) {
            shape.push_back({{mode, axis}, {*from, *to}});
        }
    }
    if (mode != GizmoMode::turn) shape.push_back({{mode, 3}, {*from}});
    return shape;
}

std::optional<GizmoHandle> gizmo_handle_at(glm::vec2 pixel, const std::vector<GizmoLine>& shape) {
    std::optional<GizmoHandle> best;
    float nearest = axis_reach;
    for (const GizmoLine& line : shape) {
        if (line.points.size() == 1 && glm::distance(pixel, line.points[0]) <= middle_reach) return line.handle;
        for (size_t k = 1; k < line.points.size(); ++k) {
            const float distance = distance_to_segment(pixel, line.points[k - 1], line.points[k]);
            if (distance > nearest) continue;
            nearest = distance;
            best = line.handle;
        }
    }
    return best;
}

GizmoDrag::GizmoDrag(const GizmoHandle& handle, const GizmoFrame& frame, glm::vec2 pixel, const Viewport& view)
    : handle_(handle), frame_(frame), pressed_(pixel) {
    const Ray ray = view.ray(pixel);
    const glm::vec3 centre(frame.centre);
    const glm::vec2 middle = view.pixel(centre).value_or(pixel);
    if (handle.mode == GizmoMode::move) {
        start_ = handle.axis < 3 ? on_axis(ray, frame.centre, frame.axes[handle.axis])
                                 : on_view_plane(ray, frame.centre, view);
    } else if (handle.mode == GizmoMode::scale) {
        way_ = axis_length * glm::normalize(glm::vec2(1.0f, -1.0f)); // up and to the right is larger
        const glm::vec3 tip = centre
                              + axis_length / view.pixels_a_metre(centre)
                                    * (handle.axis < 3 ? glm::vec3(frame.axes[handle.axis]) : glm::vec3(0.0f));
        const auto end = view.pixel(tip);
        if (end && glm::distance(*end, middle) > 1.0f) way_ = axis_length * glm::normalize(*end - middle);
    } else { // the point of the ring under the mouse, and how it moves on the screen
        const glm::dvec3 axis = frame.axes[handle.axis];
        const double radius = static_cast<double>(ring_radius / view.pixels_a_metre(centre));
        const glm::dvec3 in_view = on_view_plane(ray, frame.centre, view) - frame.centre;
        const double along = glm::dot(ray.direction, axis);
        const double t = std::abs(along) > 0.15 ? glm::dot(frame.centre - ray.from, axis) / along : 0.0;
        glm::dvec3 arm = t > 0.0 ? ray.from + t * ray.direction - frame.centre : glm::dvec3(0.0);
        if (t <= 0.0) { // the ring is seen from its edge: its near side
            const glm::dvec3 to_eye = glm::normalize(glm::dvec3(view.camera().eye) - frame.centre);
            arm = in_view + std::sqrt(std::max(0.0, radius * radius - glm::dot(in_view, in_view))) * to_eye;
            arm -= glm::dot(arm, axis) * axis;
        }
        if (const double length = glm::length(arm); length > 0.0) arm *= radius / length;
        const glm::vec3 at(frame.centre + arm), beside(frame.centre + arm + 0.01 * glm::cross(axis, arm));
        const auto a = view.pixel(at), b = view.pixel(beside);
        if (a && b && *a != *b) {
            way_ = (*b - *a) / 0.01f;
            if (const float least = min_way * ring_radius, length = glm::length(way_); length < least)
                way_ *= least / length;
        }
    }
}

GizmoChange GizmoDrag::change(glm::vec2 cursor, const Viewport& view, bool snaps) const {
    GizmoChange change;
    const double share = static_cast<double>(glm::dot(cursor - pressed_, way_) / glm::dot(way_, way_));
    switch (handle_.mode) {
    case GizmoMode::move: {
        const Ray ray = view.ray(cursor);
        if (handle_.axis == 3) {
            change.move = on_view_plane(ray, start_, view) - start_;
            if (snaps)
                for (int k = 0; k < 3; ++k) change.move[k] = rounded(change.move[k], move_step);
            break;
        }
        const glm::dvec3 axis = frame_.axes[handle_.axis];
        const double by = glm::dot(on_axis(ray, frame_.centre, axis) - start_, axis);
        change.move = (snaps ? rounded(by, move_step) : by) * axis;
        break;
    }
    case GizmoMode::turn:
        change.turn = glm::degrees(share);
        change.turn = rounded(change.turn, snaps ? turn_step : 0.1); // a tenth of a degree is finer than a pixel
        break;
    case GizmoMode::scale: {
        double factor = std::max(1.0 + share, min_factor);
        factor = snaps ? std::max(rounded(factor, scale_step), scale_step) : rounded(factor, 0.001);
        if (handle_.axis == 3)
            change.factor = glm::dvec3(std::max(factor, min_factor));
        else
            change.factor[handle_.axis] = std::max(factor, min_factor);
        break;
    }
    }
    return change;
}

ObjectPlacement GizmoDrag::place(const ObjectPlacement& before, const GizmoChange& change) const {
    switch (handle_.mode) {
    case GizmoMode::move: {
        ObjectPlacement placement = before;
        placement.translation = tidy(before.translation + change.move);
        return placement;
    }
    case GizmoMode::turn:
        return turned(before, handle_.axis, change.turn, frame_.centre);
    case GizmoMode::scale:
        if (frame_.own || handle_.axis == 3) return scaled(before, change.factor, frame_.centre);
        return stretched(before, change.factor, frame_.centre).value_or(before);
    }
    return before;
}

std::string GizmoDrag::text(const GizmoChange& change) const {
    char text[96] = "";
    const glm::dvec3& by = change.move;
    if (handle_.mode == GizmoMode::move && handle_.axis < 3)
        std::snprintf(text, sizeof text, "%+.2f m", by[handle_.axis]);
    else if (handle_.mode == GizmoMode::move)
        std::snprintf(text, sizeof text, "%+.2f %+.2f %+.2f m", by.x, by.y, by.z);
    else if (handle_.mode == GizmoMode::turn)
        std::snprintf(text, sizeof text, "%+.0f\xc2\xb0", change.turn);
    else
        std::snprintf(text, sizeof text, "\xc3\x97 %.2f", change.factor[handle_.axis % 3]);
    return text;
}

ObjectPlacement turned(const ObjectPlacement& placement, int axis, double degrees, const glm::dvec3& about) {
    glm::dvec3 unit(0.0);
    unit[axis] = 1.0;
    const glm::dmat3 turn(glm::rotate(glm::dmat4(1.0), glm::radians(degrees), unit));
    ObjectPlacement result = placement;
    result.translation = tidy(about + turn * (placement.translation - about));
    bool adds = true; // rotations about later axes come after this one
    for (int later = axis + 1; later < 3; ++later) adds = adds && placement.rotation[later] == 0.0;
    if (adds) {
        result.rotation[axis] = std::remainder(placement.rotation[axis] + degrees, 360.0);
        return result;
    }
    ObjectPlacement bare{.rotation = placement.rotation};
    result.rotation = placement_of(glm::dmat4(turn * linear_part(bare))).value_or(bare).rotation;
    return result;
}

ObjectPlacement scaled(const ObjectPlacement& placement, const glm::dvec3& factor, const glm::dvec3& about) {
    ObjectPlacement result = placement;
    for (int k = 0; k < 3; ++k) {
        const double scale = placement.scale[k] * factor[k];
        result.scale[k] = std::copysign(std::clamp(std::abs(scale), min_scale, max_scale), scale);
    }
    const glm::dvec3 fixed = glm::inverse(linear_part(placement)) * (about - placement.translation);
    result.translation = tidy(about - linear_part(result) * fixed);
    return result;
}

std::optional<ObjectPlacement> stretched(const ObjectPlacement& placement, const glm::dvec3& factor,
                                         const glm::dvec3& about) {
    glm::dmat4 stretch = glm::translate(glm::dmat4(1.0), about);
    stretch = glm::translate(glm::scale(stretch, factor), -about);
    std::optional<ObjectPlacement> result = placement_of(stretch * affine(placement));
    if (result) result->translation = tidy(result->translation);
    return result;
}

} // namespace brittle::tools
