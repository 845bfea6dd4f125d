#include <algorithm>
#include <cstdio>
#include <optional>

#include <nlohmann/json.hpp>

#include "engine/core/bitmap.h"
#include "fracture/doctor/inspect.h"
#include "fracture/io/export.h"
#include "tools/brittle/base/console.h"
#include "tools/brittle/base/device_failure.h"
#include "tools/brittle/commands/commands.h"
#include "tools/brittle/commands/inspect_objects.h"
#include "tools/brittle/pictures/marks.h"
#include "tools/brittle/pictures/view.h"
#include "tools/brittle/stage/loading.h"
#include "tools/brittle/stage/stage.h"
#include "tools/scenario/base/failure.h"
#include "tools/scenario/recipe/json_reader.h"
#include "tools/scenario/recipe/recipe.h"
#include "tools/scenario/run/scene.h"

namespace brittle::tools {

namespace {

using Json = nlohmann::ordered_json;

constexpr float azimuth = 0.55f;  // rad
constexpr float elevation = 0.3f; // rad

Json pair_json(const std::optional<glm::uvec2>& pair) {
    return pair ? Json{pair->x, pair->y} : Json();
}

// What a union would change, for meshes that are closed.
using Union = std::optional<fracture::UniteReport>;

Union union_of(const fracture::TriangleMesh& mesh, const fracture::Inspection& inspection) {
    if (!inspection.topology.closed() || mesh.triangles.empty()) return std::nullopt;
    return fracture::measure_union(mesh);
}

// Null where the pairs of triangles that were tested do not tell.
Json crosses_itself(const fracture::Inspection& i) {
    return i.intersections > 0 ? Json(true) : (i.all_pairs_seen ? Json(false) : Json());
}

// Every property stands for itself: `closed` says nothing of orientation.
Json to_json(const std::string& name, const fracture::Inspection& i, const Union& united) {
    const auto& t = i.topology;
    Json json{
        {"mesh", name},
        {"breakable", !i.refusal},
        {"refusal", i.refusal ? Json(fracture::to_string(*i.refusal)) : Json()},
        {"triangles", t.triangles},
        {"vertices", t.vertices},
        {"unused_vertices", i.unused_vertices},
        {"box", {{"min", {i.box.min.x, i.box.min.y, i.box.min.z}}, {"max", {i.box.max.x, i.box.max.y, i.box.max.z}}}},
        {"area", i.area},
        {"volume", i.volume},
        {"closed", t.open_edges == 0},
        {"manifold", t.non_manifold_edges == 0 && t.non_manifold_vertices == 0},
        {"oriented", t.misoriented_edges == 0},
        {"self_intersecting", crosses_itself(i)},
        {"open_edges", t.open_edges},
        {"misoriented_edges", t.misoriented_edges},
        {"non_manifold_edges", t.non_manifold_edges},
        {"non_manifold_vertices", t.non_manifold_vertices},
        {"degenerate_triangles", t.degenerate_triangles},
        {"flat_triangles", i.flat_triangles},
        {"duplicate_triangles", i.duplicate_triangles},
        {"first_duplicate", pair_json(i.first_duplicate)},
        {"intersections", i.intersections},
        {"first_intersection", pair_json(i.first_intersection)},
        {"all_pairs_seen", i.all_pairs_seen}};
    if (i.min_thickness)
        json["thickness"] = {
            {"least", *i.min_thickness}, {"triangle", i.thinnest_triangle}, {"thin_share", i.thin_share}};
    if (united)
        json["union"] = {{"changes", united->changed()},
                         {"volume", united->volume_after},
                         {"inside_out", united->inside_out},
                         {"cut_triangles", united->cut_triangles},
                         {"dropped_triangles", united->dropped_triangles}};
    const auto edges = [](const std::vector<glm::uvec2>& list) {
        Json array = Json::array();
        for (const glm::uvec2& edge : list) array.push_back({edge.x, edge.y});
        return array;
    };
    json["places"] = {{"open_edges", edges(i.places.open_edges)},
                      {"misoriented_edges", edges(i.places.misoriented_edges)},
                      {"non_manifold_edges", edges(i.places.non_manifold_edges)},
                      {"non_manifold_vertices", i.places.non_manifold_vertices},
                      {"flat_triangles", i.places.flat_triangles},
                      {"duplicate_triangles", i.places.duplicate_triangles},
                      {"crossings", edges(i.places.crossings)},
                      {"thin_triangles", i.places.thin_triangles}};
    for (const auto& rim : i.rims)
        json["rims"].push_back({{"edges", rim.edges}, {"length", rim.length}, {"vertex", rim.vertex}});
    for (const auto& c : i.components)
        json["components"].push_back({{"first_triangle", c.first_triangle},
                                      {"triangles", c.triangles},
                                      {"volume", c.volume},
                                      {"closed", c.closed},
                                      {"cavity", c.is_cavity},
                                      {"inside_out", c.is_inside_out}});
    return json;
}

// Draws the faults that are visible from above and the left, the view of `brittle render`.
void draw(const InspectCommand& command, Input input, const std::vector<Marks>& marks) {
    const fracture::Box before = fracture::bounds(input.model.mesh);
    input = placed_on_stage(std::move(input));
    const fracture::Box after = fracture::bounds(input.model.mesh);
    const glm::dvec3 size = before.size();
    const int longest = size.x >= size.y && size.x >= size.z ? 0 : (size.y >= size.z ? 1 : 2);
    const double scale = size[longest] > 0.0 ? after.size()[longest] / size[longest] : 1.0;
    std::vector<engine::LineVertex> lines;
    for (const Marks& one : marks)
        for (const auto& segment : one.segments)
            for (const glm::dvec3& end : segment)
                lines.push_back({glm::vec3((end - before.min) * scale + after.min),
                                 engine::srgb8(one.colour.x, one.colour.y, one.colour.z)});
    const auto device = open_device(command.view);
    const auto renderer = must(engine::Renderer::create(*device, film_settings(command.view)));
    Stage stage(*renderer, input.model.mesh);
    stage.show_lines(std::move(lines));
    engine::Scene scene = stage.scene();
    const float aspect = static_cast<float>(command.view.width) / static_cast<float>(command.view.height);
    scene.camera = engine::look_at_bounds(stage.home_bounds(), azimuth, elevation, aspect);
    must(engine::write_png(must(renderer->render(scene, {command.view.width, command.view.height})), command.picture));
    check_validation(*device);
}

// Lists the objects of a scene. Returns exit_mesh where one that should break cannot.
int inspect_scene(const InspectCommand& command) {
    if (!command.marks.empty() || !command.picture.empty())
        throw Failure(exit_usage, "--marks and --picture show one mesh, and " + command.mesh + " is a recipe");
    FractureOptions options;
    read_recipe(command.mesh, options);
    if (!is_scene(options))
        throw Failure(exit_usage, command.mesh + " is a recipe of one mesh; inspect " + options.mesh + " instead");
    const LoadedScene scene = open_scene(options, program_host());
    const std::vector<InspectedObject> objects = inspect_objects(scene);
    if (command.json)
        std::printf("%s\n", text_of({{"scene", command.mesh}, {"objects", to_json(objects, true)}}, 2).c_str());
    else
        print_report("%s: %zu objects\n%s", command.mesh.c_str(), objects.size(), describe(objects, true).c_str());
    for (const std::string& note : scene.notes) tell("%s", note.c_str());
    const bool breaks_as_told = std::ranges::none_of(scene.objects, &LoadedObject::refused)
                                && std::ranges::all_of(objects, [](const InspectedObject& object) {
                                       return object.kind == "fixed" || object.refusal.empty();
                                   });
    return breaks_as_told ? exit_success : exit_mesh;
}

} // namespace

int run_inspect(const InspectCommand& command) {
    if (command.mesh.ends_with(".json")) return inspect_scene(command);
    const Input input = load_mesh_only(command.mesh, false, program_host(), command.format);
    const fracture::Inspection inspection = fracture::inspect(input.model.mesh);
    const bool is_readable = inspection.topology.vertices > 0;
    std::string seen;
    if (is_readable && !(command.marks.empty() && command.picture.empty())) {
        const std::vector<Marks> marks = marks_of(input.model.mesh, inspection);
        if (!command.marks.empty())
            must(fracture::export_model(command.marks, marked_model(input.model.mesh, marks), input.name));
        if (!command.picture.empty()) draw(command, input, marks);
        for (const Marks& one : marks) seen += (seen.empty() ? "" : ", ") + one.kind + " " + one.colour_name;
        seen = "  marked     " + (seen.empty() ? "nothing" : seen) + "\n";
    }
    const Union united = union_of(input.model.mesh, inspection);
    if (united)
        if (const std::string overlap = overlap_text(*united); !overlap.empty())
            seen += "  union      " + overlap + "; --unite makes one solid of it\n";
    Json json = to_json(input.name, inspection, united);
    if (const std::optional<LoadedScene> nodes = nodes_of(command.mesh)) {
        const std::vector<InspectedObject> objects = inspect_objects(*nodes);
        json["objects"] = to_json(objects, false);
        seen += "  nodes      " + std::to_string(objects.size()) + "; a level makes an object of each\n";
        seen += describe(objects, false);
        for (const std::string& note : nodes->notes) tell("%s", note.c_str());
    }
    if (command.json)
        std::printf("%s\n", text_of(json, 2).c_str());
    else
        print_report("%s\n%s%s", input.name.c_str(), describe(inspection).c_str(), seen.c_str());
    return inspection.refusal ? exit_mesh : exit_success;
}

} // namespace brittle::tools
