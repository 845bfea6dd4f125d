#include "tools/scenario/recipe/recipe.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <optional>
#include <set>
#include <span>
#include <string_view>
#include <utility>
#include <vector>

#include <glm/geometric.hpp>
#include <nlohmann/json.hpp>

#include "fracture/io/atomic_file.h"
#include "fracture/io/text_cursor.h"
#include "tools/scenario/base/failure.h"
#include "tools/scenario/recipe/glue.h"
#include "tools/scenario/recipe/json_reader.h"
#include "tools/scenario/recipe/world_json.h"

namespace brittle::tools {

namespace {

using Json = nlohmann::ordered_json;
using fracture::Pattern;

constexpr int version = 1, scene_version = 2;
constexpr std::string_view shape_prefix = "shape:";
constexpr size_t max_strikes = 1000;
constexpr size_t max_rules = 1000;

// Returns the values that differ from the plain pattern, which is the one that reading starts with.
Json pattern_json(const Pattern& pattern, const Pattern& plain) {
    Json json{{"type", fracture::pattern_names()[static_cast<size_t>(pattern.kind)]},
              {"count", pattern.count},
              {"seed", pattern.seed}};
    if (pattern.piece_size != plain.piece_size) json["piece_size"] = pattern.piece_size;
    if (pattern.jitter != plain.jitter) json["jitter"] = pattern.jitter;
    if (pattern.focus != plain.focus) json["focus"] = vector_json(pattern.focus);
    if (pattern.axis != plain.axis) json["axis"] = vector_json(pattern.axis);
    if (pattern.spread != plain.spread) json["spread"] = pattern.spread;
    if (pattern.slenderness != plain.slenderness) json["slenderness"] = pattern.slenderness;
    if (pattern.line != plain.line) {
        json["line"] = Json::array();
        for (const glm::dvec3& p : pattern.line) json["line"].push_back(vector_json(p));
    }
    if (pattern.grading != plain.grading) json["grading"] = pattern.grading;
    if (pattern.cells_per_piece != plain.cells_per_piece) json["cells_per_piece"] = pattern.cells_per_piece;
    if (pattern.inside) json["inside"] = true;
    return json;
}

Json automatic_json(const FractureOptions& options) {
    Json json{{"type", "automatic"}};
    if (options.automatic->scale != AutomaticPattern{}.scale) json["scale"] = options.automatic->scale;
    if (!options.automatic->named_seed) json["seed"] = options.pattern.seed;
    return json;
}

Json points_json(const FractureOptions& options) {
    const fracture::Placement plain, &placement = options.sites_placement;
    Json json{{"type", "points"}};
    if (options.pattern.seed != Pattern{}.seed) json["seed"] = options.pattern.seed; // seed of the cuts that blows make
    if (!options.points.empty()) {
        const auto any = [&](auto member) {
            return std::ranges::any_of(options.points, [&](const PlacedSite& site) { return site.*member != 0; });
        };
        const bool weighted = any(&PlacedSite::weight), grouped = any(&PlacedSite::group);
        for (const PlacedSite& site : options.points) {
            json["sites"].push_back(vector_json(site.at));
            if (weighted) json["weights"].push_back(site.weight);
            if (grouped) json["groups"].push_back(site.group);
        }
        return json;
    }
    json["file"] = options.sites_file;
    if (options.fit_sites) json["fit"] = true;
    if (placement.turn != plain.turn) json["turn"] = vector_json(placement.turn);
    if (placement.scale != plain.scale) json["scale"] = placement.scale;
    if (placement.move != plain.move) json["move"] = vector_json(placement.move);
    return json;
}

Json strikes_json(const std::vector<Strike>& strikes) {
    Json json = Json::array();
    for (const Strike& strike : strikes)
        json.push_back({{"at", vector_json(strike.at)},
                        {"direction", vector_json(strike.direction)},
                        {"radius", strike.radius},
                        {"pieces", strike.pieces}});
    return json;
}

// Adds the values that differ from the plain roughness, with which reading starts.
void add_roughness(const fracture::Roughness& rough, const fracture::Roughness& plain, Json& recipe) {
    if (rough.amount > 0.0) recipe["roughness"] = rough.amount;
    if (rough.wavelength > 0.0) recipe["rough_size"] = rough.wavelength;
    if (rough.grain != plain.grain) recipe["grain"] = vector_json(rough.grain);
    if (rough.detail != plain.detail) recipe["detail"] = rough.detail;
}

// How a mesh is broken: all but its physics.
void add_fracture(const FractureOptions& options, Json& recipe) {
    if (!options.material.empty()) recipe["material"] = options.material;
    if (options.repair) recipe["repair"] = true;
    if (options.unite) recipe["unite"] = true;
    FractureOptions plain;
    if (!options.material.empty()) use_material(options.material, plain);
    // Strikes break by the pattern, even if there are sites.
    const bool by_pattern = !options.strikes.empty() || (options.sites_file.empty() && options.points.empty());
    recipe["pattern"] = !by_pattern         ? points_json(options)
                        : options.automatic ? automatic_json(options)
                                            : pattern_json(options.pattern, plain.pattern);
    if (!options.strikes.empty()) recipe["strikes"] = strikes_json(options.strikes);
    recipe["algorithm"] = fracture::to_string(options.algorithm);
    if (options.min_volume > 0.0) recipe["min_volume"] = options.min_volume;
    if (by_pattern) plain.rough.grain = grain_of_material(plain, options.pattern.axis);
    add_roughness(options.rough, plain.rough, recipe);
}

void add_placement(const ObjectPlacement& placement, Json& json) {
    const ObjectPlacement plain;
    if (placement.translation != plain.translation) json["translation"] = vector_json(placement.translation);
    if (placement.rotation != plain.rotation) json["rotation"] = vector_json(placement.rotation);
    if (placement.shear != plain.shear) json["shear"] = vector_json(placement.shear);
    if (placement.scale != plain.scale) json["scale"] = vector_json(placement.scale);
}

// What an object is, whatever its mesh and place.
void add_kind(const SceneObject& object, Json& json) {
    add_fracture(object.recipe, json);
    if (object.fixed) json["fixed"] = true;
    if (object.shattered) json["shattered"] = true;
    add_body(object.recipe.world, json);
    json.erase("breakable"); // the default of an object, unlike that of a world
    if (!object.recipe.world.breakable && !object.fixed) json["breakable"] = false;
}

Json object_json(const SceneObject& object) {
    Json json{{"name", object.name}, {"mesh", object.recipe.mesh}};
    if (!object.node.empty()) json["node"] = object.node;
    if (object.in_pieces) json["in_pieces"] = true;
    if (object.contact_tolerance != SceneObject{}.contact_tolerance)
        json["contact_tolerance"] = object.contact_tolerance;
    add_placement(object.placement, json);
    add_kind(object, json);
    return json;
}

Json rule_json(const LevelRule& rule) {
    Json json = Json::object();
    if (!rule.node.empty()) json["node"] = rule.node;
    if (!rule.material.empty()) json["material"] = rule.material;
    for (const auto& [key, value] : rule.extras) json["extras"][key] = Json::parse(value);
    json["then"] = Json::object();
    add_kind(rule.then, json["then"]);
    return json;
}

Json level_json(const Level& level) {
    Json json{{"mesh", level.mesh}};
    add_placement(level.placement, json);
    for (const LevelRule& rule : level.rules) json["rules"].push_back(rule_json(rule));
    return json;
}

Json glue_json(const Glue& glue) {
    const Glue plain;
    Json json{{"between", Json::array({glue.first, glue.second})}};
    if (glue.strength != plain.strength) json["strength"] = glue.strength;
    if (glue.tolerance != plain.tolerance) json["tolerance"] = glue.tolerance;
    return json;
}

Json scene_json(const FractureOptions& scene) {
    Json json{{"brittle", scene_version}};
    if (scene.units != LengthUnit::metre) json["units"] = to_string(scene.units);
    if (scene.piece_scale != 1.0) json["piece_scale"] = scene.piece_scale;
    if (!scene.level.mesh.empty()) json["level"] = level_json(scene.level);
    for (const SceneObject& object : scene.objects) json["objects"].push_back(object_json(object));
    for (const Glue& glue : scene.glue) json["glue"].push_back(glue_json(glue));
    Json world = Json::object();
    add_world(scene.world, world);
    if (!world.empty()) json["world"] = world;
    if (const Json picture = picture_json(scene.picture); !picture.empty()) json["picture"] = picture;
    if (const Json files = export_json(scene.exports); !files.empty()) json["export"] = files;
    return json;
}

Json recipe_object(const FractureOptions& options) {
    if (is_scene(options)) return scene_json(options);
    Json recipe{{"brittle", version}, {"mesh", options.mesh}};
    add_fracture(options, recipe);
    if (options.units != LengthUnit::fit) recipe["units"] = to_string(options.units);
    Json world = Json::object();
    add_body(options.world, world);
    if (options.world.height != WorldOptions{}.height) world["height"] = options.world.height;
    add_world(options.world, world);
    if (!world.empty()) recipe["world"] = world;
    if (const Json picture = picture_json(options.picture); !picture.empty()) recipe["picture"] = picture;
    if (const Json files = export_json(options.exports); !files.empty()) recipe["export"] = files;
    return recipe;
}

// Returns a list with one value per site, or null.
const Json* read_list_by_site(JsonReader& reader, const char* key, size_t sites) {
    const Json* list = reader.find(key);
    if (list && (!list->is_array() || list->size() != sites))
        reader.fail(key, "a list of " + std::to_string(sites) + " values, one per site", *list);
    return list;
}

std::vector<PlacedSite> read_points(JsonReader& reader) {
    std::vector<PlacedSite> points;
    const Json* sites = reader.find("sites");
    if (!sites) return points;
    if (!sites->is_array() || sites->empty() || sites->size() > max_points)
        reader.fail("sites", "1 to " + std::to_string(max_points) + " points [[x, y, z], ...]", *sites);
    for (size_t k = 0; k < sites->size(); ++k)
        points.push_back({reader.vector_of("sites/" + std::to_string(k), (*sites)[k])});
    const Json* weights = read_list_by_site(reader, "weights", points.size());
    const Json* groups = read_list_by_site(reader, "groups", points.size());
    for (size_t k = 0; k < points.size(); ++k) {
        const std::string at = "/" + std::to_string(k);
        if (weights) points[k].weight = reader.number_of("weights" + at, (*weights)[k], -max_weight, max_weight);
        if (groups) points[k].group = static_cast<uint32_t>(reader.whole_of("groups" + at, (*groups)[k], 0, max_group));
    }
    return points;
}

void read_strikes(const std::filesystem::path& file, const std::string& path, JsonReader& reader,
                  std::vector<Strike>& strikes) {
    const Json* list = reader.find("strikes");
    if (!list) return;
    if (!list->is_array() || list->size() > max_strikes)
        reader.fail("strikes", "a list [{ }, ...] of at most " + std::to_string(max_strikes), *list);
    strikes.clear();
    for (size_t k = 0; k < list->size(); ++k) {
        JsonReader inner(file, (*list)[k], path + "/strikes/" + std::to_string(k));
        Strike strike;
        inner.vector("at", strike.at);
        inner.vector("direction", strike.direction);
        inner.number("radius", strike.radius, 1e-30, 1e30);
        inner.whole("pieces", strike.pieces, 1, 10'000);
        inner.refuse_unknown_keys();
        strikes.push_back(strike);
    }
}

void read_pattern(JsonReader& reader, FractureOptions& options) {
    options.automatic.reset();
    const auto names = fracture::pattern_names();
    std::string type(names[static_cast<size_t>(options.pattern.kind)]);
    reader.text("type", type);
    if (type == "points") {
        options.sites_file.clear();
        reader.text("file", options.sites_file);
        options.points = read_points(reader);
        reader.whole("seed", options.pattern.seed, 0, UINT64_MAX);
        if (options.sites_file.empty() == options.points.empty())
            throw reader.failure("file", "a pattern of points needs either a \"file\" or a list of \"sites\"");
        reader.flag("fit", options.fit_sites);
        reader.vector("turn", options.sites_placement.turn);
        reader.number("scale", options.sites_placement.scale, 1e-9, 1e9);
        reader.vector("move", options.sites_placement.move);
        return;
    }
    if (type == "automatic") {
        options.automatic = AutomaticPattern{.named_seed = !reader.find("seed")};
        reader.number("scale", options.automatic->scale, 1e-3, 1e3);
        reader.whole("seed", options.pattern.seed, 0, UINT64_MAX);
        return;
    }
    const auto at = std::find(names.begin(), names.end(), type);
    if (at == names.end()) {
        std::string list;
        for (const std::string_view name : names) list.append(name).append(", ");
        throw reader.failure("type", "there is no pattern " + shown(type) + "; the patterns are: " + list
                                         + "automatic, points");
    }
    options.sites_file.clear();
    options.points.clear();
    Pattern& pattern = options.pattern;
    pattern.kind = static_cast<fracture::PatternKind>(at - names.begin());
    reader.whole("count", pattern.count, 1, 1'000'000);
    reader.whole("seed", pattern.seed, 0, UINT64_MAX);
    reader.number("piece_size", pattern.piece_size, 0.0, 1e30);
    reader.number("jitter", pattern.jitter, 0.0, 1.0);
    reader.vector("focus", pattern.focus);
    reader.vector("axis", pattern.axis);
    reader.number("spread", pattern.spread, 1e-9, 100.0);
    reader.number("slenderness", pattern.slenderness, 1.0, 1e4);
    reader.number("grading", pattern.grading, 0.0, 1.0);
    reader.whole("cells_per_piece", pattern.cells_per_piece, 1, 1000);
    reader.flag("inside", pattern.inside);
    if (const Json* line = reader.find("line")) {
        if (!line->is_array() || line->size() < 2) reader.fail("line", "two points or more [[x, y, z], ...]", *line);
        pattern.line.clear();
        for (size_t k = 0; k < line->size(); ++k)
            pattern.line.push_back(reader.vector_of("line/" + std::to_string(k), (*line)[k]));
    }
}

// Precondition: material and pattern are read, whose grain holds where the recipe gives none.
void read_roughness(JsonReader& reader, FractureOptions& options) {
    fracture::Roughness& rough = options.rough;
    reader.number("roughness", rough.amount, 0.0, 1.0);
    reader.number("rough_size", rough.wavelength, 0.0, max_rough_size);
    reader.whole("detail", rough.detail, 1, max_detail);
    const Json* grain = reader.find("grain");
    if (!grain) return;
    reader.vector("grain", rough.grain);
    const double stretch = glm::length(rough.grain);
    if (rough.grain != glm::dvec3(0.0) && !(stretch >= min_stretch && stretch <= max_stretch))
        reader.fail("grain", "a direction as long as the factor of its stretch, from 1/16 to 16, or [0, 0, 0]", *grain);
}

} // namespace

std::string recipe_json(const FractureOptions& options) {
    return text_of(recipe_object(options));
}

void read_recipe(const std::filesystem::path& file, FractureOptions& options) {
    read_recipe(file, read_json_file(file, "recipe", max_recipe_bytes), "", options);
}

namespace {

void read_units(JsonReader& reader, LengthUnit& units) {
    std::string name = to_string(units);
    reader.text("units", name);
    const std::optional<LengthUnit> known = length_unit(name);
    if (!known)
        throw reader.failure("units", "expected \"m\", \"cm\", \"mm\", \"inch\" or \"fit\", found " + shown(name));
    units = *known;
}

// Returns the name of a file in the recipe as a path from the working folder; shapes stay.
std::string path_from(const std::filesystem::path& file, const std::string& name) {
    if (name.empty() || name.starts_with(shape_prefix)) return name;
    return (file.parent_path() / name).lexically_normal().string();
}

void read_mesh(const std::filesystem::path& file, JsonReader& reader, std::string& mesh) {
    if (!reader.find("mesh")) return;
    reader.text("mesh", mesh);
    mesh = path_from(file, mesh);
}

// Reads what add_fracture() writes.
void read_fracture(const std::filesystem::path& file, const std::string& path, JsonReader& reader,
                   FractureOptions& options) {
    reader.flag("repair", options.repair);
    reader.flag("unite", options.unite);
    std::string material;
    reader.text("material", material);
    if (!material.empty()) {
        try {
            use_material(material, options);
        } catch (const Failure& failure) {
            throw reader.failure("material", failure.what());
        }
        options.rough.amount = 0.0; // a recipe is rough only where it says so; older ones keep their pieces
    }
    if (const Json* pattern = reader.find("pattern")) {
        JsonReader inner(file, *pattern, path + "/pattern");
        read_pattern(inner, options);
        inner.refuse_unknown_keys();
        options.sites_file = path_from(file, options.sites_file);
        if (!material.empty()) options.rough.grain = grain_of_material(options, options.pattern.axis);
    }
    read_strikes(file, path, reader, options.strikes);
    std::string algorithm = fracture::to_string(options.algorithm);
    reader.text("algorithm", algorithm);
    if (algorithm != "exact" && algorithm != "sequential")
        throw reader.failure("algorithm", "expected \"exact\" or \"sequential\", found " + shown(algorithm));
    options.algorithm = algorithm == "exact" ? fracture::Algorithm::exact : fracture::Algorithm::sequential;
    reader.number("min_volume", options.min_volume, 0.0, 1e90);
    read_roughness(reader, options);
}

void read_placement(JsonReader& reader, ObjectPlacement& placement) {
    reader.world_vector("translation", placement.translation);
    reader.vector("rotation", placement.rotation);
    reader.world_vector("shear", placement.shear);
    glm::dvec3& scale = placement.scale;
    const Json* value = reader.find("scale");
    if (!value) return;
    scale = value->is_array() ? reader.vector_of("scale", *value)
                              : glm::dvec3(reader.number_of("scale", *value, min_scale, max_scale));
    for (int axis = 0; axis < 3; ++axis)
        if (!(std::abs(scale[axis]) >= min_scale && std::abs(scale[axis]) <= max_scale))
            reader.fail("scale", "a factor, or three of them, none of which is 0", *value);
}

void check_body(const JsonReader& reader, const SceneObject& object, bool says_breakable) {
    const WorldOptions& world = object.recipe.world;
    if (object.fixed
        && (world.bonded || world.anchored || object.shattered || says_breakable || !world.anchors.empty()))
        throw reader.failure("fixed", "a fixed object neither moves nor breaks; leave bonded, anchored, anchors, "
                                      "breakable and shattered out, or hold it by \"anchored\": true instead");
    if (object.shattered && (world.bonded || world.anchored || !world.anchors.empty()))
        throw reader.failure("shattered", "the pieces of a shattered object are loose; leave bonded, anchored and "
                                          "anchors out");
}

// Reads what add_kind() writes.
void read_kind(const std::filesystem::path& file, const std::string& path, JsonReader& reader, SceneObject& object) {
    read_fracture(file, path, reader, object.recipe);
    reader.flag("fixed", object.fixed);
    reader.flag("shattered", object.shattered);
    read_body(file, path, reader, object.recipe.world);
    const bool cut = object.shattered || object.recipe.world.bonded;
    if (cut && !reader.find("pattern")) object.recipe.automatic = AutomaticPattern{};
    const Json* breakable = reader.find("breakable");
    check_body(reader, object, breakable && breakable->is_boolean() && breakable->get<bool>());
    reader.refuse_unknown_keys();
}

void check_pieces(JsonReader& reader, const SceneObject& object) {
    if (!object.in_pieces) {
        if (reader.find("contact_tolerance"))
            throw reader.failure("contact_tolerance",
                                 "only pieces of a file touch within a tolerance; leave it out, or "
                                 "add \"in_pieces\": true");
        return;
    }
    const std::string& mesh = object.recipe.mesh;
    if (!mesh.ends_with(".glb") && !mesh.ends_with(".gltf"))
        throw reader.failure("in_pieces",
                             "the pieces are the nodes of a .glb or .gltf file, and the mesh is " + shown(mesh));
    if (!object.node.empty()) throw reader.failure("in_pieces", "the pieces are all nodes of the file; leave node out");
    if (object.recipe.repair || object.recipe.unite || !object.recipe.strikes.empty())
        throw reader.failure("in_pieces", "pieces are taken as they are; leave repair, unite and strikes out");
}

void read_object(const std::filesystem::path& file, const std::string& path, JsonReader& reader, SceneObject& object) {
    read_mesh(file, reader, object.recipe.mesh);
    if (object.recipe.mesh.empty()) throw reader.failure("mesh", "expected a mesh file or shape:NAME");
    reader.text("node", object.node);
    if (!object.node.empty() && object.recipe.mesh.starts_with(shape_prefix))
        throw reader.failure("node", "a shape has no nodes; leave it out, or name a .glb or .gltf file as the mesh");
    reader.flag("in_pieces", object.in_pieces);
    reader.number("contact_tolerance", object.contact_tolerance, 0.0, max_contact_tolerance);
    read_placement(reader, object.placement);
    read_kind(file, path, reader, object);
    check_pieces(reader, object);
}

void read_rule(const std::filesystem::path& file, const Json& json, const std::string& path, LevelRule& rule) {
    JsonReader reader(file, json, path);
    reader.text("node", rule.node);
    reader.text("material", rule.material);
    if (const Json* extras = reader.find("extras")) {
        if (!extras->is_object()) reader.fail("extras", "an object {\"key\": value, ...}", *extras);
        for (const auto& [key, value] : extras->items()) rule.extras.emplace_back(key, value.dump());
    }
    const Json* then = reader.find("then");
    if (!then) throw reader.failure("then", "expected the keys of the object, such as {\"material\": \"glass\"}");
    reader.refuse_unknown_keys();
    read_object_kind(file, *then, path + "/then", rule.then);
}

void read_level(const std::filesystem::path& file, const Json& json, const std::string& path, Level& level) {
    JsonReader reader(file, json, path);
    level = {};
    read_mesh(file, reader, level.mesh);
    if (level.mesh.empty() || level.mesh.starts_with(shape_prefix))
        throw reader.failure("mesh", "expected a .glb or .gltf file");
    read_placement(reader, level.placement);
    if (const Json* rules = reader.find("rules")) {
        if (!rules->is_array() || rules->size() > max_rules)
            reader.fail("rules", "a list [{ }, ...] of at most " + std::to_string(max_rules), *rules);
        for (size_t k = 0; k < rules->size(); ++k)
            read_rule(file, (*rules)[k], path + "/rules/" + std::to_string(k), level.rules.emplace_back());
    }
    reader.refuse_unknown_keys();
}

// Names the objects without one by their meshes: "vase", "vase 2", "vase 3" ...
void name_by_mesh(std::vector<SceneObject>& objects, std::set<std::string> taken) {
    std::map<std::string, int> last; // by name of the mesh
    for (SceneObject& object : objects) {
        if (!object.name.empty()) continue;
        const std::string mesh = object.node.empty() ? mesh_name(object.recipe.mesh) : object.node;
        int& number = last[mesh];
        do {
            object.name = ++number == 1 ? mesh : mesh + " " + std::to_string(number);
        } while (!taken.insert(object.name).second);
    }
}

void read_objects(const std::filesystem::path& file, const std::string& path, JsonReader& reader,
                  FractureOptions& scene) {
    const Json* level = reader.find("level");
    if (level) read_level(file, *level, path + "/level", scene.level);
    const Json* list = reader.find("objects");
    if (level && !list) return;
    if (!list || !list->is_array() || list->empty() || list->size() > max_objects)
        reader.fail("objects", "1 to " + std::to_string(max_objects) + " objects [{ }, ...]", list ? *list : Json());
    std::set<std::string> names;
    for (size_t k = 0; k < list->size(); ++k) {
        const std::string own = path + "/objects/" + std::to_string(k);
        JsonReader inner(file, (*list)[k], own);
        SceneObject object;
        inner.text("name", object.name);
        try {
            read_object(file, own, inner, object);
        } catch (const Failure& failure) {
            if (object.name.empty()) throw;
            throw Failure(failure.code(), failure.what() + std::string(" (object ") + shown(object.name) + ")");
        }
        if (!object.name.empty() && !names.insert(object.name).second)
            throw inner.failure("name", "there is another object " + shown(object.name) + "; names are unique");
        scene.objects.push_back(std::move(object));
    }
    name_by_mesh(scene.objects, std::move(names));
}

// Of a level, the objects are known once its file is read.
void check_glue(JsonReader& reader, const FractureOptions& scene, const Glue& glue) {
    for (const int side : {0, 1}) {
        const std::string key = "between/" + std::to_string(side);
        const std::string& pattern = side == 0 ? glue.first : glue.second;
        bool fits = !scene.level.mesh.empty();
        for (const SceneObject& object : scene.objects) {
            if (!fits_pattern(pattern, object.name)) continue;
            fits = true;
            if (const std::string refusal = refusal_of_glue(object); !refusal.empty())
                throw reader.failure(key, refusal);
        }
        if (!fits)
            throw reader.failure(key, "no object has the name " + shown(pattern)
                                          + "; give the name of an object, in which * may stand for any text");
    }
}

void read_glue(const std::filesystem::path& file, const std::string& path, JsonReader& reader, FractureOptions& scene) {
    const Json* list = reader.find("glue");
    if (!list) return;
    if (!list->is_array() || list->size() > max_glue)
        reader.fail("glue", "a list [{ }, ...] of at most " + std::to_string(max_glue), *list);
    for (size_t k = 0; k < list->size(); ++k) {
        JsonReader inner(file, (*list)[k], path + "/glue/" + std::to_string(k));
        Glue& glue = scene.glue.emplace_back();
        const Json* between = inner.find("between");
        if (!between || !between->is_array() || between->size() != 2 || !(*between)[0].is_string()
            || !(*between)[1].is_string())
            inner.fail("between", "the names of two objects, such as [\"shelf\", \"wall\"]",
                       between ? *between : Json());
        glue.first = (*between)[0].get<std::string>();
        glue.second = (*between)[1].get<std::string>();
        inner.number("strength", glue.strength, min_glue_strength, max_glue_strength);
        inner.number("tolerance", glue.tolerance, 0.0, max_contact_tolerance);
        inner.refuse_unknown_keys();
        check_glue(inner, scene, glue);
    }
}

} // namespace

void read_object_kind(const std::filesystem::path& file, const Json& json, const std::string& path,
                      SceneObject& object) {
    JsonReader reader(file, json, path);
    read_kind(file, path, reader, object);
}

void read_recipe(const std::filesystem::path& file, const Json& json, const std::string& path,
                 FractureOptions& options) {
    JsonReader reader(file, json, path);
    std::string schema; // for editors, which complete and check what is written
    reader.text("$schema", schema);
    int written_for = 0;
    reader.whole("brittle", written_for, 0, INT32_MAX);
    if (written_for != version && written_for != scene_version)
        throw reader.failure("brittle", "expected the recipe's version, which is " + std::to_string(version)
                                            + " for one mesh and " + std::to_string(scene_version) + " for a scene");
    const bool scene = written_for == scene_version;
    options.level = {};
    options.objects.clear();
    options.glue.clear();
    if (scene) options.units = LengthUnit::metre;
    read_units(reader, options.units);
    options.piece_scale = 1.0;
    if (scene) {
        reader.number("piece_scale", options.piece_scale, 1e-3, 1e3);
        read_objects(file, path, reader, options);
        read_glue(file, path, reader, options);
    } else {
        read_mesh(file, reader, options.mesh);
        read_fracture(file, path, reader, options);
    }
    if (const Json* world = reader.find("world")) {
        JsonReader inner(file, *world, path + "/world");
        if (!scene) {
            read_body(file, path + "/world", inner, options.world);
            inner.number("height", options.world.height, 0.0, 100.0);
        }
        read_world(file, path + "/world", inner, options.world);
        inner.refuse_unknown_keys();
    }
    if (const Json* picture = reader.find("picture")) {
        JsonReader inner(file, *picture, path + "/picture");
        read_picture(inner, options.picture);
        if (inner.find("interior_texture"))
            options.picture.interior_texture = path_from(file, options.picture.interior_texture);
        inner.refuse_unknown_keys();
    }
    if (const Json* files = reader.find("export")) {
        JsonReader inner(file, *files, path + "/export");
        read_export(inner, options.exports);
        if (inner.find("interior_texture"))
            options.exports.interior_texture = path_from(file, options.exports.interior_texture);
        inner.refuse_unknown_keys();
    }
    reader.refuse_unknown_keys();
}

namespace {

// Calls visit for each path of a file in the options.
template<class Options, class Visit>
void visit_files(Options& options, Visit visit) {
    visit(options.mesh);
    visit(options.sites_file);
    visit(options.picture.interior_texture);
    visit(options.exports.interior_texture);
    visit(options.level.mesh);
    for (auto& rule : options.level.rules) visit_files(rule.then.recipe, visit);
    for (auto& object : options.objects) visit_files(object.recipe, visit);
}

} // namespace

Json recipe_object(const FractureOptions& options, const std::filesystem::path& folder) {
    FractureOptions relative = options;
    visit_files(relative, [&](std::string& path) {
        if (path.empty() || path.starts_with(shape_prefix) || std::filesystem::path(path).is_absolute()) return;
        path = std::filesystem::proximate(std::filesystem::absolute(path), folder).string();
    });
    return recipe_object(relative);
}

void write_recipe(const std::filesystem::path& file, const FractureOptions& options) {
    const Json recipe = recipe_object(options, std::filesystem::absolute(file).parent_path());
    visit_files(options, [&](const std::string& name) {
        if (!is_utf8(name))
            throw Failure(exit_output, file.string() + ": a recipe cannot name a file whose name is not UTF-8: "
                                           + fracture::printable(name) + "; rename that file");
    });
    const std::string text = text_of(recipe, 2) + "\n";
    must(fracture::write_file_atomically(file, std::as_bytes(std::span(text))));
}

} // namespace brittle::tools
