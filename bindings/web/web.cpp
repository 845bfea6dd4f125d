// The C interface for JavaScript: settings come as JSON, and what several values would be goes out as JSON. Each
// function returns 0 or null after a failure, which web_status() and web_message() then explain.
#include <cstdio>
#include <cstring>
#include <string>

#include <emscripten.h>
#include <emscripten/threading.h>
#include <nlohmann/json.hpp>

#include "bindings/c/brittle.h"

// Tells JavaScript the completed share of the work, or -1, and asks it whether to stop.
EM_JS(int, web_tell, (double share), { return Module["tell"] ? Module["tell"](share) : 0; });

namespace {

using Json = nlohmann::json;

brittle_error last{sizeof(brittle_error), BRITTLE_OK, ""};
std::string text;

// The handle that a call gives out, or null.
template<class T, class Call>
T* made(const Call& call) {
    T* out = nullptr;
    last.status = BRITTLE_OK;
    call(&out);
    return out;
}

const char* returned(const Json& json) {
    text = json.dump(-1, ' ', false, Json::error_handler_t::replace);
    return text.c_str();
}

// Writes address, rows, columns, bytes between rows, and type.
int describe(const brittle_array& array, uint32_t* out) {
    const uint32_t values[] = {reinterpret_cast<uint32_t>(array.data), static_cast<uint32_t>(array.rows), array.columns,
                               static_cast<uint32_t>(array.stride), array.type};
    std::memcpy(out, values, sizeof values);
    return 1;
}

void read(const Json& json, const char* key, double* numbers, size_t count) {
    const auto at = json.find(key);
    if (at == json.end()) return;
    for (size_t k = 0; k < count && k < at->size(); ++k) numbers[k] = (*at)[k].get<double>();
}

template<class T>
void read(const Json& json, const char* key, T& value) {
    if (const auto at = json.find(key); at != json.end()) value = at->get<T>();
}

} // namespace

#define WEB_API extern "C" __attribute__((used, visibility("default")))

WEB_API const char* web_status() {
    return brittle_status_name(last.status);
}
WEB_API const char* web_message() {
    return last.message;
}
WEB_API const char* web_version() {
    return brittle_version();
}

WEB_API brittle_mesh* web_mesh(const double* positions, uint32_t vertices, const uint32_t* triangles, uint32_t count,
                               const float* uv, const uint32_t* materials, int weld) {
    brittle_mesh_arrays arrays{};
    arrays.struct_size = sizeof arrays;
    arrays.weld = weld;
    arrays.positions = {BRITTLE_FLOAT64, 3, vertices, 0, positions};
    arrays.triangles = {BRITTLE_UINT32, 3, count, 0, triangles};
    if (uv) arrays.uv = {BRITTLE_FLOAT32, 2, vertices, 0, uv};
    if (materials) arrays.materials = {BRITTLE_UINT32, 1, count, 0, materials};
    return made<brittle_mesh>([&](brittle_mesh** out) { return brittle_mesh_from_arrays(&arrays, out, &last); });
}
WEB_API brittle_mesh* web_mesh_load(const void* bytes, uint32_t size, const char* extension) {
    return made<brittle_mesh>(
        [&](brittle_mesh** out) { return brittle_mesh_load_memory(bytes, size, extension, out, &last); });
}
WEB_API brittle_mesh* web_mesh_shape(const char* name) {
    return made<brittle_mesh>([&](brittle_mesh** out) { return brittle_mesh_shape(name, out, &last); });
}
WEB_API brittle_mesh* web_mesh_repair(const brittle_mesh* mesh) {
    return made<brittle_mesh>(
        [&](brittle_mesh** out) { return brittle_mesh_repair(mesh, nullptr, out, nullptr, &last); });
}
WEB_API brittle_mesh* web_mesh_unite(const brittle_mesh* mesh) {
    return made<brittle_mesh>([&](brittle_mesh** out) { return brittle_mesh_unite(mesh, 0, out, nullptr, &last); });
}
WEB_API const char* web_mesh_inspect(const brittle_mesh* mesh) {
    brittle_inspection found{};
    found.struct_size = sizeof found;
    brittle_text* report = nullptr;
    if (brittle_mesh_inspect(mesh, &found, &report, &last) != BRITTLE_OK) return nullptr;
    const Json json{{"refusal", found.refusal == BRITTLE_OK ? Json() : Json(brittle_status_name(found.refusal))},
                    {"report", brittle_text_get(report)},
                    {"min", found.box_min},
                    {"max", found.box_max},
                    {"area", found.area},
                    {"volume", found.volume},
                    {"vertices", found.vertices},
                    {"triangles", found.triangles},
                    {"components", found.components},
                    {"openEdges", found.open_edges},
                    {"nonManifoldEdges", found.non_manifold_edges},
                    {"misorientedEdges", found.misoriented_edges},
                    {"intersections", found.intersections},
                    {"holes", found.holes}};
    brittle_text_free(report);
    return returned(json);
}
WEB_API void web_mesh_free(brittle_mesh* mesh) {
    brittle_mesh_free(mesh);
}

