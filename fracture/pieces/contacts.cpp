#include "fracture/pieces/contacts.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <map>
#include <string>
#include <tuple>
#include <utility>

#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <glm/vec2.hpp>

namespace brittle::fracture {

namespace {

constexpr uint32_t block_triangles = 128; // of one piece; more: fewer pairs of boxes, and more triangles beside a pair
// Of the normals of two faces in contact: |n_a + n_b|, the angle between them: one degree.
constexpr double max_deviation = 0.0175;
// An overlap below this share of the square of the longest edge is rounding: faces that share an edge overlap by it.
constexpr double min_area_share = 1e-13;
// Of the side of a cell: what reaches into a cell by less belongs to the next one.
constexpr double cell_slack = 1e-6;

struct Block {
    Box box;
    uint32_t piece = 0;
    uint32_t begin = 0, end = 0; // its triangles
};

struct Face {
    std::array<glm::dvec3, 3> corners; // from the origin of the pair
    glm::dvec3 normal;
    double offset; // |d|
};

// The overlaps of two pieces.
struct Sum {
    double area = 0.0, largest = 0.0;
    glm::dvec3 moment{0.0}, normal{0.0}; // area times centroid, area times normal
    glm::dvec3 largest_normal{0.0};
};

bool is_finite(const glm::dvec3& p) {
    return std::isfinite(p.x) && std::isfinite(p.y) && std::isfinite(p.z);
}

Error fault(size_t piece, size_t triangle, const std::string& what) {
    return {Status::invalid_mesh,
            "piece " + std::to_string(piece) + ", triangle " + std::to_string(triangle) + ": " + what};
}

// Fails at the first triangle that is no triangle.
Result<std::vector<Block>> blocks_of(std::span<const PieceSurface> surfaces) {
    std::vector<Block> blocks;
    for (uint32_t piece = 0; piece < surfaces.size(); ++piece) {
        const auto [positions, triangles] = surfaces[piece];
        for (uint32_t t = 0; t < triangles.size(); ++t) {
            if (t % block_triangles == 0)
                blocks.push_back({{glm::dvec3(std::numeric_limits<double>::infinity()),
                                   glm::dvec3(-std::numeric_limits<double>::infinity())},
                                  piece,
                                  t,
                                  t});
            Block& block = blocks.back();
            block.end = t + 1;
            for (int k = 0; k < 3; ++k) {
                const uint32_t corner = triangles[t][k];
                if (corner >= positions.size())
                    return fault(piece, t,
                                 "there is no position " + std::to_string(corner) + ", only "
                                     + std::to_string(positions.size()));
                if (!is_finite(positions[corner]))
                    return fault(piece, t, "position " + std::to_string(corner) + " is not finite");
                block.box.min = glm::min(block.box.min, positions[corner]);
                block.box.max = glm::max(block.box.max, positions[corner]);
            }
        }
    }
    return blocks;
}

bool overlaps(const Box& a, const Box& b) {
    return a.min.x <= b.max.x && b.min.x <= a.max.x && a.min.y <= b.max.y && b.min.y <= a.max.y && a.min.z <= b.max.z
           && b.min.z <= a.max.z;
}

// The faces of a block that reach into a box, from its middle, by |d|.
void faces_in(const Box& box, const PieceSurface& surface, const Block& block, std::vector<Face>& faces) {
    faces.clear();
    const glm::dvec3 origin = box.centre();
    for (uint32_t t = block.begin; t < block.end; ++t) {
        const Triangle& triangle = surface.triangles[t];
        const std::array corners{surface.positions[triangle.x], surface.positions[triangle.y],
                                 surface.positions[triangle.z]};
        if (!overlaps(box, {glm::min(glm::min(corners[0], corners[1]), corners[2]),
                            glm::max(glm::max(corners[0], corners[1]), corners[2])}))
            continue;
        Face face{{corners[0] - origin, corners[1] - origin, corners[2] - origin}, {}, 0.0};
        const glm::dvec3 cross = glm::cross(corners[1] - corners[0], corners[2] - corners[0]);
        const double length = glm::length(cross);
        if (!(length > 0.0) || !std::isfinite(length)) continue;
        face.normal = cross / length;
        face.offset = std::abs(glm::dot(face.normal, face.corners[0]));
        faces.push_back(face);
    }
    std::ranges::stable_sort(faces, {}, &Face::offset);
}

double cross_of(const glm::dvec2& a, const glm::dvec2& b) {
    return a.x * b.y - a.y * b.x;
}

// A convex polygon of at most six corners: what two triangles have in common.
struct Polygon {
    std::array<glm::dvec2, 12> corners;
    size_t count = 0;

