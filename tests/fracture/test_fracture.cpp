#include <doctest/doctest.h>

#include <algorithm>
#include <atomic>
#include <chrono>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <limits>
#include <set>
#include <string>
#include <tuple>
#include <vector>

#include <glm/geometric.hpp>

#include "fracture/base/random.h"
#include "fracture/fracture.h"
#include "fracture/mesh/topology.h"
#include "fracture/pieces/certificate.h"
#include "fracture/shapes/shapes.h"
#include "fracture/sites/sites.h"

using namespace brittle::fracture;

namespace {

using Sites = std::vector<glm::dvec3>;

constexpr double not_a_number = std::numeric_limits<double>::quiet_NaN();
constexpr double infinity = std::numeric_limits<double>::infinity();

double distance_to_nearest(const Sites& sites, const glm::dvec3& point) {
    double nearest = infinity;
    for (const glm::dvec3& site : sites) nearest = std::min(nearest, glm::distance(site, point));
    return nearest;
}

// Checks layout, closedness, positive volumes, the volume sum, and that each piece lies in the cell of its site.
void check_fragments(const TriangleMesh& mesh, const Sites& sites, const Fragments& fragments, double tolerance) {
    const double size = glm::length(bounds(mesh).size());
    uint32_t vertex = 0;
    uint32_t triangle = 0;
    uint32_t site = 0;
    REQUIRE(fragments.triangle_source.size() == fragments.triangles.size());
    for (const Piece& piece : fragments.pieces) {
        CAPTURE(piece.site);
        CHECK(piece.vertices.begin == vertex);
        CHECK(piece.triangles.begin == triangle);
        CHECK(piece.site >= site);
        REQUIRE(piece.site < sites.size());
        vertex = piece.vertices.end;
        triangle = piece.triangles.end;
        site = piece.site;
        REQUIRE(vertex <= fragments.positions.size());
        REQUIRE(triangle <= fragments.triangles.size());
        const auto positions = fragments.positions_of(piece);
        const auto triangles = fragments.triangles_of(piece);
        REQUIRE(std::all_of(triangles.begin(), triangles.end(), [&](const Triangle& t) {
            return std::max({t.x, t.y, t.z}) < positions.size();
        }));
        CHECK(describe(check_topology(positions.size(), triangles)) == "");
        CHECK(piece.mass.volume > 0.0);
        double furthest_out = 0.0;
        for (const glm::dvec3& p : positions)
            furthest_out = std::max(furthest_out, glm::distance(sites[piece.site], p) - distance_to_nearest(sites, p));
        CHECK(furthest_out <= tolerance * size);
        for (uint32_t i = 0; i < triangles.size(); ++i) {
            const uint32_t source = fragments.triangle_source[piece.triangles.begin + i];
            const bool fits = i < piece.exterior_triangles ? source < mesh.triangles.size()
                                                           : source < sites.size() && source != piece.site;
            if (!fits) FAIL_CHECK("triangle " << i << " has source " << source);
        }
    }
    CHECK(vertex == fragments.positions.size());
    CHECK(triangle == fragments.triangles.size());
    const Certificate certificate = certify(mesh, fragments);
    CHECK(certificate.closed);
    CHECK(certificate.open_pieces == 0);
    CHECK(certificate.volume_error <= tolerance);
}

// Returns the sum of the volumes of each site's pieces.
std::vector<double> cell_volumes(const Fragments& fragments, size_t sites) {
    std::vector<double> volumes(sites);
    for (const Piece& piece : fragments.pieces) volumes[piece.site] += piece.mass.volume;
    return volumes;
}

// Checks that both algorithms give valid pieces and cells of equal volume. Returns the pieces of the default algorithm.
Fragments fracture_and_check(const TriangleMesh& mesh, const Sites& sites, double tolerance = 1e-9) {
    Result<Fragments> exact = fracture(mesh, sites);
    REQUIRE_MESSAGE(exact, (exact ? "" : exact.error().message));
    check_fragments(mesh, sites, *exact, tolerance);
    const Result<Fragments> sequential = fracture(mesh, sites, {.algorithm = Algorithm::sequential});
    REQUIRE_MESSAGE(sequential, (sequential ? "" : sequential.error().message));
    check_fragments(mesh, sites, *sequential, tolerance);
    const std::vector<double> a = cell_volumes(*exact, sites.size());
    const std::vector<double> b = cell_volumes(*sequential, sites.size());
    const double volume = std::abs(mass_properties(mesh.positions, mesh.triangles).volume);
    for (size_t site = 0; site < sites.size(); ++site) {
        CAPTURE(site);
        CHECK(std::abs(a[site] - b[site]) <= tolerance * volume);
    }
    return *std::move(exact);
}

Sites lattice_sites(int n, double spacing, const glm::dvec3& centre = glm::dvec3(0.0)) {
    Sites sites;
    for (int x = 0; x < n; ++x)
        for (int y = 0; y < n; ++y)
            for (int z = 0; z < n; ++z) sites.push_back(centre + (glm::dvec3(x, y, z) - 0.5 * (n - 1)) * spacing);
    return sites;
}

TriangleMesh transformed(TriangleMesh mesh, double scale, const glm::dvec3& offset = glm::dvec3(0.0)) {
    for (glm::dvec3& p : mesh.positions) p = p * scale + offset;
    return mesh;
}

Error error_of(const TriangleMesh& mesh, const Sites& sites, const Settings& settings = {}) {
    const Result<Fragments> result = fracture(mesh, sites, settings);
    REQUIRE_FALSE(result);
    return result.error();
}

bool mentions(const Error& error, Status status, std::string_view text) {
    INFO(error.message);
    CHECK(error.status == status);
    return error.message.find(text) != std::string::npos;
}

using Point = std::tuple<double, double, double>;
std::set<Point> points_of(const Fragments& fragments, const Piece& piece) {
    std::set<Point> points;
    for (const glm::dvec3& p : fragments.positions_of(piece)) points.insert({p.x, p.y, p.z});
    return points;
}

// Reads `v` and triangular `f` lines with plain indices only; the importer has tests of its own.
TriangleMesh read_plain_obj(const std::filesystem::path& file) {
    TriangleMesh mesh;
    std::ifstream in(file);
    std::string kind;
    while (in >> kind) {
        if (kind == "v") {
            glm::dvec3 p;
            in >> p.x >> p.y >> p.z;
            mesh.positions.push_back(p);
        } else if (kind == "f") {
            Triangle t;
            in >> t.x >> t.y >> t.z;
            mesh.triangles.push_back(t - 1u);
        }
        in.ignore(std::numeric_limits<std::streamsize>::max(), '\n');
    }
    return mesh;
}

} // namespace

