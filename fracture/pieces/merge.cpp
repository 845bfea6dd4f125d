#include "fracture/pieces/merge.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <map>
#include <numeric>
#include <queue>
#include <tuple>
#include <utility>

#include <glm/geometric.hpp>

#include "fracture/base/union_find.h"
#include "fracture/pieces/cap_pairs.h"
#include "fracture/pieces/sewing.h"

namespace brittle::fracture {

namespace {

constexpr uint32_t none = CapPairs::none;

// Tolerances of sticks_out(): the fraction of a sheet's side that counts as all of it, and the overhang, in units of
// the box's diagonal, that counts as none.
constexpr double whole_side = 1.0 - 1e-6;
constexpr double touching = 1e-9;

// Disjoint sets of pieces, with their volumes, surface areas and contacts.
class PieceSets {
  public:
    explicit PieceSets(const Fragments& fragments)
        : parent_(fragments.pieces.size()), name_(parent_.size()), contacts_(parent_.size()) {
        std::iota(parent_.begin(), parent_.end(), 0u);
        std::iota(name_.begin(), name_.end(), 0u);
        volume_.reserve(parent_.size());
        for (const Piece& piece : fragments.pieces) {
            volume_.push_back(piece.mass.volume);
            area_.push_back(piece.mass.area);
        }
        for (const Bond& bond : fragments.bonds) {
            contacts_[bond.a][bond.b] += bond.area;
            contacts_[bond.b][bond.a] += bond.area;
        }
    }

    uint32_t root(uint32_t piece) { return root_of(parent_, piece); }
    // The functions below take roots.
    [[nodiscard]] double volume(uint32_t root) const { return volume_[root]; }
    [[nodiscard]] uint32_t name(uint32_t root) const { return name_[root]; } // a piece of the set
    // Returns the set with the largest contact area; none without contacts.
    [[nodiscard]] uint32_t neighbour(uint32_t root) const {
        uint32_t best = none;
        double area = 0.0;
        for (const auto& [other, contact] : contacts_[root]) {
            if (contact > area || (contact == area && best != none && name_[other] < name_[best])) {
                area = contact;
                best = other;
            }
        }
        return best;
    }

    [[nodiscard]] const std::map<uint32_t, double>& contacts(uint32_t root) const { return contacts_[root]; }
    [[nodiscard]] double area(uint32_t root) const { return area_[root]; } // surface area

    // Unites the sets of two roots. Returns the new root, which is the root with more neighbours.
    uint32_t unite(uint32_t a, uint32_t b, uint32_t name) {
        const auto between = contacts_[a].find(b);
        const double contact = between == contacts_[a].end() ? 0.0 : between->second;
        contacts_[a].erase(b);
        contacts_[b].erase(a);
        const bool a_stays = contacts_[a].size() >= contacts_[b].size();
        const uint32_t stays = a_stays ? a : b, goes = a_stays ? b : a;
        parent_[goes] = stays;
        name_[stays] = name;
        volume_[stays] += volume_[goes];
        area_[stays] += area_[goes] - 2.0 * contact;
        for (const auto& [other, area] : contacts_[goes]) {
            contacts_[other].erase(goes);
            contacts_[other][stays] = contacts_[stays][other] += area;
        }
        contacts_[goes].clear();
        return stays;
    }

