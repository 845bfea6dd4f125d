#include "tools/scenario/run/scene_glue.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <limits>
#include <numbers>
#include <optional>
#include <tuple>
#include <utility>

#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <glm/gtc/quaternion.hpp>

#include "fracture/io/text_cursor.h"
#include "fracture/mesh/triangle_tree.h"
#include "fracture/pieces/contacts.h"
#include "tools/scenario/base/failure.h"

namespace brittle::tools {

namespace {

using fracture::TriangleMesh;

constexpr uint32_t none = UINT32_MAX;
// Cells of a contact by joints, along the longest side of the object that breaks: a blow takes a part of them with it.
constexpr double cells_per_object = 2.0;
constexpr size_t max_measured_pairs = 1'000'000; // of one entry, for the note how far apart its objects are

// Which entry of the glue decides for a pair of objects.
class Entries {
  public:
    Entries(const LoadedScene& scene) : scene_(scene) {
        for (const Glue& glue : scene.glue)
            for (const std::string* pattern : {&glue.first, &glue.second}) {
                std::vector<bool>& fits = fits_.emplace_back();
                for (const LoadedObject& object : scene.objects)
                    fits.push_back(fits_pattern(*pattern, object.object.name));
            }
    }

    [[nodiscard]] bool fits(size_t entry, size_t side, uint32_t object) const {
        return fits_[2 * entry + side][object];
    }
    [[nodiscard]] bool fits(uint32_t object) const {
        return std::ranges::any_of(fits_, [&](const std::vector<bool>& by_object) { return by_object[object]; });
    }
    // Whether an entry glues two objects. A fixed object needs no glue to another one.
    [[nodiscard]] bool glues(size_t entry, uint32_t i, uint32_t j) const {
        return i != j && !(is_fixed(i) && is_fixed(j))
               && ((fits(entry, 0, i) && fits(entry, 1, j)) || (fits(entry, 0, j) && fits(entry, 1, i)));
    }
    // The entry that decides for two objects, or none.
    [[nodiscard]] uint32_t of(uint32_t i, uint32_t j) {
        const auto [at, is_new] = known_.try_emplace(std::minmax(i, j), none);
        for (uint32_t entry = 0; is_new && entry < scene_.glue.size() && at->second == none; ++entry)
            if (glues(entry, i, j)) at->second = entry;
        return at->second;
    }

  private:
    [[nodiscard]] bool is_fixed(uint32_t object) const { return scene_.objects[object].object.fixed; }

