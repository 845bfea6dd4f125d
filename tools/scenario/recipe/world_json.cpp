#include "tools/scenario/recipe/world_json.h"

#include <algorithm>
#include <array>
#include <initializer_list>
#include <string_view>
#include <utility>
#include <vector>

#include <glm/geometric.hpp>
#include <nlohmann/json.hpp>

#include "physics/world/joint.h"
#include "tools/scenario/recipe/recipe.h"

namespace brittle::tools {

namespace {

using Json = nlohmann::ordered_json;

constexpr std::array<std::string_view, 3> axes = {"x", "y", "z"};

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
    if (joint.max_torque != plain.max_torque) json["max_torque"] = joint.max_torque;
    if (joint.links != plain.links) json["links"] = joint.links;
    if (joint.link_radius != plain.link_radius) json["link_radius"] = joint.link_radius;
    return json;
}

} // namespace

Json vector_json(const glm::dvec3& v) {
    return {v.x, v.y, v.z};
}

void add_body(const WorldOptions& world, Json& json) {
    const WorldOptions plain;
    if (world.bonded) json["bonded"] = true;
    if (world.anchored) json["anchored"] = true;
    if (world.strength != plain.strength) json["strength"] = world.strength;
    if (world.breakable) json["breakable"] = true;
    if (world.min_size != plain.min_size) json["min_size"] = world.min_size;
    if (world.blow_pieces != plain.blow_pieces) json["blow_pieces"] = world.blow_pieces;
    if (world.bond.brick != plain.bond.brick || world.bond.along != plain.bond.along)
        json["brick"] = brick_json(world.bond);
    for (const Anchor& anchor : world.anchors)
        json["anchors"].push_back({{"at", vector_json(anchor.at)}, {"radius", anchor.radius}});
}

void add_world(const WorldOptions& world, Json& json) {
    const WorldOptions plain;
    if (world.engine != plain.engine) json["physics"] = physics::to_string(world.engine);
    if (world.air_density != plain.air_density) json["air_density"] = world.air_density;
    if (world.max_colliding != plain.max_colliding) json["max_colliding"] = world.max_colliding;
    if (world.piece_limit != plain.piece_limit) json["piece_limit"] = world.piece_limit;
    for (const Shot& shot : world.shots)
        json["shots"].push_back({{"time", shot.time},
                                 {"from", vector_json(shot.from)},
                                 {"velocity", vector_json(shot.velocity)},
                                 {"radius", shot.radius},
                                 {"density", shot.density}});
    for (const JointOptions& joint : world.joints) json["joints"].push_back(joint_json(joint));
}

// Returns the values that differ from the defaults.
Json picture_json(const PictureOptions& picture) {
    const PictureOptions plain;
    Json json = Json::object();
    if (picture.frames != plain.frames) json["frames"] = picture.frames;
    if (picture.every != plain.every) json["every"] = picture.every;
    if (picture.width > 0) json["size"] = {picture.width, picture.height};
    if (!picture.quality.empty()) json["quality"] = picture.quality;
    if (picture.whole) json["whole"] = true;
    if (picture.planes != plain.planes) json["planes"] = picture.planes;
    if (picture.explode != plain.explode) json["explode"] = picture.explode;
    if (picture.dust != plain.dust) json["dust"] = picture.dust;
    if (picture.sites) json["sites"] = true;
    if (picture.hulls) json["hulls"] = true;
    if (picture.cells) json["cells"] = true;
    if (picture.colours != plain.colours)
        json["colors"] = picture.colours == PieceColours::pieces ? "pieces" : "materials";
    if (!picture.interior_texture.empty()) json["interior_texture"] = picture.interior_texture;
    if (picture.smooth) json["smooth"] = true;
    if (picture.wireframe) json["wireframe"] = true;
    if (picture.azimuth != plain.azimuth) json["azimuth"] = picture.azimuth;
    if (picture.elevation != plain.elevation) json["elevation"] = picture.elevation;
    if (picture.distance != plain.distance) json["distance"] = picture.distance;
    return json;
}