WEB_API const char* web_materials() {
    Json all = Json::object();
    for (uint32_t k = 0; const char* name = brittle_material_name(k); ++k) {
        brittle_material stuff{};
        stuff.struct_size = sizeof stuff;
        if (brittle_material_get(name, &stuff, &last) != BRITTLE_OK) return nullptr;
        all[name] = {{"density", stuff.density},     {"friction", stuff.friction}, {"restitution", stuff.restitution},
                     {"roughness", stuff.roughness}, {"pattern", stuff.pattern},   {"tensile", stuff.tensile},
                     {"exterior", stuff.exterior},   {"interior", stuff.interior}};
    }
    return returned(all);
}

WEB_API brittle_pieces* web_fracture(const brittle_mesh* mesh, const char* settings, const double* sites,
                                     const double* weights, uint32_t count) {
    const Json json = Json::parse(settings);
    brittle_pattern pattern;
    brittle_pattern_init(&pattern, sizeof pattern);
    brittle_fracture_settings cut;
    brittle_fracture_settings_init(&cut, sizeof cut);
    cut.threads = 0; // as many as init() was given, see threads_library.js
    cut.progress = [](void*, double share) { web_tell(share); };
    // Only the thread of the caller has its functions.
    cut.cancelled = [](void*) -> int32_t { return emscripten_is_main_runtime_thread() ? web_tell(-1.0) : 0; };
    std::string kind = "uniform";
    if (const auto material = json.find("material"); material != json.end() && material->is_string()) {
        brittle_material stuff{};
        stuff.struct_size = sizeof stuff;
        if (brittle_material_get(material->get<std::string>().c_str(), &stuff, &last) != BRITTLE_OK) return nullptr;
        kind = stuff.pattern;
        pattern.jitter = stuff.pattern_jitter;
        pattern.spread = stuff.pattern_spread;
        pattern.slenderness = stuff.pattern_slenderness;
        std::memcpy(pattern.axis, stuff.pattern_axis, sizeof pattern.axis);
        cut.roughness = stuff.roughness;
        cut.rough_detail = stuff.rough_detail;
        std::memcpy(cut.rough_grain, stuff.rough_grain, sizeof cut.rough_grain);
    }
    read(json, "pattern", kind);
    pattern.kind = kind.c_str();
    read(json, "sites", pattern.count);
    read(json, "seed", pattern.seed);
    read(json, "pieceSize", pattern.piece_size);
    read(json, "jitter", pattern.jitter);
    read(json, "spread", pattern.spread);
    read(json, "slenderness", pattern.slenderness);
    read(json, "grading", pattern.grading);
    read(json, "cellsPerPiece", pattern.cells_per_piece);
    read(json, "focus", pattern.focus, 3);
    read(json, "axis", pattern.axis, 3);
    bool inside = kind == "uniform" || kind == "clustered"; // as the command line
    read(json, "inside", inside);
    pattern.inside = inside;
    cut.rough_seed = pattern.seed;
    read(json, "roughness", cut.roughness);
    read(json, "wavelength", cut.rough_wavelength);
    read(json, "detail", cut.rough_detail);
    read(json, "minVolume", cut.min_volume);
    read(json, "grain", cut.rough_grain, 3);

    brittle_sites* placed = nullptr;
    if (sites) {
        const brittle_array positions{BRITTLE_FLOAT64, 3, count, 0, sites};
        const brittle_array heavier{BRITTLE_FLOAT64, 1, count, 0, weights};
        if (brittle_sites_from_arrays(&positions, weights ? &heavier : nullptr, nullptr, &placed, &last) != BRITTLE_OK)
            return nullptr;
    } else if (brittle_sites_pattern(&pattern, mesh, &placed, &last) != BRITTLE_OK) {
        return nullptr;
    }
    brittle_pieces* pieces =
        made<brittle_pieces>([&](brittle_pieces** out) { return brittle_fracture(mesh, placed, &cut, out, &last); });
    brittle_sites_free(placed);
    return pieces;
}
WEB_API void web_pieces_free(brittle_pieces* pieces) {
    brittle_pieces_free(pieces);
}

