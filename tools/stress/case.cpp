#include "tools/stress/case.h"

#include <algorithm>
#include <array>
#include <cinttypes>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <fstream>
#include <limits>
#include <numbers>
#include <sstream>

#include <glm/common.hpp>
#include <glm/geometric.hpp>

#include "fracture/base/random.h"
#include "fracture/shapes/shapes.h"

namespace brittle::stress {

using namespace fracture;

namespace {

using Sites = std::vector<glm::dvec3>;

struct Dice {
    Random random;

    uint32_t below(uint32_t n) { return static_cast<uint32_t>(random.next() % n); }
    uint32_t between(uint32_t low, uint32_t high) { return low + below(high - low + 1); }
    bool chance(double p) { return random.uniform() < p; }
    double in(double low, double high) { return low + (high - low) * random.uniform(); }
    glm::dvec3 in_box(const Box& box) { return random.uniform_in(box); }
    glm::dvec3 direction() {
        const double z = in(-1.0, 1.0), angle = in(0.0, 2.0 * std::numbers::pi), r = std::sqrt(1.0 - z * z);
        return {r * std::cos(angle), r * std::sin(angle), z};
    }
};

void append(TriangleMesh& mesh, const TriangleMesh& other, const glm::dvec3& offset = glm::dvec3(0.0)) {
    const auto base = static_cast<uint32_t>(mesh.positions.size());
    for (const glm::dvec3& p : other.positions) mesh.positions.push_back(p + offset);
    for (const Triangle& t : other.triangles) mesh.triangles.push_back(t + base);
}

void scale(TriangleMesh& mesh, const glm::dvec3& factor) {
    for (glm::dvec3& p : mesh.positions) p *= factor;
}

TriangleMesh simple_shape(Dice& dice) {
    switch (dice.below(5)) {
    case 0:
        return cube();
    case 1:
        return lattice_cube(dice.between(1, 4));
    case 2:
        return icosphere(dice.between(0, 2));
    case 3:
        return torus(dice.between(3, 24), dice.between(3, 16), 0.7, 0.28);
    default:
        return hollow_sphere(dice.between(1, 2));
    }
}

TriangleMesh knot(Dice& dice) {
    return torus_knot(2, 3, dice.between(40, 160), dice.between(4, 12), 0.2);
}

TriangleMesh components(Dice& dice) {
    TriangleMesh mesh;
    const uint32_t n = dice.between(2, 4);
    for (uint32_t x = 0; x < n; ++x)
        for (uint32_t y = 0; y < n; ++y)
            for (uint32_t z = 0; z < n; ++z) {
                if (dice.chance(0.4)) continue;
                TriangleMesh one = simple_shape(dice);
                scale(one, glm::dvec3(0.9 / n));
                append(mesh, one, (glm::dvec3(x, y, z) + 0.5) * (2.0 / n) - 1.0);
            }
    if (mesh.triangles.empty()) return cube();
    return mesh;
}

TriangleMesh overlapping(Dice& dice) {
    TriangleMesh mesh;
    for (uint32_t n = dice.between(2, 4); n > 0; --n) {
        // Offsets in steps of a quarter make faces and edges coincide.
        glm::dvec3 offset(dice.in(-0.7, 0.7), dice.in(-0.7, 0.7), dice.in(-0.7, 0.7));
        if (dice.chance(0.5)) offset = glm::round(offset * 4.0) / 4.0;
        append(mesh, simple_shape(dice), offset);
    }
    return mesh;
}

// A cube with cavities, cubes or balls, whose faces lie on a lattice of eighths.
TriangleMesh cavities(Dice& dice) {
    TriangleMesh mesh = cube();
    for (double x : {-0.5, 0.5})
        for (double y : {-0.5, 0.5})
            for (double z : {-0.5, 0.5}) {
                if (dice.chance(0.6)) continue;
                TriangleMesh hole = dice.chance(0.7) ? cube() : icosphere(1);
                scale(hole, glm::dvec3(0.125 * dice.between(1, 3)));
                for (Triangle& t : hole.triangles) std::swap(t.y, t.z);
                append(mesh, hole, {x, y, z});
            }
    return mesh;
}

// A ball with randomly displaced vertices, so that its surface crosses itself.
TriangleMesh crumpled(Dice& dice) {
    TriangleMesh mesh = icosphere(dice.between(1, 3));
    const double amount = dice.in(0.05, 0.8);
    for (glm::dvec3& p : mesh.positions) p += dice.direction() * dice.in(0.0, amount);
    return mesh;
}

// Vertices rounded to a coarse lattice: degenerate triangles, coincident vertices and coincident faces.
TriangleMesh rounded(Dice& dice) {
    TriangleMesh mesh = dice.chance(0.5) ? icosphere(dice.between(1, 3)) : torus(12, 8);
    const double steps = dice.between(2, 9);
    for (glm::dvec3& p : mesh.positions) p = glm::round(p * steps) / steps;
    return mesh;
}

TriangleMesh thin(Dice& dice) {
    TriangleMesh mesh = simple_shape(dice);
    glm::dvec3 factor(1.0);
    for (int k = 0; k < 3; ++k)
        if (dice.chance(0.6)) factor[k] = std::pow(10.0, dice.in(-5.0, 1.0));
    scale(mesh, factor);
    return mesh;
}

struct Family {
    std::string_view name;
    TriangleMesh (*make)(Dice&);
    bool simple; // without self-intersections and coincidences
};

constexpr std::array families = {
    Family{"cube", [](Dice&) { return cube(); }, true},
    Family{"lattice_cube", [](Dice& dice) { return lattice_cube(dice.between(1, 8)); }, true},
    Family{"icosphere", [](Dice& dice) { return icosphere(dice.between(0, 4)); }, true},
    Family{"torus", [](Dice& dice) { return torus(dice.between(3, 40), dice.between(3, 20)); }, true},
    Family{"knot", knot, true},
    Family{"hollow", [](Dice& dice) { return hollow_sphere(dice.between(1, 3)); }, true},
    Family{"sponge", [](Dice& dice) { return menger_sponge(dice.between(1, 2)); }, true},
    Family{"components", components, true},
    Family{"cavities", cavities, true},
    Family{"overlapping", overlapping, false},
    Family{"crumpled", crumpled, false},
    Family{"rounded", rounded, false},
    Family{"thin", thin, true},
    Family{"broken", nullptr, false},
};

constexpr auto family_names = [] {
    std::array<std::string_view, families.size()> names{};
    for (size_t k = 0; k < names.size(); ++k) names[k] = families[k].name;
    return names;
}();

// Damages a valid mesh in one of the ways that fracture() must report, or fills it with random bits.
void break_mesh(Dice& dice, Case& c) {
    TriangleMesh& mesh = c.mesh;
    Triangle& victim = mesh.triangles[dice.below(static_cast<uint32_t>(mesh.triangles.size()))];
    c.expect = Expect::refusal;
    switch (dice.below(8)) {
    case 0:
        mesh.triangles.erase(mesh.triangles.begin() + (&victim - mesh.triangles.data()));
        break;
    case 1:
        std::swap(victim.x, victim.y);
        break;
    case 2:
        mesh.triangles.push_back(Triangle(victim));
        break;
    case 3:
        victim.y = static_cast<uint32_t>(mesh.positions.size()) + dice.below(1000);
        break;
    case 4:
        victim.x = victim.z;
        break;
    case 5:
        mesh.positions[victim.x].y =
            dice.chance(0.5) ? std::numeric_limits<double>::quiet_NaN() : std::numeric_limits<double>::infinity();
        break;
    case 6: { // an edge of four triangles
        const Triangle t = victim;
        mesh.triangles.push_back(t);
        mesh.triangles.push_back({t.x, t.z, t.y});
        c.expect = Expect::either;
        break;
    }
    default:
        for (Triangle& t : mesh.triangles)
            for (int k = 0; k < 3; ++k)
                if (dice.chance(0.3)) t[k] = dice.below(static_cast<uint32_t>(mesh.positions.size()));
        c.expect = Expect::either;
    }
}

glm::dvec3 mesh_point(Dice& dice, const TriangleMesh& mesh) {
    const Triangle& t = mesh.triangles[dice.below(static_cast<uint32_t>(mesh.triangles.size()))];
    const glm::dvec3 &a = mesh.positions[t.x], &b = mesh.positions[t.y], &c = mesh.positions[t.z];
    switch (dice.below(3)) {
    case 0:
        return a;
    case 1:
        return (a + b) * 0.5;
    default:
        return (a + b + c) / 3.0;
    }
}

Sites lattice_sites(Dice& dice, const Box& box) {
    const uint32_t n = dice.between(1, 5);
    Sites sites;
    for (uint32_t x = 0; x < n; ++x)
        for (uint32_t y = 0; y < n; ++y)
            for (uint32_t z = 0; z < n; ++z)
                sites.push_back(box.min + (glm::dvec3(x, y, z) + 0.5) / static_cast<double>(n) * box.size());
    return sites;
}

// Integers with x^2 + y^2 + z^2 = n, exactly on a sphere.
Sites cospherical_sites(Dice& dice, const Box& box) {
    constexpr std::array squares = {2, 3, 5, 6, 9, 14, 17, 26, 29, 41};
    const int n = squares[dice.below(squares.size())];
    Sites sites;
    for (int x = -6; x <= 6; ++x)
        for (int y = -6; y <= 6; ++y)
            for (int z = -6; z <= 6; ++z)
                if (x * x + y * y + z * z == n)
                    sites.push_back(box.centre() + glm::dvec3(x, y, z) * (0.0625 * box.size().x));
    if (dice.chance(0.3)) sites.push_back(box.centre());
    return sites;
}

Sites random_sites(Dice& dice, const TriangleMesh& mesh, std::string& name, bool& generic) {
    const Box box = bounds(mesh);
    const uint32_t count = dice.chance(0.1) ? dice.between(50, 250) : dice.between(1, 40);
    Sites sites;
    generic = false;
    switch (dice.below(12)) {
    case 0:
    case 1:
        name = "uniform";
        generic = true;
        for (uint32_t k = 0; k < count; ++k) sites.push_back(dice.in_box(box));
        break;
    case 2:
        name = "lattice";
        return lattice_sites(dice, box);
    case 3:
        name = "coarse";
        for (uint32_t k = 0; k < count; ++k) {
            const double steps = 4.0;
            sites.push_back(box.min + glm::round(dice.in_box({{}, glm::dvec3(1.0)}) * steps) / steps * box.size());
        }
        break;
    case 4:
        name = "cospherical";
        return cospherical_sites(dice, box);
    case 5:
        name = "on the mesh";
        for (uint32_t k = 0; k < count; ++k) sites.push_back(mesh_point(dice, mesh));
        break;
    case 6:
        name = "mirrored";
        for (uint32_t k = 0; k < (count + 1) / 2; ++k) {
            const glm::dvec3 site = dice.in_box(box);
            sites.push_back(site);
            sites.push_back(2.0 * mesh_point(dice, mesh) - site);
        }
        break;
    case 7:
        name = "duplicates";
        for (uint32_t k = 0; k < count; ++k)
            sites.push_back(k > 0 && dice.chance(0.4) ? sites[dice.below(k)] : dice.in_box(box));
        break;
    case 8: {
        name = "collinear";
        const glm::dvec3 from = dice.in_box(box), step = dice.direction() * (dice.in(0.01, 0.3) * box.size().x);
        for (uint32_t k = 0; k < count; ++k) sites.push_back(from + step * static_cast<double>(k));
        break;
    }
    case 9: {
        name = "clustered";
        const double tightness = std::pow(10.0, dice.in(-6.0, -0.5));
        const glm::dvec3 centre = dice.in_box(box);
        for (uint32_t k = 0; k < count; ++k)
            sites.push_back(centre + dice.direction() * (tightness * dice.random.uniform() * box.size().x));
        break;
    }
    case 10:
        name = "in faces"; // bisectors coincide with faces
        for (uint32_t k = 0; k < (std::min(count, 16u) + 1) / 2; ++k) {
            const Triangle& t = mesh.triangles[dice.below(static_cast<uint32_t>(mesh.triangles.size()))];
            const glm::dvec3 &a = mesh.positions[t.x], &b = mesh.positions[t.y], &c = mesh.positions[t.z];
            const glm::dvec3 normal = glm::cross(b - a, c - a);
            const double length = glm::length(normal);
            const glm::dvec3 step = length > 0.0 ? normal * (0.25 * box.size().x / length) : dice.direction();
            const glm::dvec3 middle = dice.chance(0.5) ? (b + c) * 0.5 : a;
            sites.push_back(middle - step);
            sites.push_back(middle + step);
        }
        break;
    default:
        name = "far";
        for (uint32_t k = 0; k < count; ++k)
            sites.push_back(box.centre() + dice.direction() * (box.size().x * std::pow(10.0, dice.in(-2.0, 9.0))));
    }
    return sites;
}

// Scales and moves mesh and sites. Equal coordinates stay equal, but round numbers do not stay round.
void place(Dice& dice, Case& c) {
    double factor = 1.0;
    glm::dvec3 offset(0.0);
    const uint32_t kind = dice.below(8);
    if (kind == 0) factor = 1e-9;
    if (kind == 1) factor = 1e9;
    if (kind == 2) offset = glm::dvec3(1e6, -1e6, 1e6);
    if (kind == 3) offset = dice.direction() * 1e3;
    if (kind > 3) return;
    for (glm::dvec3& p : c.mesh.positions) p = p * factor + offset;
    for (glm::dvec3& p : c.sites) p = p * factor + offset;
    c.family += kind < 2 ? ", scaled" : ", offset";
    c.generic = c.generic && kind < 2;
}

} // namespace

std::span<const std::string_view> mesh_families() {
    return family_names;
}

Case random_case(uint64_t seed, std::string_view family) {
    Dice dice{Random(seed)};
    const Family* chosen = &families[dice.below(families.size())];
    for (const Family& f : families)
        if (f.name == family) chosen = &f;
    Case c;
    const bool broken = chosen->make == nullptr;
    c.mesh = broken ? simple_shape(dice) : chosen->make(dice);
    std::string sites;
    bool generic = false;
    c.sites = random_sites(dice, c.mesh, sites, generic);
    c.simple = chosen->simple;
    c.generic = generic && chosen->simple;
    c.family = std::string(chosen->name) + ", sites " + sites;
    place(dice, c);
    if (dice.chance(0.2)) {
        // Squares of few distinct shares of the mesh's size; on a lattice they give points that many cells share.
        const glm::dvec3 size = bounds(c.mesh).size();
        const double largest = std::max({size.x, size.y, size.z}) * std::pow(10.0, dice.in(-3.0, 0.0));
        const bool rounded = dice.chance(0.5);
        for (size_t k = 0; k < c.sites.size(); ++k) {
            const double share = dice.in(-0.2, 1.0);
            c.weights.push_back((rounded ? std::round(share * 4.0) / 4.0 : share) * largest * largest);
        }
        c.family += ", weights";
        c.generic = c.generic && !rounded;
    }
    if (dice.chance(0.2)) {
        for (size_t k = 0, n = dice.between(1, 6); k < c.sites.size(); ++k)
            c.groups.push_back(dice.below(static_cast<uint32_t>(n)));
        c.family += ", groups";
        c.generic = false;
    }
    if (dice.chance(0.15)) {
        const glm::dvec3 size = bounds(c.mesh).size();
        c.min_volume = size.x * size.y * size.z * std::pow(10.0, dice.in(-5.0, -1.0));
        c.family += ", least volume";
        c.generic = false;
    }
    if (broken) break_mesh(dice, c);
    return c;
}

std::string to_text(const Case& c) {
    constexpr std::array expectations = {"pieces", "refusal", "either"};
    std::string text = "brittle-case 1\nfamily " + c.family + "\nexpect " + expectations[static_cast<size_t>(c.expect)]
                       + "\nsimple " + (c.simple ? "1" : "0") + "\ngeneric " + (c.generic ? "1" : "0") + "\n";
    char line[120];
    const auto points = [&](const char* name, const std::vector<glm::dvec3>& list) {
        text += name + (" " + std::to_string(list.size())) + "\n";
        for (const glm::dvec3& p : list) {
            std::snprintf(line, sizeof line, "%a %a %a\n", p.x, p.y, p.z);
            text += line;
        }
    };
    points("vertices", c.mesh.positions);
    text += "triangles " + std::to_string(c.mesh.triangles.size()) + "\n";
    for (const Triangle& t : c.mesh.triangles) {
        std::snprintf(line, sizeof line, "%" PRIu32 " %" PRIu32 " %" PRIu32 "\n", t.x, t.y, t.z);
        text += line;
    }
    points("sites", c.sites);
    text += "groups " + std::to_string(c.groups.size()) + "\n";
    for (const uint32_t group : c.groups) text += std::to_string(group) + "\n";
    text += "weights " + std::to_string(c.weights.size()) + "\n";
    for (const double weight : c.weights) {
        std::snprintf(line, sizeof line, "%a\n", weight);
        text += line;
    }
    std::snprintf(line, sizeof line, "min_volume %a\n", c.min_volume);
    return text + line;
}

Result<Case> read_case(const std::filesystem::path& file) {
    std::ifstream in(file);
    if (!in) return Error{Status::file_not_found, "cannot read " + file.string()};
    Case c;
    std::string line;
    int number = 0;
    const auto malformed = [&](const std::string& wanted) {
        return Error{Status::malformed_file,
                     file.string() + ", line " + std::to_string(number) + ": expected " + wanted};
    };
    // Reads the next line, which must start with the word, and gives its rest.
    const auto field = [&](const char* word, std::string& value) {
        ++number;
        if (!std::getline(in, line) || !line.starts_with(std::string(word) + " ")) return false;
        value = line.substr(std::string_view(word).size() + 1);
        return true;
    };
    const auto points = [&](const char* word, std::vector<glm::dvec3>& list) {
        std::string value;
        if (!field(word, value)) return false;
        for (unsigned long n = std::strtoul(value.c_str(), nullptr, 10); n > 0; --n) {
            ++number;
            if (!std::getline(in, line)) return false;
            glm::dvec3 p;
            char* at = line.data();
            for (int k = 0; k < 3; ++k) {
                char* end = nullptr;
                p[k] = std::strtod(at, &end);
                if (end == at) return false;
                at = end;
            }
            list.push_back(p);
        }
        return true;
    };
    std::string value;
    if (!field("brittle-case", value) || value != "1") return malformed("brittle-case 1");
    if (!field("family", c.family)) return malformed("family");
    if (!field("expect", value)) return malformed("expect");
    if (value != "pieces" && value != "refusal" && value != "either") return malformed("pieces, refusal or either");
    c.expect = value == "pieces" ? Expect::pieces : (value == "refusal" ? Expect::refusal : Expect::either);
    if (!field("simple", value)) return malformed("simple");
    c.simple = value == "1";
    if (!field("generic", value)) return malformed("generic");
    c.generic = value == "1";
    if (!points("vertices", c.mesh.positions)) return malformed("vertices, then three numbers a line");
    if (!field("triangles", value)) return malformed("triangles");
    for (unsigned long n = std::strtoul(value.c_str(), nullptr, 10); n > 0; --n) {
        ++number;
        Triangle t;
        if (!std::getline(in, line) || !(std::istringstream(line) >> t.x >> t.y >> t.z))
            return malformed("three indices");
        c.mesh.triangles.push_back(t);
    }
    if (!points("sites", c.sites)) return malformed("sites, then three numbers a line");
    if (!field("groups", value)) return malformed("groups");
    for (unsigned long n = std::strtoul(value.c_str(), nullptr, 10); n > 0; --n) {
        ++number;
        if (!std::getline(in, line)) return malformed("a group");
        c.groups.push_back(static_cast<uint32_t>(std::strtoul(line.c_str(), nullptr, 10)));
    }
    if (!field("weights", value)) return malformed("weights");
    for (unsigned long n = std::strtoul(value.c_str(), nullptr, 10); n > 0; --n) {
        ++number;
        if (!std::getline(in, line)) return malformed("a weight");
        c.weights.push_back(std::strtod(line.c_str(), nullptr));
    }
    if (!field("min_volume", value)) return malformed("min_volume");
    c.min_volume = std::strtod(value.c_str(), nullptr);
    return c;
}

} // namespace brittle::stress
