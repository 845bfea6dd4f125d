// The shapes of shapes.h that are several solids: blocks that stand on each other.
#include "fracture/base/rounded_math.h"
#include "fracture/shapes/shapes.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <vector>

namespace brittle::fracture {
namespace {

constexpr uint32_t max_stones = 4096;
constexpr uint32_t max_levels = 64;
constexpr uint32_t max_rows = 256; // 33,000 blocks
constexpr uint32_t max_blocks = 100'000;

// Corners of a block: x, y and z low or high are bits 0, 1 and 2 of the index.
using Corners = std::array<glm::dvec3, 8>;

void append_block(TriangleMesh& mesh, const Corners& corners) {
    static constexpr std::array<Triangle, 12> faces = {{{0, 4, 6},
                                                        {0, 6, 2},
                                                        {1, 3, 7},
                                                        {1, 7, 5},
                                                        {0, 1, 5},
                                                        {0, 5, 4},
                                                        {2, 6, 7},
                                                        {2, 7, 3},
                                                        {0, 2, 3},
                                                        {0, 3, 1},
                                                        {4, 5, 7},
                                                        {4, 7, 6}}};
    const auto first = static_cast<uint32_t>(mesh.positions.size());
    mesh.positions.insert(mesh.positions.end(), corners.begin(), corners.end());
    for (const Triangle& face : faces) mesh.triangles.push_back(face + Triangle(first));
}

// A box with two sides along `along` and `up`, which are perpendicular unit vectors.
void append_box(TriangleMesh& mesh, const glm::dvec3& centre, const glm::dvec3& size, const glm::dvec3& along,
                const glm::dvec3& up) {
    const glm::dvec3 across(along.y * up.z - along.z * up.y, along.z * up.x - along.x * up.z,
                            along.x * up.y - along.y * up.x);
    Corners corners;
    for (size_t i = 0; i < corners.size(); ++i) {
        const auto half = [&](int axis) { return (i >> axis & 1 ? 0.5 : -0.5) * size[axis]; };
        corners[i] = centre + along * half(0) + up * half(1) + across * half(2);
    }
    append_block(mesh, corners);
}

void append_box(TriangleMesh& mesh, const glm::dvec3& centre, const glm::dvec3& size) {
    append_box(mesh, centre, size, {1.0, 0.0, 0.0}, {0.0, 1.0, 0.0});
}

} // namespace

TriangleMesh stone_arch(double thickness, uint32_t stones, double joint) {
    stones = std::clamp(stones, 3u, max_stones);
    thickness = std::clamp(thickness, 0.01, 1.0);
    constexpr double half_depth = 0.25;
    const double inner = 1.0 - 0.5 * thickness, outer = 1.0 + 0.5 * thickness;
    TriangleMesh mesh;
    for (uint32_t stone = 0; stone < stones; ++stone) {
        // From left to right, so that x rises with the index of a corner.
        const double from = std::numbers::pi * (1.0 - static_cast<double>(stone) / stones);
        const double to = std::numbers::pi * (1.0 - static_cast<double>(stone + 1) / stones);
        // Joints are planes: each stone is pulled back from them by half a joint.
        Corners corners;
        for (size_t i = 0; i < corners.size(); ++i) {
            const double angle = i & 1 ? to : from, radius = i & 2 ? outer : inner;
            const double back = 0.5 * joint * (i & 1 ? 1.0 : -1.0);
            corners[i] = {radius * rounded::cos(angle) - back * rounded::sin(angle),
                          radius * rounded::sin(angle) + back * rounded::cos(angle), i & 4 ? half_depth : -half_depth};
        }
        append_block(mesh, corners);
    }
    return mesh;
}

TriangleMesh card_house(uint32_t levels, double joint) {
    levels = std::clamp(levels, 1u, max_levels);
    constexpr double height = 0.088, width = 0.063, thickness = 0.002;
    constexpr double lean = 20.0 * std::numbers::pi / 180.0; // from upright
    constexpr double overhang = 0.003;                       // of the outermost lying cards beyond the crest below them
    constexpr double pitch = height + 1e-4;                  // of lying cards
    const double c = rounded::cos(lean), s = rounded::sin(lean);
    TriangleMesh mesh;
    double floor = 0.0;
    for (uint32_t pairs = levels; pairs >= 1; --pairs) {
        const int bridges = static_cast<int>(pairs) - 1;
        // The outermost lying cards reach over both corners of the outermost crests.
        const double crests = bridges > 0 ? (bridges * pitch - (pitch - height) - 2.0 * overhang) / bridges : 0.0;
        const double aside = 0.5 * (thickness * c + height * s + joint); // of a card's middle from its crest
        const double level = height * c + thickness * s;
        for (int i = 0; i <= bridges; ++i)
            for (const double side : {-1.0, 1.0})
                append_box(mesh, {crests * (i - 0.5 * bridges) + side * aside, floor + 0.5 * level, 0.0},
                           {thickness, height, width}, {c, side * s, 0.0}, {-side * s, c, 0.0});
        floor += level + joint;
        for (int i = 0; i < bridges; ++i)
            append_box(mesh, {pitch * (i - 0.5 * (bridges - 1)), floor + 0.5 * thickness, 0.0},
                       {height, thickness, width});
        floor += thickness + joint;
    }
    return mesh;
}

TriangleMesh domino_spiral(uint32_t count) {
    count = std::clamp(count, 1u, max_blocks);
    constexpr double height = 0.048, width = 0.024, thickness = 0.0075, gap = 0.0135;
    constexpr double turns_apart = 0.055; // between two turns
    constexpr double innermost = 0.1;     // radius of the first domino's place from the inside
    // Archimedes' spiral, from the inside outwards; the first domino of the mesh is the outermost.
    std::vector<double> angles{2.0 * std::numbers::pi * innermost / turns_apart};
    const auto radius_at = [&](double angle) { return turns_apart * angle / (2.0 * std::numbers::pi); };
    while (angles.size() < count) angles.push_back(angles.back() + (thickness + gap) / radius_at(angles.back()));
    TriangleMesh mesh;
    for (size_t i = angles.size(); i-- > 0;) {
        const double angle = angles[i] - angles.back(), radius = radius_at(angles[i]);
        // The tangent of the spiral: across the radius, and inwards a little.
        const double slope = turns_apart / (2.0 * std::numbers::pi * radius), length = std::sqrt(1.0 + slope * slope);
        const glm::dvec3 outward(rounded::cos(angle), 0.0, rounded::sin(angle));
        const glm::dvec3 inwards = (glm::dvec3(outward.z, 0.0, -outward.x) - slope * outward) / length;
        append_box(mesh, radius * outward + glm::dvec3(0.0, 0.5 * height, 0.0), {thickness, height, width}, inwards,
                   {0.0, 1.0, 0.0});
    }
    return mesh;
}

TriangleMesh pyramid(uint32_t rows, double edge, double joint) {
    rows = std::clamp(rows, 1u, max_rows);
    TriangleMesh mesh;
    for (uint32_t row = 0; row < rows; ++row)
        for (uint32_t i = 0; i < rows - row; ++i)
            append_box(mesh, {1.1 * edge * (i - 0.5 * (rows - row - 1.0)), (edge + joint) * row + 0.5 * edge, 0.0},
                       glm::dvec3(edge));
    return mesh;
}

TriangleMesh stack(uint32_t count, double edge, double joint) {
    count = std::clamp(count, 1u, max_blocks);
    TriangleMesh mesh;
    for (uint32_t i = 0; i < count; ++i)
        append_box(mesh, {0.0, (edge + joint) * i + 0.5 * edge, 0.0}, glm::dvec3(edge));
    return mesh;
}

} // namespace brittle::fracture
