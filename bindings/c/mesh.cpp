// Meshes of the C interface: from arrays, files, memory and shapes; inspection, repair and union.
#include <cmath>

#include "bindings/c/handles.h"
#include "fracture/doctor/inspect.h"
#include "fracture/doctor/repair.h"
#include "fracture/io/import.h"
#include "fracture/io/weld.h"
#include "fracture/mesh/topology.h"
#include "fracture/shapes/shapes.h"
#include "fracture/unite/unite.h"

using namespace brittle;

namespace brittle::c {

namespace {

constexpr uint32_t max_materials = 65536;
constexpr double max_coordinate = 1e50; // as fracture()

std::unique_ptr<brittle_mesh> mesh_of(fracture::Model model) {
    auto mesh = std::make_unique<brittle_mesh>();
    mesh->model = std::make_shared<const fracture::Model>(std::move(model));
    return mesh;
}

std::unique_ptr<brittle_mesh> mesh_of(fracture::TriangleMesh triangles) {
    fracture::Model model;
    model.mesh = std::move(triangles);
    return mesh_of(std::move(model));
}

std::vector<fracture::Triangle> read_triangles(const brittle_array& array, size_t vertices) {
    std::vector<uint32_t> indices;
    if (array.rows == 0) {
        indices.resize(vertices);
        for (uint32_t v = 0; v < vertices; ++v) indices[v] = v;
    } else {
        indices = read_integers(array, array.columns == 1 ? 1 : 3, "triangles");
    }
    if (indices.size() % 3 != 0)
        refuse("there are " + std::to_string(indices.size()) + (array.rows == 0 ? " positions" : " indices")
               + " for triangles; their number must be a multiple of 3");
    std::vector<fracture::Triangle> triangles(indices.size() / 3);
    for (size_t k = 0; k < indices.size(); ++k) {
        if (indices[k] >= vertices)
            refuse("triangle " + std::to_string(k / 3) + " names vertex " + std::to_string(indices[k])
                       + ", and there are " + std::to_string(vertices) + " vertices",
                   BRITTLE_INVALID_MESH);
        triangles[k / 3][static_cast<int>(k % 3)] = indices[k];
    }
    return triangles;
}

void check_rows(const brittle_array& array, size_t rows, const char* name, const char* each) {
    if (array.rows != rows)
        refuse(std::string(name) + " has " + std::to_string(array.rows) + " rows; it must have one for each " + each
               + ", " + std::to_string(rows));
}

// Attributes of vertices become attributes of corners.
void read_attributes(const brittle_mesh_arrays& arrays, fracture::Model& model) {
    const fracture::TriangleMesh& mesh = model.mesh;
    const auto corners = [&](auto&& put) {
        for (const fracture::Triangle& triangle : mesh.triangles)
            for (int k = 0; k < 3; ++k) put(size_t{triangle[k]});
    };
    const auto finite = [](const std::vector<double>& numbers, uint32_t columns, const char* name) {
        for (size_t k = 0; k < numbers.size(); ++k)
            if (!(std::abs(numbers[k]) <= 1e30))
                refuse(std::string(name) + " has " + std::to_string(numbers[k]) + " in row "
                       + std::to_string(k / columns) + "; numbers must be finite and at most 1e30");
    };
    if (arrays.normals.rows > 0) {
        check_rows(arrays.normals, mesh.positions.size(), "normals", "vertex");
        const std::vector<double> n = read_floats(arrays.normals, 3, "normals");
        finite(n, 3, "normals");
        corners([&](size_t v) {
            const glm::dvec3 normal(n[3 * v], n[3 * v + 1], n[3 * v + 2]);
            const double length = std::sqrt(normal.x * normal.x + normal.y * normal.y + normal.z * normal.z);
            model.normals.push_back(length > 0.0 ? glm::vec3(normal / length) : glm::vec3(0.0f));
        });
    }
    if (arrays.uv.rows > 0) {
        check_rows(arrays.uv, mesh.positions.size(), "uv", "vertex");
        const std::vector<double> uv = read_floats(arrays.uv, 2, "uv");
        finite(uv, 2, "uv");
        corners([&](size_t v) { model.uv[0].emplace_back(uv[2 * v], uv[2 * v + 1]); });
    }
    if (arrays.materials.rows > 0) {
        check_rows(arrays.materials, mesh.triangles.size(), "materials", "triangle");
        model.material_of = read_integers(arrays.materials, 1, "materials");
        const uint32_t last = *std::max_element(model.material_of.begin(), model.material_of.end());
        if (last >= max_materials)
            refuse("materials has the number " + std::to_string(last) + "; numbers must be below 65536");
        for (uint32_t m = 0; m <= last; ++m) model.materials.push_back({.name = "material_" + std::to_string(m)});
    }
}

std::unique_ptr<brittle_mesh> mesh_of_arrays(const brittle_mesh_arrays& given) {
    const brittle_mesh_arrays arrays = read_settings(&given, brittle_mesh_arrays{}, "arrays");
    fracture::Model model;
    model.mesh.positions = read_points(arrays.positions, "positions", BRITTLE_INVALID_MESH);
    model.mesh.triangles = read_triangles(arrays.triangles, model.mesh.positions.size());
    if (model.mesh.triangles.empty()) refuse("there are no triangles", BRITTLE_EMPTY_MESH);
    read_attributes(arrays, model);
    if (arrays.weld != 0) {
        std::vector<uint32_t> kept;
        fracture::TriangleMesh welded = fracture::weld_surface(model.mesh, {}, kept);
        if (welded.triangles.empty()) refuse("every triangle has two corners at the same place", BRITTLE_EMPTY_MESH);
        fracture::keep_triangles(model, std::move(welded), kept);
    }
    return mesh_of(std::move(model));
}

brittle_repair_settings repair_defaults() {
    const fracture::RepairSettings d;
    return {sizeof(brittle_repair_settings),
            static_cast<uint32_t>(d.remesh_holes),
            d.weld_distance,
            d.close_holes,
            d.cavities,
            d.covered_parts};
}

fracture::RepairSettings settings_of(const brittle_repair_settings& given) {
    if (given.remesh_holes > 2)
        refuse("settings.remesh_holes is " + std::to_string(given.remesh_holes) + "; it must be 0, 1 or 2",
               BRITTLE_INVALID_SETTING);
    if (!(given.weld_distance <= max_coordinate))
        refuse("settings.weld_distance must be a number of at most 1e50", BRITTLE_INVALID_SETTING);
    if (!(given.close_holes >= 0.0))
        refuse("settings.close_holes must be a number of at least 0", BRITTLE_INVALID_SETTING);
    fracture::RepairSettings settings;
    settings.remesh_holes = static_cast<fracture::RepairSettings::Remesh>(given.remesh_holes);
    settings.weld_distance = given.weld_distance;
    settings.close_holes = given.close_holes;
    settings.cavities = given.cavities != 0;
    settings.covered_parts = given.covered_parts != 0;
    return settings;
}

std::unique_ptr<brittle_text> text_of(std::string text) {
    return std::unique_ptr<brittle_text>(new brittle_text{std::move(text)});
}

} // namespace

} // namespace brittle::c

