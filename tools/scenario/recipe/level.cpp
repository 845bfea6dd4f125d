#include "tools/scenario/recipe/level.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <optional>
#include <string_view>
#include <utility>

#include <glm/common.hpp>
#include <nlohmann/json.hpp>

#include "fracture/io/text_cursor.h"
#include "tools/scenario/base/failure.h"
#include "tools/scenario/recipe/glue.h"
#include "tools/scenario/recipe/json_reader.h"
#include "tools/scenario/recipe/recipe.h"

namespace brittle::tools {

namespace {

using Json = nlohmann::ordered_json;
using fracture::SceneMesh;
using fracture::SceneNode;

Json parsed(const std::string& extras) {
    return extras.empty() ? Json::object() : Json::parse(extras);
}

// A node with its custom properties.
struct Candidate {
    const SceneNode& node;
    const SceneMesh& mesh;
    Json node_extras;
    const Json& mesh_extras;

    [[nodiscard]] const Json* property(const std::string& key) const {
        for (const Json* extras : {&node_extras, &mesh_extras})
            if (const auto at = extras->is_object() ? extras->find(key) : extras->end(); at != extras->end())
                return &*at;
        return nullptr;
    }
};

bool holds(const LevelRule& rule, const Candidate& candidate) {
    const auto has = [&](const auto& extra) {
        const Json* value = candidate.property(extra.first);
        return value && *value == Json::parse(extra.second);
    };
    const auto fits_material = [&](const std::string& name) { return fits_pattern(rule.material, name); };
    return (rule.node.empty() || fits_pattern(rule.node, candidate.node.name))
           && (rule.material.empty() || std::ranges::any_of(candidate.mesh.materials, fits_material))
           && std::ranges::all_of(rule.extras, has);
}

// The keys of an object in the extras of a node; null where there are none. The pieces that an export of this program
// describes there (docs/files.md) are left to the rules.
const Json* object_keys(const Candidate& candidate) {
    const Json* keys = candidate.property("brittle");
    return keys && keys->is_object() && keys->contains("site") ? nullptr : keys;
}

// What the extras of a node say that it is.
SceneObject object_of_extras(const std::string& file, const Candidate& candidate, const Json& keys) {
    const std::string path = "node " + fracture::quoted(std::string_view(candidate.node.name)) + ": /extras/brittle";
    SceneObject object;
    const Json in_text =
        keys.is_string() ? parse_json(file + ": " + path, keys.get<std::string>(), "custom property") : Json();
    read_object_kind(file, keys.is_string() ? in_text : keys, path, object);
    return object;
}

// Returns the deformation of an instance: an earlier one of its mesh where they differ by rounding alone.
void share(ObjectPlacement& placement, std::vector<ObjectPlacement>& known) {
    const glm::dvec3 limit = placement_rounding * glm::abs(placement.scale);
    for (const ObjectPlacement& other : known) {
        const bool is_equal =
            glm::all(glm::lessThanEqual(glm::abs(other.scale - placement.scale), limit))
            && glm::all(glm::lessThanEqual(glm::abs(other.shear - placement.shear), glm::dvec3(placement_rounding)));
        if (!is_equal) continue;
        placement.scale = other.scale;
        placement.shear = other.shear;
        return;
    }
    known.push_back(placement);
}

glm::dmat4 in_world(const glm::dmat4& node, double metres, const ObjectPlacement& level) {
    const glm::dmat3 linear = linear_part(level);
    glm::dmat4 world(linear * glm::dmat3(node));
    world[3] = glm::dvec4(level.translation + linear * (metres * glm::dvec3(node[3])), 1.0);
    return world;
}

std::string unique(const std::string& name, std::set<std::string>& taken) {
    std::string own = name;
    for (int number = 2; !taken.insert(own).second; ++number) own = name + " " + std::to_string(number);
    return own;
}

} // namespace

LevelObjects level_objects(const Level& level, const fracture::MeshScene& file, double metres,
                           std::set<std::string> taken) {
    if (file.nodes.size() > max_objects)
        throw Failure(exit_input, level.mesh + ": " + std::to_string(file.nodes.size())
                                      + " nodes show meshes; a scene has at most " + std::to_string(max_objects)
                                      + " objects. Join nodes that do not move");
    LevelObjects made;
    std::vector<Json> mesh_extras;
    for (const SceneMesh& mesh : file.meshes) mesh_extras.push_back(parsed(mesh.extras));
    std::vector<bool> decides(level.rules.size(), false);
    std::map<uint32_t, std::vector<ObjectPlacement>> deformations; // by mesh
    for (const SceneNode& node : file.nodes) {
        std::optional<ObjectPlacement> placement = placement_of(in_world(node.world, metres, level.placement));
        if (!placement) {
            made.notes.push_back(fracture::printable(node.name)
                                 + " is left out: its transform makes it flat, or too large or small");
            continue;
        }
        share(*placement, deformations[node.mesh]);
        const Candidate candidate{node, file.meshes[node.mesh], parsed(node.extras), mesh_extras[node.mesh]};
        const auto rule = std::ranges::find_if(level.rules, [&](const LevelRule& r) { return holds(r, candidate); });
        SceneObject object;
        object.fixed = true;
        if (const Json* keys = object_keys(candidate)) {
            try {
                object = object_of_extras(level.mesh, candidate, *keys);
            } catch (const Failure& failure) {
                made.notes.push_back(fracture::printable(node.name) + " stays whole and fixed: " + failure.what());
            }
        } else if (rule != level.rules.end()) {
            object = rule->then;
            decides[static_cast<size_t>(rule - level.rules.begin())] = true;
        }
        object.name = unique(node.name, taken);
        object.node = node.name;
        object.recipe.mesh = level.mesh;
        object.placement = *placement;
        made.objects.push_back(std::move(object));
    }
    for (size_t k = 0; k < decides.size(); ++k)
        if (!decides[k])
            made.notes.push_back("/level/rules/" + std::to_string(k) + " decides for no node of " + level.mesh);
    return made;
}

} // namespace brittle::tools