    void add(const glm::dvec2& corner) {
        if (count < corners.size()) corners[count++] = corner;
    }
};

// The part of a polygon where a linear function is not negative.
Polygon clip(const Polygon& polygon, const auto& value_at) {
    Polygon inside;
    for (size_t i = 0; i < polygon.count; ++i) {
        const glm::dvec2 &p = polygon.corners[i], &q = polygon.corners[(i + 1) % polygon.count];
        const double at_p = value_at(p), at_q = value_at(q);
        if (at_p >= 0.0) inside.add(p);
        if ((at_p > 0.0 && at_q < 0.0) || (at_p < 0.0 && at_q > 0.0)) inside.add(p + (q - p) * (at_p / (at_p - at_q)));
    }
    return inside;
}

Polygon overlap_of(const std::array<glm::dvec2, 3>& subject, const std::array<glm::dvec2, 3>& by) {
    Polygon polygon;
    for (const glm::dvec2& corner : subject) polygon.add(corner);
    for (size_t k = 0; k < 3 && polygon.count > 0; ++k) {
        const glm::dvec2 from = by[k], edge = by[(k + 1) % 3] - from;
        polygon = clip(polygon, [&](const glm::dvec2& p) { return cross_of(edge, p - from); });
    }
    return polygon;
}

double area_of(const Polygon& polygon, glm::dvec2& moment) {
    double area = 0.0;
    moment = glm::dvec2(0.0);
    for (size_t k = 1; k + 1 < polygon.count; ++k) {
        const glm::dvec2 &p = polygon.corners[0], &q = polygon.corners[k], &r = polygon.corners[k + 1];
        const double part = 0.5 * cross_of(q - p, r - p);
        area += part;
        moment += part / 3.0 * (p + q + r);
    }
    return area;
}

// Of a contact: the coordinate that it is not divided along, and the numbers of the cell along the other two.
using Cell = std::array<int64_t, 3>;
using CellSums = std::map<Cell, Sum>;

// Divides a polygon into cells; false where there would be too many. `point_at` gives the point of a corner in the grid.
bool divide(const Polygon& polygon, const glm::dvec3& normal, double size, const auto& point_at, const auto& visit) {
    const glm::dvec3 steep = glm::abs(normal);
    const int flat = steep.x >= steep.y && steep.x >= steep.z ? 0 : steep.y >= steep.z ? 1 : 2;
    const std::array<int, 2> axes{(flat + 1) % 3, (flat + 2) % 3};
    std::array<double, 2> first{}, last{}; // cells
    for (size_t i = 0; i < 2; ++i) {
        double low = std::numeric_limits<double>::infinity(), high = -low;
        for (size_t k = 0; k < polygon.count; ++k) {
            const double at = point_at(polygon.corners[k])[axes[i]];
            low = std::min(low, at);
            high = std::max(high, at);
        }
        first[i] = std::floor(low / size + cell_slack);
        last[i] = std::max(first[i], std::ceil(high / size - cell_slack) - 1.0);
        if (!(last[i] - first[i] < max_contact_cells) || std::abs(first[i]) > 1e15) return false;
    }
    const auto strip = [&](const Polygon& from, size_t i, double cell) {
        Polygon part = from;
        if (cell > first[i]) part = clip(part, [&](const glm::dvec2& p) { return point_at(p)[axes[i]] - cell * size; });
        if (cell < last[i])
            part = clip(part, [&](const glm::dvec2& p) { return (cell + 1.0) * size - point_at(p)[axes[i]]; });
        return part;
    };
    for (double i = first[0]; i <= last[0]; ++i) {
        const Polygon column = strip(polygon, 0, i);
        for (double j = first[1]; j <= last[1]; ++j)
            visit(Cell{flat, static_cast<int64_t>(i), static_cast<int64_t>(j)}, strip(column, 1, j));
    }
    return true;
}

// Adds the overlap of two opposite faces, of the pieces a and b. False where there are too many cells.
bool add_overlap(const Face& a, const Face& b, const glm::dvec3& origin, double tolerance, const ContactGrid& grid,
                 CellSums& sums) {
    const glm::dvec3 normal = glm::normalize(a.normal - b.normal);
    const glm::dvec3 across = std::abs(normal.x) < 0.6 ? glm::dvec3(1.0, 0.0, 0.0) : glm::dvec3(0.0, 1.0, 0.0);
    const glm::dvec3 u = glm::normalize(glm::cross(across, normal)), v = glm::cross(normal, u);
    const glm::dvec3 middle = a.corners[0];
    const auto flat = [&](const glm::dvec3& p) { return glm::dvec2(glm::dot(p - middle, u), glm::dot(p - middle, v)); };
    const std::array subject{flat(a.corners[0]), flat(a.corners[1]), flat(a.corners[2])};
    const std::array by{flat(b.corners[0]), flat(b.corners[2]), flat(b.corners[1])}; // counter-clockwise from a's side
    const Polygon overlap = overlap_of(subject, by);
    if (overlap.count < 3) return true;
    double longest = 0.0;
    glm::dvec2 moment;
    for (const auto& triangle : {subject, by})
        for (size_t k = 0; k < 3; ++k)
            longest =
                std::max(longest, glm::dot(triangle[k] - triangle[(k + 1) % 3], triangle[k] - triangle[(k + 1) % 3]));
    if (!(area_of(overlap, moment) > min_area_share * longest)) return true;
    // Both planes as heights over the common one; their difference is linear, so the corners have the largest.
    const auto height = [&](const Face& face, const glm::dvec2& at) {
        const glm::dvec3 foot = middle + at.x * u + at.y * v;
        return glm::dot(face.normal, face.corners[0] - foot) / glm::dot(face.normal, normal);
    };
    for (size_t k = 0; k < overlap.count; ++k)
        if (!(std::abs(height(a, overlap.corners[k]) - height(b, overlap.corners[k])) <= tolerance)) return true;
    const auto point_at = [&](const glm::dvec2& p) {
        const double up = 0.5 * (height(a, p) + height(b, p));
        return origin + middle + p.x * u + p.y * v + up * normal;
    };
    const auto add = [&](const Cell& cell, const Polygon& part) {
        const double area = area_of(part, moment);
        if (!(area > 0.0)) return;
        Sum& sum = sums[cell];
        sum.area += area;
        sum.moment += area * point_at(moment / area);
        sum.normal += area * normal;
        if (area > sum.largest) {
            sum.largest = area;
            sum.largest_normal = normal;
        }
    };
    if (std::isfinite(grid.size)) {
        const auto in_grid = [&](const glm::dvec2& p) { return point_at(p) - grid.origin; };
        return divide(overlap, normal, grid.size, in_grid, add);
    }
    add({}, overlap);
    return true;
}

struct Contact {
    uint32_t a = 0, b = 0;
    Cell cell{};

