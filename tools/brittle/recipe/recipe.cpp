#include "tools/brittle/recipe/recipe.h"

#include <algorithm>
#include <array>
#include <span>
#include <string_view>
#include <utility>
#include <vector>

#include <glm/geometric.hpp>
#include <nlohmann/json.hpp>

#include "fracture/io/atomic_file.h"
#include "fracture/io/text_cursor.h"
#include "physics/world/joint.h"
#include "tools/brittle/base/failure.h"
#include "tools/brittle/recipe/json_reader.h"

namespace brittle::tools {

namespace {

using Json = nlohmann::ordered_json;
using fracture::Pattern;

constexpr int version = 1;
constexpr std::string_view shape_prefix = "shape:";
constexpr size_t max_recipe_bytes = size_t{1} << 20;
constexpr size_t max_strikes = 1000;
constexpr std::array<std::string_view, 3> axes = {"x", "y", "z"};

Json vector_json(const glm::dvec3& v) {
    return {v.x, v.y, v.z};
}

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

// Converts the size of a brick along X, Y and Z to length, height and thickness, and back: exchanges the X component
// with the component of the axis that the length lies along.
glm::dvec3 exchanged(glm::dvec3 size, uint32_t along) {
    std::swap(size.x, size[static_cast<int>(along)]);
    return size;
}

Json brick_json(const physics::RunningBond& bond) {
    return {{"size", vector_json(exchanged(bond.brick, bond.along))}, {"along", axes[bond.along]}};
}

Json joint_json(const JointOptions& joint) {
    const JointOptions plain;
    Json json{{"kind", physics::to_string(joint.kind)}};
    if (joint.shot) json["shot"] = *joint.shot;
    if (joint.at != plain.at) json["at"] = vector_json(joint.at);
    if (joint.to_piece) json["to_piece"] = true;
    if (joint.to != plain.to) json["to"] = vector_json(joint.to);
    if (joint.axis != plain.axis) json["axis"] = vector_json(joint.axis);
    if (joint.min_length != plain.min_length) json["min_length"] = joint.min_length;
    if (joint.max_length) json["max_length"] = *joint.max_length;
    if (joint.max_force != plain.max_force) json["max_force"] = joint.max_force;
    if (joint.links != plain.links) json["links"] = joint.links;
    if (joint.link_radius != plain.link_radius) json["link_radius"] = joint.link_radius;
    return json;
}

Json world_json(const WorldOptions& world) {
    const WorldOptions plain;
    Json json = Json::object();
    if (world.engine != plain.engine) json["physics"] = physics::to_string(world.engine);
    if (world.bonded) json["bonded"] = true;
    if (world.anchored) json["anchored"] = true;
    if (world.height != plain.height) json["height"] = world.height;
    if (world.air_density != plain.air_density) json["air_density"] = world.air_density;
    if (world.max_colliding != plain.max_colliding) json["max_colliding"] = world.max_colliding;
    if (world.strength != plain.strength) json["strength"] = world.strength;
    if (world.breakable) json["breakable"] = true;
    if (world.min_size != plain.min_size) json["min_size"] = world.min_size;
    if (world.blow_pieces != plain.blow_pieces) json["blow_pieces"] = world.blow_pieces;
    if (world.bond.brick != plain.bond.brick || world.bond.along != plain.bond.along)
        json["brick"] = brick_json(world.bond);
    if (world.piece_limit != plain.piece_limit) json["piece_limit"] = world.piece_limit;
    for (const Anchor& anchor : world.anchors)
        json["anchors"].push_back({{"at", vector_json(anchor.at)}, {"radius", anchor.radius}});
    for (const Shot& shot : world.shots)
        json["shots"].push_back({{"time", shot.time},
                                 {"from", vector_json(shot.from)},
                                 {"velocity", vector_json(shot.velocity)},
                                 {"radius", shot.radius},
                                 {"density", shot.density}});
    for (const JointOptions& joint : world.joints) json["joints"].push_back(joint_json(joint));
    return json;
}

// Returns the values that differ from the defaults.
Json picture_json(const PictureOptions& picture) {
    const PictureOptions plain;
    Json json = Json::object();
    if (picture.frames != plain.frames) json["frames"] = picture.frames;
    if (picture.whole) json["whole"] = true;
    if (picture.planes != plain.planes) json["planes"] = picture.planes;
    if (picture.explode != plain.explode) json["explode"] = picture.explode;
    if (picture.sites) json["sites"] = true;
    if (picture.hulls) json["hulls"] = true;
    if (picture.cells) json["cells"] = true;
    if (picture.smooth) json["smooth"] = true;
    if (picture.wireframe) json["wireframe"] = true;
    if (picture.azimuth != plain.azimuth) json["azimuth"] = picture.azimuth;
    if (picture.elevation != plain.elevation) json["elevation"] = picture.elevation;
    if (picture.distance != plain.distance) json["distance"] = picture.distance;
    return json;
}

// Adds the values that differ from the plain roughness, with which reading starts.
void add_roughness(const fracture::Roughness& rough, const fracture::Roughness& plain, Json& recipe) {
    if (rough.amount > 0.0) recipe["roughness"] = rough.amount;
    if (rough.wavelength > 0.0) recipe["rough_size"] = rough.wavelength;
    if (rough.grain != plain.grain) recipe["grain"] = vector_json(rough.grain);
    if (rough.detail != plain.detail) recipe["detail"] = rough.detail;
}

Json recipe_object(const FractureOptions& options) {
    Json recipe{{"brittle", version}, {"mesh", options.mesh}};
    if (!options.material.empty()) recipe["material"] = options.material;
    if (options.repair) recipe["repair"] = true;
    if (options.unite) recipe["unite"] = true;
    FractureOptions plain;
    if (!options.material.empty()) use_material(options.material, plain);
    // Strikes break by the pattern, even if there are sites.
    const bool by_pattern = !options.strikes.empty() || (options.sites_file.empty() && options.points.empty());
    recipe["pattern"] = by_pattern ? pattern_json(options.pattern, plain.pattern) : points_json(options);
    if (!options.strikes.empty()) recipe["strikes"] = strikes_json(options.strikes);
    recipe["algorithm"] = fracture::to_string(options.algorithm);
    if (options.min_volume > 0.0) recipe["min_volume"] = options.min_volume;
    if (by_pattern) plain.rough.grain = grain_of_material(plain, options.pattern.axis);
    add_roughness(options.rough, plain.rough, recipe);
    if (const Json world = world_json(options.world); !world.empty()) recipe["world"] = world;
    if (const Json picture = picture_json(options.picture); !picture.empty()) recipe["picture"] = picture;
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

void read_strikes(const std::filesystem::path& file, JsonReader& reader, std::vector<Strike>& strikes) {
    const Json* list = reader.find("strikes");
    if (!list) return;
    if (!list->is_array() || list->size() > max_strikes)
        reader.fail("strikes", "a list [{ }, ...] of at most " + std::to_string(max_strikes), *list);
    strikes.clear();
    for (size_t k = 0; k < list->size(); ++k) {
        JsonReader inner(file, (*list)[k], "/strikes/" + std::to_string(k));
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
    const auto at = std::find(names.begin(), names.end(), type);
    if (at == names.end()) {
        std::string list;
        for (const std::string_view name : names) list.append(name).append(", ");
        throw reader.failure("type", "there is no pattern " + shown(type) + "; the patterns are: " + list + "points");
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

void read_anchors(const std::filesystem::path& file, const std::string& path, JsonReader& reader,
                  std::vector<Anchor>& anchors) {
    const Json* list = reader.find("anchors");
    if (!list) return;
    if (!list->is_array() || list->size() > max_anchors)
        reader.fail("anchors", "a list [{ }, ...] of at most " + std::to_string(max_anchors), *list);
    anchors.clear();
    for (size_t k = 0; k < list->size(); ++k) {
        JsonReader inner(file, (*list)[k], path + "/anchors/" + std::to_string(k));
        Anchor anchor;
        inner.vector("at", anchor.at);
        inner.number("radius", anchor.radius, 0.001, 10.0);
        inner.refuse_unknown_keys();
        anchors.push_back(anchor);
    }
}

void read_brick(JsonReader& reader, physics::RunningBond& bond) {
    glm::dvec3 size = exchanged(bond.brick, bond.along);
    if (const Json* sides = reader.find("size")) {
        if (!sides->is_array() || sides->size() != 3)
            reader.fail("size", "length, height and thickness in metres, such as [0.25, 0.075, 0.12]", *sides);
        for (int side = 0; side < 3; ++side)
            size[side] =
                reader.number_of("size/" + std::to_string(side), (*sides)[static_cast<size_t>(side)], 0.001, 10.0);
    }
    std::string along(axes[bond.along]);
    reader.text("along", along);
    const auto axis = std::ranges::find(axes, along);
    if (axis == axes.end()) throw reader.failure("along", "expected \"x\", \"y\" or \"z\", found " + shown(along));
    bond.along = static_cast<uint32_t>(axis - axes.begin());
    bond.brick = exchanged(size, bond.along);
}

void read_engine(JsonReader& reader, physics::EngineKind& engine) {
    std::string name = physics::to_string(engine);
    reader.text("physics", name);
    if (name != "solver" && name != "bullet")
        throw reader.failure("physics", "expected \"solver\" or \"bullet\", found " + shown(name));
    engine = name == "bullet" ? physics::EngineKind::bullet : physics::EngineKind::solver;
}

physics::JointKind joint_kind(JsonReader& reader) {
    std::string name = physics::to_string(JointOptions{}.kind);
    reader.text("kind", name);
    for (const physics::JointKind kind :
         {physics::JointKind::ball, physics::JointKind::hinge, physics::JointKind::distance})
        if (name == physics::to_string(kind)) return kind;
    throw reader.failure("kind", "expected \"ball\", \"hinge\" or \"distance\", found " + shown(name));
}

void read_joint(JsonReader& reader, JointOptions& joint) {
    constexpr double longest = 1000.0; // m
    joint.kind = joint_kind(reader);
    if (reader.find("shot")) reader.whole("shot", joint.shot.emplace(), 0, 100'000);
    reader.vector("at", joint.at);
    reader.flag("to_piece", joint.to_piece);
    reader.vector("to", joint.to);
    reader.vector("axis", joint.axis);
    reader.number("min_length", joint.min_length, 0.0, longest);
    if (reader.find("max_length")) reader.number("max_length", joint.max_length.emplace(), 0.001, longest);
    reader.number("max_force", joint.max_force, 0.0, 1e12);
    reader.whole("links", joint.links, 0, max_links);
    reader.number("link_radius", joint.link_radius, 0.001, 1.0);
    if (joint.kind == physics::JointKind::hinge && glm::length(joint.axis) < 1e-6)
        throw reader.failure("axis",
                             "expected a direction, such as [0, 1, 0], found " + shown(vector_json(joint.axis)));
    if (joint.max_length && *joint.max_length < joint.min_length)
        throw reader.failure("max_length", "is below min_length, " + std::to_string(joint.min_length) + " m");
    if (joint.links > 0 && joint.kind != physics::JointKind::distance)
        throw reader.failure("links", "only a distance joint has links; give \"kind\": \"distance\"");
    if (joint.links > 0 && (joint.max_length || joint.min_length > 0.0))
        throw reader.failure("links", "a chain is as long as its ends are apart; leave min_length and max_length out");
    if (joint.kind == physics::JointKind::distance && !joint.shot && glm::length(joint.to - joint.at) < 0.001)
        throw reader.failure("to", "is where \"at\" is; give the other end of the joint");
}

void read_joints(const std::filesystem::path& file, const std::string& path, JsonReader& reader,
                 std::vector<JointOptions>& joints) {
    const Json* all = reader.find("joints");
    if (!all) return;
    if (!all->is_array() || all->size() > max_joints)
        reader.fail("joints", "a list [{ }, ...] of at most " + std::to_string(max_joints) + " joints", *all);
    joints.clear();
    for (size_t k = 0; k < all->size(); ++k) {
        JsonReader inner(file, (*all)[k], path + "/joints/" + std::to_string(k));
        read_joint(inner, joints.emplace_back());
        inner.refuse_unknown_keys();
    }
}

void read_world(const std::filesystem::path& file, const std::string& path, JsonReader& reader, WorldOptions& world) {
    read_engine(reader, world.engine);
    reader.flag("bonded", world.bonded);
    reader.flag("anchored", world.anchored);
    reader.number("height", world.height, 0.0, 100.0);
    reader.number("air_density", world.air_density, 0.0, 1e4);
    reader.whole(reader.renamed("max_colliding", "most_colliding"), world.max_colliding, 0, 1'000'000);
    reader.number("strength", world.strength, 1e-6, 1e6);
    reader.flag("breakable", world.breakable);
    reader.number("min_size", world.min_size, 1e-4, 10.0);
    reader.whole("blow_pieces", world.blow_pieces, 2, 1000);
    if (const Json* brick = reader.find("brick")) {
        JsonReader inner(file, *brick, path + "/brick");
        read_brick(inner, world.bond);
        inner.refuse_unknown_keys();
    }
    reader.whole("piece_limit", world.piece_limit, 1, 1'000'000);
    read_anchors(file, path, reader, world.anchors);
    read_joints(file, path, reader, world.joints);
    const Json* shots = reader.find("shots");
    if (!shots) return;
    if (!shots->is_array()) reader.fail("shots", "a list [{ }, ...]", *shots);
    world.shots.clear();
    for (size_t k = 0; k < shots->size(); ++k) {
        JsonReader inner(file, (*shots)[k], path + "/shots/" + std::to_string(k));
        Shot shot;
        inner.number("time", shot.time, 0.0, 1e4);
        inner.vector("from", shot.from);
        inner.vector("velocity", shot.velocity);
        inner.number("radius", shot.radius, 0.001, 10.0);
        inner.number("density", shot.density, 1.0, 1e5);
        inner.refuse_unknown_keys();
        world.shots.push_back(shot);
    }
}

void read_picture(JsonReader& reader, PictureOptions& picture) {
    const auto number = [&](const char* key, float& target, double low, double high) {
        double value = target;
        reader.number(key, value, low, high);
        target = static_cast<float>(value);
    };
    reader.whole("frames", picture.frames, 0, 100'000);
    reader.flag("whole", picture.whole);
    reader.whole("planes", picture.planes, 0, 1'000'000);
    number("explode", picture.explode, 0.0, 10.0);
    reader.flag("sites", picture.sites);
    reader.flag("hulls", picture.hulls);
    reader.flag("cells", picture.cells);
    reader.flag("smooth", picture.smooth);
    reader.flag("wireframe", picture.wireframe);
    number("azimuth", picture.azimuth, -360.0, 360.0);
    number("elevation", picture.elevation, -89.0, 89.0);
    number("distance", picture.distance, 0.1, 10.0);
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

void read_recipe(const std::filesystem::path& file, const Json& json, const std::string& path,
                 FractureOptions& options) {
    JsonReader reader(file, json, path);
    int written_for = 0;
    reader.whole("brittle", written_for, 0, INT32_MAX);
    if (written_for != version)
        throw reader.failure("brittle", "expected the recipe's version, which is " + std::to_string(version));
    const auto from_here = [&](std::string& name) {
        if (!name.empty() && !name.starts_with(shape_prefix))
            name = (file.parent_path() / name).lexically_normal().string();
    };
    if (reader.find("mesh")) {
        reader.text("mesh", options.mesh);
        from_here(options.mesh);
    }
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
        from_here(options.sites_file);
        if (!material.empty()) options.rough.grain = grain_of_material(options, options.pattern.axis);
    }
    read_strikes(file, reader, options.strikes);
    if (const Json* world = reader.find("world")) {
        JsonReader inner(file, *world, path + "/world");
        read_world(file, path + "/world", inner, options.world);
        inner.refuse_unknown_keys();
    }
    if (const Json* picture = reader.find("picture")) {
        JsonReader inner(file, *picture, path + "/picture");
        read_picture(inner, options.picture);
        inner.refuse_unknown_keys();
    }
    std::string algorithm = fracture::to_string(options.algorithm);
    reader.text("algorithm", algorithm);
    if (algorithm != "exact" && algorithm != "sequential")
        throw reader.failure("algorithm", "expected \"exact\" or \"sequential\", found " + shown(algorithm));
    options.algorithm = algorithm == "exact" ? fracture::Algorithm::exact : fracture::Algorithm::sequential;
    reader.number("min_volume", options.min_volume, 0.0, 1e90);
    read_roughness(reader, options);
    reader.refuse_unknown_keys();
}

Json recipe_object(const FractureOptions& options, const std::filesystem::path& folder) {
    FractureOptions relative = options;
    for (std::string* path : {&relative.mesh, &relative.sites_file}) {
        if (path->empty() || path->starts_with(shape_prefix) || std::filesystem::path(*path).is_absolute()) continue;
        *path = std::filesystem::proximate(std::filesystem::absolute(*path), folder).string();
    }
    return recipe_object(relative);
}

void write_recipe(const std::filesystem::path& file, const FractureOptions& options) {
    const Json recipe = recipe_object(options, std::filesystem::absolute(file).parent_path());
    for (const std::string& name : {options.mesh, options.sites_file})
        if (!is_utf8(name))
            throw Failure(exit_output, file.string() + ": a recipe cannot name a file whose name is not UTF-8: "
                                           + fracture::printable(name) + "; rename that file");
    const std::string text = text_of(recipe, 2) + "\n";
    must(fracture::write_file_atomically(file, std::as_bytes(std::span(text))));
}

} // namespace brittle::tools
