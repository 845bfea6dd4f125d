#include "fracture/rough/rough.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <limits>

#include <glm/geometric.hpp>

#include "fracture/base/rounded_math.h"
#include "fracture/mesh/mass_properties.h"
#include "fracture/pieces/merge.h"

namespace brittle::fracture::rough {

namespace {

constexpr uint32_t min_points_per_chunk = 2048;

// Points per wavelength of the shortest octave, along the cuts and their borders.
constexpr double points_per_wavelength = 4.0;

// The spacing of points is at least this share of the size of the mesh: below it they come close to rounding.
constexpr double min_spacing = 1e-6;

// The volume of a flake, in units of its area to the power of 1.5: a disc of this thickness per diameter has 0.4 of it.
constexpr double min_thickness = 1e-6;

// How often the warp is calmed before crossings are left, and counted.
constexpr uint32_t max_rounds = 4;

constexpr uint32_t distance_samples = 256; // of typical_distance()

constexpr double max_stretch = 16.0, max_detail = 6;

class Stopwatch {
  public:
    void lap(const char* phase, Fragments& out) {
        const auto now = std::chrono::steady_clock::now();
        out.timings.push_back({phase, std::chrono::duration<double, std::milli>(now - last_).count()});
        last_ = now;
    }

  private:
    std::chrono::steady_clock::time_point last_ = std::chrono::steady_clock::now();
};

Error out_of_range(const char* what, double value, const char* range) {
    char text[160];
    std::snprintf(text, sizeof text, "%s is %g; give %s", what, value, range);
    return {Status::invalid_setting, text};
}

// About how many triangles the cuts get at a spacing, on both sides: cells of a random diagram have about 2.9 times the
// area of a face of a cube of their volume (Okabe et al., "Spatial Tessellations", table 5.5.2), each facet shared.
double estimate_triangles(const Box& box, size_t sites, double spacing) {
    const glm::dvec3 size = box.size();
    const double volume = size.x * size.y * size.z, n = static_cast<double>(sites);
    const double area = 2.9 * rounded::cbrt(n) * rounded::cbrt(volume * volume);
    return 2.0 * area / (0.433 * spacing * spacing);
}

// Returns 1.5 times the median distance of a site to the nearest other one, of at most 256 sites. 0 where there are not
// two different sites.
double distance_between(std::span<const glm::dvec3> sites) {
    std::vector<double> nearest;
    const size_t stride = std::max<size_t>(1, sites.size() / 256);
    for (size_t i = 0; i < sites.size(); i += stride) {
        double least = std::numeric_limits<double>::infinity();
        for (const glm::dvec3& other : sites) {
            const glm::dvec3 d = other - sites[i];
            const double square = glm::dot(d, d);
            if (square > 0.0 && square < least) least = square;
        }
        if (std::isfinite(least)) nearest.push_back(std::sqrt(least));
    }
    if (nearest.empty()) return 0.0;
    const auto middle = nearest.begin() + static_cast<std::ptrdiff_t>(nearest.size() / 2);
    std::nth_element(nearest.begin(), middle, nearest.end());
    return 1.5 * *middle;
}

// Returns a multiple of the median distance of a point of the surface to the nearest site. 1.2 makes the two functions
// about equal for uniform sites. Precondition: the indices of the mesh are in range.
double distance_from(const TriangleMesh& mesh, std::span<const glm::dvec3> sites) {
    std::vector<double> area_before{0.0}; // of the triangles before each one
    for (const Triangle& t : mesh.triangles) {
        const glm::dvec3& a = mesh.positions[t.x];
        const double area = glm::length(glm::cross(mesh.positions[t.y] - a, mesh.positions[t.z] - a));
        area_before.push_back(area_before.back() + (area > 0.0 ? area : 0.0));
    }
    if (sites.size() < 2 || !(area_before.back() > 0.0)) return 0.0;
    std::vector<double> nearest;
    for (uint32_t k = 0; k < distance_samples; ++k) {
        const double at = (k + 0.5) / distance_samples * area_before.back();
        const auto after = std::upper_bound(area_before.begin(), area_before.end(), at);
        const auto t = std::min<size_t>(static_cast<size_t>(after - area_before.begin()), mesh.triangles.size()) - 1;
        // A low-discrepancy sequence in the unit square, folded into the triangle (Roberts 2018, R2).
        double u = 0.5 + 0.7548776662466927 * k, v = 0.5 + 0.5698402909980532 * k;
        u -= std::floor(u);
        v -= std::floor(v);
        if (u + v > 1.0) {
            u = 1.0 - u;
            v = 1.0 - v;
        }
        const Triangle& corners = mesh.triangles[t];
        const glm::dvec3& a = mesh.positions[corners.x];
        const glm::dvec3 p = a + u * (mesh.positions[corners.y] - a) + v * (mesh.positions[corners.z] - a);
        double least = std::numeric_limits<double>::infinity();
        for (const glm::dvec3& site : sites) {
            const glm::dvec3 d = p - site;
            least = std::min(least, glm::dot(d, d));
        }
        nearest.push_back(std::sqrt(least));
    }
    const auto middle = nearest.begin() + distance_samples / 2;
    std::nth_element(nearest.begin(), middle, nearest.end());
    return 1.2 * *middle;
}

// Returns the groups of sites whose pieces are merged after the cut; empty for none.
std::span<const uint32_t> groups_of(const Settings& settings) {
    return settings.groups.empty() ? settings.merged_later : settings.groups;
}

} // namespace

double typical_distance(const TriangleMesh& mesh, std::span<const glm::dvec3> sites) {
    return std::sqrt(distance_between(sites) * distance_from(mesh, sites));
}

Result<void> check(const Roughness& r) {
    if (!(r.amount >= 0.0 && r.amount <= 1.0)) return out_of_range("the roughness", r.amount, "0 to 1");
    if (!(r.wavelength >= 0.0) || !std::isfinite(r.wavelength))
        return out_of_range("the wavelength of the roughness", r.wavelength, "a positive length in metres, or 0");
    const double stretch = glm::length(r.grain);
    if (!(stretch == 0.0 || (stretch >= 1.0 / max_stretch && stretch <= max_stretch)))
        return out_of_range("the length of the grain", stretch, "0, or 1/16 to 16");
    if (r.detail < 1 || r.detail > max_detail)
        return out_of_range("the detail of the roughness", r.detail, "1 to 6 octaves");
    return {};
}

// Sets roughness_, wavelength_ and spacing_: as asked, or coarser, where the triangles would be too many.
void RoughCut::choose_spacing(const Box& box, size_t site_count, const Roughness& roughness) {
    roughness_ = roughness;
    wavelength_ = roughness.wavelength;
    const double stretch = glm::length(roughness.grain);
    const double shrink = stretch > 0.0 ? std::min(stretch, 1.0) : 1.0;
    const double least = min_spacing * glm::length(box.size());
    const auto spacing = [&] {
        return shrink * wavelength_ / points_per_wavelength / static_cast<double>(1u << (roughness_.detail - 1));
    };
    const auto fits = [&](double s) {
        return s >= least && estimate_triangles(box, site_count, s) <= static_cast<double>(roughness.max_triangles);
    };
    while (roughness_.detail > 1 && !fits(spacing())) --roughness_.detail;
    spacing_ = spacing();
    while (spacing_ < wavelength_ && !fits(spacing_)) spacing_ *= 2.0;
    if (!fits(spacing_)) spacing_ = 0.0;
    // A wavelength beyond rounding would not change the cuts.
    if (!(wavelength_ > least)) roughness_.amount = 0.0;
}

void RoughCut::begin(const Settings& settings) {
    if (requested_threads_ != settings.threads) {
        threads_ = Threads(settings.threads);
        requested_threads_ = settings.threads;
    }
    threads_.log_to(settings.work_log);
    threads_.cancel_by(settings.cancelled);
    calm_balls_.clear();
    crossing_finder_.forget();
    rounds_ = 0;
    far_ = {};
}

void RoughCut::start(const TriangleMesh& mesh, std::span<const glm::dvec3> sites, const Settings& settings) {
    begin(settings);
    const auto vertices = static_cast<uint32_t>(mesh.positions.size());
    in_range_ = std::all_of(mesh.triangles.begin(), mesh.triangles.end(),
                            [&](const Triangle& t) { return t.x < vertices && t.y < vertices && t.z < vertices; });
    if (!in_range_) return;
    Roughness roughness = settings.rough;
    if (!(roughness.wavelength > 0.0)) roughness.wavelength = typical_distance(mesh, sites);
    choose_spacing(bounds(mesh), sites.size(), roughness);
}

void RoughCut::start(const Box& solid, size_t site_count, const Settings& settings, std::span<const uint8_t> far) {
    begin(settings);
    far_ = far;
    in_range_ = true;
    choose_spacing(solid, site_count, settings.rough);
}

Result<void> RoughCut::cut(const TriangleMesh& mesh, std::span<const glm::dvec3> sites, const Settings& settings,
                           exact::Scratch& scratch, Fragments& out) {
    // The flat cut reports the errors, in terms of the mesh that the caller knows.
    if (!in_range_ || mesh.triangles.empty() || sites.empty())
        return exact::fracture_exact(mesh, sites, settings, scratch, out);
    Stopwatch watch;
    warp_ = Warp(roughness_, wavelength_, calm_balls_);
    const auto warp_all = [&](std::span<const glm::dvec3> from, std::vector<glm::dvec3>& to) {
        to.assign(from.begin(), from.end());
        threads_.for_chunks(
            static_cast<uint32_t>(to.size()), min_points_per_chunk,
            [&](uint32_t, uint32_t begin, uint32_t end) { warp_.apply(std::span(to).subspan(begin, end - begin)); });
    };
    warp_all(mesh.positions, warped_positions_);
    warp_all(sites, warped_sites_);
    const std::span<const uint32_t> groups = groups_of(settings);
    const WarpedSites warped{warped_sites_, settings.weights, groups};
    const double unlimited = std::numeric_limits<double>::infinity();
    double spacing = spacing_ > 0.0 ? spacing_ : unlimited;
    while (!refiner_.run(mesh, warped_positions_, far_, warp_, warped, spacing,
                         mesh.triangles.size() + settings.rough.max_triangles, surface_))
        spacing *= 2.0;
    std::vector<Milliseconds> timings;
    watch.lap("warp", out);
    timings.push_back(out.timings.back());

    Result<void> done = exact::fracture_exact(surface_.warped, warped_sites_, settings, scratch, out,
                                              {spacing_, surface_.positions, groups});
    if (!done) {
        if (done.error().status == Status::cancelled) return done;
        if (Result<void> flat = exact::fracture_exact(mesh, sites, settings, scratch, out); !flat) return flat;
        return done;
    }
    out.timings.insert(out.timings.begin(), timings.begin(), timings.end());
    watch = {};
    restorer_.start(surface_, exact::cut(scratch), exact::scene(scratch), warp_, spacing_, out, threads_);
    watch.lap("find places", out);
    return {};
}

void RoughCut::weigh(Fragments& pieces) {
    threads_.for_chunks(static_cast<uint32_t>(pieces.pieces.size()), 1, [&](uint32_t, uint32_t begin, uint32_t end) {
        for (uint32_t p = begin; p < end; ++p) {
            Piece& piece = pieces.pieces[p];
            piece.mass = mass_properties(pieces.positions_of(piece), pieces.triangles_of(piece));
        }
    });
}

std::vector<uint8_t> RoughCut::place(size_t site_count, Fragments& pieces) {
    Stopwatch watch;
    cut_positions_ = restorer_.places(pieces, threads_);
    std::swap(cut_positions_, pieces.positions);
    weigh(pieces);
    bonds_.run_bent(site_count, pieces);
    std::vector<uint8_t> flakes;
    for (size_t p = 0; p < pieces.pieces.size(); ++p) {
        const MassProperties& mass = pieces.pieces[p].mass;
        if (mass.volume > min_thickness * mass.area * std::sqrt(mass.area)) continue;
        flakes.resize(pieces.pieces.size(), 0);
        flakes[p] = 1;
    }
    watch.lap("place", pieces);
    return flakes;
}

void RoughCut::warp_back(Fragments& pieces) {
    std::swap(cut_positions_, pieces.positions);
}

void RoughCut::join(const TriangleMesh& mesh, Fragments& pieces) {
    Stopwatch watch;
    restorer_.join_triangles(mesh, threads_, pieces);
    watch.lap("join", pieces);
}

bool RoughCut::calm(const Settings& settings, Fragments& pieces) {
    Stopwatch watch;
    const std::vector<Crossing> crossings = crossing_finder_.run(pieces, groups_of(settings), threads_);
    watch.lap("check", pieces);
    pieces.crossings = static_cast<uint32_t>(crossings.size());
    if (crossings.empty() || rounds_++ == max_rounds) return false;
    // Later rounds calm more around what is left.
    for (const Crossing& crossing : crossings) {
        const double radius = crossing.radius * static_cast<double>(rounds_);
        const bool is_new = std::none_of(calm_balls_.begin(), calm_balls_.end(), [&](const CalmBall& ball) {
            return glm::distance(ball.centre, crossing.centre) + radius <= ball.radius;
        });
        if (is_new) calm_balls_.push_back({crossing.centre, radius});
    }
    return true;
}

Result<void> RoughCut::run(const TriangleMesh& mesh, std::span<const glm::dvec3> sites, const Settings& settings,
                           exact::Scratch& scratch, const Choice& choose, Fragments& out) {
    do {
        if (Result<void> done = cut(mesh, sites, settings, scratch, out); !done) return done;
        const std::vector<uint32_t> representative = choose(place(sites.size(), out));
        if (!representative.empty()) {
            Stopwatch watch;
            warp_back(out);
            merge_pieces(out, representative, threads_);
            watch.lap("merge", out);
            (void)place(sites.size(), out);
        }
        join(mesh, out);
    } while (calm(settings, out));
    return {};
}

} // namespace brittle::fracture::rough
