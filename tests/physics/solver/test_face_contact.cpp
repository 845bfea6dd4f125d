// The intersection of two facing faces: degenerate hulls, known pairs, and random pairs against polygons in double.
#include "physics/solver/face_contact.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <span>
#include <vector>

#include <doctest/doctest.h>
#include <glm/geometric.hpp>
#include <glm/gtc/quaternion.hpp>
#include <glm/vec2.hpp>

#include "physics/world/hull.h"
#include "tests/physics/convex_pieces.h"

using namespace brittle;
using namespace brittle::physics;

namespace {

const glm::vec3 up(0.0f, 1.0f, 0.0f);
constexpr float tolerance = 1e-4f;

HullShape shape_of(const std::vector<glm::vec3>& points) {
    return {points, 0.0f, hull_faces(points)};
}

std::vector<glm::vec3> box_corners(const glm::vec3& half) {
    std::vector<glm::vec3> corners;
    for (int i = 0; i < 8; ++i) corners.push_back(half * glm::vec3(i & 1 ? 1 : -1, i & 2 ? 1 : -1, i & 4 ? 1 : -1));
    return corners;
}
HullShape box_of(const glm::vec3& half) {
    return shape_of(box_corners(half));
}

// A prism around the y axis, one unit high, with corners at a distance of 1 from the axis.
HullShape prism(int sides) {
    std::vector<glm::vec3> corners;
    for (int i = 0; i < sides; ++i) {
        const float angle = 2.0f * std::numbers::pi_v<float> * static_cast<float>(i) / static_cast<float>(sides);
        for (const float y : {-0.5f, 0.5f}) corners.emplace_back(std::cos(angle), y, std::sin(angle));
    }
    return shape_of(corners);
}

glm::mat3 turned(float angle, const glm::vec3& axis) {
    return matrix_of(glm::angleAxis(angle, glm::normalize(axis)));
}

// The points of a pair with the second hull below the first.
std::vector<FacePoint> points_of(const HullShape& first, const HullShape& second, const Transform& second_in_first,
                                 const glm::vec3& direction = up) {
    std::vector<FacePoint> points(3); // of the pair before
    clip_faces(first, second, second_in_first, facing_faces(first, second, second_in_first, direction), tolerance,
               points);
    return points;
}

std::vector<uint32_t> features_of(const std::vector<FacePoint>& points) {
    std::vector<uint32_t> features;
    for (const FacePoint& point : points) features.push_back(point.feature);
    std::ranges::sort(features);
    return features;
}

void check_distinct(const std::vector<FacePoint>& points) {
    const std::vector<uint32_t> features = features_of(points);
    CHECK(std::ranges::adjacent_find(features) == features.end());
    CHECK(std::ranges::find(features, no_feature) == features.end());
}

// The places of points with a gap below a bound.
std::vector<glm::vec3> places_within(const std::vector<FacePoint>& points, float gap) {
    std::vector<glm::vec3> places;
    for (const FacePoint& point : points)
        if (point.gap < gap) places.push_back(point.on_second);
    return places;
}
bool has_place(const std::vector<glm::vec3>& places, const glm::vec3& place) {
    return std::ranges::any_of(places, [&](const glm::vec3& p) { return glm::length(p - place) < 1e-5f; });
}

// The plane across a unit normal, in double.
struct Plane {
    glm::dvec3 normal, u, v;
    explicit Plane(const glm::dvec3& n) : normal(n) {
        u = glm::normalize(glm::cross(n, std::abs(n.x) < 0.7 ? glm::dvec3(1, 0, 0) : glm::dvec3(0, 1, 0)));
        v = glm::cross(n, u);
    }
    [[nodiscard]] glm::dvec2 flat(const glm::dvec3& p) const { return {glm::dot(u, p), glm::dot(v, p)}; }
};

double cross(const glm::dvec2& a, const glm::dvec2& b) {
    return a.x * b.y - a.y * b.x;
}
double area_of(const std::vector<glm::dvec2>& loop) { // counter-clockwise
    double twice = 0.0;
    for (size_t i = 0; i < loop.size(); ++i) twice += cross(loop[i], loop[(i + 1) % loop.size()]);
    return 0.5 * twice;
}
double length_around(const std::vector<glm::dvec2>& loop) {
    double sum = 0.0;
    for (size_t i = 0; i < loop.size(); ++i) sum += glm::length(loop[(i + 1) % loop.size()] - loop[i]);
    return sum;
}

// How far a point is outside a convex loop, at most; negative inside.
double outside(const std::vector<glm::dvec2>& loop, const glm::dvec2& p) {
    double most = -1e30;
    for (size_t i = 0; i < loop.size(); ++i) {
        const glm::dvec2 edge = loop[(i + 1) % loop.size()] - loop[i];
        most = std::max(most, -cross(edge, p - loop[i]) / glm::length(edge));
    }
    return most;
}

// The area that two convex loops share: corners of each inside the other, and crossings of edges, around their mean.
double shared_area(const std::vector<glm::dvec2>& a, const std::vector<glm::dvec2>& b) {
    std::vector<glm::dvec2> corners;
    for (const glm::dvec2& p : a)
        if (outside(b, p) <= 0.0) corners.push_back(p);
    for (const glm::dvec2& p : b)
        if (outside(a, p) <= 0.0) corners.push_back(p);
    for (size_t i = 0; i < a.size(); ++i)
        for (size_t k = 0; k < b.size(); ++k) {
            const glm::dvec2 edge = a[(i + 1) % a.size()] - a[i], other = b[(k + 1) % b.size()] - b[k];
            const double determinant = cross(edge, other);
            if (determinant == 0.0) continue;
            const double along = cross(b[k] - a[i], other) / determinant,
                         across = cross(b[k] - a[i], edge) / determinant;
            if (along >= 0.0 && along <= 1.0 && across >= 0.0 && across <= 1.0) corners.push_back(a[i] + along * edge);
        }
    if (corners.size() < 3) return 0.0;
    glm::dvec2 mean(0.0);
    for (const glm::dvec2& p : corners) mean += p / static_cast<double>(corners.size());
    std::ranges::sort(corners, {}, [&](const glm::dvec2& p) { return std::atan2(p.y - mean.y, p.x - mean.x); });
    return area_of(corners);
}

// A face in the first hull's frame.
std::vector<glm::dvec3> corners_of(const HullShape& hull, int face, const Transform& frame) {
    std::vector<glm::dvec3> corners;
    for (const uint16_t corner : hull.corners_of(face))
        corners.push_back(glm::dmat3(frame.basis) * glm::dvec3(hull.points()[corner]) + glm::dvec3(frame.origin));
    return corners;
}
glm::dvec3 normal_of(const std::vector<glm::dvec3>& face) {
    glm::dvec3 area(0.0);
    for (size_t i = 2; i < face.size(); ++i) area += glm::cross(face[i - 1] - face[0], face[i] - face[0]);
    return glm::normalize(area);
}
glm::dvec3 mean_of(const std::vector<glm::dvec3>& points) {
    glm::dvec3 sum(0.0);
    for (const glm::dvec3& p : points) sum += p;
    return sum / static_cast<double>(points.size());
}
std::vector<glm::dvec2> flat(const Plane& plane, const std::vector<glm::dvec3>& face) {
    std::vector<glm::dvec2> loop;
    for (const glm::dvec3& p : face) loop.push_back(plane.flat(p));
    if (area_of(loop) < 0.0) std::ranges::reverse(loop);
    return loop;
}

// The height of a face over the plane at the place of a point.
double height_at(const glm::dvec3& face_normal, const glm::dvec3& on_face, const glm::dvec3& normal,
                 const glm::dvec3& p) {
    return glm::dot(normal, p) + glm::dot(face_normal, on_face - p) / glm::dot(face_normal, normal);
}

// A side of a feature: the edge of either hull with that name.
std::array<glm::dvec3, 2> edge_of(uint32_t name, const HullShape& first, const HullShape& second,
                                  const Transform& second_in_first, const FacingFaces& faces) {
    const bool of_second = (name & 0x8000u) != 0;
    const HullShape& hull = of_second ? second : first;
    const int face = of_second ? faces.second : faces.first;
    const std::vector<glm::dvec3> corners = corners_of(hull, face, of_second ? second_in_first : Transform{});
    const size_t corner = (name & 0x7fffu) - hull.first_corner_of(face);
    REQUIRE(corner < corners.size());
    return {corners[corner], corners[(corner + 1) % corners.size()]};
}
double distance_to(const glm::dvec2& p, const glm::dvec2& from, const glm::dvec2& to) {
    const glm::dvec2 along = to - from;
    const double part = std::clamp(glm::dot(p - from, along) / glm::dot(along, along), 0.0, 1.0);
    return glm::length(p - from - part * along);
}

// Checks the result for a pair; returns the shared area.
double check_pair(const HullShape& first, const HullShape& second, const Transform& second_in_first,
                  const FacingFaces& faces, const std::vector<FacePoint>& points) {
    const Plane plane{glm::normalize(glm::dvec3(faces.normal))};
    const std::vector<glm::dvec3> first_face = corners_of(first, faces.first, {});
    const std::vector<glm::dvec3> second_face = corners_of(second, faces.second, second_in_first);
    const glm::dvec3 first_normal = normal_of(first_face), second_normal = normal_of(second_face);
    const double first_cosine = -glm::dot(first_normal, plane.normal);
    const double second_cosine = glm::dot(second_normal, plane.normal);
    if (std::min(first_cosine, second_cosine) < 0.169) { // too steep
        CHECK(points.empty());
        return 0.0;
    }
    if (std::min(first_cosine, second_cosine) < 0.171) return 0.0; // rounding decides
    const std::vector<glm::dvec2> first_loop = flat(plane, first_face), second_loop = flat(plane, second_face);
    const double area = shared_area(first_loop, second_loop);
    const double rounding = 4e-6, allowed = static_cast<double>(tolerance) + rounding;
    std::vector<glm::dvec2> loop;
    for (const FacePoint& point : points) {
        const glm::dvec3 on_first(point.on_first), on_second(point.on_second), apart = on_first - on_second;
        loop.push_back(plane.flat(on_second));
        CHECK(outside(first_loop, loop.back()) < allowed);
        CHECK(outside(second_loop, loop.back()) < allowed);
        const uint32_t in = point.feature >> 16, out = point.feature & 0xffffu;
        CHECK(in != out);
        for (const uint32_t name : {in, out}) {
            const auto edge = edge_of(name, first, second, second_in_first, faces);
            CHECK(distance_to(loop.back(), plane.flat(edge[0]), plane.flat(edge[1]))
                  < 10.0 * allowed); // beside a sharp corner
        }
        const double gap = static_cast<double>(point.gap);
        CHECK(glm::length(apart - plane.normal * gap) < rounding);
        CHECK(std::abs(glm::dot(first_normal, on_first - first_face[0])) < rounding); // flat faces
        const double exact = height_at(first_normal, first_face[0], plane.normal, on_second)
                             - height_at(second_normal, second_face[0], plane.normal, on_second);
        CHECK(std::abs(gap - exact) < rounding / std::min(first_cosine, second_cosine));
    }
    const double strip = allowed * (length_around(first_loop) + length_around(second_loop));
    CHECK(std::abs(area_of(loop) - area) < strip);
    return area;
}

} // namespace