WEB_API int web_mesh_array(const brittle_mesh* mesh, uint32_t which, uint32_t* out) {
    brittle_array array{};
    if (brittle_mesh_array(mesh, which, &array, &last) != BRITTLE_OK) return 0;
    return describe(array, out);
}
WEB_API int web_pieces_array(const brittle_pieces* pieces, uint32_t which, uint32_t* out) {
    brittle_array array{};
    if (brittle_pieces_array(pieces, which, &array, &last) != BRITTLE_OK) return 0;
    return describe(array, out);
}
WEB_API const char* web_certificate(const brittle_pieces* pieces) {
    brittle_certificate found{};
    found.struct_size = sizeof found;
    if (brittle_pieces_certificate(pieces, &found, &last) != BRITTLE_OK) return nullptr;
    char hash[17];
    std::snprintf(hash, sizeof hash, "%016llx", static_cast<unsigned long long>(found.hash));
    return returned({{"pieces", found.pieces},
                     {"closed", found.closed == 1},
                     {"openPieces", found.open_pieces},
                     {"cells", found.cells},
                     {"volumeInput", found.volume_input},
                     {"volumeSum", found.volume_sum},
                     {"volumeError", found.volume_error},
                     {"smallestPiece", found.smallest_piece},
                     {"trianglesIn", found.triangles_in},
                     {"trianglesOut", found.triangles_out},
                     {"hash", hash}});
}

WEB_API brittle_surface* web_surface(const brittle_pieces* pieces, uint32_t piece) {
    return made<brittle_surface>(
        [&](brittle_surface** out) { return brittle_pieces_surface(pieces, piece, out, &last); });
}
WEB_API uint32_t web_surface_parts(const brittle_surface* surface) {
    return static_cast<uint32_t>(brittle_surface_parts(surface));
}
// Material (0xffffffff for none) and whether the part is a cut.
WEB_API int web_surface_part(const brittle_surface* surface, uint32_t part, uint32_t* out) {
    return brittle_surface_part(surface, part, out, out + 1, &last) == BRITTLE_OK;
}
WEB_API int web_surface_array(const brittle_surface* surface, uint32_t part, uint32_t which, uint32_t* out) {
    brittle_array array{};
    if (brittle_surface_array(surface, part, which, &array, &last) != BRITTLE_OK) return 0;
    return describe(array, out);
}
WEB_API void web_surface_free(brittle_surface* surface) {
    brittle_surface_free(surface);
}

WEB_API brittle_hulls* web_hulls(const brittle_pieces* pieces, uint32_t parts, uint32_t vertices) {
    return made<brittle_hulls>(
        [&](brittle_hulls** out) { return brittle_pieces_hulls(pieces, parts, vertices, out, &last); });
}
WEB_API int web_hulls_array(const brittle_hulls* hulls, uint32_t which, uint32_t* out) {
    brittle_array array{};
    if (brittle_hulls_array(hulls, which, &array, &last) != BRITTLE_OK) return 0;
    return describe(array, out);
}
WEB_API void web_hulls_free(brittle_hulls* hulls) {
    brittle_hulls_free(hulls);
}

WEB_API brittle_files* web_save(const brittle_pieces* pieces, const char* name) {
    return made<brittle_files>(
        [&](brittle_files** out) { return brittle_pieces_save_memory(pieces, name, nullptr, out, &last); });
}
// Address and size of the first file.
WEB_API int web_file(const brittle_files* files, uint32_t* out) {
    const void* bytes = nullptr;
    size_t size = 0;
    if (brittle_files_get(files, 0, nullptr, &bytes, &size, &last) != BRITTLE_OK) return 0;
    out[0] = reinterpret_cast<uint32_t>(bytes);
    out[1] = static_cast<uint32_t>(size);
    return 1;
}
WEB_API void web_files_free(brittle_files* files) {
    brittle_files_free(files);
}
