#include "fracture/unite/planar_mesh.h"

#include <algorithm>
#include <cassert>

#include "fracture/arithmetic/plane_predicates.h"

namespace brittle::fracture::arrangement {
namespace {

size_t next(size_t k) {
    return k == 2 ? 0 : k + 1;
}

size_t before(size_t k) {
    return k == 0 ? 2 : k - 1;
}

} // namespace

void PlanarMesh::start(const std::array<uint32_t, 3>& corners, int axis) {
    axis_ = axis;
    sign_ = points_.turn(corners[0], corners[1], corners[2], axis);
    point_.assign(corners.begin(), corners.end());
    face_of_.assign(3, 0);
    faces_.assign(1, {{0, 1, 2}, {no_index, no_index, no_index}, {1, 1, 1}});
    last_ = 0;
}

uint32_t PlanarMesh::add(uint32_t point) {
    point_.push_back(point);
    face_of_.push_back(no_index);
    return static_cast<uint32_t>(point_.size() - 1);
}

// Writes a face and lets the faces beside it know.
void PlanarMesh::put(uint32_t face, const Face& content) {
    faces_[face] = content;
    for (size_t k = 0; k < 3; ++k) {
        face_of_[content.corner[k]] = face;
        if (content.beside[k] != no_index) relink(content.beside[k], content.corner[next(k)], content.corner[k], face);
    }
    last_ = face;
}

void PlanarMesh::relink(uint32_t face, uint32_t from, uint32_t to, uint32_t beside) {
    Face& f = faces_[face];
    for (size_t k = 0; k < 3; ++k)
        if (f.corner[k] == from && f.corner[next(k)] == to) f.beside[k] = beside;
}

// Returns the face on the left of an edge; face no_index where there is none. Turns around `from`, in both directions,
// because the boundary may interrupt a turn.
PlanarMesh::Side PlanarMesh::find(uint32_t from, uint32_t to) const {
    for (const bool forward : {true, false}) {
        uint32_t face = face_of_[from];
        do {
            const Face& f = faces_[face];
            const size_t k = f.corner[0] == from ? 0 : (f.corner[1] == from ? 1 : 2);
            if (f.corner[next(k)] == to) return {face, k};
            face = forward ? f.beside[before(k)] : f.beside[k];
        } while (face != no_index && face != face_of_[from]);
        if (face != no_index) break;
    }
    return {no_index, 0};
}

uint32_t PlanarMesh::divide_boundary(uint32_t from, uint32_t to, uint32_t point) {
    const Side side = find(from, to);
    assert(side.face != no_index);
    const uint32_t index = add(point);
    split_edge(side, index);
    flip_towards_delaunay();
    return index;
}

uint32_t PlanarMesh::insert(uint32_t point) {
    const uint32_t index = add(point);
    const Side side = locate(index);
    if (side.edge == 3)
        split_face(side.face, index);
    else
        split_edge(side, index);
    flip_towards_delaunay();
    return index;
}

// Returns the face that holds a point; its edge where the point lies on one, else 3.
PlanarMesh::Side PlanarMesh::locate(uint32_t index) const {
    // The walk ends in a Delaunay triangulation. This one may not be, so a search through all faces follows.
    uint32_t face = last_;
    for (size_t step = 0; step < 2 * faces_.size() && face != no_index; ++step) {
        uint32_t beyond = face;
        size_t on = 3;
        for (size_t k = 0; k < 3 && beyond == face; ++k) {
            const int side = turn(faces_[face].corner[k], faces_[face].corner[next(k)], index);
            if (side < 0) beyond = faces_[face].beside[k];
            if (side == 0) on = k;
        }
        if (beyond == face) return {face, on};
        face = beyond;
    }
    for (face = 0; face < faces_.size(); ++face) {
        std::array<int, 3> side{};
        for (size_t k = 0; k < 3; ++k) side[k] = turn(faces_[face].corner[k], faces_[face].corner[next(k)], index);
        const auto lowest = std::min_element(side.begin(), side.end());
        if (*lowest >= 0) return {face, *lowest == 0 ? static_cast<size_t>(lowest - side.begin()) : 3};
    }
    assert(false && "the point lies outside the triangle");
    return {0, 3};
}

void PlanarMesh::split_face(uint32_t face, uint32_t index) {
    const Face f = faces_[face];
    const auto first = static_cast<uint32_t>(faces_.size());
    const std::array<uint32_t, 3> part{face, first, first + 1};
    faces_.resize(faces_.size() + 2);
    for (size_t k = 0; k < 3; ++k)
        faces_[part[k]] = {{f.corner[k], f.corner[next(k)], index},
                           {f.beside[k], part[next(k)], part[before(k)]},
                           {f.constrained[k], 0, 0}};
    for (size_t k = 0; k < 3; ++k) {
        put(part[k], Face(faces_[part[k]]));
        doubtful_.push_back({part[k], 0});
    }
}

void PlanarMesh::split_edge(Side side, uint32_t index) {
    const Face f = faces_[side.face];
    const size_t k = side.edge;
    const uint32_t a = f.corner[k], b = f.corner[next(k)], c = f.corner[before(k)];
    const uint8_t constrained = f.constrained[k];
    const auto half = static_cast<uint32_t>(faces_.size()); // the new face at b
    faces_.push_back({});
    uint32_t across = f.beside[k], across_half = no_index;
    Face g{};
    size_t j = 0;
    if (across != no_index) {
        g = faces_[across];
        while (g.corner[j] != b || g.corner[next(j)] != a) ++j;
        across_half = half + 1; // the new face at a
        faces_.push_back({});
    }
    // Of the two faces beyond the edge, `across` keeps b.
    faces_[side.face] = {
        {a, index, c}, {across_half, half, f.beside[before(k)]}, {constrained, 0, f.constrained[before(k)]}};
    faces_[half] = {{index, b, c}, {across, f.beside[next(k)], side.face}, {constrained, f.constrained[next(k)], 0}};
    std::vector<uint32_t> parts{side.face, half};
    if (across != no_index) {
        const uint32_t d = g.corner[before(j)];
        faces_[across] = {
            {b, index, d}, {half, across_half, g.beside[before(j)]}, {constrained, 0, g.constrained[before(j)]}};
        faces_[across_half] = {
            {index, a, d}, {side.face, g.beside[next(j)], across}, {constrained, g.constrained[next(j)], 0}};
        parts.insert(parts.end(), {across, across_half});
    }
    for (const uint32_t part : parts) put(part, Face(faces_[part]));
    doubtful_.push_back({side.face, 2});
    doubtful_.push_back({half, 1});
    if (across != no_index) {
        doubtful_.push_back({across, 2});
        doubtful_.push_back({across_half, 1});
    }
}

bool PlanarMesh::should_flip(uint32_t face, size_t edge) const {
    const Face& f = faces_[face];
    if (f.constrained[edge] || f.beside[edge] == no_index) return false;
    const Face& g = faces_[f.beside[edge]];
    const uint32_t a = f.corner[edge], b = f.corner[next(edge)], c = f.corner[before(edge)];
    size_t j = 0;
    while (g.corner[j] == a || g.corner[j] == b) ++j;
    const uint32_t d = g.corner[j];
    const auto flat = [&](uint32_t index) {
        const glm::dvec3& p = points_[point_[index]];
        return sign_ > 0 ? glm::dvec2(p[(axis_ + 1) % 3], p[(axis_ + 2) % 3])
                         : glm::dvec2(p[(axis_ + 2) % 3], p[(axis_ + 1) % 3]);
    };
    return certainly_in_circle(flat(a), flat(b), flat(c), flat(d)) && turn(a, d, c) > 0 && turn(d, b, c) > 0;
}

void PlanarMesh::flip(uint32_t face, size_t k) {
    const Face f = faces_[face];
    const uint32_t across = f.beside[k];
    const Face g = faces_[across];
    const uint32_t a = f.corner[k], b = f.corner[next(k)], c = f.corner[before(k)];
    size_t j = 0;
    while (g.corner[j] != b || g.corner[next(j)] != a) ++j;
    const uint32_t d = g.corner[before(j)];
    faces_[face] = {{c, a, d},
                    {f.beside[before(k)], g.beside[next(j)], across},
                    {f.constrained[before(k)], g.constrained[next(j)], 0}};
    faces_[across] = {{d, b, c},
                      {g.beside[before(j)], f.beside[next(k)], face},
                      {g.constrained[before(j)], f.constrained[next(k)], 0}};
    put(face, Face(faces_[face]));
    put(across, Face(faces_[across]));
    for (const uint32_t part : {face, across})
        for (const size_t edge : {size_t{0}, size_t{1}}) doubtful_.push_back({part, edge});
}

void PlanarMesh::flip_towards_delaunay() {
    // Each flip of a Delaunay triangulation improves it, but the in-circle test rounds: the bound ends any cycle.
    for (size_t left = 16 * faces_.size() + 64; !doubtful_.empty() && left > 0; --left) {
        const Side side = doubtful_.back();
        doubtful_.pop_back();
        if (should_flip(side.face, side.edge)) flip(side.face, side.edge);
    }
    doubtful_.clear();
}

void PlanarMesh::mark(Side side) {
    Face& f = faces_[side.face];
    f.constrained[side.edge] = 1;
    if (f.beside[side.edge] == no_index) return;
    Face& g = faces_[f.beside[side.edge]];
    for (size_t j = 0; j < 3; ++j)
        if (g.corner[j] == f.corner[next(side.edge)] && g.corner[next(j)] == f.corner[side.edge]) g.constrained[j] = 1;
}

void PlanarMesh::constrain(uint32_t from, uint32_t to) {
    if (const Side side = find(from, to); side.face != no_index) return mark(side);
    if (const Side side = find(to, from); side.face != no_index) return mark(side);
    // The face at `from` through which the edge leaves.
    uint32_t face = no_index;
    size_t k = 0;
    for (const bool forward : {true, false}) {
        uint32_t at = face_of_[from];
        do {
            const Face& f = faces_[at];
            k = f.corner[0] == from ? 0 : (f.corner[1] == from ? 1 : 2);
            if (turn(from, f.corner[next(k)], to) > 0 && turn(from, to, f.corner[before(k)]) > 0) {
                face = at;
                break;
            }
            at = forward ? f.beside[before(k)] : f.beside[k];
        } while (at != no_index && at != face_of_[from]);
        if (face != no_index || at != no_index) break;
    }
    assert(face != no_index && "a point lies on the edge");
    if (face == no_index) return;
    std::vector<uint32_t> removed{face}, left{faces_[face].corner[before(k)]}, right{faces_[face].corner[next(k)]};
    size_t edge = next(k);
    while (true) {
        const uint32_t a = faces_[face].corner[edge], b = faces_[face].corner[next(edge)];
        face = faces_[face].beside[edge];
        assert(face != no_index);
        removed.push_back(face);
        size_t j = 0;
        while (faces_[face].corner[j] != b || faces_[face].corner[next(j)] != a) ++j;
        const uint32_t apex = faces_[face].corner[before(j)];
        if (apex == to) break;
        const bool is_left = turn(from, to, apex) > 0;
        (is_left ? left : right).push_back(apex);
        edge = is_left ? next(j) : before(j); // the edge between the last points on both sides
    }
    std::vector<std::array<uint32_t, 3>> added;
    std::vector<uint32_t> polygon{from, to};
    polygon.insert(polygon.end(), left.rbegin(), left.rend());
    fill(polygon, added);
    polygon.assign({to, from});
    polygon.insert(polygon.end(), right.begin(), right.end());
    fill(polygon, added);
    replace(removed, added);
    mark(find(from, to));
    flip_towards_delaunay();
}

// Replaces faces by as many others over the same region.
void PlanarMesh::replace(std::span<const uint32_t> removed, std::span<const std::array<uint32_t, 3>> added) {
    assert(removed.size() == added.size());
    std::vector<DirectedEdge> edges; // of the removed faces
    for (const uint32_t face : removed)
        for (size_t k = 0; k < 3; ++k) {
            const Face& f = faces_[face];
            const bool is_inner = std::find(removed.begin(), removed.end(), f.beside[k]) != removed.end();
            edges.push_back({f.corner[k], f.corner[next(k)], is_inner ? no_index : f.beside[k], f.constrained[k]});
        }
    for (size_t n = 0; n < added.size(); ++n) {
        Face f{added[n], {no_index, no_index, no_index}, {0, 0, 0}};
        for (size_t k = 0; k < 3; ++k) {
            const uint32_t from = f.corner[k], to = f.corner[next(k)];
            for (const DirectedEdge& edge : edges)
                if (edge.from == from && edge.to == to) {
                    f.beside[k] = edge.beside;
                    f.constrained[k] = edge.constrained;
                }
            for (size_t m = 0; m < added.size(); ++m)
                for (size_t j = 0; j < 3; ++j)
                    if (added[m][j] == to && added[m][next(j)] == from) f.beside[k] = removed[m];
            doubtful_.push_back({removed[n], k});
        }
        faces_[removed[n]] = f;
    }
    for (const uint32_t face : removed) put(face, Face(faces_[face]));
}

// Cuts a polygon into triangles, ear by ear. Its points may touch its sides.
void PlanarMesh::fill(std::vector<uint32_t> polygon, std::vector<std::array<uint32_t, 3>>& out) const {
    while (polygon.size() > 3) {
        size_t ear = 0;
        while (ear < polygon.size() && !is_ear(polygon, ear)) ++ear;
        assert(ear < polygon.size());
        if (ear == polygon.size()) ear = 0;
        const size_t n = polygon.size();
        out.push_back({polygon[(ear + n - 1) % n], polygon[ear], polygon[(ear + 1) % n]});
        polygon.erase(polygon.begin() + static_cast<std::ptrdiff_t>(ear));
    }
    out.push_back({polygon[0], polygon[1], polygon[2]});
}

bool PlanarMesh::is_ear(const std::vector<uint32_t>& polygon, size_t k) const {
    const size_t n = polygon.size();
    const std::array<uint32_t, 3> ear{polygon[(k + n - 1) % n], polygon[k], polygon[(k + 1) % n]};
    if (turn(ear[0], ear[1], ear[2]) <= 0) return false;
    for (const uint32_t p : polygon) {
        if (p == ear[0] || p == ear[1] || p == ear[2]) continue;
        if (turn(ear[0], ear[1], p) >= 0 && turn(ear[1], ear[2], p) >= 0 && turn(ear[2], ear[0], p) >= 0) return false;
    }
    return true;
}

} // namespace brittle::fracture::arrangement
