#include <cstdio>

#include <nlohmann/json.hpp>

#include "fracture/inspect.h"
#include "tools/brittle/commands.h"
#include "tools/brittle/failure.h"

namespace brittle::tools {

namespace {

using Json = nlohmann::ordered_json;

Json pair_json(const std::optional<glm::uvec2>& pair) {
    return pair ? Json{pair->x, pair->y} : Json();
}

Json to_json(const std::string& name, const fracture::Inspection& i) {
    const auto& t = i.topology;
    Json json{{"mesh", name},
              {"breakable", !i.refusal},
              {"refusal", i.refusal ? Json(fracture::to_string(*i.refusal)) : Json()},
              {"triangles", t.triangles},
              {"vertices", t.vertices},
              {"unused_vertices", i.unused_vertices},
              {"box", {{"min", {i.box.min.x, i.box.min.y, i.box.min.z}}, {"max", {i.box.max.x, i.box.max.y, i.box.max.z}}}},
              {"area", i.area},
              {"volume", i.volume},
              {"closed", t.closed()},
              {"manifold", t.manifold()},
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

} // namespace

int run_inspect(const InspectCommand& command) {
    const Input input = load_mesh_only(command.mesh);
    const fracture::Inspection inspection = fracture::inspect(input.model.mesh);
    if (command.json)
        std::printf("%s\n", to_json(input.name, inspection).dump(2).c_str());
    else
        std::printf("%s\n%s", input.name.c_str(), describe(inspection).c_str());
    return inspection.refusal ? exit_mesh : exit_success;
}

} // namespace brittle::tools