TEST_CASE("face contact: hulls without faces have no points, and keep the direction") {
    const HullShape cube = box_of(glm::vec3(0.5f)), point({glm::vec3(0.0f)}, 0.0f);
    const HullShape flat = shape_of({{-1, 0, -1}, {1, 0, -1}, {1, 0, 1}, {-1, 0, 1}});
    const HullShape no_faces(box_corners(glm::vec3(0.5f)), 0.0f);
    CHECK(flat.face_along(up) == -1);
    const glm::vec3 tilted = glm::normalize(glm::vec3(0.01f, 1.0f, 0.0f));
    for (const HullShape* const bare : {&point, &flat, &no_faces})
        for (const HullShape* const other : {&cube, bare})
            for (const bool swapped : {false, true}) {
                const HullShape &first = swapped ? *other : *bare, &second = swapped ? *bare : *other;
                const Transform below{glm::mat3(1.0f), {0.0f, -0.5f, 0.0f}};
                CHECK(facing_faces(first, second, below, tilted).normal == tilted);
                CHECK(points_of(first, second, below, tilted).empty());
            }
}

TEST_CASE("face contact: a face without an area has no points") {
    const std::vector<glm::vec3> line{{-1, 0, 0}, {1, 0, 0}, {0, 0, 0}};
    const HullShape degenerate(line, 0.0f, {.corners = {0, 1, 2}, .ends = {3}});
    const HullShape cube = box_of(glm::vec3(0.5f));
    CHECK(points_of(degenerate, cube, {glm::mat3(1.0f), {0.0f, -0.5f, 0.0f}}).empty());
    CHECK(points_of(cube, degenerate, {glm::mat3(1.0f), {0.0f, -0.5f, 0.0f}}).empty());
}

