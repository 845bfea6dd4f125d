#include "tools/brittle/commands/inspect_objects.h"
#include "tools/brittle/stage/loading.h"

#include <algorithm>
#include <cstdio>
#include <map>

#include <nlohmann/json.hpp>

#include "fracture/base/threads.h"
#include "fracture/doctor/inspect.h"
#include "fracture/io/text_cursor.h"

namespace brittle::tools {

namespace {

using Json = nlohmann::ordered_json;

// Why fracture() refuses a mesh; empty where it does not.
std::string refusal_of(const fracture::TriangleMesh& mesh) {
    const fracture::Inspection found = fracture::inspect(mesh, {.max_pairs = 0, .max_places = 0, .max_measured = 0});
    if (!found.refusal) return {};
    std::string text = fracture::to_string(*found.refusal);
    std::ranges::replace(text, '_', ' ');
    return found.topology.closed() ? text : text + ", " + fracture::describe(found.topology);
}

std::string kind_of(const SceneObject& object) {
    const WorldOptions& world = object.recipe.world;
    if (object.fixed) return "fixed";
    if (object.shattered) return "shattered";
    const std::string kind = world.bonded ? "bonded" : (world.breakable ? "breakable" : "rigid");
    return kind + (world.anchored || !world.anchors.empty() ? ", anchored" : "");
}

} // namespace

std::vector<InspectedObject> inspect_objects(const LoadedScene& scene, uint32_t threads) {
    struct Mesh {
        uint32_t copies = 0;
        std::string refusal{};
    };
    std::map<const Input*, uint32_t> numbers;
    std::vector<const Input*> inputs;
    std::vector<Mesh> meshes;
    for (const LoadedObject& object : scene.objects) {
        const auto [at, is_new] = numbers.try_emplace(object.input.get(), static_cast<uint32_t>(inputs.size()));
        if (is_new) inputs.push_back(object.input.get());
        meshes.resize(inputs.size());
        ++meshes[at->second].copies;
    }
    fracture::Threads(threads).for_each(static_cast<uint32_t>(inputs.size()),
                                        [&](uint32_t k) { meshes[k].refusal = refusal_of(inputs[k]->model.mesh); });
    std::vector<InspectedObject> inspected;
    for (const LoadedObject& object : scene.objects) {
        const Mesh& mesh = meshes[numbers[object.input.get()]];
        inspected.push_back({object.object.name, kind_of(object.object), object.input->model.mesh.triangles.size(),
                             mesh.copies, object.box.size(), mesh.refusal});
    }
    return inspected;
}

std::string describe(const std::vector<InspectedObject>& objects, bool with_kinds) {
    size_t width = 4;
    for (const InspectedObject& object : objects)
        width = std::max(width, std::min<size_t>(fracture::printable(object.name).size(), 40));
    char line[512];
    std::snprintf(line, sizeof line, "  %-*s  triangles  copies  size, m\n", static_cast<int>(width), "name");
    std::string text = line;
    for (const InspectedObject& object : objects) {
        char size[64];
        std::snprintf(size, sizeof size, "%.4g x %.4g x %.4g", object.size.x, object.size.y, object.size.z);
        std::snprintf(line, sizeof line, "  %-*s %10llu %7u  %-26s  ", static_cast<int>(width),
                      fracture::printable(object.name).c_str(), static_cast<unsigned long long>(object.triangles),
                      object.copies, size);
        text += line;
        if (with_kinds) text += object.kind + (object.refusal.empty() ? "" : "; ");
        if (!object.refusal.empty()) text += "cannot be broken: " + object.refusal;
        if (!with_kinds && object.refusal.empty()) text += "can be broken";
        text += "\n";
    }
    return text;
}

Json to_json(const std::vector<InspectedObject>& objects, bool with_kinds) {
    Json list = Json::array();
    for (const InspectedObject& object : objects) {
        Json& json = list.emplace_back(Json{{"name", object.name}});
        if (with_kinds) json["kind"] = object.kind;
        json["triangles"] = object.triangles;
        json["copies"] = object.copies;
        json["size"] = {object.size.x, object.size.y, object.size.z};
        json["breakable"] = object.refusal.empty();
        json["refusal"] = object.refusal.empty() ? Json() : Json(object.refusal);
    }
    return list;
}

std::optional<LoadedScene> nodes_of(const std::string& mesh) {
    if (!mesh.ends_with(".glb") && !mesh.ends_with(".gltf")) return std::nullopt;
    FractureOptions scene;
    scene.units = LengthUnit::metre;
    scene.level.mesh = mesh;
    LoadedScene loaded = open_scene(scene, program_host());
    if (loaded.objects.size() < 2) return std::nullopt;
    return loaded;
}

} // namespace brittle::tools
