// The gizmo: handles on the screen, and the placements that dragging them gives.
#include "tools/brittle/studio/gizmo.h"

#include <cmath>
#include <random>

#include <doctest/doctest.h>
#include <glm/geometric.hpp>
#include <glm/gtc/matrix_transform.hpp>

using namespace brittle;
using namespace brittle::tools;

namespace {

Viewport view_from(const glm::vec3& eye, const glm::vec3& target = glm::vec3(0.0f)) {
    engine::Camera camera;
    camera.eye = eye;
    camera.target = target;
    return {camera, {800.0f, 600.0f}, {}, {800.0f, 600.0f}};
}

glm::dmat4 affine(const ObjectPlacement& placement) {
    glm::dmat4 all(linear_part(placement));
    all[3] = glm::dvec4(placement.translation, 1.0);
    return all;
}

double difference(const glm::dmat4& a, const glm::dmat4& b) {
    double most = 0.0;
    for (int c = 0; c < 4; ++c) most = std::max(most, glm::length(a[c] - b[c]));
    return most;
}

// The middle of a handle as drawn.
glm::vec2 grip(const GizmoLine& line) {
    return line.points.size() == 2 ? 0.3f * line.points[0] + 0.7f * line.points[1]
                                   : line.points[line.points.size() / 2];
}

} // namespace

TEST_CASE("gizmo: turns and scales are those of the matrices, whatever the placement") {
    std::mt19937 random(7);
    const auto number = [&](double low, double high) {
        return low + (high - low) * static_cast<double>(random()) / static_cast<double>(std::mt19937::max());
    };
    const auto three = [&](double low, double high) {
        return glm::dvec3(number(low, high), number(low, high), number(low, high));
    };
    for (int k = 0; k < 300; ++k) {
        CAPTURE(k);
        ObjectPlacement placement{three(-5, 5), three(-180, 180), glm::dvec3(0.0), three(0.1, 3)};
        if (k % 3 == 0) placement.rotation = {};
        if (k % 5 == 0) placement.scale.y *= -1.0; // mirrored
        if (k % 4 == 0) placement.shear = three(-0.5, 0.5);
        const glm::dvec3 about = three(-3, 3), factor = three(0.2, 4);
        const glm::dmat4 there = glm::translate(glm::dmat4(1.0), about), back = glm::translate(glm::dmat4(1.0), -about);
        const int axis = k % 3;
        glm::dvec3 unit(0.0);
        unit[axis] = 1.0;
        const double degrees = number(-400, 400);
        const glm::dmat4 rotation = glm::rotate(glm::dmat4(1.0), glm::radians(degrees), unit);
        CHECK(difference(affine(turned(placement, axis, degrees, about)), there * rotation * back * affine(placement))
              < 1e-7);
        CHECK(turned(placement, axis, degrees, about).scale == placement.scale);
        const auto stretch = stretched(placement, factor, about);
        REQUIRE(stretch);
        CHECK(difference(affine(*stretch), there * glm::scale(glm::dmat4(1.0), factor) * back * affine(placement))
              < 1e-5);
        const ObjectPlacement own = scaled(placement, factor, about);
        CHECK(own.rotation == placement.rotation);
        CHECK(glm::distance(own.scale, placement.scale * factor) < 1e-12);
        const glm::dvec4 local = glm::inverse(affine(placement)) * glm::dvec4(about, 1.0);
        CHECK(glm::distance(glm::dvec3(affine(own) * local), about) < 1e-7); // it stays in its place
    }
}

TEST_CASE("gizmo: angles about one axis add up, and stay within half a turn") {
    ObjectPlacement placement;
    for (int k = 0; k < 24; ++k) placement = turned(placement, 1, 15.0, glm::dvec3(0.0));
    CHECK(placement.rotation == glm::dvec3(0.0));
    placement = turned(placement, 1, 195.0, glm::dvec3(0.0));
    CHECK(placement.rotation == glm::dvec3(0.0, -165.0, 0.0));
    CHECK(turned(placement, 2, 90.0, glm::dvec3(0.0)).rotation == glm::dvec3(0.0, -165.0, 90.0));
}

TEST_CASE("gizmo: a scale stays within its limits") {
    ObjectPlacement thin;
    thin.scale = {min_scale, -min_scale, max_scale};
    const ObjectPlacement same = scaled(thin, {0.01, 0.01, 100.0}, glm::dvec3(0.0));
    CHECK(same.scale == thin.scale);
    CHECK_FALSE(stretched(thin, {0.01, 1.0, 1.0}, glm::dvec3(0.0)));
}