TEST_CASE("face contact: a spike that stands on its tip has no points, whichever hull it is") {
    const HullShape floor = box_of({5.0f, 0.5f, 5.0f});
    const HullShape spike = shape_of({{0, 0, 0}, {0.05f, 1, 0.05f}, {-0.05f, 1, 0.05f}, {0, 1, -0.05f}});
    CHECK(points_of(spike, floor, {glm::mat3(1.0f), {0.0f, -0.5f, 0.0f}}).empty());
    // Upside down, below a ceiling.
    const Transform under{turned(std::numbers::pi_v<float>, {1, 0, 0}), {0.0f, -0.5f, 0.0f}};
    CHECK(points_of(floor, spike, under).empty());
}

TEST_CASE("face contact: faces that miss each other have no points, and aligned edges of neighbours two places") {
    const HullShape cube = box_of(glm::vec3(0.5f));
    for (const float x : {1.001f, -1.001f, 3.0f}) {
        CHECK(points_of(cube, cube, {glm::mat3(1.0f), {x, -1.0f, 0.0f}}).empty());
        CHECK(points_of(cube, cube, {glm::mat3(1.0f), {0.0f, -1.0f, x}}).empty());
    }
    const auto edge = points_of(cube, cube, {glm::mat3(1.0f), {1.0f, -1.0f, 0.0f}});
    for (const FacePoint& point : edge) {
        CHECK(std::abs(point.on_second.x - 0.5f) < 2.0f * tolerance);
        CHECK(std::abs(std::abs(point.on_second.z) - 0.5f) < 1e-5f);
    }
}

