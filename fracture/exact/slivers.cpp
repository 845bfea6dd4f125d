#include "fracture/exact/slivers.h"

#include <algorithm>
#include <utility>

#include <glm/common.hpp>
#include <glm/geometric.hpp>

namespace brittle::fracture::exact {

namespace {

constexpr uint32_t min_cells_per_chunk = 4;

// A split may turn its neighbours into slivers, which are shorter. Slivers found after this many rounds stay.
constexpr int max_rounds = 8;

bool has(const std::array<uint32_t, 3>& corners, uint32_t point) {
    return corners[0] == point || corners[1] == point || corners[2] == point;
}

// The corner that is neither a nor b.
uint32_t third(const std::array<uint32_t, 3>& corners, uint32_t a, uint32_t b) {
    for (const uint32_t corner : corners) {
        if (corner != a && corner != b) return corner;
    }
    return no_index;
}

// In units of the minimum height. The height over the longest side is twice the area divided by its length.
bool is_sliver(const glm::dvec3& ab, const glm::dvec3& ac) {
    const glm::dvec3 bc = ac - ab, area = glm::cross(ab, ac);
    return glm::dot(area, area) <= std::max({glm::dot(ab, ab), glm::dot(ac, ac), glm::dot(bc, bc)});
}

} // namespace

uint32_t SliverCollapser::number(uint32_t point) const {
    return first_of_kind_[point >> 30] + (point & 0x3fffffffu);
}

VertexId SliverCollapser::id(uint32_t number) const {
    uint32_t kind = VertexId::node;
    while (number < first_of_kind_[kind]) --kind;
    return {static_cast<VertexId::Kind>(kind), number - first_of_kind_[kind]};
}

glm::dvec3 SliverCollapser::position(const Assembler::Input& input, uint32_t number) const {
    const VertexId point = id(number);
    return point.kind() == VertexId::mesh ? input.mesh.positions[point.index()]
                                          : cap_position(input.cut, point) * input.scene.to_input;
}

void SliverCollapser::find(std::span<const CellRun> cells, Threads& threads, const Fragments& out) {
    const auto count = static_cast<uint32_t>(cells.size());
    const uint32_t parts = threads.chunks(count, min_cells_per_chunk);
    if (found_by_chunk_.size() < parts) found_by_chunk_.resize(parts);
    threads.for_chunks(count, min_cells_per_chunk, [&](uint32_t chunk, uint32_t begin, uint32_t end) {
        std::vector<Sliver>& found = found_by_chunk_[chunk];
        found.clear();
        for (SiteId c = begin; c < end; ++c) {
            const CellRun& cell = cells[c];
            const glm::dvec3* const positions = out.positions.data() + cell.vertices.begin;
            for (uint32_t t = cell.triangles.begin + cell.whole_triangles; t < cell.triangles.end; ++t) {
                const bool is_cap = t >= cell.triangles.begin + cell.exterior;
                if (is_cap && out.triangle_source[t] < c) continue; // counted in the cell on the other side
                const Triangle& corners = out.triangles[t];
                const glm::dvec3& a = positions[corners.x];
                if (is_sliver((positions[corners.y] - a) * to_heights_, (positions[corners.z] - a) * to_heights_))
                    found.push_back({c, t});
            }
        }
    });
    slivers_.clear();
    for (uint32_t k = 0; k < parts; ++k)
        slivers_.insert(slivers_.end(), found_by_chunk_[k].begin(), found_by_chunk_[k].end());
}

void SliverCollapser::gather(const Assembler::Input& input, std::span<const CellRun> cells, const Fragments& out) {
    const auto count = [](const auto& points) { return static_cast<uint32_t>(points.size()); };
    first_of_kind_ = {0, count(input.mesh.positions)};
    first_of_kind_[2] = first_of_kind_[1] + count(input.cut.edge_points);
    first_of_kind_[3] = first_of_kind_[2] + count(input.cut.pierce_points);
    first_of_kind_[4] = first_of_kind_[3] + count(input.cut.nodes);
    const uint32_t points = first_of_kind_[4];
    became_.resize(points);
    for (uint32_t n = 0; n < points; ++n) became_[n] = n;
    local_.assign(points, no_index);
    cluster_.clear();
    in_cluster_.assign(points, 0);
    changed_.assign(cells.size(), 0);
    star_of_.assign(points, no_index);
    star_count_ = 0;
    faces_.clear();
    work_.clear();

    const auto corners_of = [&](const CellRun& cell, uint32_t t) {
        std::array<uint32_t, 3> corners{};
        for (int k = 0; k < 3; ++k)
            corners[static_cast<size_t>(k)] = number(out.vertex_point[cell.vertices.begin + out.triangles[t][k]]);
        return corners;
    };
    for (const Sliver& sliver : slivers_) {
        for (const uint32_t corner : corners_of(cells[sliver.cell], sliver.triangle)) {
            if (is_gathered(corner)) continue;
            star_of_[corner] = star_count_++;
            if (stars_.size() < star_count_) stars_.emplace_back();
            stars_[star_of_[corner]].clear();
        }
    }
    auto sliver = slivers_.begin();
    for (SiteId c = 0; c < cells.size(); ++c) {
        const CellRun& cell = cells[c];
        for (uint32_t t = cell.triangles.begin; t < cell.triangles.end; ++t) {
            const auto corners = corners_of(cell, t);
            if (std::none_of(corners.begin(), corners.end(), [&](uint32_t n) { return is_gathered(n); })) continue;
            if (sliver != slivers_.end() && sliver->triangle == t) {
                work_.push_back(count(faces_));
                ++sliver;
            }
            const uint32_t rank = t - cell.triangles.begin;
            add_face({corners, c, t, out.triangle_source[t], rank < cell.exterior, rank < cell.whole_triangles});
        }
    }
    gathered_ = count(faces_);
}

void SliverCollapser::add_face(const Face& face) {
    for (const uint32_t corner : face.corners) {
        if (is_gathered(corner)) stars_[star_of_[corner]].push_back(static_cast<uint32_t>(faces_.size()));
    }
    faces_.push_back(face);
}

std::span<const uint32_t> SliverCollapser::star(uint32_t point) {
    std::vector<uint32_t>& star = stars_[star_of_[point]];
    std::erase_if(star, [&](uint32_t f) { return !faces_[f].alive || !has(faces_[f].corners, point); });
    return star;
}

void SliverCollapser::start_cluster() {
    for (const uint32_t point : cluster_) in_cluster_[point] = 0;
    cluster_.clear();
}

void SliverCollapser::add_to_cluster(uint32_t point) {
    cluster_.push_back(point);
    in_cluster_[point] = 1;
}

bool SliverCollapser::mend_all(const Assembler::Input& input) {
    bool any = false;
    size_t max_faces = 4 * faces_.size();
    for (bool again = true; again;) {
        again = false;
        for (size_t k = 0; k < work_.size() && faces_.size() < max_faces; ++k) {
            if (faces_[work_[k]].alive && mend(input, work_[k])) again = any = true;
        }
    }
    return any;
}

bool SliverCollapser::mend(const Assembler::Input& input, uint32_t face) {
    const auto corners = faces_[face].corners;
    if (!is_gathered(corners[0]) || !is_gathered(corners[1]) || !is_gathered(corners[2])) return false;
    std::array<glm::dvec3, 3> at{};
    for (size_t k = 0; k < 3; ++k) at[k] = position(input, corners[k]);
    if (!is_sliver((at[1] - at[0]) * to_heights_, (at[2] - at[0]) * to_heights_)) return false;
    struct Side {
        double length;
        size_t from;
    };
    std::array<Side, 3> sides{};
    for (size_t k = 0; k < 3; ++k) sides[k] = {glm::length((at[(k + 1) % 3] - at[k]) * to_heights_), k};
    std::stable_sort(sides.begin(), sides.end(), [](const Side& x, const Side& y) { return x.length < y.length; });
    for (const Side& side : sides) {
        if (side.length > 1.0) break;
        start_cluster();
        add_to_cluster(corners[side.from]);
        add_to_cluster(corners[(side.from + 1) % 3]);
        if (collapse()) return true;
    }
    if (sides[0].length <= 1.0) {
        find_cluster(input, corners[sides[0].from]);
        if (collapse()) return true;
    }
    // A split shortens nothing where a side is short: the remaining part is about as long as the longest side.
    if (sides[0].length <= 1.0) return false;
    const size_t from = sides[2].from;
    return split(corners[from], corners[(from + 1) % 3], corners[(from + 2) % 3]);
}

// Collects the points that are connected with the seed by sides of at most the minimum height, and no farther from it.
void SliverCollapser::find_cluster(const Assembler::Input& input, uint32_t seed) {
    start_cluster();
    add_to_cluster(seed);
    const glm::dvec3 centre = position(input, seed);
    for (size_t k = 0; k < cluster_.size(); ++k) {
        for (const uint32_t f : star(cluster_[k])) {
            for (const uint32_t corner : faces_[f].corners) {
                if (!is_gathered(corner) || in_cluster_[corner]) continue;
                if (glm::distance(position(input, corner), centre) * to_heights_ <= 1.0) add_to_cluster(corner);
            }
        }
    }
}

// The link condition for the cluster. In every cell, the triangles with exactly one corner in the cluster remain; their
// sides opposite to the cluster must form one simple loop. No triangle remains where the cluster was a whole island;
// two remain where that island was flat.
bool SliverCollapser::may_collapse() {
    std::sort(cluster_.begin(), cluster_.end());
    if (cluster_[1] < first_of_kind_[VertexId::edge]) return false; // two vertices of the mesh do not merge
    moved_.clear();
    two_sided_.clear();
    for (const uint32_t point : cluster_) {
        const auto around = star(point);
        moved_.insert(moved_.end(), around.begin(), around.end());
    }
    std::sort(moved_.begin(), moved_.end(),
              [&](uint32_t x, uint32_t y) { return std::pair(faces_[x].cell, x) < std::pair(faces_[y].cell, y); });
    moved_.erase(std::unique(moved_.begin(), moved_.end()), moved_.end());
    for (auto begin = moved_.begin(), end = begin; begin != moved_.end(); begin = end) {
        const SiteId cell = faces_[*begin].cell;
        loop_.clear();
        uint32_t present = no_index;
        bool several = false;
        for (; end != moved_.end() && faces_[*end].cell == cell; ++end) {
            const auto& corners = faces_[*end].corners;
            uint32_t inside = 0;
            size_t last = 0;
            for (size_t k = 0; k < 3; ++k) {
                if (!in_cluster_[corners[k]]) continue;
                ++inside;
                last = k;
                several = several || (present != no_index && present != corners[k]);
                present = corners[k];
            }
            if (inside == 1) loop_.push_back({corners[(last + 1) % 3], corners[(last + 2) % 3], *end});
        }
        if (!several) continue;
        if (!is_one_loop()) return false;
        if (loop_.size() == 2) two_sided_.push_back({loop_[0][2], loop_[1][2]});
    }
    return true;
}

// Whether the sides in loop_ form one simple loop. True for no side.
bool SliverCollapser::is_one_loop() {
    if (loop_.empty()) return true;
    std::sort(loop_.begin(), loop_.end());
    size_t length = 0;
    uint32_t at = loop_.front()[0];
    do {
        const auto side = std::lower_bound(loop_.begin(), loop_.end(), std::array{at, 0u, 0u});
        if (side == loop_.end() || (*side)[0] != at) return false;
        if (side + 1 != loop_.end() && (*(side + 1))[0] == at) return false;
        at = (*side)[1];
    } while (++length < loop_.size() && at != loop_.front()[0]);
    return length == loop_.size() && at == loop_.front()[0];
}

// Merges the points of cluster_ into the lowest of them.
bool SliverCollapser::collapse() {
    if (cluster_.size() < 2 || !may_collapse()) return false;
    const uint32_t kept = cluster_.front();
    for (const uint32_t point : cluster_) became_[point] = kept;
    for (const uint32_t f : moved_) {
        Face& face = faces_[f];
        changed_[face.cell] = 1;
        uint32_t inside = 0;
        const bool had = has(face.corners, kept);
        for (uint32_t& corner : face.corners) {
            if (!in_cluster_[corner]) continue;
            corner = kept;
            ++inside;
        }
        face.alive = inside == 1;
        if (face.alive && !had) stars_[star_of_[kept]].push_back(f);
    }
    for (const auto& [f, g] : two_sided_) drop_two_sided(kept, f, g);
    return true;
}

// Drops two triangles back to back. In the neighbouring cell, the face across one of them gets the source of the other,
// since that now lies across.
void SliverCollapser::drop_two_sided(uint32_t corner, uint32_t f, uint32_t g) {
    const Face one = faces_[f], two = faces_[g];
    faces_[f].alive = faces_[g].alive = false;
    const auto redirect = [&](const Face& from, const Face& to) {
        if (from.exterior || (!to.exterior && to.source == from.source)) return;
        for (const uint32_t h : star(corner)) {
            Face& across = faces_[h];
            if (across.cell != from.source || across.exterior || across.source != from.cell) continue;
            if (!has(across.corners, from.corners[0]) || !has(across.corners, from.corners[1])
                || !has(across.corners, from.corners[2]))
                continue;
            across.source = to.source;
            across.exterior = to.exterior;
            changed_[across.cell] = 1;
        }
    };
    redirect(one, two);
    redirect(two, one);
}

bool SliverCollapser::may_split(uint32_t a, uint32_t b, uint32_t c) {
    for (const uint32_t f : star(a)) {
        if (!has(faces_[f].corners, b)) continue;
        const SiteId cell = faces_[f].cell;
        opposite_.clear();
        for (const uint32_t g : star(a)) {
            if (faces_[g].cell == cell && has(faces_[g].corners, b))
                opposite_.push_back(third(faces_[g].corners, a, b));
        }
        if (opposite_.size() != 2 || opposite_[0] == opposite_[1]) return false;
        const bool is_flip = opposite_[0] == c || opposite_[1] == c;
        const uint32_t far = opposite_[0] == c ? opposite_[1] : opposite_[0];
        for (const uint32_t g : star(c)) {
            if (faces_[g].cell == cell && (!is_flip || has(faces_[g].corners, far))) return false;
        }
    }
    return true;
}

bool SliverCollapser::split(uint32_t a, uint32_t b, uint32_t c) {
    if (!may_split(a, b, c)) return false;
    const auto around = star(a);
    moved_.assign(around.begin(), around.end());
    for (const uint32_t f : moved_) {
        if (!has(faces_[f].corners, b)) continue;
        changed_[faces_[f].cell] = 1;
        if (has(faces_[f].corners, c)) {
            faces_[f].alive = false;
            continue;
        }
        faces_[f].whole = false;
        Face far_half = faces_[f];
        far_half.triangle = no_index;
        for (uint32_t& corner : far_half.corners) corner = corner == a ? c : corner;
        for (uint32_t& corner : faces_[f].corners) corner = corner == b ? c : corner;
        stars_[star_of_[c]].push_back(f);
        work_.push_back(f);
        work_.push_back(static_cast<uint32_t>(faces_.size()));
        add_face(far_half);
    }
    return true;
}

void SliverCollapser::rebuild(const Assembler::Input& input, std::span<CellRun> cells, Fragments& out) {
    rebuilt_.positions.clear();
    rebuilt_.vertex_point.clear();
    rebuilt_.triangles.clear();
    rebuilt_.triangle_source.clear();
    added_.clear();
    for (uint32_t f = gathered_; f < faces_.size(); ++f) added_.push_back(f);
    std::stable_sort(added_.begin(), added_.end(),
                     [&](uint32_t x, uint32_t y) { return faces_[x].cell < faces_[y].cell; });
    uint32_t gathered = 0;
    auto added = added_.begin();
    for (SiteId c = 0; c < cells.size(); ++c) {
        const auto added_begin = added;
        while (added != added_.end() && faces_[*added].cell == c) ++added;
        const uint32_t gathered_begin = gathered;
        while (gathered < gathered_ && faces_[gathered].cell == c) ++gathered;
        if (changed_[c]) {
            const auto first = static_cast<size_t>(added_begin - added_.begin());
            const std::span<const uint32_t> of_cell(added_);
            collect(cells[c], gathered_begin, of_cell.subspan(first, static_cast<size_t>(added - added_begin)), out);
            place(input, cells[c], out);
        } else {
            copy(cells[c], out);
        }
    }
    std::swap(out.positions, rebuilt_.positions);
    std::swap(out.vertex_point, rebuilt_.vertex_point);
    std::swap(out.triangles, rebuilt_.triangles);
    std::swap(out.triangle_source, rebuilt_.triangle_source);
}

// Collects the current triangles of a cell: gathered ones in their present state, the others unchanged, then new ones.
void SliverCollapser::collect(const CellRun& cell, uint32_t gathered, std::span<const uint32_t> added,
                              const Fragments& out) {
    collected_.clear();
    for (uint32_t t = cell.triangles.begin; t < cell.triangles.end; ++t) {
        if (gathered < gathered_ && faces_[gathered].triangle == t) {
            if (faces_[gathered].alive) collected_.push_back(faces_[gathered]);
            ++gathered;
            continue;
        }
        const uint32_t rank = t - cell.triangles.begin;
        Face face{{}, 0, t, out.triangle_source[t], rank < cell.exterior, rank < cell.whole_triangles};
        for (int k = 0; k < 3; ++k)
            face.corners[static_cast<size_t>(k)] = number(out.vertex_point[cell.vertices.begin + out.triangles[t][k]]);
        collected_.push_back(face);
    }
    for (const uint32_t f : added) {
        if (faces_[f].alive) collected_.push_back(faces_[f]);
    }
    const auto section = [](const Face& face) { return face.whole ? 0 : (face.exterior ? 1 : 2); };
    std::stable_sort(collected_.begin(), collected_.end(),
                     [&](const Face& x, const Face& y) { return section(x) < section(y); });
}

void SliverCollapser::place(const Assembler::Input& input, CellRun& cell, const Fragments& out) {
    constexpr uint32_t in_use = no_index - 1;
    const Range old = cell.vertices;
    const auto first = static_cast<uint32_t>(rebuilt_.positions.size());
    for (const Face& face : collected_) {
        for (const uint32_t corner : face.corners) local_[corner] = in_use;
    }
    const auto put = [&](uint32_t point) {
        if (local_[point] != in_use) return;
        local_[point] = static_cast<uint32_t>(rebuilt_.positions.size()) - first;
        rebuilt_.positions.push_back(position(input, point));
        rebuilt_.vertex_point.push_back(id(point).bits());
    };
    uint32_t mesh_vertices = 0;
    for (uint32_t v = old.begin; v < old.end; ++v) {
        uint32_t point = number(out.vertex_point[v]);
        while (became_[point] != point) point = became_[point];
        put(point);
        if (v + 1 == old.begin + cell.mesh_vertices)
            mesh_vertices = static_cast<uint32_t>(rebuilt_.positions.size()) - first;
    }
    const auto first_triangle = static_cast<uint32_t>(rebuilt_.triangles.size());
    cell.whole_triangles = cell.exterior = 0;
    for (const Face& face : collected_) {
        for (const uint32_t corner : face.corners) put(corner); // points that a split brought into the cell
        const auto& [a, b, c] = face.corners;
        rebuilt_.triangles.push_back({local_[a], local_[b], local_[c]});
        rebuilt_.triangle_source.push_back(face.source);
        cell.whole_triangles += face.whole ? 1 : 0;
        cell.exterior += face.exterior ? 1 : 0;
    }
    cell.vertices = {first, static_cast<uint32_t>(rebuilt_.positions.size())};
    cell.triangles = {first_triangle, static_cast<uint32_t>(rebuilt_.triangles.size())};
    cell.mesh_vertices = mesh_vertices;
}

void SliverCollapser::copy(CellRun& cell, const Fragments& out) {
    append_range(out.vertex_point, cell.vertices, rebuilt_.vertex_point);
    append_range(out.triangle_source, cell.triangles, rebuilt_.triangle_source);
    cell.vertices = append_range(out.positions, cell.vertices, rebuilt_.positions);
    cell.triangles = append_range(out.triangles, cell.triangles, rebuilt_.triangles);
}

void SliverCollapser::run(const Assembler::Input& input, std::span<CellRun> cells, Threads& threads, Fragments& out) {
    const glm::dvec3 furthest = glm::max(glm::abs(input.scene.box.min), glm::abs(input.scene.box.max));
    to_heights_ = input.scene.to_scene / (min_height * std::max({furthest.x, furthest.y, furthest.z}));
    find(cells, threads, out);
    found_ = slivers_.size();
    for (int round = 0; round < max_rounds && !slivers_.empty(); ++round) {
        gather(input, cells, out);
        if (!mend_all(input)) return;
        rebuild(input, cells, out);
        find(cells, threads, out);
    }
}

} // namespace brittle::fracture::exact