TEST_CASE("a mesh without triangles is refused") {
    CHECK(mentions(error_of({}, {{0, 0, 0}}), Status::empty_mesh, "no triangles"));
}

TEST_CASE("bad values are refused by index and value") {
    TriangleMesh mesh = cube();
    mesh.positions[5].y = not_a_number;
    CHECK(mentions(error_of(mesh, {{0, 0, 0}}), Status::invalid_mesh, "vertex 5 is at (1, nan"));
    mesh = cube();
    mesh.positions[2].z = -infinity;
    CHECK(mentions(error_of(mesh, {{0, 0, 0}}), Status::invalid_mesh, "vertex 2"));
    mesh = cube();
    mesh.positions[3].x = 1e60;
    CHECK(mentions(error_of(mesh, {{0, 0, 0}}), Status::invalid_mesh, "1e+60"));
    mesh = cube();
    mesh.triangles[7].y = 8;
    CHECK(mentions(error_of(mesh, {{0, 0, 0}}), Status::invalid_mesh, "triangle 7 names vertex 8"));
}

TEST_CASE("bad sites are refused by index and value") {
    CHECK(mentions(error_of(cube(), {}), Status::invalid_sites, "no sites"));
    CHECK(mentions(error_of(cube(), {{0, 0, 0}, {0, not_a_number, 0}}), Status::invalid_sites,
                   "site 1 is at (0, nan, 0)"));
    CHECK(mentions(error_of(cube(), {{infinity, 0, 0}}), Status::invalid_sites, "site 0"));
}

TEST_CASE("settings out of range are refused") {
    Settings settings;
    settings.threads = 5000;
    CHECK(mentions(error_of(cube(), {{0, 0, 0}}, settings), Status::invalid_setting, "5000"));
}