    const LoadedScene& scene_;
    std::vector<std::vector<bool>> fits_; // two an entry, by object
    std::map<std::pair<uint32_t, uint32_t>, uint32_t> known_;
};

std::vector<glm::dvec3> in_world(const std::vector<glm::dvec3>& positions, const physics::Pose& placement) {
    const glm::dquat turn = glm::normalize(glm::dquat(placement.orientation));
    std::vector<glm::dvec3> placed;
    for (const glm::dvec3& p : positions) placed.push_back(glm::dvec3(placement.position) + turn * p);
    return placed;
}

// The surfaces of all pieces of objects that glue fits, in the world.
struct Surfaces {
    std::vector<std::vector<glm::dvec3>> positions; // by object
    std::vector<fracture::PieceSurface> pieces;
    std::vector<std::pair<uint32_t, uint32_t>> owners; // by surface: its object and piece
};

Surfaces surfaces_of(std::span<const PreparedObject> objects, const Entries& entries) {
    Surfaces surfaces;
    for (uint32_t k = 0; k < objects.size(); ++k) {
        const PreparedObject& object = objects[k];
        std::vector<glm::dvec3>& placed = surfaces.positions.emplace_back();
        if (!entries.fits(k)) continue;
        placed = in_world(object.fixed() ? object.surface->positions : object.fragments->positions, object.placement);
        if (object.fixed()) {
            surfaces.pieces.push_back({placed, object.surface->triangles});
            surfaces.owners.emplace_back(k, 0);
            continue;
        }
        for (uint32_t p = 0; p < object.fragments->pieces.size(); ++p) {
            const fracture::Piece& piece = object.fragments->pieces[p];
            surfaces.pieces.push_back({std::span(placed).subspan(piece.vertices.begin, piece.vertices.size()),
                                       object.fragments->triangles_of(piece)});
            surfaces.owners.emplace_back(k, p);
        }
    }
    return surfaces;
}

// m; 0 where the boxes touch
double between(const fracture::Box& a, const fracture::Box& b) {
    return glm::length(glm::max(glm::max(a.min - b.max, b.min - a.max), glm::dvec3(0.0)));
}

TriangleMesh mesh_in_world(const LoadedObject& object) {
    return {in_world(object.input->model.mesh.positions, object.placement), object.input->model.mesh.triangles};
}

// m, from the nearest corner of one object to the surface of the other.
double corner_distance(const LoadedObject& a, const LoadedObject& b) {
    const TriangleMesh first = mesh_in_world(a), second = mesh_in_world(b);
    double nearest = std::numeric_limits<double>::infinity();
    for (const auto& [corners, surface] : {std::pair(&first, &second), std::pair(&second, &first)}) {
        std::vector<uint32_t> all;
        for (uint32_t t = 0; t < surface->triangles.size(); ++t) all.push_back(t);
        const fracture::TriangleTree tree(*surface, std::move(all));
        for (const glm::dvec3& corner : corners->positions) nearest = std::min(nearest, tree.distance(corner));
    }
    return nearest;
}

std::string name_of(const LoadedObject& object) {
    return fracture::quoted(std::string_view(object.object.name));
}

// Why an entry glues nothing.
std::string reason_of(const LoadedScene& scene, const Entries& entries, size_t entry) {
    const auto count = static_cast<uint32_t>(scene.objects.size());
    std::array<std::vector<uint32_t>, 2> sides;
    for (size_t side = 0; side < 2; ++side) {
        for (uint32_t k = 0; k < count; ++k)
            if (entries.fits(entry, side, k)) sides[side].push_back(k);
        const std::string& pattern = side == 0 ? scene.glue[entry].first : scene.glue[entry].second;
        if (sides[side].empty()) return "no object has the name " + fracture::quoted(std::string_view(pattern));
    }
    if (sides[0].size() * sides[1].size() > max_measured_pairs) return "none of its objects touch";
    std::optional<std::pair<uint32_t, uint32_t>> nearest;
    double least = std::numeric_limits<double>::infinity();
    for (const uint32_t i : sides[0])
        for (const uint32_t j : sides[1]) {
            const double apart = between(scene.objects[i].box, scene.objects[j].box);
            if (!entries.glues(entry, i, j) || !(apart < least)) continue;
            least = apart;
            nearest = {i, j};
        }
    if (!nearest) return "it takes two objects, and one of them that is not fixed";
    const LoadedObject &a = scene.objects[nearest->first], &b = scene.objects[nearest->second];
    const double tolerance = scene.glue[entry].tolerance;
    char apart[160];
    std::snprintf(apart, sizeof apart,
                  "the nearest corner of one is %.3g m from the other, and glue takes faces that lie in one plane "
                  "within %.3g m",
                  corner_distance(a, b), tolerance);
    return name_of(a) + " and " + name_of(b) + " have no faces against each other: " + apart;
}

// The grid of contacts between two objects: in the box of the smaller one that starts whole and breaks.
fracture::ContactGrid grid_of(const LoadedScene& scene, std::span<const PreparedObject> objects, uint32_t i,
                              uint32_t j) {
    fracture::ContactGrid grid;
    for (const uint32_t k : {i, j}) {
        const fracture::Box& box = scene.objects[k].box;
        const double size = std::max({box.size().x, box.size().y, box.size().z}) / cells_per_object;
        if (objects[k].breaks_from_whole() && size < grid.size) grid = {box.min, size};
    }
    return grid;
}

// The contacts of objects. Those by joints with several pieces of a structure are one in each cell: the piece with most
// of it holds the joint.
class Contacts {
  public:
    explicit Contacts(std::span<PreparedObject> objects) : objects_(objects) {}