TEST_CASE("face contact: a cube on a cube touches at four corners of the shared square") {
    const HullShape cube = box_of(glm::vec3(0.5f));
    for (const float gap : {0.0f, 0.01f, -0.02f, 3.0f}) {
        const auto aligned = points_of(cube, cube, {glm::mat3(1.0f), {0.0f, -1.0f - gap, 0.0f}});
        REQUIRE(aligned.size() == 4);
        check_distinct(aligned);
        for (const FacePoint& point : aligned) {
            CHECK(std::abs(point.gap - gap) < 1e-6f);
            CHECK(std::abs(std::abs(point.on_first.x) - 0.5f) < 1e-6f);
            CHECK(std::abs(std::abs(point.on_first.z) - 0.5f) < 1e-6f);
            CHECK(std::abs(point.on_first.y + 0.5f) < 1e-6f);
            CHECK(std::abs(point.on_second.y + 0.5f + gap) < 1e-6f);
        }
        const auto moved = points_of(cube, cube, {glm::mat3(1.0f), {0.2f, -1.0f - gap, -0.3f}});
        REQUIRE(moved.size() == 4);
        check_distinct(moved);
        const auto places = places_within(moved, 10.0f);
        for (const float x : {-0.3f, 0.5f})
            for (const float z : {-0.5f, 0.2f}) CHECK(has_place(places, {x, -0.5f - gap, z}));
    }
    const auto inside =
        points_of(box_of(glm::vec3(0.1f)), box_of({5.0f, 0.5f, 5.0f}), {glm::mat3(1.0f), {1.0f, -0.6f, 2.0f}});
    CHECK(inside.size() == 4);
    const auto around =
        points_of(box_of({5.0f, 0.5f, 5.0f}), box_of(glm::vec3(0.1f)), {glm::mat3(1.0f), {1.0f, -0.6f, 2.0f}});
    CHECK(around.size() == 4);
    for (const FacePoint& point : around) CHECK(std::abs(point.on_first.x - 1.0f) < 0.1f + tolerance);
}