TEST_CASE("a mesh that bounds no solid is refused with the status of its gravest fault, the counts and a location") {
    const Sites one{{0, 0, 0}};
    TriangleMesh open = cube();
    open.triangles.pop_back();
    CHECK(mentions(error_of(open, one), Status::not_closed, "3 open edges, the first between vertices"));
    TriangleMesh turned = cube();
    std::swap(turned.triangles[4].x, turned.triangles[4].y);
    CHECK(mentions(error_of(turned, one), Status::not_oriented, "3 edges whose two triangles face opposite ways"));
    TriangleMesh doubled = cube();
    doubled.triangles.push_back(doubled.triangles.front());
    CHECK(mentions(error_of(doubled, one), Status::non_manifold, "3 edges used by three triangles or more, the first"));
    TriangleMesh degenerate = cube();
    degenerate.triangles.push_back({3, 3, 5});
    CHECK(mentions(error_of(degenerate, one), Status::invalid_mesh, "the first is triangle 12"));
    TriangleMesh several = doubled;
    several.triangles.erase(several.triangles.begin() + 5);
    CHECK(mentions(error_of(several, one), Status::not_closed, "edges used by three triangles or more"));
}

TEST_CASE("a surface that encloses zero or negative volume is refused with its own status") {
    const Sites sites = uniform_sites({glm::dvec3(-1), glm::dvec3(1)}, 5, 1);
    for (const Algorithm algorithm : {Algorithm::exact, Algorithm::sequential}) {
        const Settings settings{.algorithm = algorithm};
        TriangleMesh inverted = transformed(cube(), 1e-4);
        for (Triangle& t : inverted.triangles) std::swap(t.x, t.y);
        CHECK(mentions(error_of(inverted, sites, settings), Status::inside_out, "its volume is -8e-12"));
        TriangleMesh flat = cube();
        for (glm::dvec3& p : flat.positions) p.z = 1.0;
        CHECK(mentions(error_of(flat, sites, settings), Status::no_volume, "no volume"));
        TriangleMesh point = cube();
        for (glm::dvec3& p : point.positions) p = {1, 2, 3};
        CHECK(mentions(error_of(point, sites, settings), Status::no_volume, "no volume"));
        const TriangleMesh pillow{{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}}, {{0, 1, 2}, {0, 2, 1}}};
        CHECK(mentions(error_of(pillow, sites, settings), Status::no_volume, "no volume"));
    }
}

TEST_CASE("an edge of four triangles is refused, whether or not a bisector cuts it and even if its triangles could be "
          "paired") {
    // Two tetrahedra that share the edge from vertex 0 to 1.
    TriangleMesh mesh{{{0, 0, 0}, {0, 0, 1}, {1, 0, 0}, {0, 1, 0}, {-1, 0, 0}, {0, -1, 0}}, {}};
    for (const glm::uvec4& v : {glm::uvec4(0, 2, 3, 1), glm::uvec4(0, 4, 5, 1)})
        for (const Triangle& t :
             {Triangle(v.x, v.z, v.y), Triangle(v.x, v.y, v.w), Triangle(v.y, v.z, v.w), Triangle(v.z, v.x, v.w)})
            mesh.triangles.push_back(t);
    for (const Sites& sites : {Sites{{0, 0, 0}}, Sites{{0, 0, 0}, {0, 0, 1}}, Sites{{9, 0, 0}, {10, 0, 0}}}) {
        for (const Algorithm algorithm : {Algorithm::exact, Algorithm::sequential}) {
            CHECK(mentions(error_of(mesh, sites, {.algorithm = algorithm}), Status::non_manifold,
                           "1 edge used by three triangles or more, the first between vertices 0 and 1"));
        }
    }
}

TEST_CASE("two triangles back to back beside a solid give no piece and change no other piece") {
    const TriangleMesh ball = icosphere(2);
    TriangleMesh mesh = ball;
    const auto n = static_cast<uint32_t>(mesh.positions.size());
    for (const glm::dvec3& p : {glm::dvec3(0, 0, 0), glm::dvec3(2, 0, 0), glm::dvec3(0, 2, 1)})
        mesh.positions.push_back(p);
    mesh.triangles.insert(mesh.triangles.begin() + 7, {n, n + 1, n + 2});
    mesh.triangles.push_back({n, n + 2, n + 1});
    const Sites sites = uniform_sites(bounds(ball), 8, 2);
    const Fragments with = fracture_and_check(mesh, sites);
    const Fragments without = fracture_and_check(ball, sites);
    CHECK(with.positions == without.positions);
    CHECK(with.triangles == without.triangles);
}

