#include "tools/stress/shrink.h"

#include <algorithm>
#include <cmath>
#include <set>
#include <utility>

#include "fracture/mesh/topology.h"

namespace brittle::stress {

using namespace fracture;

namespace {

class Shrinker {
  public:
    Shrinker(Case c, const std::function<bool(const Case&)>& fails, unsigned tries)
        : best_(std::move(c)), fails_(fails), tries_(tries) {}

    Case run() {
        for (size_t before = 0; before != size() && tries_ > 0;) {
            before = size();
            drop_settings();
            drop_sites();
            drop_components();
            contract_edges();
        }
        drop_unused_vertices();
        round_coordinates();
        return best_;
    }

  private:
    [[nodiscard]] size_t size() const { return best_.mesh.triangles.size() + best_.sites.size(); }

    bool try_case(Case candidate) {
        if (tries_ == 0) return false;
        --tries_;
        if (!fails_(candidate)) return false;
        best_ = std::move(candidate);
        return true;
    }

    void drop_settings() {
        Case c = best_;
        c.groups.clear();
        if (!best_.groups.empty()) try_case(std::move(c));
        c = best_;
        c.weights.clear();
        if (!best_.weights.empty()) try_case(std::move(c));
        c = best_;
        c.min_volume = 0.0;
        if (best_.min_volume > 0.0) try_case(std::move(c));
    }

    // Drops runs of sites, of half of them at first and of one in the end.
    void drop_sites() {
        for (size_t run = std::max<size_t>(best_.sites.size() / 2, 1); run >= 1; run /= 2) {
            for (size_t at = 0; at < best_.sites.size() && best_.sites.size() > 1;) {
                Case c = best_;
                const auto begin = c.sites.begin() + static_cast<std::ptrdiff_t>(at);
                const auto count = static_cast<std::ptrdiff_t>(std::min(run, c.sites.size() - at));
                c.sites.erase(begin, begin + count);
                if (!c.weights.empty()) {
                    const auto weight = c.weights.begin() + static_cast<std::ptrdiff_t>(at);
                    c.weights.erase(weight, weight + count);
                }
                if (!c.groups.empty()) {
                    const auto group = c.groups.begin() + static_cast<std::ptrdiff_t>(at);
                    c.groups.erase(group, group + count);
                }
                if (c.sites.empty() || !try_case(std::move(c))) at += run;
            }
        }
    }

    void drop_components() {
        if (!indices_in_range()) return;
        auto component = triangle_components(best_.mesh.positions.size(), best_.mesh.triangles);
        for (uint32_t k = 0; k <= *std::max_element(component.begin(), component.end()); ++k) {
            Case c = best_;
            c.mesh.triangles.clear();
            for (size_t t = 0; t < component.size(); ++t)
                if (component[t] != k) c.mesh.triangles.push_back(best_.mesh.triangles[t]);
            if (c.mesh.triangles.empty() || !try_case(std::move(c))) continue;
            component = triangle_components(best_.mesh.positions.size(), best_.mesh.triangles);
            k = static_cast<uint32_t>(-1);
        }
    }

    // Contracts edges whose ends have exactly two common neighbours, which keeps a closed surface closed.
    void contract_edges() {
        if (!indices_in_range()) return;
        for (size_t t = 0; t < best_.mesh.triangles.size() && tries_ > 0; ++t) {
            for (int k = 0; k < 3 && t < best_.mesh.triangles.size(); ++k) {
                const uint32_t from = best_.mesh.triangles[t][k], to = best_.mesh.triangles[t][(k + 1) % 3];
                if (from == to || common_neighbours(from, to) != 2) continue;
                Case c = best_;
                c.mesh.triangles.clear();
                for (Triangle u : best_.mesh.triangles) {
                    for (int m = 0; m < 3; ++m)
                        if (u[m] == from) u[m] = to;
                    if (u.x != u.y && u.y != u.z && u.z != u.x) c.mesh.triangles.push_back(u);
                }
                if (c.mesh.triangles.size() >= 4) try_case(std::move(c));
            }
        }
    }

    [[nodiscard]] size_t common_neighbours(uint32_t a, uint32_t b) const {
        std::set<uint32_t> of_a, of_b;
        for (const Triangle& t : best_.mesh.triangles) {
            for (int k = 0; k < 3; ++k) {
                if (t[k] == a) of_a.insert({t[(k + 1) % 3], t[(k + 2) % 3]});
                if (t[k] == b) of_b.insert({t[(k + 1) % 3], t[(k + 2) % 3]});
            }
        }
        return static_cast<size_t>(
            std::count_if(of_a.begin(), of_a.end(), [&](uint32_t v) { return of_b.contains(v); }));
    }

    [[nodiscard]] bool indices_in_range() const {
        return std::all_of(best_.mesh.triangles.begin(), best_.mesh.triangles.end(), [&](const Triangle& t) {
            return std::max({t.x, t.y, t.z}) < best_.mesh.positions.size();
        });
    }

    void drop_unused_vertices() {
        if (!indices_in_range()) return;
        Case c = best_;
        std::vector<uint32_t> renumbered(c.mesh.positions.size(), ~0u);
        c.mesh.positions.clear();
        for (Triangle& t : c.mesh.triangles) {
            for (int k = 0; k < 3; ++k) {
                uint32_t& to = renumbered[t[k]];
                if (to == ~0u) {
                    to = static_cast<uint32_t>(c.mesh.positions.size());
                    c.mesh.positions.push_back(best_.mesh.positions[t[k]]);
                }
                t[k] = to;
            }
        }
        try_case(std::move(c));
    }

    void round_coordinates() {
        for (const double steps : {1.0, 2.0, 4.0, 8.0, 16.0, 256.0, 65536.0}) {
            Case c = best_;
            for (auto* points : {&c.mesh.positions, &c.sites})
                for (glm::dvec3& p : *points)
                    for (int k = 0; k < 3; ++k) p[k] = std::round(p[k] * steps) / steps;
            if (try_case(std::move(c))) return;
        }
    }

    Case best_;
    const std::function<bool(const Case&)>& fails_;
    unsigned tries_;
};

} // namespace

Case shrink(Case c, const std::function<bool(const Case&)>& fails, unsigned tries) {
    return Shrinker(std::move(c), fails, tries).run();
}

} // namespace brittle::stress
