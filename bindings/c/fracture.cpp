// Sites and fractures of the C interface.
#include <cmath>

#include "bindings/c/handles.h"
#include "fracture/mesh/topology.h"
#include "fracture/sites/pattern.h"
#include "fracture/sites/sites.h"

using namespace brittle;

namespace brittle::c {

namespace {

brittle_pattern pattern_defaults() {
    const fracture::Pattern d;
    brittle_pattern pattern{};
    pattern.struct_size = sizeof pattern;
    pattern.count = d.count;
    pattern.seed = d.seed;
    pattern.piece_size = d.piece_size;
    pattern.jitter = d.jitter;
    for (int k = 0; k < 3; ++k) {
        pattern.focus[k] = d.focus[k];
        pattern.axis[k] = d.axis[k];
    }
    pattern.spread = d.spread;
    pattern.slenderness = d.slenderness;
    pattern.grading = d.grading;
    pattern.cells_per_piece = d.cells_per_piece;
    pattern.inside = 1; // as the command line
    return pattern;
}

fracture::PatternKind kind_of(const char* name) {
    if (!name) return fracture::PatternKind::uniform;
    const auto names = fracture::pattern_names();
    const auto found = std::find(names.begin(), names.end(), std::string_view(name));
    if (found == names.end()) {
        std::string known;
        for (const std::string_view one : names) known.append(known.empty() ? "" : ", ").append(one);
        refuse("there is no pattern named '" + std::string(name) + "'; the patterns are: " + known);
    }
    return static_cast<fracture::PatternKind>(found - names.begin());
}

fracture::Pattern pattern_of(const brittle_pattern& given) {
    fracture::Pattern pattern;
    pattern.kind = kind_of(given.kind);
    pattern.count = given.count;
    pattern.seed = given.seed;
    pattern.piece_size = given.piece_size;
    pattern.jitter = given.jitter;
    pattern.focus = {given.focus[0], given.focus[1], given.focus[2]};
    pattern.axis = {given.axis[0], given.axis[1], given.axis[2]};
    pattern.spread = given.spread;
    pattern.slenderness = given.slenderness;
    pattern.grading = given.grading;
    pattern.cells_per_piece = given.cells_per_piece;
    pattern.inside = given.inside != 0;
    if (given.line.rows > 0) pattern.line = read_points(given.line, "pattern.line", BRITTLE_INVALID_SETTING);
    return pattern;
}

brittle_fracture_settings fracture_defaults() {
    const fracture::Settings d;
    brittle_fracture_settings settings{};
    settings.struct_size = sizeof settings;
    settings.threads = d.threads;
    settings.rough_detail = d.rough.detail;
    settings.rough_seed = d.rough.seed;
    settings.rough_max_triangles = d.rough.max_triangles;
    return settings;
}

fracture::Settings settings_of(const brittle_fracture_settings& given, const brittle_sites& sites) {
    fracture::Settings settings;
    settings.algorithm = given.sequential != 0 ? fracture::Algorithm::sequential : fracture::Algorithm::exact;
    settings.threads = given.threads;
    settings.groups = sites.groups;
    settings.weights = sites.weights;
    settings.min_volume = given.min_volume;
    settings.rough.amount = given.roughness;
    settings.rough.wavelength = given.rough_wavelength;
    settings.rough.grain = {given.rough_grain[0], given.rough_grain[1], given.rough_grain[2]};
    settings.rough.detail = given.rough_detail;
    settings.rough.seed = given.rough_seed;
    settings.rough.max_triangles = given.rough_max_triangles;
    if (given.progress)
        settings.progress = [call = given.progress, user = given.user](double share) { call(user, share); };
    settings.cancelled = cancel_question(given.cancelled, given.user, given.cancel_flag);
    return settings;
}

// A mesh that is not closed has no inside for sites: that is what to tell.
void refuse_open(const fracture::TriangleMesh& mesh) {
    const fracture::TopologyReport report = fracture::check_topology(mesh.positions.size(), mesh.triangles);
    if (report.closed()) return;
    refuse("the mesh is not closed: " + fracture::describe(report) + remedy, report.open_edges > 0 ? BRITTLE_NOT_CLOSED
                                                                             : report.non_manifold_edges > 0
                                                                                 ? BRITTLE_NON_MANIFOLD
                                                                                 : BRITTLE_NOT_ORIENTED);
}

} // namespace

} // namespace brittle::c

using c::guarded;
using c::must;
using c::need;
using c::refuse;