TEST_CASE("face contact: features stay while hulls move a little, and while rounding swaps aligned edges") {
    const HullShape cube = box_of(glm::vec3(0.5f));
    test::Random random(5);
    for (const glm::vec3& place :
         {glm::vec3(0.0f, -1.0f, 0.0f), glm::vec3(0.2f, -1.0f, -0.3f), glm::vec3(0.0f, -1.0f, 0.3f)}) {
        const auto before = features_of(points_of(cube, cube, {glm::mat3(1.0f), place}));
        REQUIRE(before.size() == 4);
        const bool aligned = place.x == 0.0f;
        const double way = aligned ? 2e-5 : 0.02, turn = aligned ? 2e-5 : 0.02;
        for (int i = 0; i < 500; ++i) {
            const glm::vec3 shift(random.point(glm::dvec3(-way), glm::dvec3(way)));
            const float angle = static_cast<float>(random.uniform(-turn, turn));
            const glm::vec3 axis(random.direction());
            CHECK(features_of(points_of(cube, cube, {turned(angle, axis), place + shift})) == before);
        }
    }
}

TEST_CASE("face contact: an edge on a face touches at both ends, in either order of the hulls") {
    const HullShape cube = box_of(glm::vec3(0.5f)), floor = box_of({5.0f, 0.5f, 5.0f});
    const float half = std::numbers::pi_v<float> / 4.0f;
    for (const float angle : {half, -half, half + 0.1f, half - 0.1f, 3.0f * half}) {
        CAPTURE(angle);
        const float deepest = 0.5f * (std::abs(std::cos(angle)) + std::abs(std::sin(angle)));
        const Transform cube_frame{turned(angle, {0, 0, 1}), {1.0f, deepest, 2.0f}};
        const Transform floor_frame{glm::mat3(1.0f), {0.0f, -0.5f, 0.0f}};
        const Transform floor_in_cube = cube_frame.to_local(floor_frame);
        const auto on_floor = points_of(cube, floor, floor_in_cube, up * cube_frame.basis);
        CHECK(on_floor.size() == 4);
        CHECK(places_within(on_floor, 1e-5f).size() == 2);
        CHECK(places_within(on_floor, 0.3f).size() == 2); // the others are far
        // Below a ceiling.
        const auto ceiling = points_of(floor, cube, {cube_frame.basis, {1.0f, -0.5f - deepest, 2.0f}});
        CHECK(ceiling.size() == 4);
        CHECK(places_within(ceiling, 1e-5f).size() == 2);
        for (const glm::vec3& p : places_within(ceiling, 1e-5f)) CHECK(std::abs(std::abs(p.z - 2.0f) - 0.5f) < 1e-5f);
    }
}

