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

#include <glm/common.hpp>
#include <glm/geometric.hpp>

#include "fracture/base/union_find.h"
#include "fracture/mesh/islands.h"
#include "fracture/pieces/cap_pairs.h"
#include "fracture/pieces/sewing.h"

namespace brittle::fracture {

namespace {

// The fraction of a sheet's side that counts as the whole side, up to rounding.
constexpr double whole_side = 1.0 - 1e-6;

// The overhang, in units of the diagonal of a set's box, that is zero up to rounding.
constexpr double max_overhang = 1e-9;

// Disjoint sets of pieces, with their volumes, surface areas and contacts.
class PieceSets {
  public:
    explicit PieceSets(const Fragments& fragments)
        : parent_(fragments.pieces.size()), representative_(parent_.size()), contacts_(parent_.size()) {
        std::iota(parent_.begin(), parent_.end(), 0u);
        std::iota(representative_.begin(), representative_.end(), 0u);
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
    [[nodiscard]] uint32_t representative(uint32_t root) const { return representative_[root]; } // a piece of the set
    // Returns the set with the largest contact area; no_index without contacts.
    [[nodiscard]] uint32_t neighbour(uint32_t root) const {
        uint32_t best = no_index;
        double area = 0.0;
        for (const auto& [other, contact] : contacts_[root]) {
            if (contact > area
                || (contact == area && best != no_index && representative_[other] < representative_[best])) {
                area = contact;
                best = other;
            }
        }
        return best;
    }

    [[nodiscard]] const std::map<uint32_t, double>& contacts(uint32_t root) const { return contacts_[root]; }
    [[nodiscard]] double area(uint32_t root) const { return area_[root]; } // surface area

    // Unites the sets of two roots. Returns the new root, which is the root with more neighbours.
    uint32_t unite(uint32_t a, uint32_t b, uint32_t representative) {
        const auto between = contacts_[a].find(b);
        const double contact = between == contacts_[a].end() ? 0.0 : between->second;
        contacts_[a].erase(b);
        contacts_[b].erase(a);
        const bool keep_a = contacts_[a].size() >= contacts_[b].size();
        const uint32_t kept = keep_a ? a : b, absorbed = keep_a ? b : a;
        parent_[absorbed] = kept;
        representative_[kept] = representative;
        volume_[kept] += volume_[absorbed];
        area_[kept] += area_[absorbed] - 2.0 * contact;
        for (const auto& [other, area] : contacts_[absorbed]) {
            contacts_[other].erase(absorbed);
            contacts_[other][kept] = contacts_[kept][other] += area;
        }
        contacts_[absorbed].clear();
        return kept;
    }

  private:
    std::vector<uint32_t> parent_, representative_;
    std::vector<double> volume_, area_;
    std::vector<std::map<uint32_t, double>> contacts_; // per root: contact area with each neighbouring root
};

double exterior_area(const Fragments& fragments, const Piece& piece) {
    const auto positions = fragments.positions_of(piece);
    double sum = 0.0;
    for (const Triangle& t : fragments.triangles_of(piece).first(piece.exterior_triangles))
        sum += 0.5 * glm::length(glm::cross(positions[t.y] - positions[t.x], positions[t.z] - positions[t.x]));
    return sum;
}

// The decisions of choose_mergers(). Call the phases in their order.
class MergerChoice {
  public:
    MergerChoice(const Fragments& fragments, const MergeRules& rules)
        : fragments_(fragments), rules_(rules), count_(static_cast<uint32_t>(fragments.pieces.size())),
          sets_(fragments) {}

    // Phase 1: unites adjacent pieces of one group.
    void unite_groups() {
        if (rules_.group_of_site.empty()) return;
        const std::span<const uint32_t> group = rules_.group_of_site;
        const CapPairs caps(fragments_, [&](uint32_t a, uint32_t b) { return group[a] == group[b]; });
        for (uint32_t t = 0; t < fragments_.triangles.size(); ++t) {
            if (caps.across(t) == no_index) continue;
            const uint32_t a = sets_.root(caps.piece_of(t)), b = sets_.root(caps.piece_of(caps.across(t)));
            if (a != b) sets_.unite(a, b, std::min(sets_.representative(a), sets_.representative(b)));
        }
    }