TEST_CASE("intersecting surfaces give closed pieces whose volumes sum to the input's, unless a piece is inside out") {
    const auto together = [](TriangleMesh a, const TriangleMesh& b) {
        const auto n = static_cast<uint32_t>(a.positions.size());
        a.positions.insert(a.positions.end(), b.positions.begin(), b.positions.end());
        for (const Triangle& t : b.triangles) a.triangles.push_back(t + n);
        return a;
    };
    const auto check = [](const TriangleMesh& mesh) {
        const Result<Fragments> fragments = fracture(mesh, uniform_sites(bounds(mesh), 20, 3));
        REQUIRE(fragments);
        const Certificate certificate = certify(mesh, *fragments);
        CHECK(certificate.closed);
        CHECK(certificate.volume_error < 1e-12);
        CHECK(certificate.negative_pieces == 0);
    };
    const TriangleMesh ball = icosphere(3);
    check(together(ball, transformed(ball, 1.0, {0.7, 0.1, 0.2})));
    check(torus_knot(2, 9, 300, 12, 0.4)); // its tube intersects itself
    // A small inside-out ball, half inside a large one: the part outside has negative volume.
    TriangleMesh hole = transformed(ball, 0.4, {1.0, 0.0, 0.0});
    for (Triangle& t : hole.triangles) std::swap(t.x, t.y);
    CHECK(mentions(error_of(together(ball, hole), uniform_sites(bounds(together(ball, hole)), 20, 3)),
                   Status::inverted_part, "near ("));
}

TEST_CASE("a reused workspace gives equal pieces, for the same mesh, for another mesh and after an error") {
    Workspace workspace;
    Fragments out;
    TriangleMesh mesh = torus(40, 20);
    const Sites sites = uniform_sites(bounds(mesh), 12, 5);
    for (int round = 0; round < 3; ++round) {
        REQUIRE(fracture(mesh, sites, {}, workspace, out));
        CHECK(hash(out) == hash(*fracture(mesh, sites)));
    }
    // Equal counts, one triangle reversed: the cached result of the previous mesh must not hide the fault.
    std::swap(mesh.triangles[100].x, mesh.triangles[100].y);
    const Result<void> turned = fracture(mesh, sites, {}, workspace, out);
    REQUIRE_FALSE(turned);
    CHECK(turned.error().status == Status::not_oriented);
    const TriangleMesh other = icosphere(3);
    REQUIRE(fracture(other, sites, {}, workspace, out));
    CHECK(hash(out) == hash(*fracture(other, sites)));
}

TEST_CASE("one site returns the mesh itself") {
    const TriangleMesh mesh = torus(24, 12);
    const Fragments fragments = fracture_and_check(mesh, {{7, 7, 7}}, 1e-14);
    REQUIRE(fragments.pieces.size() == 1);
    CHECK(fragments.positions.size() == mesh.positions.size());
    CHECK(fragments.triangles.size() == mesh.triangles.size());
    CHECK(fragments.pieces[0].exterior_triangles == mesh.triangles.size());
}

TEST_CASE("two sites cut once, and both pieces have the same points on the cut") {
    const TriangleMesh mesh = icosphere(3);
    const Fragments fragments = fracture_and_check(mesh, {{0.3, 0.1, -0.2}, {-0.4, 0.2, 0.1}}, 1e-13);
    REQUIRE(fragments.pieces.size() == 2);
    const auto a = points_of(fragments, fragments.pieces[0]);
    const auto b = points_of(fragments, fragments.pieces[1]);
    std::set<Point> shared;
    std::set_intersection(a.begin(), a.end(), b.begin(), b.end(), std::inserter(shared, shared.end()));
    std::set<Point> input;
    for (const glm::dvec3& p : mesh.positions) input.insert({p.x, p.y, p.z});
    // Every point of a cut is in both pieces, every vertex of the input in one.
    CHECK(a.size() + b.size() == input.size() + 2 * shared.size());
    CHECK(shared.size() > 20);
    for (const Point& p : shared) CHECK_FALSE(input.contains(p));
}

