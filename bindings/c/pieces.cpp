// Pieces of the C interface: arrays, certificate, render buffers, collision hulls and export.
#include "bindings/c/handles.h"
#include "fracture/io/piece_surface.h"
#include "physics/cutting/convex_parts.h"
#include "physics/cutting/hull_meshes.h"
#include "physics/world/hull.h"

using namespace brittle;

struct brittle_surface {
    struct Part {
        fracture::DrawnPart drawn;
        std::vector<glm::vec3> positions;
    };
    std::vector<Part> parts;
};

struct brittle_hulls {
    std::vector<glm::vec3> points;
    std::vector<glm::uvec2> ranges;
    std::vector<uint32_t> pieces;
    std::vector<float> margins;
};

namespace brittle::c {

namespace {

void add_hull(const physics::CollisionHull& hull, const glm::vec3& offset, uint32_t piece, brittle_hulls& out) {
    const auto begin = static_cast<uint32_t>(out.points.size());
    const fracture::TriangleMesh plain = physics::plain_hull(hull.points);
    for (const glm::dvec3& point : plain.positions) out.points.push_back(glm::vec3(point) + offset);
    if (plain.positions.empty()) // flatter than single precision tells from a plane
        for (const glm::vec3& point : hull.points) out.points.push_back(point + offset);
    out.ranges.push_back({begin, static_cast<uint32_t>(out.points.size())});
    out.pieces.push_back(piece);
    out.margins.push_back(hull.margin);
}

brittle_export_settings export_defaults() {
    brittle_export_settings settings{};
    settings.struct_size = sizeof settings;
    settings.density = fracture::ExportOptions{}.density;
    settings.hull_parts = physics::HullMeshSettings{}.max_parts;
    return settings;
}

// The options, and what they refer to.
struct Export {
    std::vector<std::vector<fracture::TriangleMesh>> hulls;
    fracture::ExportOptions options;

    Export(const brittle_pieces& pieces, const brittle_export_settings* settings) {
        const brittle_export_settings given = read_settings(settings, export_defaults(), "settings");
        if (given.hulls > 2)
            refuse("settings.hulls is " + std::to_string(given.hulls) + "; it must be 0, 1 or 2",
                   BRITTLE_INVALID_SETTING);
        if (given.name) options.name = given.name;
        options.source = pieces.source.get();
        options.sites = pieces.sites;
        options.rough = pieces.rough;
        options.per_piece = given.per_piece != 0;
        constexpr fracture::BodyNames names[] = {fracture::BodyNames::none, fracture::BodyNames::godot,
                                                 fracture::BodyNames::unreal};
        options.body_names = names[given.hulls];
        options.rigid_bodies = given.rigid_bodies != 0;
        options.density = in_range(given.density, 1e-30, 1e30, "settings.density");
        if (given.hull_parts < 1 || given.hull_parts > 256)
            refuse("settings.hull_parts is " + std::to_string(given.hull_parts) + "; it must be 1 to 256",
                   BRITTLE_INVALID_SETTING);
        if (options.body_names == fracture::BodyNames::unreal || options.rigid_bodies) {
            hulls = physics::hull_meshes(pieces.fragments, {.max_parts = given.hull_parts});
            options.hulls = hulls;
        }
    }
    Export(const Export&) = delete;
    Export& operator=(const Export&) = delete;
};

const fracture::Piece& piece_at(const brittle_pieces& pieces, uint32_t piece) {
    const auto& all = pieces.fragments.pieces;
    if (piece >= all.size())
        refuse("there is no piece " + std::to_string(piece) + "; there are " + std::to_string(all.size()));
    return all[piece];
}

const brittle_surface::Part& part_at(const brittle_surface& surface, uint64_t part) {
    if (part >= surface.parts.size())
        refuse("there is no part " + std::to_string(part) + "; there are " + std::to_string(surface.parts.size()));
    return surface.parts[part];
}

} // namespace

} // namespace brittle::c

using c::guarded;
using c::guarded_json;
using c::must;
using c::need;
using c::refuse;