    friend bool operator<(const Contact& x, const Contact& y) {
        return std::tie(x.a, x.b, x.cell) < std::tie(y.a, y.b, y.cell);
    }
};
using Sums = std::map<Contact, Sum>;

// Matches the faces of two blocks. Where two faces lie in one plane within the tolerance at a point x, |d_a + d_b| is
// at most the tolerance plus |n_a + n_b| |x|.
class Matcher {
  public:
    Matcher(std::span<const PieceSurface> surfaces, double tolerance) : surfaces_(surfaces), tolerance_(tolerance) {}

    // False where there are too many cells.
    bool match(const Block& a, const Block& b, const ContactGrid& grid, Sums& sums) {
        const Box common{glm::max(a.box.min, b.box.min) - tolerance_, glm::min(a.box.max, b.box.max) + tolerance_};
        faces_in(common, surfaces_[a.piece], a, faces_a_);
        faces_in(common, surfaces_[b.piece], b, faces_b_);
        const double reach = 0.5 * glm::length(common.size()) + tolerance_;
        const double window = 2.0 * tolerance_ + max_deviation * reach;
        CellSums of_blocks;
        bool fits = true;
        size_t first = 0;
        for (const Face& face : faces_a_) {
            while (first < faces_b_.size() && faces_b_[first].offset < face.offset - window) ++first;
            for (size_t k = first; k < faces_b_.size() && faces_b_[k].offset <= face.offset + window; ++k) {
                const glm::dvec3 deviation = face.normal + faces_b_[k].normal;
                if (glm::dot(deviation, deviation) <= max_deviation * max_deviation)
                    fits = add_overlap(face, faces_b_[k], common.centre(), tolerance_, grid, of_blocks) && fits;
            }
        }
        for (const auto& [cell, sum] : of_blocks) {
            Sum& all = sums[{a.piece, b.piece, cell}];
            all.area += sum.area;
            all.moment += sum.moment;
            all.normal += sum.normal;
            if (sum.largest > all.largest) {
                all.largest = sum.largest;
                all.largest_normal = sum.largest_normal;
            }
        }
        return fits;
    }