TEST_CASE("face contact: a corner on a face touches at one point") {
    const HullShape cube = box_of(glm::vec3(0.5f)), floor = box_of({5.0f, 0.5f, 5.0f});
    for (const auto& turn : {turned(0.9f, {1, 0, 1}), turned(0.7f, {1, 0.3f, -0.6f}), turned(2.0f, {0.2f, 1, 1})}) {
        float lowest = 1e9f;
        for (const glm::vec3& p : cube.points()) lowest = std::min(lowest, (turn * p).y);
        const Transform frame{turn, {1.0f, -lowest, 2.0f}}, floor_frame{glm::mat3(1.0f), {0.0f, -0.5f, 0.0f}};
        const auto points = points_of(cube, floor, frame.to_local(floor_frame), up * turn);
        CHECK(points.size() == 4);
        CHECK(places_within(points, 1e-5f).size() == 1);
        CHECK(places_within(points, 0.01f).size() == 1);
        for (const FacePoint& point : points) CHECK(point.gap > -1e-5f);
    }
}

TEST_CASE("face contact: parallel edges touch at the ends of their common length, whichever faces are chosen") {
    const HullShape cube = box_of(glm::vec3(0.5f));
    const float quarter = std::numbers::pi_v<float> / 4.0f, diagonal = std::sqrt(2.0f);
    for (int i = 0; i < 4; ++i)
        for (int k = 0; k < 4; ++k)
            for (const float tilt : {0.0f, 0.1f, -0.1f}) {
                CAPTURE(i);
                CAPTURE(k);
                CAPTURE(tilt);
                const Transform upper{turned(quarter * static_cast<float>(2 * i + 1), {0, 0, 1}), glm::vec3(0.0f)};
                const Transform lower{turned(quarter * static_cast<float>(2 * k + 1), {0, 0, 1}),
                                      {0.0f, -diagonal, 0.3f}};
                const glm::vec3 direction = glm::normalize(glm::vec3(tilt, 1.0f, 0.0f));
                const auto points = points_of(cube, cube, upper.to_local(lower), direction * upper.basis);
                const auto near = places_within(points, 1e-3f);
                CHECK(near.size() >= 2);
                bool at_front = false, at_back = false;
                for (const glm::vec3& local : near) {
                    const glm::vec3 p = upper * local;
                    CHECK(std::abs(p.x) < 2.0f * tolerance);
                    CHECK(std::abs(p.y + 0.5f * diagonal) < 1e-3f);
                    at_front = at_front || std::abs(p.z - 0.5f) < 1e-3f;
                    at_back = at_back || std::abs(p.z + 0.2f) < 1e-3f;
                }
                CHECK(at_front);
                CHECK(at_back);
            }
}

TEST_CASE("face contact: an octagon on an octagon turned by half a side has sixteen corners") {
    const HullShape octagon = prism(8);
    const Transform below{turned(std::numbers::pi_v<float> / 8.0f, up), {0.0f, -1.0f, 0.0f}};
    const FacingFaces faces = facing_faces(octagon, octagon, below, up);
    const auto points = points_of(octagon, octagon, below);
    CHECK(points.size() == 16);
    check_distinct(points);
    // A regular polygon of sixteen sides around the circle that the octagon's sides touch.
    const double inner = std::cos(std::numbers::pi / 8.0);
    const double area = 16.0 * inner * inner * std::tan(std::numbers::pi / 16.0);
    CHECK(check_pair(octagon, octagon, below, faces, points) == doctest::Approx(area).epsilon(1e-5));
    const auto same = points_of(octagon, octagon, {glm::mat3(1.0f), {0.0f, -1.0f, 0.0f}});
    CHECK(same.size() == 8);
    check_distinct(same);
}