  private:
    std::vector<uint32_t> parent_, name_;
    std::vector<double> volume_, area_;
    std::vector<std::map<uint32_t, double>> contacts_; // per root: contact areas by neighbouring root
};

} // namespace

namespace {

double exterior_area(const Fragments& fragments, const Piece& piece) {
    const auto positions = fragments.positions_of(piece);
    double sum = 0.0;
    for (const Triangle& t : fragments.triangles_of(piece).first(piece.exterior_triangles))
        sum += 0.5 * glm::length(glm::cross(positions[t.y] - positions[t.x], positions[t.z] - positions[t.x]));
    return sum;
}

} // namespace

std::vector<uint32_t> choose_mergers(const Fragments& fragments, const MergeRules& rules) {
    const auto count = static_cast<uint32_t>(fragments.pieces.size());
    PieceSets sets(fragments);
    if (!rules.group_of_site.empty()) {
        const CapPairs caps(fragments,
                            [&](uint32_t a, uint32_t b) { return rules.group_of_site[a] == rules.group_of_site[b]; });
        for (uint32_t t = 0; t < fragments.triangles.size(); ++t) {
            if (caps.across(t) == none) continue;
            const uint32_t a = sets.root(caps.piece_of(t)), b = sets.root(caps.piece_of(caps.across(t)));
            if (a != b) sets.unite(a, b, std::min(sets.name(a), sets.name(b)));
        }
    }
    std::vector<uint8_t> flat(count, rules.flat.empty() ? 0 : 1); // per root: 1 if all pieces of the set are flat
    for (uint32_t p = 0; p < rules.flat.size(); ++p)
        if (!rules.flat[p]) flat[sets.root(p)] = 0;

    const auto box_of = [&](uint32_t root) {
        constexpr double infinity = std::numeric_limits<double>::infinity();
        Box box{glm::dvec3(infinity), glm::dvec3(-infinity)};
        for (uint32_t p = 0; p < count; ++p) {
            if (sets.root(p) != root) continue;
            for (const glm::dvec3& v : fragments.positions_of(fragments.pieces[p]))
                box = {glm::min(box.min, v), glm::max(box.max, v)};
        }
        return box;
    };
    const auto grows_by = [&](uint32_t root, uint32_t by) {
        const Box box = box_of(root), other = box_of(by);
        const glm::dvec3 beyond = glm::max(box.min - other.min, other.max - box.max);
        return std::max({beyond.x, beyond.y, beyond.z}) > touching * glm::length(box.size());
    };
    // Returns whether merging a sheet into one neighbour would leave it sticking out: a sheet on the outside of the
    // solid may cover several neighbours.
    const auto sticks_out = [&](uint32_t root, uint32_t other) {
        double outside = 0.0;
        for (uint32_t p = 0; p < count; ++p)
            if (sets.root(p) == root) outside += exterior_area(fragments, fragments.pieces[p]);
        // About half of the surface of a sheet is exterior, less where the input folds it; a speck inside the solid has
        // no exterior surface.
        return outside >= 0.25 * sets.area(root)
               && (sets.contacts(root).at(other) < 0.5 * whole_side * sets.area(root) || grows_by(other, root));
    };
    const auto find_mate = [&](uint32_t root) {
        if (rules.group_of_site.empty()) return none;
        const auto group = [&](uint32_t r) { return rules.group_of_site[fragments.pieces[sets.name(r)].site]; };
        for (const auto& [other, contact] : sets.contacts(root))
            if (group(other) == group(root)) return other;
        return none;
    };
    using Entry = std::tuple<double, uint32_t, uint32_t>; // volume, name, root
    std::priority_queue<Entry, std::vector<Entry>, std::greater<>> smallest;
    const auto enqueue = [&](uint32_t root) {
        const double volume = std::abs(sets.volume(root));
        if (flat[root] || volume < rules.min_volume) smallest.push({volume, sets.name(root), root});
    };
    for (uint32_t p = 0; p < count; ++p)
        if (sets.root(p) == p) enqueue(p);
    while (!smallest.empty()) {
        const auto [volume, name, root] = smallest.top();
        smallest.pop();
        if (sets.root(root) != root || volume != std::abs(sets.volume(root)) || name != sets.name(root)) continue;
        const uint32_t other = sets.neighbour(root);
        if (other == none || (flat[root] && sticks_out(root, other))) continue;
        const uint8_t both_flat = flat[root] & flat[other];
        uint32_t united = sets.unite(root, other, sets.name(other));
        flat[united] = both_flat;
        // The merged piece may have separated two pieces of a group; these are now in contact.
        for (uint32_t mate = find_mate(united); mate != none; mate = find_mate(united)) {
            const uint8_t flat_too = flat[united] & flat[mate];
            united = sets.unite(united, mate, std::min(sets.name(united), sets.name(mate)));
            flat[united] = flat_too;
        }
        enqueue(united);
    }
    std::vector<uint32_t> representative(count);
    for (uint32_t p = 0; p < count; ++p) {
        const uint32_t root = sets.root(p);
        representative[p] = flat[root] ? dropped : sets.name(root);
    }
    return representative;
}

namespace {

void copy_piece(const Fragments& from, Piece piece, Fragments& to) {
    append_range(from.vertex_point, piece.vertices, to.vertex_point);
    append_range(from.triangle_source, piece.triangles, to.triangle_source);
    piece.vertices = append_range(from.positions, piece.vertices, to.positions);
    piece.triangles = append_range(from.triangles, piece.triangles, to.triangles);
    to.pieces.push_back(piece);
}

std::vector<Bond> merge_bonds(std::span<const Bond> bonds, std::span<const uint32_t> new_index) {
    std::map<std::pair<uint32_t, uint32_t>, Bond> merged;
    for (const Bond& bond : bonds) {
        const uint32_t a = new_index[bond.a], b = new_index[bond.b];
        if (a == b || a == none || b == none) continue;
        Bond& sum = merged.try_emplace(std::minmax(a, b), Bond{std::min(a, b), std::max(a, b)}).first->second;
        sum.area += bond.area;
        sum.centroid += bond.area * bond.centroid;
        sum.normal += (a < b ? bond.area : -bond.area) * bond.normal;
    }
    std::vector<Bond> result;
    for (auto& [ends, bond] : merged) {
        bond.centroid /= bond.area;
        const double length = glm::length(bond.normal);
        // No direction is meaningful where one piece surrounds the other.
        bond.normal = length > 1e-9 * bond.area ? bond.normal / length : glm::dvec3(0.0, 1.0, 0.0);
        result.push_back(bond);
    }
    return result;
}

} // namespace

void merge_pieces(Fragments& fragments, std::span<const uint32_t> representative, Threads& threads) {
    const auto count = static_cast<uint32_t>(fragments.pieces.size());
    std::vector<std::vector<uint32_t>> members(count);
    bool any = false;
    for (uint32_t p = 0; p < count; ++p) {
        any = any || representative[p] != p;
        if (representative[p] != dropped) members[representative[p]].push_back(p);
    }
    if (!any) return;

    std::vector<uint32_t> parts_of_source;
    for (const Piece& piece : fragments.pieces) {
        for (uint32_t t = piece.triangles.begin; t < piece.triangles.begin + piece.exterior_triangles; ++t) {
            const uint32_t source = fragments.triangle_source[t];
            if (source >= parts_of_source.size()) parts_of_source.resize(size_t{source} + 1, 0);
            ++parts_of_source[source];
        }
    }
    std::vector<uint8_t> changes; // per site: 1 if one of its pieces changes
    for (const Piece& piece : fragments.pieces)
        if (piece.site >= changes.size()) changes.resize(size_t{piece.site} + 1, 0);
    for (uint32_t p = 0; p < count; ++p)
        if (representative[p] != p) changes[fragments.pieces[p].site] = 1;
    const CapPairs caps(fragments, [&](uint32_t a, uint32_t b) {
        return (a < changes.size() && changes[a]) || (b < changes.size() && changes[b]);
    });
    const auto is_as_before = [&](uint32_t p) {
        if (members[p].size() > 1) return false;
        const Range& triangles = fragments.pieces[p].triangles;
        for (uint32_t t = triangles.begin + fragments.pieces[p].exterior_triangles; t < triangles.end; ++t) {
            const uint32_t across = caps.across(t);
            if (across != none && representative[caps.piece_of(across)] != caps.piece_of(across)) return false;
        }
        return true;
    };
    const SewingPlan plan{fragments, representative, caps, parts_of_source};
    // Sets are sewn in parallel, each into fragments of its own and with a range of its own for the points of halved
    // edges.
    struct Set {
        uint32_t piece;
        uint32_t next_point;
        Fragments sewn{};
    };
    std::vector<Set> sets;
    uint32_t next_point = 1 + *std::max_element(fragments.vertex_point.begin(), fragments.vertex_point.end());
    for (uint32_t p = 0; p < count; ++p) {
        if (members[p].empty() || is_as_before(p)) continue;
        sets.push_back({p, next_point});
        for (const uint32_t member : members[p]) next_point += 3 * fragments.pieces[member].triangles.size();
    }
    threads.for_chunks(static_cast<uint32_t>(sets.size()), 1, [&](uint32_t, uint32_t begin, uint32_t end) {
        for (uint32_t k = begin; k < end; ++k) {
            auto& [piece, point, sewn] = sets[k];
            sewn.pieces = {sew_pieces(plan, members[piece], point, sewn)};
            sewn.pieces[0].site = fragments.pieces[piece].site;
            sewn.pieces[0].mass = mass_properties(sewn.positions, sewn.triangles);
        }
    });
    Fragments merged;
    std::vector<uint32_t> new_index(count, none);
    auto set = sets.begin();
    for (uint32_t p = 0; p < count; ++p) {
        if (members[p].empty()) continue;
        for (const uint32_t member : members[p]) new_index[member] = static_cast<uint32_t>(merged.pieces.size());
        const bool is_sewn = set != sets.end() && set->piece == p;
        const Fragments& from = is_sewn ? set->sewn : fragments;
        copy_piece(from, is_sewn ? from.pieces[0] : from.pieces[p], merged);
        if (is_sewn) ++set;
    }
    merged.bonds = merge_bonds(fragments.bonds, new_index);
    merged.timings = std::move(fragments.timings);
    fragments = std::move(merged);
}

} // namespace brittle::fracture