    void add(uint32_t own, const PreparedGlue& contact, const fracture::ContactGrid& grid) {
        PreparedObject& object = objects_[own];
        if (!contact.by_joint) {
            object.glue.push_back(contact);
            return;
        }
        const auto whole = [&](uint32_t k, uint32_t piece) { return objects_[k].breaks_from_whole() ? piece : none; };
        const glm::dvec3 cell = glm::floor((contact.centroid - grid.origin) / grid.size);
        const auto [at, is_new] =
            joints_.try_emplace({own, whole(own, contact.piece), contact.other,
                                 whole(contact.other, contact.other_piece), cell.x, cell.y, cell.z},
                                Joint{object.glue.size(), contact.area});
        if (is_new) {
            object.glue.push_back(contact);
            return;
        }
        PreparedGlue& joint = object.glue[at->second.index];
        const double area = joint.area + contact.area;
        const glm::dvec3 centroid = (joint.area * joint.centroid + contact.area * contact.centroid) / area;
        if (contact.area > at->second.largest) {
            at->second.largest = contact.area;
            joint = contact;
        }
        joint.area = area;
        joint.centroid = centroid;
    }

  private:
    struct Joint {
        size_t index;   // into the glue of its object
        double largest; // m^2, of its contacts
    };
    std::span<PreparedObject> objects_;
    std::map<std::tuple<uint32_t, uint32_t, uint32_t, uint32_t, double, double, double>, Joint> joints_;
};

// The contacts between objects whose pair one entry of this tolerance decides on.
void add_contacts(const LoadedScene& scene, const Surfaces& surfaces, double tolerance, Entries& entries,
                  std::span<PreparedObject> objects, std::vector<bool>& has_effect) {
    const auto entry_of = [&](uint32_t a, uint32_t b) {
        return entries.of(surfaces.owners[a].first, surfaces.owners[b].first);
    };
    const auto grid = [&](uint32_t a, uint32_t b) {
        return grid_of(scene, objects, surfaces.owners[a].first, surfaces.owners[b].first);
    };
    const fracture::ContactSettings settings{.tolerance = tolerance,
                                             .wanted =
                                                 [&](uint32_t a, uint32_t b) {
                                                     const uint32_t entry = entry_of(a, b);
                                                     return entry != none && scene.glue[entry].tolerance == tolerance;
                                                 },
                                             .grid = grid};
    Contacts all(objects);
    for (const fracture::Bond& contact : must(fracture::find_contacts(surfaces.pieces, settings))) {
        auto own = surfaces.owners[contact.b], other = surfaces.owners[contact.a];
        glm::dvec3 to_other = -contact.normal;
        if (objects[own.first].fixed()) {
            std::swap(own, other);
            to_other = contact.normal;
        }
        all.add(own.first,
                {own.second, other.first, other.second, contact.area, contact.centroid, to_other,
                 static_cast<float>(scene.glue[entry_of(contact.a, contact.b)].strength),
                 objects[own.first].breaks_from_whole() || objects[other.first].breaks_from_whole()},
                grid(contact.a, contact.b));
        for (size_t entry = 0; entry < scene.glue.size(); ++entry)
            if (!has_effect[entry] && entries.glues(entry, own.first, other.first)) has_effect[entry] = true;
    }
}

// Whether an object ends the groups that joints hold together: what is anchored does not move.
bool is_still(const PreparedObject& object) {
    return object.fixed() || object.world.anchored;
}

// The groups that glue by joints, or else by bonds, holds together, by their first members.
std::map<uint32_t, std::vector<uint32_t>> groups_of(std::span<const PreparedObject> objects, bool by_joint) {
    std::vector<uint32_t> leader(objects.size()); // union-find; the lowest object leads
    for (uint32_t k = 0; k < objects.size(); ++k) leader[k] = k;
    const auto leader_of = [&](uint32_t k) {
        while (leader[k] != k) k = leader[k] = leader[leader[k]];
        return k;
    };
    std::vector<bool> is_glued(objects.size(), false);
    for (uint32_t k = 0; k < objects.size(); ++k)
        for (const PreparedGlue& contact : objects[k].glue) {
            if (contact.by_joint != by_joint) continue;
            is_glued[k] = true;
            if (objects[contact.other].fixed()) continue;
            is_glued[contact.other] = true;
            if (by_joint && (is_still(objects[k]) || is_still(objects[contact.other]))) continue;
            const uint32_t a = leader_of(k), b = leader_of(contact.other);
            leader[std::max(a, b)] = std::min(a, b);
        }
    std::map<uint32_t, std::vector<uint32_t>> groups;
    for (uint32_t k = 0; k < objects.size(); ++k)
        if (is_glued[k]) groups[leader_of(k)].push_back(k);
    return groups;
}

// The joints of a group are solved together, in a time that grows faster than their number.
void check_joints(std::span<const PreparedObject> objects) {
    std::vector<size_t> joints_of(objects.size(), 0); // those of the object itself, and with earlier ones
    for (uint32_t k = 0; k < objects.size(); ++k)
        for (const PreparedGlue& contact : objects[k].glue)
            if (contact.by_joint) ++joints_of[is_still(objects[k]) ? contact.other : k];
    for (const auto& [first, members] : groups_of(objects, true)) {
        size_t joints = 0;
        for (const uint32_t k : members) joints += joints_of[k];
        if (joints > max_glue_joints)
            throw Failure(exit_input,
                          "/glue: " + std::to_string(members.size())
                              + " objects that start whole and break are glued to each other by "
                              + std::to_string(joints) + " contacts; at most " + std::to_string(max_glue_joints)
                              + " can hold one group; cut some at the start with \"bonded\": true, or keep them whole "
                                "with \"breakable\": false");
    }
}

} // namespace

std::vector<std::string> find_glue(const LoadedScene& scene, std::span<PreparedObject> objects) {
    std::vector<std::string> notes;
    for (PreparedObject& object : objects) object.glue.clear();
    if (scene.glue.empty()) return notes;
    Entries entries(scene);
    const Surfaces surfaces = surfaces_of(objects, entries);
    std::vector<double> tolerances;
    for (const Glue& glue : scene.glue)
        if (std::ranges::find(tolerances, glue.tolerance) == tolerances.end()) tolerances.push_back(glue.tolerance);
    std::vector<bool> has_effect(scene.glue.size(), false);
    for (const double tolerance : tolerances) add_contacts(scene, surfaces, tolerance, entries, objects, has_effect);
    for (size_t entry = 0; entry < scene.glue.size(); ++entry)
        if (!has_effect[entry])
            notes.push_back("/glue/" + std::to_string(entry) + " glues nothing: " + reason_of(scene, entries, entry));
    check_joints(objects);
    return notes;
}

std::map<uint32_t, std::vector<uint32_t>> glued_groups(std::span<const PreparedObject> objects) {
    return groups_of(objects, false);
}

physics::JointDesc glue_joint(std::span<const PreparedObject> objects, const PreparedObject& object,
                              const PreparedGlue& contact, physics::BodyId a, physics::BodyId b) {
    const PreparedObject& other = objects[contact.other];
    double strength = static_cast<double>(flawed_material(object).tensile); // Pa
    if (!other.fixed() || !other.material.empty())
        strength = std::min(strength, static_cast<double>(flawed_material(other).tensile));
    strength *= static_cast<double>(contact.strength);
    const double section_modulus = std::pow(contact.area, 1.5) / (4.0 * std::sqrt(std::numbers::pi)); // m^3, of a disc
    return {.kind = physics::JointKind::fixed,
            .a = a,
            .b = b,
            .anchor_a = glm::vec3(contact.centroid),
            .axis = glm::vec3(contact.normal),
            .max_force = static_cast<float>(strength * contact.area),
            .max_torque = static_cast<float>(strength * section_modulus),
            .bears_pressure = true};
}

} // namespace brittle::tools