  private:
    std::span<const PieceSurface> surfaces_;
    double tolerance_;
    std::vector<Face> faces_a_, faces_b_; // scratch
};

// The axis along which the boxes spread most, for the sweep.
int longest_axis(std::span<const Block> blocks) {
    glm::dvec3 mean(0.0), square(0.0);
    for (const Block& block : blocks) mean += block.box.centre() / static_cast<double>(blocks.size());
    for (const Block& block : blocks) square += (block.box.centre() - mean) * (block.box.centre() - mean);
    if (square.x >= square.y && square.x >= square.z) return 0;
    return square.y >= square.z ? 1 : 2;
}

} // namespace

Result<std::vector<Bond>> find_contacts(std::span<const PieceSurface> surfaces, const ContactSettings& settings) {
    if (!(settings.tolerance >= 0.0) || !std::isfinite(settings.tolerance))
        return Error{Status::invalid_setting, "the tolerance of contacts must be a length of 0 m or more"};
    Result<std::vector<Block>> made = blocks_of(surfaces);
    if (!made) return made.error();
    std::vector<Block>& blocks = *made;
    const int axis = longest_axis(blocks);
    std::ranges::stable_sort(blocks, {}, [&](const Block& block) { return block.box.min[axis]; });
    Sums sums;
    Matcher matcher(surfaces, settings.tolerance);
    for (size_t i = 0; i < blocks.size(); ++i) {
        const Box near{blocks[i].box.min - settings.tolerance, blocks[i].box.max + settings.tolerance};
        for (size_t k = i + 1; k < blocks.size() && blocks[k].box.min[axis] <= near.max[axis]; ++k) {
            if (blocks[i].piece == blocks[k].piece || !overlaps(near, blocks[k].box)) continue;
            const bool ordered = blocks[i].piece < blocks[k].piece;
            const Block &a = blocks[ordered ? i : k], &b = blocks[ordered ? k : i];
            if (settings.wanted && !settings.wanted(a.piece, b.piece)) continue;
            const ContactGrid grid = settings.grid ? settings.grid(a.piece, b.piece) : ContactGrid{};
            if (!(grid.size > 0.0) || !matcher.match(a, b, grid, sums))
                return Error{Status::invalid_setting,
                             "cells of " + std::to_string(grid.size) + " m for the contact of pieces "
                                 + std::to_string(a.piece) + " and " + std::to_string(b.piece)
                                 + ": give a positive length, of which at most "
                                 + std::to_string(static_cast<int>(max_contact_cells)) + " lie along a face"};
        }
    }
    std::vector<Bond> bonds;
    for (const auto& [contact, sum] : sums) {
        const double length = glm::length(sum.normal);
        // Contacts on two opposite sides, as of a tongue in a groove, cancel: the largest overlap decides.
        const bool cancels = length < 1e-6 * sum.area;
        bonds.push_back({contact.a, contact.b, sum.area, sum.moment / sum.area,
                         cancels ? sum.largest_normal : sum.normal / length});
    }
    return bonds;
}

Result<std::vector<Bond>> find_contacts(const Fragments& fragments, const ContactSettings& settings) {
    std::vector<PieceSurface> surfaces;
    for (const Piece& piece : fragments.pieces)
        surfaces.push_back({fragments.positions_of(piece), fragments.triangles_of(piece)});
    return find_contacts(surfaces, settings);
}

} // namespace brittle::fracture