using c::guarded;
using c::guarded_json;
using c::must;
using c::need;
using c::refuse;

extern "C" {

brittle_status brittle_mesh_from_arrays(const brittle_mesh_arrays* arrays, brittle_mesh** out, brittle_error* error) {
    return guarded(error, [&] {
        need(out, "out");
        *out = c::mesh_of_arrays(need(arrays, "arrays")).release();
    });
}

brittle_status brittle_mesh_load(const char* path, brittle_mesh** out, brittle_error* error) {
    return guarded_json(error, [&] {
        need(out, "out");
        *out = c::mesh_of(must(fracture::import_model(c::read_text(path, "path")))).release();
    });
}

brittle_status brittle_mesh_load_memory(const void* bytes, size_t size, const char* extension, brittle_mesh** out,
                                        brittle_error* error) {
    return guarded_json(error, [&] {
        need(out, "out");
        if (!bytes) refuse("bytes is NULL");
        const std::span all(static_cast<const std::byte*>(bytes), size);
        *out = c::mesh_of(must(fracture::import_model(all, c::read_text(extension, "extension")))).release();
    });
}

brittle_status brittle_mesh_shape(const char* name, brittle_mesh** out, brittle_error* error) {
    return guarded(error, [&] {
        need(out, "out");
        const std::string text = c::read_text(name, "name");
        std::optional<fracture::TriangleMesh> shape = fracture::shape(text);
        if (!shape) {
            std::string known;
            for (const std::string_view one : fracture::shape_names())
                known.append(known.empty() ? "" : ", ").append(one);
            refuse("there is no shape named '" + text + "'; the shapes are: " + known);
        }
        *out = c::mesh_of(std::move(*shape)).release();
    });
}

brittle_status brittle_mesh_box(const double* size, brittle_mesh** out, brittle_error* error) {
    return guarded(error, [&] {
        need(out, "out");
        const glm::dvec3 edges = c::read_vector(size, "size");
        for (int k = 0; k < 3; ++k) c::in_range(edges[k], 1e-100, 1e50, "an edge of the box");
        *out = c::mesh_of(fracture::cuboid(edges)).release();
    });
}

void brittle_mesh_free(brittle_mesh* mesh) {
    delete mesh;
}

brittle_status brittle_mesh_save(const brittle_mesh* mesh, const char* path, brittle_error* error) {
    return guarded_json(
        error, [&] { (void)must(fracture::export_model(c::read_text(path, "path"), *need(mesh, "mesh").model)); });
}

brittle_status brittle_mesh_save_memory(const brittle_mesh* mesh, const char* name, brittle_files** out,
                                        brittle_error* error) {
    return guarded_json(error, [&] {
        need(out, "out");
        auto files = std::make_unique<brittle_files>();
        files->files = must(fracture::export_model_to_memory(c::read_text(name, "name"), *need(mesh, "mesh").model));
        *out = files.release();
    });
}

brittle_status brittle_mesh_array(const brittle_mesh* mesh, uint32_t which, brittle_array* out, brittle_error* error) {
    return guarded(error, [&] {
        need(out, "out");
        const fracture::Model& model = *need(mesh, "mesh").model;
        switch (which) {
        case BRITTLE_MESH_POSITIONS:
            *out = c::view<double>(model.mesh.positions);
            return;
        case BRITTLE_MESH_TRIANGLES:
            *out = c::view<uint32_t>(model.mesh.triangles);
            return;
        case BRITTLE_MESH_NORMALS:
            *out = c::view<float>(model.normals);
            return;
        case BRITTLE_MESH_UV:
        case BRITTLE_MESH_UV2:
            *out = c::view<float>(model.uv[which - BRITTLE_MESH_UV]);
            return;
        case BRITTLE_MESH_COLOURS:
            *out = c::view<float>(model.colours);
            return;
        case BRITTLE_MESH_MATERIALS:
            *out = c::view<uint32_t>(model.material_of);
            return;
        default:
            c::refuse_which(which, BRITTLE_MESH_MATERIALS);
        }
    });
}

brittle_status brittle_mesh_inspect(const brittle_mesh* mesh, brittle_inspection* out, brittle_text** report,
                                    brittle_error* error) {
    return guarded(error, [&] {
        const fracture::Inspection found = fracture::inspect(need(mesh, "mesh").model->mesh);
        brittle_inspection values{};
        values.refusal = found.refusal ? c::status_of(*found.refusal) : brittle_status{BRITTLE_OK};
        for (int k = 0; k < 3; ++k) {
            values.box_min[k] = found.box.min[k];
            values.box_max[k] = found.box.max[k];
        }
        values.area = found.area;
        values.volume = found.volume;
        values.vertices = found.topology.vertices;
        values.edges = found.topology.edges;
        values.triangles = found.topology.triangles;
        values.components = found.topology.components;
        values.open_edges = found.topology.open_edges;
        values.misoriented_edges = found.topology.misoriented_edges;
        values.non_manifold_edges = found.topology.non_manifold_edges;
        values.non_manifold_vertices = found.topology.non_manifold_vertices;
        values.flat_triangles = found.flat_triangles;
        values.duplicate_triangles = found.duplicate_triangles;
        values.intersections = found.intersections;
        values.holes = found.rims.size();
        std::unique_ptr<brittle_text> text = report ? c::text_of(fracture::describe(found)) : nullptr;
        c::write_struct(values, out, "out");
        if (report) *report = text.release();
    });
}

void brittle_repair_settings_init(brittle_repair_settings* settings, size_t struct_size) {
    c::init_struct(settings, struct_size, c::repair_defaults());
}

brittle_status brittle_mesh_repair(const brittle_mesh* mesh, const brittle_repair_settings* settings,
                                   brittle_mesh** out, brittle_text** report, brittle_error* error) {
    return guarded(error, [&] {
        need(out, "out");
        fracture::Model model = *need(mesh, "mesh").model;
        fracture::Repaired repaired =
            fracture::repair(model.mesh, c::settings_of(c::read_settings(settings, c::repair_defaults(), "settings")));
        std::unique_ptr<brittle_text> text = report ? c::text_of(fracture::describe(repaired.report)) : nullptr;
        if (repaired.report.changed())
            fracture::replace_mesh(model, std::move(repaired.mesh), repaired.source_triangle);
        *out = c::mesh_of(std::move(model)).release();
        if (report) *report = text.release();
    });
}

brittle_status brittle_mesh_unite(const brittle_mesh* mesh, uint32_t threads, brittle_mesh** out, brittle_text** report,
                                  brittle_error* error) {
    return guarded(error, [&] {
        need(out, "out");
        fracture::Model model = *need(mesh, "mesh").model;
        const auto topology = fracture::check_topology(model.mesh.positions.size(), model.mesh.triangles);
        if (!topology.closed())
            refuse("parts can be united only where the mesh is closed, and it has " + fracture::describe(topology)
                       + "; repair it first",
                   c::status_of(fracture::status_of(topology)));
        fracture::United united = fracture::unite(model.mesh, threads);
        if (united.mesh.triangles.empty()) {
            if (united.report.inside_out > 0.0)
                refuse("the whole surface is inside out, so the union is empty; repair it first", BRITTLE_INSIDE_OUT);
            refuse("the surface encloses no space, so the union is empty", BRITTLE_NO_VOLUME);
        }
        std::unique_ptr<brittle_text> text = report ? c::text_of(fracture::describe(united.report)) : nullptr;
        if (united.report.changed()) fracture::divide_mesh(model, std::move(united.mesh), united.source_triangle);
        *out = c::mesh_of(std::move(model)).release();
        if (report) *report = text.release();
    });
}

} // extern "C"