    // Phase 2: merges flat and small sets into their neighbours, in ascending order of volume.
    void absorb_small_sets() {
        flat_.assign(count_, rules_.flat.empty() ? 0 : 1);
        for (uint32_t p = 0; p < rules_.flat.size(); ++p)
            if (!rules_.flat[p]) flat_[sets_.root(p)] = 0;
        small_.assign(count_, rules_.small.empty() ? 0 : 1);
        for (uint32_t p = 0; p < rules_.small.size(); ++p)
            if (!rules_.small[p]) small_[sets_.root(p)] = 0;
        for (uint32_t p = 0; p < count_; ++p)
            if (sets_.root(p) == p) enqueue(p);
        while (!smallest_.empty()) {
            const auto [volume, piece, root] = smallest_.top();
            smallest_.pop();
            if (sets_.root(root) != root || volume != std::abs(sets_.volume(root))
                || piece != sets_.representative(root))
                continue; // an outdated entry
            const uint32_t other = sets_.neighbour(root);
            if (other == no_index || (flat_[root] && sticks_out(root, other))) continue;
            uint32_t united = unite(root, other, sets_.representative(other));
            // The absorbed set may have separated two pieces of a group, which are now in contact.
            for (uint32_t mate = find_mate(united); mate != no_index; mate = find_mate(united))
                united = unite(united, mate, std::min(sets_.representative(united), sets_.representative(mate)));
            enqueue(united);
        }
    }

    [[nodiscard]] std::vector<uint32_t> representatives() {
        std::vector<uint32_t> representative(count_);
        for (uint32_t p = 0; p < count_; ++p) {
            const uint32_t root = sets_.root(p);
            representative[p] = flat_[root] ? dropped : sets_.representative(root);
        }
        return representative;
    }

  private:
    using Entry = std::tuple<double, uint32_t, uint32_t>; // volume, representative, root

    void enqueue(uint32_t root) {
        const double volume = std::abs(sets_.volume(root));
        if (flat_[root] || small_[root] || volume < rules_.min_volume)
            smallest_.push({volume, sets_.representative(root), root});
    }

    uint32_t unite(uint32_t a, uint32_t b, uint32_t representative) {
        const uint8_t both_flat = flat_[a] & flat_[b], both_small = small_[a] & small_[b];
        const uint32_t united = sets_.unite(a, b, representative);
        flat_[united] = both_flat;
        small_[united] = both_small;
        return united;
    }

    // Returns an adjacent set of the same group, or no_index.
    [[nodiscard]] uint32_t find_mate(uint32_t root) const {
        if (rules_.group_of_site.empty()) return no_index;
        const auto group = [&](uint32_t r) {
            return rules_.group_of_site[fragments_.pieces[sets_.representative(r)].site];
        };
        for (const auto& [other, contact] : sets_.contacts(root))
            if (group(other) == group(root)) return other;
        return no_index;
    }

    [[nodiscard]] Box box_of(uint32_t root) {
        constexpr double infinity = std::numeric_limits<double>::infinity();
        Box box{glm::dvec3(infinity), glm::dvec3(-infinity)};
        for (uint32_t p = 0; p < count_; ++p) {
            if (sets_.root(p) != root) continue;
            for (const glm::dvec3& v : fragments_.positions_of(fragments_.pieces[p]))
                box = {glm::min(box.min, v), glm::max(box.max, v)};
        }
        return box;
    }

    // Returns whether the box of the set with the given root grows if `added` is merged into it.
    [[nodiscard]] bool grows_by(uint32_t root, uint32_t added) {
        const Box box = box_of(root), other = box_of(added);
        const glm::dvec3 beyond = glm::max(box.min - other.min, other.max - box.max);
        return std::max({beyond.x, beyond.y, beyond.z}) > max_overhang * glm::length(box.size());
    }