TEST_CASE("of duplicate sites only the first has a cell") {
    const Fragments fragments =
        fracture_and_check(cube(), {{0.5, 0, 0}, {0.5, 0, 0}, {-0.5, 0, 0}, {0.5, 0, 0}}, 1e-14);
    REQUIRE(fragments.pieces.size() == 2);
    CHECK(fragments.pieces[0].site == 0);
    CHECK(fragments.pieces[1].site == 2);
    CHECK(fracture_and_check(cube(), Sites(20, glm::dvec3(0.1)), 1e-14).pieces.size() == 1);
}

TEST_CASE("sites outside the box of the mesh cut it") {
    const Fragments fragments = fracture_and_check(cube(), {{100, 0, 0}, {-100, 1, 0}, {0, 300, 1}});
    CHECK(fragments.pieces.size() == 2);
    fracture_and_check(icosphere(2), {{1e6, 0, 0}, {-1e6, 1, 3}, {2, 1e6, 1}, {0, 5, -1e6}}, 1e-8);
    const Sites far{{0, 0, 0}, {1e20, 0, 0}, {0, -1e50, 1e50}};
    const Result<Fragments> sequential = fracture(icosphere(2), far, {.algorithm = Algorithm::sequential});
    REQUIRE(sequential);
    check_fragments(icosphere(2), far, *sequential, 1e-9);
    // The exact algorithm supports coordinates up to 1e30 mesh sizes and returns an error beyond.
    fracture_and_check(icosphere(2), {{0, 0, 0}, {1e20, 0, 0}, {0, -1e29, 1e29}});
    CHECK(mentions(error_of(icosphere(2), far), Status::invalid_sites, "site 2"));
}

TEST_CASE("pieces are closed and their volumes sum to the input's for all shapes, seeds and counts of sites") {
    const std::vector<std::pair<const char*, TriangleMesh>> shapes{{"cube", cube()},
                                                                   {"icosphere", icosphere(3)},
                                                                   {"torus", torus(40, 20)},
                                                                   {"torus knot", torus_knot(2, 3, 120, 12)},
                                                                   {"hollow sphere", hollow_sphere(3)}};
    for (const auto& [case_name, mesh] : shapes) {
        const auto name = case_name; // clang 14 captures no structured binding
        for (const uint32_t count : {1u, 2u, 10u, 40u}) {
            for (const uint64_t seed : {1u, 2u, 3u}) {
                CAPTURE(name);
                CAPTURE(count);
                CAPTURE(seed);
                fracture_and_check(mesh, uniform_sites(bounds(mesh), count, seed));
            }
        }
    }
}

TEST_CASE("bisectors through vertices, edges and faces give closed pieces" * doctest::test_suite("long")) {
    SUBCASE("lattice sites in a lattice cube: planes run in faces and through edges") {
        const Fragments fragments = fracture_and_check(lattice_cube(4, 2.0), lattice_sites(4, 0.5), 1e-12);
        CHECK(fragments.pieces.size() == 64);
        for (const Piece& piece : fragments.pieces) CHECK(piece.mass.volume == doctest::Approx(0.125));
    }
    SUBCASE("planes in the faces of the cube itself leave nothing outside") {
        const Fragments fragments = fracture_and_check(cube(2.0), lattice_sites(3, 2.0), 1e-12);
        REQUIRE(fragments.pieces.size() == 1);
        CHECK(fragments.pieces[0].site == 13);
    }
    SUBCASE("sites mirrored in the vertices of an icosphere") {
        const TriangleMesh mesh = icosphere(1);
        Sites sites{{0, 0, 0}};
        for (const glm::dvec3& p : mesh.positions) sites.push_back(p * 2.0 - sites[0]);
        fracture_and_check(mesh, sites);
        sites[0] = {0.25, 0.5, 0.125};
        for (size_t i = 1; i < sites.size(); ++i) sites[i] = mesh.positions[i - 1] * 2.0 - sites[0];
        fracture_and_check(mesh, sites);
    }
    SUBCASE("all sites on one sphere around the middle") {
        Sites sites = icosphere(2).positions;
        fracture_and_check(cube(2.0), sites);
        sites.emplace_back(0, 0, 0);
        fracture_and_check(cube(2.0), sites);
    }
    SUBCASE("sites on the vertices of the mesh") {
        fracture_and_check(lattice_cube(2), lattice_cube(2).positions);
    }
    SUBCASE("sites on a line") {
        Sites sites;
        for (int i = -8; i <= 8; ++i) sites.emplace_back(0.125 * i, 0, 0);
        CHECK(fracture_and_check(lattice_cube(8, 2.0), sites, 1e-12).pieces.size() == 17);
    }
    SUBCASE("sites one bit apart") {
        const double next = std::nextafter(0.25, 1.0);
        fracture_and_check(icosphere(2), {{0.25, 0, 0}, {next, 0, 0}, {0.25, next - 0.25, 0}, {-0.5, 0, 0}});
    }
}