TEST_CASE("gizmo: there is none behind the eye, and handles are found where they are drawn") {
    CHECK(gizmo_shape(GizmoMode::move, {glm::dvec3(0.0, 0.0, 9.0)}, view_from({0.0f, 0.0f, 5.0f})).empty());
    for (const glm::vec3& eye : {glm::vec3(3.0f, 2.0f, 5.0f), glm::vec3(-4.0f, 1.0f, -2.0f)}) {
        const Viewport view = view_from(eye);
        for (const GizmoMode mode : {GizmoMode::move, GizmoMode::turn, GizmoMode::scale}) {
            const auto shape = gizmo_shape(mode, {}, view);
            CHECK(shape.size() == (mode == GizmoMode::turn ? 3 : 4));
            for (const GizmoLine& line : shape) CHECK(gizmo_handle_at(grip(line), shape) == line.handle);
            CHECK_FALSE(gizmo_handle_at({10.0f, 10.0f}, shape));
        }
    }
}

TEST_CASE("gizmo: what is dragged follows the mouse, and Ctrl makes steps") {
    for (const glm::vec3& eye :
         {glm::vec3(3.0f, 2.0f, 5.0f), glm::vec3(-4.0f, 1.0f, -2.0f), glm::vec3(0.4f, 6.0f, 1.0f)}) {
        const Viewport view = view_from(eye);
        const GizmoFrame frame{glm::dvec3(0.1, 0.2, -0.1)};
        for (int axis = 0; axis < 3; ++axis) {
            CAPTURE(axis);
            const auto moves = gizmo_shape(GizmoMode::move, frame, view);
            const GizmoLine& arrow = moves[static_cast<size_t>(axis)];
            const GizmoDrag move(arrow.handle, frame, grip(arrow), view);
            CHECK(glm::length(move.change(grip(arrow), view, false).move) < 1e-6);
            // The pixel of a point that is moved by 0.47 m along the axis.
            glm::dvec3 by(0.0);
            by[axis] = 0.47;
            const Ray ray = view.ray(grip(arrow));
            const glm::dvec3 on = on_axis(ray, frame.centre, by / 0.47);
            const glm::vec2 to = *view.pixel(glm::vec3(on + by));
            CHECK(glm::distance(move.change(to, view, false).move, by) < 0.03);
            CHECK(move.change(to, view, true).move[axis] == doctest::Approx(0.5));
            CHECK(move.text(move.change(to, view, true)) == "+0.50 m");

            const auto rings = gizmo_shape(GizmoMode::turn, frame, view);
            const GizmoLine& ring = rings[static_cast<size_t>(axis)];
            const size_t middle = ring.points.size() / 2;
            const GizmoDrag turn(ring.handle, frame, ring.points[middle], view);
            // Two points of the ring are 11.25 degrees apart, one towards and one against its angle.
            const double ahead = turn.change(ring.points[middle + 2], view, false).turn;
            const double behind = turn.change(ring.points[middle - 2], view, false).turn;
            CHECK(ahead == doctest::Approx(11.25).epsilon(0.1));
            CHECK(behind == doctest::Approx(-11.25).epsilon(0.1));
            CHECK(turn.change(ring.points[middle + 2], view, true).turn == 15.0);

            const auto scales = gizmo_shape(GizmoMode::scale, frame, view);
            const GizmoLine& handle = scales[static_cast<size_t>(axis)];
            const GizmoDrag scale(handle.handle, frame, handle.points[1], view);
            const glm::vec2 way = glm::normalize(handle.points[1] - handle.points[0]);
            const GizmoChange twice = scale.change(handle.points[1] + 64.0f * way, view, false);
            for (int k = 0; k < 3; ++k) CHECK(twice.factor[k] == doctest::Approx(k == axis ? 2.0 : 1.0));
            CHECK(scale.change(handle.points[1] + 30.0f * way, view, true).factor[axis] == doctest::Approx(1.5));
            CHECK(scale.change(handle.points[1] - 900.0f * way, view, true).factor[axis] == doctest::Approx(0.1));
            CHECK(scale.change(handle.points[1] - 900.0f * way, view, false).factor[axis] > 0.0);
        }
    }
}

TEST_CASE("gizmo: a ring seen from its edge and an axis towards the eye give finite changes") {
    const Viewport view = view_from({0.0f, 0.0f, 5.0f});
    for (const GizmoMode mode : {GizmoMode::move, GizmoMode::turn, GizmoMode::scale})
        for (int axis = 0; axis < (mode == GizmoMode::turn ? 3 : 4); ++axis) {
            const GizmoDrag drag({mode, axis}, {}, {400.0f, 300.0f}, view);
            for (const glm::vec2 to : {glm::vec2(400.0f, 300.0f), glm::vec2(500.0f, 200.0f), glm::vec2(-9e3f, 9e3f)}) {
                const ObjectPlacement placed = drag.place({}, drag.change(to, view, false));
                for (int k = 0; k < 3; ++k) {
                    CHECK(std::abs(placed.translation[k]) < 1e4);
                    CHECK(std::abs(placed.rotation[k]) <= 180.0);
                    CHECK(placed.scale[k] > 0.0);
                    CHECK(placed.scale[k] < 1e4);
                }
            }
        }
}