extern "C" {

void brittle_pieces_free(brittle_pieces* pieces) {
    delete pieces;
}

brittle_status brittle_pieces_array(const brittle_pieces* pieces, uint32_t which, brittle_array* out,
                                    brittle_error* error) {
    return guarded(error, [&] {
        need(out, "out");
        const fracture::Fragments& f = need(pieces, "pieces").fragments;
        const fracture::Piece* const piece = f.pieces.data();
        const fracture::Bond* const bond = f.bonds.data();
        const bool none = f.pieces.empty(), unbonded = f.bonds.empty();
        static_assert(sizeof(fracture::Range) == 2 * sizeof(uint32_t));
        static_assert(offsetof(fracture::Bond, b) == offsetof(fracture::Bond, a) + sizeof(uint32_t));
        const auto of_pieces = [&]<class T>(const T* first, uint32_t columns) {
            *out = c::view(f.pieces, first, columns);
        };
        const auto of_bonds = [&]<class T>(const T* first, uint32_t columns) {
            *out = c::view(f.bonds, first, columns);
        };
        switch (which) {
        case BRITTLE_PIECES_POSITIONS:
            *out = c::view<double>(f.positions);
            return;
        case BRITTLE_PIECES_TRIANGLES:
            *out = c::view<uint32_t>(f.triangles);
            return;
        case BRITTLE_PIECES_TRIANGLE_SOURCES:
            *out = c::view<uint32_t>(f.triangle_source);
            return;
        case BRITTLE_PIECES_VERTEX_RANGES:
            return of_pieces(none ? nullptr : &piece->vertices.begin, 2);
        case BRITTLE_PIECES_TRIANGLE_RANGES:
            return of_pieces(none ? nullptr : &piece->triangles.begin, 2);
        case BRITTLE_PIECES_EXTERIOR_TRIANGLES:
            return of_pieces(none ? nullptr : &piece->exterior_triangles, 1);
        case BRITTLE_PIECES_SITES:
            return of_pieces(none ? nullptr : &piece->site, 1);
        case BRITTLE_PIECES_VOLUMES:
            return of_pieces(none ? nullptr : &piece->mass.volume, 1);
        case BRITTLE_PIECES_AREAS:
            return of_pieces(none ? nullptr : &piece->mass.area, 1);
        case BRITTLE_PIECES_CENTRES:
            return of_pieces(none ? nullptr : &piece->mass.centre_of_mass.x, 3);
        case BRITTLE_PIECES_INERTIAS:
            return of_pieces(none ? nullptr : &piece->mass.inertia[0].x, 9);
        case BRITTLE_PIECES_BONDS:
            return of_bonds(unbonded ? nullptr : &bond->a, 2);
        case BRITTLE_PIECES_BOND_AREAS:
            return of_bonds(unbonded ? nullptr : &bond->area, 1);
        case BRITTLE_PIECES_BOND_CENTROIDS:
            return of_bonds(unbonded ? nullptr : &bond->centroid.x, 3);
        case BRITTLE_PIECES_BOND_NORMALS:
            return of_bonds(unbonded ? nullptr : &bond->normal.x, 3);
        default:
            c::refuse_which(which, BRITTLE_PIECES_BOND_NORMALS);
        }
    });
}

brittle_status brittle_pieces_certificate(const brittle_pieces* pieces, brittle_certificate* out,
                                          brittle_error* error) {
    return guarded(error, [&] {
        need(out, "out");
        const fracture::Certificate& known = need(pieces, "pieces").certificate();
        brittle_certificate values{};
        values.pieces = known.pieces;
        values.closed = known.closed;
        values.open_pieces = known.open_pieces;
        values.negative_pieces = known.negative_pieces;
        values.cells = known.cells;
        values.volume_input = known.volume_input;
        values.volume_sum = known.volume_sum;
        values.smallest_piece = known.smallest_piece;
        values.volume_error = known.volume_error;
        values.triangles_in = known.triangles_in;
        values.triangles_out = known.triangles_out;
        values.cap_triangles = known.cap_triangles;
        values.hash = known.hash;
        c::write_struct(values, out, "out");
    });
}

brittle_status brittle_pieces_surface(const brittle_pieces* pieces, uint32_t piece, brittle_surface** out,
                                      brittle_error* error) {
    return guarded(error, [&] {
        need(out, "out");
        const brittle_pieces& p = need(pieces, "pieces");
        const fracture::Piece& one = c::piece_at(p, piece);
        const auto positions = p.fragments.positions_of(one);
        auto surface = std::make_unique<brittle_surface>();
        const fracture::SurfaceSettings settings{.source = p.source.get(), .sites = p.sites, .rough = p.rough};
        for (fracture::DrawnPart& drawn : fracture::drawn_parts(p.fragments, one, settings)) {
            brittle_surface::Part& part = surface->parts.emplace_back();
            for (const uint32_t v : drawn.vertices) part.positions.emplace_back(positions[v] - one.mass.centre_of_mass);
            part.drawn = std::move(drawn);
        }
        *out = surface.release();
    });
}

uint64_t brittle_surface_parts(const brittle_surface* surface) {
    return surface ? surface->parts.size() : 0;
}

brittle_status brittle_surface_part(const brittle_surface* surface, uint64_t part, uint32_t* material,
                                    uint32_t* interior, brittle_error* error) {
    return guarded(error, [&] {
        static_assert(fracture::no_material == BRITTLE_NO_MATERIAL);
        const fracture::DrawnPart& drawn = c::part_at(need(surface, "surface"), part).drawn;
        if (material) *material = drawn.material;
        if (interior) *interior = drawn.interior;
    });
}

brittle_status brittle_surface_array(const brittle_surface* surface, uint64_t part, uint32_t which, brittle_array* out,
                                     brittle_error* error) {
    return guarded(error, [&] {
        need(out, "out");
        const brittle_surface::Part& one = c::part_at(need(surface, "surface"), part);
        switch (which) {
        case BRITTLE_SURFACE_POSITIONS:
            *out = c::view<float>(one.positions);
            return;
        case BRITTLE_SURFACE_NORMALS:
            *out = c::view<float>(one.drawn.normals);
            return;
        case BRITTLE_SURFACE_UV:
            *out = c::view<float>(one.drawn.uv[0]);
            return;
        case BRITTLE_SURFACE_UV2:
            *out = c::view<float>(one.drawn.uv[1]);
            return;
        case BRITTLE_SURFACE_COLOURS:
            *out = c::view<float>(one.drawn.colours);
            return;
        case BRITTLE_SURFACE_INDICES:
            *out = c::view(one.drawn.indices, one.drawn.indices.data(), 3);
            out->rows /= 3;
            out->stride = 3 * sizeof(uint32_t);
            return;
        case BRITTLE_SURFACE_VERTICES:
            *out = c::view(one.drawn.vertices, one.drawn.vertices.data(), 1);
            return;
        default:
            c::refuse_which(which, BRITTLE_SURFACE_VERTICES);
        }
    });
}

void brittle_surface_free(brittle_surface* surface) {
    delete surface;
}

brittle_status brittle_pieces_hulls(const brittle_pieces* pieces, uint32_t max_parts, uint32_t max_vertices,
                                    brittle_hulls** out, brittle_error* error) {
    return guarded(error, [&] {
        need(out, "out");
        const fracture::Fragments& fragments = need(pieces, "pieces").fragments;
        c::in_range(max_parts, 1, 256, "max_parts");
        c::in_range(max_vertices, 8, 255, "max_vertices");
        const physics::HullSettings settings{.max_vertices = max_vertices};
        auto hulls = std::make_unique<brittle_hulls>();
        if (max_parts == 1) {
            const physics::PieceHulls one_each = physics::collision_hulls(fragments, settings);
            for (size_t p = 0; p < one_each.size(); ++p)
                c::add_hull(*one_each[p], glm::vec3(0.0f), static_cast<uint32_t>(p), *hulls);
        } else {
            for (size_t p = 0; p < fragments.pieces.size(); ++p) {
                const fracture::Piece& piece = fragments.pieces[p];
                for (const physics::BodyPart& part : physics::convex_parts(
                         fragments.positions_of(piece), fragments.triangles_of(piece), piece.mass.volume,
                         piece.mass.centre_of_mass, {.max_parts = max_parts, .hull = settings}))
                    c::add_hull(*part.hull, part.offset, static_cast<uint32_t>(p), *hulls);
            }
        }
        *out = hulls.release();
    });
}

brittle_status brittle_hulls_array(const brittle_hulls* hulls, uint32_t which, brittle_array* out,
                                   brittle_error* error) {
    return guarded(error, [&] {
        need(out, "out");
        const brittle_hulls& all = need(hulls, "hulls");
        switch (which) {
        case BRITTLE_HULL_POINTS:
            *out = c::view<float>(all.points);
            return;
        case BRITTLE_HULL_RANGES:
            *out = c::view<uint32_t>(all.ranges);
            return;
        case BRITTLE_HULL_PIECES:
            *out = c::view<uint32_t>(all.pieces);
            return;
        case BRITTLE_HULL_MARGINS:
            *out = c::view<float>(all.margins);
            return;
        default:
            c::refuse_which(which, BRITTLE_HULL_MARGINS);
        }
    });
}

void brittle_hulls_free(brittle_hulls* hulls) {
    delete hulls;
}

void brittle_export_settings_init(brittle_export_settings* settings, size_t struct_size) {
    c::init_struct(settings, struct_size, c::export_defaults());
}

brittle_status brittle_pieces_save(const brittle_pieces* pieces, const char* path,
                                   const brittle_export_settings* settings, brittle_error* error) {
    return guarded_json(error, [&] {
        const brittle_pieces& p = need(pieces, "pieces");
        const c::Export out(p, settings);
        (void)must(fracture::export_pieces(c::read_text(path, "path"), p.fragments, p.certificate(), out.options));
    });
}

brittle_status brittle_pieces_save_memory(const brittle_pieces* pieces, const char* name,
                                          const brittle_export_settings* settings, brittle_files** out,
                                          brittle_error* error) {
    return guarded_json(error, [&] {
        need(out, "out");
        const brittle_pieces& p = need(pieces, "pieces");
        const c::Export exported(p, settings);
        auto files = std::make_unique<brittle_files>();
        files->files = must(fracture::export_pieces_to_memory(c::read_text(name, "name"), p.fragments, p.certificate(),
                                                              exported.options));
        *out = files.release();
    });
}

} // extern "C"