TEST_CASE("scale and offset of the input do not change the count of pieces") {
    const TriangleMesh mesh = torus(24, 12);
    const Sites sites = uniform_sites(bounds(mesh), 12, 4);
    const size_t pieces = fracture_and_check(mesh, sites).pieces.size();
    for (const double scale : {1e-9, 1e-3, 1e9}) {
        CAPTURE(scale);
        Sites scaled = sites;
        for (glm::dvec3& s : scaled) s *= scale;
        CHECK(fracture_and_check(transformed(mesh, scale), scaled).pieces.size() == pieces);
    }
    const glm::dvec3 offset(1e6, -1e6, 3e5);
    Sites moved = sites;
    for (glm::dvec3& s : moved) s += offset;
    // Doubles near 1e6 are spaced by 1e-10, which limits the precision of cut points.
    CHECK(fracture_and_check(transformed(mesh, 1.0, offset), moved, 1e-8).pieces.size() == pieces);
}

TEST_CASE("solids that touch in a vertex are cut as two solids") {
    TriangleMesh mesh = cube(1.0); // corners at +-0.5
    const TriangleMesh first = mesh;
    const auto corner = static_cast<uint32_t>(std::find(first.positions.begin(), first.positions.end(), glm::dvec3(0.5))
                                              - first.positions.begin());
    const auto opposite = static_cast<uint32_t>(
        std::find(first.positions.begin(), first.positions.end(), glm::dvec3(-0.5)) - first.positions.begin());
    REQUIRE(corner < 8);
    REQUIRE(opposite < 8);
    for (const glm::dvec3& p : first.positions) mesh.positions.push_back(p + 1.0);
    for (Triangle t : first.triangles) {
        for (int i = 0; i < 3; ++i) t[i] = t[i] == opposite ? corner : t[i] + 8;
        mesh.triangles.push_back(t);
    }
    REQUIRE(check_topology(mesh.positions.size(), mesh.triangles).non_manifold_vertices == 1);
    CHECK(fracture_and_check(mesh, {{0, 0, 0}}, 1e-14).pieces.size() == 2);
    fracture_and_check(mesh, uniform_sites(bounds(mesh), 10, 1));
}

TEST_CASE("a two-sided triangle beside a solid has no volume and gives no piece") {
    TriangleMesh mesh = icosphere(1);
    const auto n = static_cast<uint32_t>(mesh.positions.size());
    mesh.positions.insert(mesh.positions.end(), {{2, 0, 0}, {3, 0, 0}, {2, 1, 0}});
    mesh.triangles.push_back({n, n + 1, n + 2});
    mesh.triangles.push_back({n, n + 2, n + 1});
    REQUIRE(check_topology(mesh.positions.size(), mesh.triangles).closed());
    CHECK(fracture_and_check(mesh, {{0, 0, 0}}).pieces.size() == 1);
    fracture_and_check(mesh, {{1.8, 0, 0}, {2.8, 0, 0}, {2, 0.7, 0}, {0, 0, 0}});
}

TEST_CASE("a hollow sphere in one cell is one piece, four legs below a plane are four pieces") {
    const TriangleMesh mesh = hollow_sphere(2);
    CHECK(fracture_and_check(mesh, {{0, 0, 0}}).pieces.size() == 1);
    const TriangleMesh animal = four_legged_animal(40);
    const Box box = bounds(animal);
    const double knee = box.min.y + 0.1 * box.size().y;
    const glm::dvec3 middle = box.centre();
    const Fragments legs =
        fracture_and_check(animal, {{middle.x, knee - 0.2, middle.z}, {middle.x, knee + 0.2, middle.z}});
    CHECK(std::count_if(legs.pieces.begin(), legs.pieces.end(), [](const Piece& p) { return p.site == 0; }) == 4);
    CHECK(legs.pieces.size() == 5);
}