extern "C" {

void brittle_pattern_init(brittle_pattern* pattern, size_t struct_size) {
    c::init_struct(pattern, struct_size, c::pattern_defaults());
}

brittle_status brittle_sites_pattern(const brittle_pattern* pattern, const brittle_mesh* mesh, brittle_sites** out,
                                     brittle_error* error) {
    return guarded(error, [&] {
        need(out, "out");
        const fracture::Pattern settings = c::pattern_of(c::read_settings(pattern, c::pattern_defaults(), "pattern"));
        const fracture::TriangleMesh& solid = need(mesh, "mesh").model->mesh;
        fracture::Result<fracture::PatternSites> tried = fracture::make_sites(settings, solid);
        if (!tried) c::refuse_open(solid);
        fracture::PatternSites made = must(std::move(tried));
        *out = new brittle_sites{std::move(made.sites), std::move(made.weights), std::move(made.groups)};
    });
}

brittle_status brittle_sites_from_arrays(const brittle_array* positions, const brittle_array* weights,
                                         const brittle_array* groups, brittle_sites** out, brittle_error* error) {
    return guarded(error, [&] {
        need(out, "out");
        brittle_sites sites{c::read_points(need(positions, "positions"), "positions", BRITTLE_INVALID_SITES), {}, {}};
        if (sites.sites.empty()) refuse("there are no sites", BRITTLE_INVALID_SITES);
        if (weights) sites.weights = c::read_floats(*weights, 1, "weights");
        if (groups) sites.groups = c::read_integers(*groups, 1, "groups");
        const auto check = [&](size_t count, const char* name) {
            if (count != sites.sites.size())
                refuse(std::string(name) + " has " + std::to_string(count) + " rows for "
                       + std::to_string(sites.sites.size()) + " sites");
        };
        if (weights) check(sites.weights.size(), "weights");
        if (groups) check(sites.groups.size(), "groups");
        for (size_t k = 0; k < sites.weights.size(); ++k)
            if (!std::isfinite(sites.weights[k]))
                refuse("weights has " + std::to_string(sites.weights[k]) + " in row " + std::to_string(k)
                           + "; weights must be finite",
                       BRITTLE_INVALID_SITES);
        *out = new brittle_sites(std::move(sites));
    });
}

brittle_status brittle_sites_load(const char* path, brittle_sites** out, brittle_error* error) {
    return guarded(error, [&] {
        need(out, "out");
        fracture::SiteList list = must(fracture::read_sites(c::read_text(path, "path")));
        *out = new brittle_sites{std::move(list.sites), std::move(list.weights), {}};
    });
}

brittle_status brittle_sites_array(const brittle_sites* sites, uint32_t which, brittle_array* out,
                                   brittle_error* error) {
    return guarded(error, [&] {
        need(out, "out");
        const brittle_sites& s = need(sites, "sites");
        switch (which) {
        case BRITTLE_SITE_POSITIONS:
            *out = c::view<double>(s.sites);
            return;
        case BRITTLE_SITE_WEIGHTS:
            *out = c::view<double>(s.weights);
            return;
        case BRITTLE_SITE_GROUPS:
            *out = c::view<uint32_t>(s.groups);
            return;
        default:
            c::refuse_which(which, BRITTLE_SITE_GROUPS);
        }
    });
}

void brittle_sites_free(brittle_sites* sites) {
    delete sites;
}

brittle_status brittle_workspace_create(brittle_workspace** out, brittle_error* error) {
    return guarded(error, [&] {
        need(out, "out");
        *out = new brittle_workspace;
    });
}

void brittle_workspace_free(brittle_workspace* workspace) {
    delete workspace;
}

void brittle_fracture_settings_init(brittle_fracture_settings* settings, size_t struct_size) {
    c::init_struct(settings, struct_size, c::fracture_defaults());
}

brittle_status brittle_fracture(const brittle_mesh* mesh, const brittle_sites* sites,
                                const brittle_fracture_settings* settings, brittle_pieces** out, brittle_error* error) {
    return guarded(error, [&] {
        need(out, "out");
        const brittle_fracture_settings given = c::read_settings(settings, c::fracture_defaults(), "settings");
        auto pieces = std::make_unique<brittle_pieces>();
        pieces->source = need(mesh, "mesh").model;
        pieces->sites = need(sites, "sites").sites;
        const fracture::Settings all = c::settings_of(given, *sites);
        pieces->rough = !all.rough.is_flat();
        if (given.workspace) {
            must(fracture::fracture(pieces->source->mesh, pieces->sites, all, given.workspace->workspace,
                                    pieces->fragments));
        } else {
            pieces->fragments = must(fracture::fracture(pieces->source->mesh, pieces->sites, all));
        }
        *out = pieces.release();
    });
}

} // extern "C"