TEST_CASE("face contact: the faces look at each other, and a nearly aligned one gives the direction") {
    test::Random random(9);
    size_t kept = 0, replaced = 0;
    for (int i = 0; i < 2000; ++i) {
        CAPTURE(i);
        const HullShape cube = box_of(glm::vec3(0.5f)), wedge = prism(3 + i % 7);
        const Transform frame{turned(static_cast<float>(random.uniform(-3, 3)), glm::vec3(random.direction())),
                              glm::vec3(random.direction())};
        const double spread = i % 3 == 0 ? 2.0 : 0.05;
        const glm::vec3 direction = glm::normalize(up + glm::vec3(random.direction() * random.uniform(0.0, spread)));
        const FacingFaces faces = facing_faces(cube, wedge, frame, direction);
        REQUIRE(faces.first >= 0);
        REQUIRE(faces.second >= 0);
        const auto cosine = [&](const HullShape& hull, int face, const Transform& of, double sign) {
            return sign * glm::dot(normal_of(corners_of(hull, face, of)), glm::dvec3(direction));
        };
        const double first = cosine(cube, faces.first, {}, -1.0), second = cosine(wedge, faces.second, frame, 1.0);
        for (int face = 0; face < 6; ++face) CHECK(first >= cosine(cube, face, {}, -1.0) - 1e-6);
        for (int face = 0; face < 5 + i % 7; ++face) CHECK(second >= cosine(wedge, face, frame, 1.0) - 1e-6);
        const double best = std::max(first, second), two_degrees = std::cos(2.0 * std::numbers::pi / 180.0);
        if (std::abs(best - two_degrees) < 1e-5) continue; // rounding decides
        if (best < two_degrees) {
            CHECK(faces.normal == direction);
            ++kept;
            continue;
        }
        const glm::dvec3 expected = first >= second ? -normal_of(corners_of(cube, faces.first, {}))
                                                    : normal_of(corners_of(wedge, faces.second, frame));
        if (std::abs(first - second) > 1e-6) CHECK(glm::length(glm::dvec3(faces.normal) - expected) < 1e-5);
        ++replaced;
    }
    CHECK(kept > 300);
    CHECK(replaced > 300);
}

TEST_CASE("face contact: random pairs share the area, corners and gaps that double arithmetic finds") {
    test::Random random(11);
    size_t with_area = 0, empty = 0;
    const auto hull = [&](int kind) {
        if (kind == 0) return box_of(glm::vec3(random.point(glm::dvec3(0.05), glm::dvec3(0.5))));
        if (kind == 1) return prism(3 + static_cast<int>(random.uniform(0.0, 9.0)));
        std::vector<glm::vec3> points;
        for (int i = 0; i < 8; ++i) points.emplace_back(0.5 * random.direction());
        return shape_of(points);
    };
    for (int i = 0; i < 6000; ++i) {
        CAPTURE(i);
        const HullShape first = hull(i % 3), second = hull(i / 3 % 3);
        Transform frame{turned(static_cast<float>(random.uniform(-3, 3)), glm::vec3(random.direction())), {}};
        glm::vec3 direction(random.direction());
        const FacingFaces facing = facing_faces(first, second, frame, direction);
        // Some faces of random hulls are not flat, because nearly coplanar ones are merged.
        if ((i % 3 == 2 && first.corners_of(facing.first).size() > 3)
            || (i / 3 % 3 == 2 && second.corners_of(facing.second).size() > 3))
            continue;
        // One face over the other, more or less.
        const glm::dvec3 between =
            mean_of(corners_of(first, facing.first, {})) - mean_of(corners_of(second, facing.second, frame));
        frame.origin = glm::vec3(between + random.point(glm::dvec3(-0.3), glm::dvec3(0.3)));
        const FacingFaces faces = facing_faces(first, second, frame, direction);
        std::vector<FacePoint> points;
        clip_faces(first, second, frame, faces, tolerance, points);
        const double area = check_pair(first, second, frame, faces, points);
        if (area > 1e-3) {
            CHECK(points.size() >= 3);
            ++with_area;
        }
        if (points.empty()) ++empty;
        check_distinct(points);
    }
    CHECK(with_area > 2000);
    CHECK(empty > 100);
}