TEST_CASE("the result does not depend on the number of threads or on the run") {
    const TriangleMesh mesh = torus_knot(2, 3, 100, 12);
    const Sites sites = uniform_sites(bounds(mesh), 30, 9);
    std::set<uint64_t> hashes;
    for (const uint32_t threads : {1u, 4u, 0u, 4u}) {
        Settings settings;
        settings.threads = threads;
        hashes.insert(hash(*fracture(mesh, sites, settings)));
    }
    CHECK(hashes.size() == 1);
    CHECK_FALSE(hashes.contains(hash(*fracture(mesh, uniform_sites(bounds(mesh), 30, 10)))));
}

TEST_CASE("a fracture can be cancelled within any phase, and its workspace remains usable") {
    const TriangleMesh mesh = icosphere(3);
    const Sites sites = uniform_sites(bounds(mesh), 30, 1);
    for (const Algorithm algorithm : {Algorithm::exact, Algorithm::sequential}) {
        Settings settings;
        settings.algorithm = algorithm;
        const uint64_t expected = hash(*fracture(mesh, sites, settings));
        Workspace workspace;
        Fragments out;
        int phases = 0;
        for (bool is_done = false; !is_done; ++phases) {
            int asked = 0;
            settings.cancelled = [&] { return asked++ == phases; };
            const Result<void> done = fracture(mesh, sites, settings, workspace, out);
            is_done = bool(done);
            if (!is_done) CHECK(done.error().status == Status::cancelled);
        }
        CHECK(phases > (algorithm == Algorithm::exact ? 60 : 5));
        settings.cancelled = {};
        REQUIRE(fracture(mesh, sites, settings, workspace, out));
        CHECK(hash(out) == expected);
    }
}

TEST_CASE("progress rises to 1, is reported by one thread at a time, and phases are timed") {
    Settings settings;
    std::vector<std::string> expected;
    SUBCASE("exact") {
        expected = {"prepare", "cells", "classify", "clip", "caps", "assemble", "slivers", "islands"};
    }
    SUBCASE("sequential") {
        settings.algorithm = Algorithm::sequential;
        expected = {"prepare", "cells", "clip", "islands", "assemble"};
    }
    std::vector<double> shares;
    std::atomic<int> inside = 0;
    settings.progress = [&](double share) {
        CHECK(++inside == 1);
        shares.push_back(share);
        --inside;
    };
    const Result<Fragments> fragments = fracture(icosphere(2), uniform_sites({}, 1, 1), settings);
    REQUIRE(fragments);
    CHECK(std::is_sorted(shares.begin(), shares.end()));
    REQUIRE_FALSE(shares.empty());
    CHECK(shares.front() > 0.0);
    CHECK(shares.back() == 1.0);
    std::vector<std::string> phases;
    for (const Milliseconds& m : fragments->timings) {
        phases.push_back(m.phase);
        CHECK(m.milliseconds >= 0.0);
    }
    CHECK(phases == expected);
}

TEST_CASE("the Stanford bunny breaks into closed pieces") {
    const std::filesystem::path file = "/usr/share/glmark2/models/bunny.obj";
    if (!std::filesystem::exists(file)) {
        MESSAGE("skipped: " << file << " is missing (Debian package glmark2-data)");
        return;
    }
    const TriangleMesh bunny = read_plain_obj(file);
    REQUIRE(bunny.triangles.size() == 69666);
    for (const uint32_t count : {10u, 100u}) {
        CAPTURE(count);
        const auto start = std::chrono::steady_clock::now();
        const Fragments fragments = fracture_and_check(bunny, uniform_sites(bounds(bunny), count, 1), 1e-9);
        const std::chrono::duration<double, std::milli> elapsed = std::chrono::steady_clock::now() - start;
        std::string phases;
        for (const Milliseconds& m : fragments.timings) phases += m.phase + " " + std::to_string(m.milliseconds) + ", ";
        MESSAGE(count << " sites: " << fragments.pieces.size() << " pieces, " << fragments.triangles.size()
                      << " triangles; ms: " << phases << "with checks " << elapsed.count());
    }
}