    // Returns whether a sheet would stick out of the neighbour that absorbs it: a sheet on the outside of the solid may
    // cover several neighbours.
    [[nodiscard]] bool sticks_out(uint32_t root, uint32_t other) {
        double outside = 0.0;
        for (uint32_t p = 0; p < count_; ++p)
            if (sets_.root(p) == root) outside += exterior_area(fragments_, fragments_.pieces[p]);
        // About half of the surface of a sheet is exterior, less where the input folds it; a speck inside the solid has
        // no exterior surface.
        return outside >= 0.25 * sets_.area(root)
               && (sets_.contacts(root).at(other) < 0.5 * whole_side * sets_.area(root) || grows_by(other, root));
    }

    const Fragments& fragments_;
    const MergeRules& rules_;
    uint32_t count_; // of pieces
    PieceSets sets_;
    std::vector<uint8_t> flat_;  // per root: 1 if all pieces of the set are flat
    std::vector<uint8_t> small_; // per root: 1 if all pieces of the set count as small
    std::priority_queue<Entry, std::vector<Entry>, std::greater<>> smallest_;
};

} // namespace

namespace {

// Returns whether the volume certainly exceeds the threshold of is_flat(). Most pieces pass and need no scan.
bool is_ample(const MassProperties& mass, const Box& box, double extent) {
    const double diagonal = glm::length(box.size());
    return mass.volume > 1e-12 * (mass.area * extent + diagonal * diagonal * diagonal);
}

} // namespace

std::vector<uint8_t> flat_pieces(const Fragments& fragments, const Box& solid) {
    const glm::dvec3 furthest = glm::max(glm::abs(solid.min), glm::abs(solid.max));
    const double extent = std::max({furthest.x, furthest.y, furthest.z});
    std::vector<uint8_t> flat;
    for (size_t p = 0; p < fragments.pieces.size(); ++p) {
        const Piece& piece = fragments.pieces[p];
        if (is_ample(piece.mass, solid, extent)) continue;
        const bool is_cut = piece.exterior_triangles < piece.triangles.size();
        if (!is_flat(piece.mass, fragments.positions_of(piece), fragments.triangles_of(piece), is_cut ? extent : 0.0))
            continue;
        flat.resize(fragments.pieces.size(), 0);
        flat[p] = 1;
    }
    return flat;
}

std::vector<uint32_t> choose_mergers(const Fragments& fragments, const MergeRules& rules) {
    MergerChoice choice(fragments, rules);
    choice.unite_groups();
    choice.absorb_small_sets();
    return choice.representatives();
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
        if (a == b || a == no_index || b == no_index) continue;
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

// Returns, per input triangle, the count of exterior triangles that are parts of it.
std::vector<uint32_t> count_parts_of_sources(const Fragments& fragments) {
    std::vector<uint32_t> parts;
    for (const Piece& piece : fragments.pieces) {
        for (uint32_t t = piece.triangles.begin; t < piece.triangles.begin + piece.exterior_triangles; ++t) {
            const uint32_t source = fragments.triangle_source[t];
            if (source >= parts.size()) parts.resize(size_t{source} + 1, 0);
            ++parts[source];
        }
    }
    return parts;
}

// Returns, per site, 1 if one of its pieces changes.
std::vector<uint8_t> find_changing_sites(const Fragments& fragments, std::span<const uint32_t> representative) {
    std::vector<uint8_t> changes;
    for (const Piece& piece : fragments.pieces)
        if (piece.site >= changes.size()) changes.resize(size_t{piece.site} + 1, 0);
    for (uint32_t p = 0; p < fragments.pieces.size(); ++p)
        if (representative[p] != p) changes[fragments.pieces[p].site] = 1;
    return changes;
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

    const std::vector<uint32_t> parts_of_source = count_parts_of_sources(fragments);
    const std::vector<uint8_t> changes = find_changing_sites(fragments, representative);
    const CapPairs caps(fragments, [&](uint32_t a, uint32_t b) {
        return (a < changes.size() && changes[a]) || (b < changes.size() && changes[b]);
    });
    const auto is_as_before = [&](uint32_t p) {
        if (members[p].size() > 1) return false;
        const Range& triangles = fragments.pieces[p].triangles;
        for (uint32_t t = triangles.begin + fragments.pieces[p].exterior_triangles; t < triangles.end; ++t) {
            const uint32_t across = caps.across(t);
            if (across != no_index && representative[caps.piece_of(across)] != caps.piece_of(across)) return false;
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
    std::vector<uint32_t> new_index(count, no_index);
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