// Returns the values that differ from the defaults.
Json export_json(const ExportSettings& settings) {
    const ExportSettings plain;
    Json json = Json::object();
    if (settings.name != plain.name) json["name"] = settings.name;
    if (settings.per_piece || settings.one_file) json["per_piece"] = settings.per_piece;
    if (settings.hulls != plain.hulls) json["hulls"] = settings.hulls;
    if (settings.rigid_bodies) json["rigid_bodies"] = true;
    if (settings.hull_parts != plain.hull_parts) json["hull_parts"] = settings.hull_parts;
    if (settings.density != plain.density) json["density"] = settings.density;
    if (settings.interior_texture != plain.interior_texture) json["interior_texture"] = settings.interior_texture;
    if (settings.as != plain.as) json["as"] = settings.as;
    return json;
}

namespace {

// Reads one of some words.
void read_word(JsonReader& reader, const char* key, std::string& target, std::initializer_list<const char*> words) {
    const Json* value = reader.find(key);
    if (!value) return;
    std::string list;
    for (const char* word : words) {
        if (*value == word) {
            target = word;
            return;
        }
        list += (list.empty() ? "\"" : ", \"") + std::string(word) + "\"";
    }
    reader.fail(key, "one of " + list, *value);
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
        inner.world_vector("at", anchor.at);
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
    for (const physics::JointKind kind : physics::joint_kinds)
        if (name == physics::to_string(kind)) return kind;
    throw reader.failure("kind", "expected \"ball\", \"hinge\", \"distance\" or \"fixed\", found " + shown(name));
}

void read_joint(JsonReader& reader, JointOptions& joint) {
    constexpr double longest = 1000.0; // m
    joint.kind = joint_kind(reader);
    if (reader.find("shot")) reader.whole("shot", joint.shot.emplace(), 0, 100'000);
    reader.world_vector("at", joint.at);
    reader.flag("to_piece", joint.to_piece);
    reader.world_vector("to", joint.to);
    reader.world_vector("axis", joint.axis);
    reader.number("min_length", joint.min_length, 0.0, longest);
    if (reader.find("max_length")) reader.number("max_length", joint.max_length.emplace(), 0.001, longest);
    reader.number("max_force", joint.max_force, 0.0, 1e12);
    reader.number("max_torque", joint.max_torque, 0.0, 1e12);
    reader.whole("links", joint.links, 0, max_links);
    reader.number("link_radius", joint.link_radius, 0.001, 1.0);
    const bool has_axis = joint.kind == physics::JointKind::hinge || joint.kind == physics::JointKind::fixed;
    if (has_axis && glm::length(joint.axis) < 1e-6)
        throw reader.failure("axis",
                             "expected a direction, such as [0, 1, 0], found " + shown(vector_json(joint.axis)));
    if (joint.max_length && *joint.max_length < joint.min_length)
        throw reader.failure("max_length", "is below min_length, " + std::to_string(joint.min_length) + " m");
    if (joint.max_torque > 0.0 && joint.kind != physics::JointKind::fixed)
        throw reader.failure("max_torque", "only a fixed joint breaks by torque; give \"kind\": \"fixed\"");
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

} // namespace

void read_body(const std::filesystem::path& file, const std::string& path, JsonReader& reader, WorldOptions& world) {
    reader.flag("bonded", world.bonded);
    reader.flag("anchored", world.anchored);
    reader.number("strength", world.strength, 1e-6, 1e6);
    reader.flag("breakable", world.breakable);
    reader.number("min_size", world.min_size, 1e-4, 10.0);
    reader.whole("blow_pieces", world.blow_pieces, 2, 1000);
    if (const Json* brick = reader.find("brick")) {
        JsonReader inner(file, *brick, path + "/brick");
        read_brick(inner, world.bond);
        inner.refuse_unknown_keys();
    }
    read_anchors(file, path, reader, world.anchors);
}

void read_world(const std::filesystem::path& file, const std::string& path, JsonReader& reader, WorldOptions& world) {
    read_engine(reader, world.engine);
    reader.number("air_density", world.air_density, 0.0, 1e4);
    reader.whole(reader.renamed("max_colliding", "most_colliding"), world.max_colliding, 0, 1'000'000);
    reader.whole("piece_limit", world.piece_limit, 1, 1'000'000);
    read_joints(file, path, reader, world.joints);
    const Json* shots = reader.find("shots");
    if (!shots) return;
    if (!shots->is_array()) reader.fail("shots", "a list [{ }, ...]", *shots);
    world.shots.clear();
    for (size_t k = 0; k < shots->size(); ++k) {
        JsonReader inner(file, (*shots)[k], path + "/shots/" + std::to_string(k));
        Shot shot;
        inner.number("time", shot.time, 0.0, 1e4);
        inner.world_vector("from", shot.from);
        inner.world_vector("velocity", shot.velocity);
        inner.number("radius", shot.radius, 0.001, 10.0);
        inner.number("density", shot.density, 1.0, 1e5);
        inner.refuse_unknown_keys();
        world.shots.push_back(shot);
    }
}

void read_export(JsonReader& reader, ExportSettings& settings) {
    reader.text("name", settings.name);
    if (const std::string refusal = refusal_of_name(settings.name); !refusal.empty())
        throw reader.failure("name", refusal);
    reader.flag("per_piece", settings.per_piece);
    if (reader.find("per_piece")) settings.one_file = !settings.per_piece;
    read_word(reader, "hulls", settings.hulls, {"godot", "unreal"});
    reader.flag("rigid_bodies", settings.rigid_bodies);
    reader.whole("hull_parts", settings.hull_parts, 1, max_hull_parts);
    if (reader.find("density")) {
        reader.number("density", settings.density, 0.0, max_density);
        if (settings.density == 0.0) throw reader.failure("density", "expected a number above 0, kg/m^3, found 0");
    }
    reader.text("interior_texture", settings.interior_texture);
    read_word(reader, "as", settings.as, {"lie", "made"});
}

void read_picture(JsonReader& reader, PictureOptions& picture) {
    const auto number = [&](const char* key, float& target, double low, double high) {
        double value = target;
        reader.number(key, value, low, high);
        target = static_cast<float>(value);
    };
    reader.whole("frames", picture.frames, 0, 100'000);
    reader.whole("every", picture.every, 1, 100'000);
    if (const Json* size = reader.find("size")) {
        if (!size->is_array() || size->size() != 2) reader.fail("size", "two numbers [width, height]", *size);
        picture.width = static_cast<uint32_t>(reader.whole_of("size/0", (*size)[0], min_picture, max_picture));
        picture.height = static_cast<uint32_t>(reader.whole_of("size/1", (*size)[1], min_picture, max_picture));
    }
    read_word(reader, "quality", picture.quality, {"auto", "fast", "best"});
    reader.flag("whole", picture.whole);
    reader.whole("planes", picture.planes, 0, 1'000'000);
    number("explode", picture.explode, 0.0, 10.0);
    number("dust", picture.dust, 0.0, 1.0);
    reader.flag("sites", picture.sites);
    reader.flag("hulls", picture.hulls);
    reader.flag("cells", picture.cells);
    if (const Json* colours = reader.find("colors")) {
        if (*colours == "pieces")
            picture.colours = PieceColours::pieces;
        else if (*colours == "materials")
            picture.colours = PieceColours::materials;
        else
            reader.fail("colors", "\"pieces\" or \"materials\"", *colours);
    }
    reader.text("interior_texture", picture.interior_texture);
    reader.flag("smooth", picture.smooth);
    reader.flag("wireframe", picture.wireframe);
    number("azimuth", picture.azimuth, -360.0, 360.0);
    number("elevation", picture.elevation, -89.0, 89.0);
    number("distance", picture.distance, 0.1, 10.0);
}

} // namespace brittle::tools
