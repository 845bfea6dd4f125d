/* Uses the C interface from C99. Prints each check that fails; exit code 1 if there is one.
 *   test_c BUNNY MESH     all checks; BUNNY may be missing
 *   test_c --hash MESH    only the hash of the mesh at 100 sites and seed 1 */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "brittle.h"
#include "checks.h"

/* The same fracture by the C++ library. */
uint64_t core_hash(const char* path, uint32_t count, uint64_t seed, double roughness);
uint64_t core_state_hash(void);

static brittle_array array_of(uint32_t type, uint32_t columns, uint64_t rows, const void* data) {
    brittle_array array;
    memset(&array, 0, sizeof array);
    array.type = type;
    array.columns = columns;
    array.rows = rows;
    array.data = data;
    return array;
}

static const float tetrahedron[4][4] = {{0, 0, 0, 9}, {1, 0, 0, 9}, {0, 1, 0, 9}, {0, 0, 1, 9}}; /* 9: not read */
static const uint16_t faces[12] = {0, 2, 1, 0, 1, 3, 1, 2, 3, 2, 0, 3};

static brittle_mesh_arrays tetrahedron_arrays(void) {
    brittle_mesh_arrays arrays;
    memset(&arrays, 0, sizeof arrays);
    arrays.struct_size = sizeof arrays;
    arrays.positions = array_of(BRITTLE_FLOAT32, 3, 4, tetrahedron);
    arrays.positions.stride = sizeof tetrahedron[0];
    arrays.triangles = array_of(BRITTLE_UINT16, 3, 4, faces);
    return arrays;
}

static brittle_pieces* break_mesh(const brittle_mesh* mesh, uint32_t count, double roughness) {
    brittle_pattern pattern;
    brittle_fracture_settings settings;
    brittle_sites* sites = NULL;
    brittle_pieces* pieces = NULL;
    brittle_pattern_init(&pattern, sizeof pattern);
    pattern.count = count;
    pattern.seed = 1;
    brittle_fracture_settings_init(&settings, sizeof settings);
    settings.roughness = roughness;
    CHECK(brittle_sites_pattern(&pattern, mesh, &sites, NULL) == BRITTLE_OK);
    CHECK(brittle_fracture(mesh, sites, &settings, &pieces, NULL) == BRITTLE_OK);
    brittle_sites_free(sites);
    return pieces;
}

static uint64_t hash_of(const brittle_pieces* pieces) {
    brittle_certificate certificate;
    memset(&certificate, 0, sizeof certificate);
    certificate.struct_size = sizeof certificate;
    CHECK(brittle_pieces_certificate(pieces, &certificate, NULL) == BRITTLE_OK);
    CHECK(certificate.closed == 1 && certificate.volume_error < 1e-6);
    return certificate.hash;
}

static void test_hash(const char* path) {
    brittle_mesh* mesh = NULL;
    brittle_pieces* pieces;
    CHECK(brittle_mesh_load(path, &mesh, NULL) == BRITTLE_OK);
    if (!mesh) return;
    pieces = break_mesh(mesh, 100, 0.0);
    CHECK(hash_of(pieces) == core_hash(path, 100, 1, 0.0));
    printf("hash %016llx\n", (unsigned long long)hash_of(pieces));
    brittle_pieces_free(pieces);
    pieces = break_mesh(mesh, 20, 0.3);
    CHECK(hash_of(pieces) == core_hash(path, 20, 1, 0.3));
    brittle_pieces_free(pieces);
    brittle_mesh_free(mesh);
}

static void test_meshes(void) {
    brittle_mesh_arrays arrays = tetrahedron_arrays();
    double moved[12][3]; /* a triangle soup of doubles */
    int k;
    static const float normals[4][3] = {{0, 0, -1}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
    static const float uv[4][2] = {{0, 0}, {1, 0}, {0, 1}, {0.5f, 0.25f}};
    static const uint16_t materials[4] = {3, 0, 0, 1};
    uint32_t which;
    brittle_mesh *mesh = NULL, *soup = NULL, *again = NULL, *mended = NULL, *painted = NULL;
    brittle_array positions, triangles, looks;
    brittle_files* files = NULL;
    brittle_text* report = NULL;
    brittle_inspection inspection;
    const void* bytes = NULL;
    const char* name = NULL;
    size_t size = 0;

    CHECK(brittle_mesh_from_arrays(&arrays, &mesh, NULL) == BRITTLE_OK);
    CHECK(brittle_mesh_array(mesh, BRITTLE_MESH_POSITIONS, &positions, NULL) == BRITTLE_OK);
    CHECK(positions.type == BRITTLE_FLOAT64 && positions.rows == 4 && positions.columns == 3);
    CHECK(((const double*)positions.data)[11] == 1.0);
    CHECK(brittle_mesh_array(mesh, BRITTLE_MESH_TRIANGLES, &triangles, NULL) == BRITTLE_OK);
    CHECK(triangles.rows == 4 && ((const uint32_t*)triangles.data)[1] == 2);
    for (which = BRITTLE_MESH_NORMALS; which <= BRITTLE_MESH_MATERIALS; ++which) {
        CHECK(brittle_mesh_array(mesh, which, &looks, NULL) == BRITTLE_OK);
        CHECK(looks.rows == 0);
    }
    arrays.normals = array_of(BRITTLE_FLOAT32, 3, 4, normals);
    arrays.uv = array_of(BRITTLE_FLOAT32, 2, 4, uv);
    arrays.materials = array_of(BRITTLE_UINT16, 1, 4, materials);
    CHECK(brittle_mesh_from_arrays(&arrays, &painted, NULL) == BRITTLE_OK);
    CHECK(brittle_mesh_array(painted, BRITTLE_MESH_NORMALS, &looks, NULL) == BRITTLE_OK);
    CHECK(looks.type == BRITTLE_FLOAT32 && looks.rows == 12 && looks.columns == 3);
    for (k = 0; k < 36; ++k) CHECK(((const float*)looks.data)[k] == normals[faces[k / 3]][k % 3]);
    CHECK(brittle_mesh_array(painted, BRITTLE_MESH_UV, &looks, NULL) == BRITTLE_OK);
    CHECK(looks.type == BRITTLE_FLOAT32 && looks.rows == 12 && looks.columns == 2);
    for (k = 0; k < 12; ++k) {
        CHECK(((const float*)looks.data)[2 * k] == uv[faces[k]][0]);
        CHECK(((const float*)looks.data)[2 * k + 1] == uv[faces[k]][1]);
    }
    CHECK(brittle_mesh_array(painted, BRITTLE_MESH_MATERIALS, &looks, NULL) == BRITTLE_OK);
    CHECK(looks.type == BRITTLE_UINT32 && looks.rows == 4 && looks.columns == 1);
    for (k = 0; k < 4; ++k) CHECK(((const uint32_t*)looks.data)[k] == materials[k]);
    brittle_mesh_free(painted);

    for (k = 0; k < 12; ++k) {
        moved[k][0] = (double)tetrahedron[faces[k]][0];
        moved[k][1] = (double)tetrahedron[faces[k]][1];
        moved[k][2] = (double)tetrahedron[faces[k]][2];
    }
    memset(&arrays, 0, sizeof arrays);
    arrays.struct_size = sizeof arrays;
    arrays.positions = array_of(BRITTLE_FLOAT64, 3, 12, moved);
    arrays.weld = 1;
    CHECK(brittle_mesh_from_arrays(&arrays, &soup, NULL) == BRITTLE_OK);
    CHECK(brittle_mesh_array(soup, BRITTLE_MESH_POSITIONS, &positions, NULL) == BRITTLE_OK);
    CHECK(positions.rows == 4);
    memset(&inspection, 0, sizeof inspection);
    inspection.struct_size = sizeof inspection;
    CHECK(brittle_mesh_inspect(soup, &inspection, &report, NULL) == BRITTLE_OK);
    CHECK(inspection.refusal == BRITTLE_OK && fabs(inspection.volume - 1.0 / 6.0) < 1e-15);
    CHECK(strlen(brittle_text_get(report)) > 10);
    brittle_text_free(report);
    report = NULL;

    /* An open mesh is refused by the fracture and mended by the repair. */
    arrays = tetrahedron_arrays();
    arrays.triangles.rows = 3;
    brittle_mesh_free(soup);
    CHECK(brittle_mesh_from_arrays(&arrays, &soup, NULL) == BRITTLE_OK);
    CHECK(brittle_mesh_inspect(soup, &inspection, NULL, NULL) == BRITTLE_OK);
    CHECK(inspection.refusal == BRITTLE_NOT_CLOSED && inspection.open_edges == 3 && inspection.holes == 1);
    CHECK_ERROR(brittle_mesh_unite(soup, 1, &again, NULL, &error), BRITTLE_NOT_CLOSED, "open edge");
    CHECK(again == NULL);
    {
        brittle_mesh* flat = NULL;
        brittle_sites* sites = NULL;
        arrays.triangles.rows = 1;
        CHECK(brittle_mesh_from_arrays(&arrays, &flat, NULL) == BRITTLE_OK);
        CHECK_ERROR(brittle_sites_pattern(NULL, flat, &sites, &error), BRITTLE_NOT_CLOSED, "not closed");
        CHECK(sites == NULL);
        brittle_mesh_free(flat);
        arrays.triangles.rows = 3;
    }
    CHECK(brittle_mesh_repair(soup, NULL, &mended, &report, NULL) == BRITTLE_OK);
    CHECK(strlen(brittle_text_get(report)) > 10);
    CHECK(brittle_mesh_inspect(mended, &inspection, NULL, NULL) == BRITTLE_OK);
    CHECK(inspection.refusal == BRITTLE_OK && inspection.triangles == 4);
    CHECK(brittle_mesh_unite(mended, 1, &again, NULL, NULL) == BRITTLE_OK);
    brittle_mesh_free(again);
    again = NULL;

    CHECK(brittle_mesh_save_memory(mesh, "one.glb", &files, NULL) == BRITTLE_OK);
    CHECK(brittle_files_count(files) == 1);
    CHECK(brittle_files_get(files, 0, &name, &bytes, &size, NULL) == BRITTLE_OK);
    CHECK(strcmp(name, "one.glb") == 0 && size > 100);
    CHECK_ERROR(brittle_files_get(files, 1, &name, &bytes, &size, &error), BRITTLE_INVALID_ARGUMENT, "file 1");
    CHECK(brittle_mesh_load_memory(bytes, size, ".glb", &again, NULL) == BRITTLE_OK);
    CHECK(brittle_mesh_array(again, BRITTLE_MESH_TRIANGLES, &triangles, NULL) == BRITTLE_OK);
    CHECK(triangles.rows == 4);
    brittle_mesh_free(again);
    again = NULL;
    CHECK_ERROR(brittle_mesh_load_memory(bytes, 40, ".glb", &again, &error), BRITTLE_MALFORMED_FILE, "memory");
    CHECK_ERROR(brittle_mesh_load_memory(bytes, size, ".xyz", &again, &error), BRITTLE_UNSUPPORTED_FORMAT, ".xyz");

    brittle_text_free(report);
    brittle_files_free(files);
    brittle_mesh_free(mesh);
    brittle_mesh_free(soup);
    brittle_mesh_free(mended);
}

static int32_t always(void* user) {
    ++*(int*)user;
    return 1;
}
static void keep_share(void* user, double share) {
    *(double*)user = share;
}

static void test_pieces(void) {
    brittle_mesh* mesh = NULL;
    brittle_pieces* pieces;
    brittle_pieces* none = NULL;
    brittle_sites* sites = NULL;
    brittle_workspace* workspace = NULL;
    brittle_fracture_settings settings;
    brittle_surface* surface = NULL;
    brittle_hulls* hulls = NULL;
    brittle_files* files = NULL;
    brittle_export_settings export_settings;
    brittle_array array, ranges;
    double sum = 0.0, share = 0.0;
    int asked = 0;
    int32_t flag = 1;
    uint64_t k, drawn = 0, hash;
    uint32_t material = 0, interior = 0;

    CHECK(brittle_mesh_shape("icosphere:3", &mesh, NULL) == BRITTLE_OK);
    pieces = break_mesh(mesh, 8, 0.0);
    hash = hash_of(pieces);
    CHECK(brittle_pieces_array(pieces, BRITTLE_PIECES_VOLUMES, &array, NULL) == BRITTLE_OK);
    CHECK(array.rows == 8 && array.columns == 1);
    for (k = 0; k < array.rows; ++k) {
        double volume;
        memcpy(&volume, (const char*)array.data + k * array.stride, sizeof volume);
        sum += volume;
    }
    CHECK(sum > 4.1 && sum < 4.19); /* m^3, a ball of radius 1 less the facets */
    for (k = 1; k <= BRITTLE_PIECES_BOND_NORMALS; ++k) {
        CHECK(brittle_pieces_array(pieces, (uint32_t)k, &array, NULL) == BRITTLE_OK);
        CHECK(array.rows > 0 && array.data != NULL && array.columns > 0 && array.stride > 0);
    }
    CHECK(brittle_pieces_array(pieces, BRITTLE_PIECES_TRIANGLE_RANGES, &ranges, NULL) == BRITTLE_OK);
    CHECK(brittle_pieces_surface(pieces, 0, &surface, NULL) == BRITTLE_OK);
    CHECK(brittle_surface_parts(surface) == 2);
    for (k = 0; k < brittle_surface_parts(surface); ++k) {
        CHECK(brittle_surface_part(surface, k, &material, &interior, NULL) == BRITTLE_OK);
        CHECK(material == BRITTLE_NO_MATERIAL && interior == k);
        CHECK(brittle_surface_array(surface, k, BRITTLE_SURFACE_INDICES, &array, NULL) == BRITTLE_OK);
        drawn += array.rows;
        CHECK(brittle_surface_array(surface, k, BRITTLE_SURFACE_NORMALS, &array, NULL) == BRITTLE_OK);
        CHECK(array.rows > 0 && array.columns == 3);
        CHECK(brittle_surface_array(surface, k, BRITTLE_SURFACE_UV, &array, NULL) == BRITTLE_OK);
        CHECK((array.rows > 0) == (interior == 1));
    }
    CHECK(drawn == ((const uint32_t*)ranges.data)[1] - ((const uint32_t*)ranges.data)[0]);
    brittle_surface_free(surface);
    surface = NULL;

    CHECK(brittle_pieces_hulls(pieces, 1, 32, &hulls, NULL) == BRITTLE_OK);
    CHECK(brittle_hulls_array(hulls, BRITTLE_HULL_RANGES, &array, NULL) == BRITTLE_OK);
    CHECK(array.rows == 8);
    brittle_hulls_free(hulls);
    hulls = NULL;
    CHECK(brittle_pieces_hulls(pieces, 4, 32, &hulls, NULL) == BRITTLE_OK);
    CHECK(brittle_hulls_array(hulls, BRITTLE_HULL_PIECES, &array, NULL) == BRITTLE_OK);
    CHECK(array.rows >= 8);
    brittle_hulls_free(hulls);
    hulls = NULL;

    brittle_export_settings_init(&export_settings, sizeof export_settings);
    export_settings.per_piece = 1;
    export_settings.hulls = 1;
    CHECK(brittle_pieces_save_memory(pieces, "pieces.glb", &export_settings, &files, NULL) == BRITTLE_OK);
    CHECK(brittle_files_count(files) == 8);
    brittle_files_free(files);
    files = NULL;
    CHECK_ERROR(brittle_pieces_save(pieces, "/nonexistent/pieces.glb", NULL, &error), BRITTLE_WRITE_FAILED,
                "/nonexistent");

    /* Callbacks, cancellation, workspace, and the one-site refusals of the core. */
    CHECK(brittle_sites_pattern(NULL, mesh, &sites, NULL) == BRITTLE_OK);
    brittle_fracture_settings_init(&settings, sizeof settings);
    settings.user = &asked;
    settings.cancelled = always;
    CHECK_ERROR(brittle_fracture(mesh, sites, &settings, &none, &error), BRITTLE_CANCELLED, "");
    CHECK(asked > 0 && none == NULL);
    brittle_fracture_settings_init(&settings, sizeof settings);
    settings.cancel_flag = &flag;
    CHECK_ERROR(brittle_fracture(mesh, sites, &settings, &none, &error), BRITTLE_CANCELLED, "");
    brittle_fracture_settings_init(&settings, sizeof settings);
    settings.progress = keep_share;
    settings.user = &share;
    CHECK(brittle_workspace_create(&workspace, NULL) == BRITTLE_OK);
    settings.workspace = workspace;
    settings.threads = 2;
    CHECK(brittle_fracture(mesh, sites, &settings, &none, NULL) == BRITTLE_OK);
    CHECK(share == 1.0);
    brittle_pieces_free(none);
    none = NULL;
    settings.threads = 5000;
    CHECK_ERROR(brittle_fracture(mesh, sites, &settings, &none, &error), BRITTLE_INVALID_SETTING, "5000");
    settings.threads = 1;
    settings.min_volume = NAN;
    CHECK_ERROR(brittle_fracture(mesh, sites, &settings, &none, &error), BRITTLE_INVALID_SETTING, "volume");
    settings.min_volume = 0.0;
    settings.roughness = -3.0;
    CHECK_ERROR(brittle_fracture(mesh, sites, &settings, &none, &error), BRITTLE_INVALID_SETTING, "-3");
    brittle_workspace_free(workspace);

    /* Pieces outlive their mesh. */
    brittle_mesh_free(mesh);
    CHECK(hash_of(pieces) == hash);
    brittle_pieces_free(pieces);
    brittle_sites_free(sites);
}

static void test_bad_arguments(void) {
    brittle_mesh_arrays arrays = tetrahedron_arrays();
    brittle_mesh* mesh = NULL;
    brittle_sites* sites = NULL;
    brittle_pieces* pieces = NULL;
    brittle_pattern pattern;
    brittle_array array;
    struct {
        brittle_fracture_settings known;
        uint64_t newer;
    } large;
    struct {
        uint32_t struct_size;
        brittle_status status;
        char message[8];
        char guard[8];
    } small;
    float nan_positions[4][3] = {{0, 0, 0}, {1, 0, 0}, {0, NAN, 0}, {0, 0, 1}};
    const uint32_t bad_index[3] = {0, 1, 7};
    const double site[3] = {0.1, 0.1, INFINITY};
    const double zero[3] = {1.0, 0.0, 1.0};

    CHECK_ERROR(brittle_mesh_from_arrays(NULL, &mesh, &error), BRITTLE_INVALID_ARGUMENT, "arrays is NULL");
    CHECK_ERROR(brittle_mesh_from_arrays(&arrays, NULL, &error), BRITTLE_INVALID_ARGUMENT, "out is NULL");
    arrays.struct_size = 0;
    CHECK_ERROR(brittle_mesh_from_arrays(&arrays, &mesh, &error), BRITTLE_INVALID_ARGUMENT, "struct_size");
    arrays = tetrahedron_arrays();
    arrays.positions.data = NULL;
    CHECK_ERROR(brittle_mesh_from_arrays(&arrays, &mesh, &error), BRITTLE_INVALID_ARGUMENT, "positions.data is NULL");
    arrays = tetrahedron_arrays();
    arrays.positions.rows = (uint64_t)-4; /* a negative count */
    CHECK_ERROR(brittle_mesh_from_arrays(&arrays, &mesh, &error), BRITTLE_INVALID_ARGUMENT, "rows");
    arrays = tetrahedron_arrays();
    arrays.positions.stride = 4;
    CHECK_ERROR(brittle_mesh_from_arrays(&arrays, &mesh, &error), BRITTLE_INVALID_ARGUMENT, "stride is 4");
    arrays = tetrahedron_arrays();
    arrays.positions.columns = 2;
    CHECK_ERROR(brittle_mesh_from_arrays(&arrays, &mesh, &error), BRITTLE_INVALID_ARGUMENT, "2 columns");
    arrays = tetrahedron_arrays();
    arrays.positions.type = BRITTLE_UINT32;
    CHECK_ERROR(brittle_mesh_from_arrays(&arrays, &mesh, &error), BRITTLE_INVALID_ARGUMENT, "positions.type is 4");
    arrays = tetrahedron_arrays();
    arrays.positions = array_of(BRITTLE_FLOAT32, 3, 4, nan_positions);
    CHECK_ERROR(brittle_mesh_from_arrays(&arrays, &mesh, &error), BRITTLE_INVALID_MESH, "row 2, column 1");
    arrays = tetrahedron_arrays();
    arrays.triangles = array_of(BRITTLE_UINT32, 3, 1, bad_index);
    CHECK_ERROR(brittle_mesh_from_arrays(&arrays, &mesh, &error), BRITTLE_INVALID_MESH, "vertex 7");
    arrays = tetrahedron_arrays();
    arrays.triangles = array_of(BRITTLE_UINT16, 1, 11, faces);
    CHECK_ERROR(brittle_mesh_from_arrays(&arrays, &mesh, &error), BRITTLE_INVALID_ARGUMENT, "multiple of 3");
    arrays = tetrahedron_arrays();
    arrays.normals = array_of(BRITTLE_FLOAT32, 3, 3, tetrahedron);
    CHECK_ERROR(brittle_mesh_from_arrays(&arrays, &mesh, &error), BRITTLE_INVALID_ARGUMENT, "normals has 3 rows");
    arrays = tetrahedron_arrays();
    arrays.positions.rows = 0;
    arrays.triangles.rows = 0;
    CHECK_ERROR(brittle_mesh_from_arrays(&arrays, &mesh, &error), BRITTLE_EMPTY_MESH, "no triangles");

    CHECK_ERROR(brittle_mesh_load("/nonexistent.obj", &mesh, &error), BRITTLE_FILE_NOT_FOUND, "/nonexistent.obj");
    CHECK_ERROR(brittle_mesh_load(NULL, &mesh, &error), BRITTLE_INVALID_ARGUMENT, "path is NULL");
    CHECK_ERROR(brittle_mesh_shape("rabbit", &mesh, &error), BRITTLE_INVALID_ARGUMENT, "icosphere");
    CHECK_ERROR(brittle_mesh_box(zero, &mesh, &error), BRITTLE_INVALID_SETTING, "box");
    CHECK_ERROR(brittle_mesh_load_memory(NULL, 8, ".obj", &mesh, &error), BRITTLE_INVALID_ARGUMENT, "bytes is NULL");
    CHECK(mesh == NULL);

    CHECK(brittle_mesh_shape("cube", &mesh, NULL) == BRITTLE_OK);
    CHECK_ERROR(brittle_mesh_array(mesh, 9, &array, &error), BRITTLE_INVALID_ARGUMENT, "which is 9");
    CHECK_ERROR(brittle_mesh_array(NULL, 1, &array, &error), BRITTLE_INVALID_ARGUMENT, "mesh is NULL");
    CHECK_ERROR(brittle_mesh_inspect(mesh, NULL, NULL, &error), BRITTLE_INVALID_ARGUMENT, "out is NULL");
    array = array_of(BRITTLE_FLOAT64, 3, 1, site);
    CHECK_ERROR(brittle_sites_from_arrays(&array, NULL, NULL, &sites, &error), BRITTLE_INVALID_SITES, "inf");
    array.rows = 0;
    CHECK_ERROR(brittle_sites_from_arrays(&array, NULL, NULL, &sites, &error), BRITTLE_INVALID_SITES, "no sites");
    brittle_pattern_init(&pattern, sizeof pattern);
    pattern.kind = "stars";
    CHECK_ERROR(brittle_sites_pattern(&pattern, mesh, &sites, &error), BRITTLE_INVALID_ARGUMENT, "stars");
    pattern.kind = NULL;
    pattern.count = UINT32_MAX;
    CHECK_ERROR(brittle_sites_pattern(&pattern, mesh, &sites, &error), BRITTLE_INVALID_SETTING, "4294967295");
    pattern.count = 0;
    CHECK_ERROR(brittle_sites_pattern(&pattern, mesh, &sites, &error), BRITTLE_INVALID_SETTING, "0");
    CHECK(sites == NULL);

    CHECK(brittle_sites_pattern(NULL, mesh, &sites, NULL) == BRITTLE_OK);
    CHECK_ERROR(brittle_fracture(NULL, sites, NULL, &pieces, &error), BRITTLE_INVALID_ARGUMENT, "mesh is NULL");
    CHECK_ERROR(brittle_fracture(mesh, NULL, NULL, &pieces, &error), BRITTLE_INVALID_ARGUMENT, "sites is NULL");
    /* A caller of a newer header: its new field must be zero. */
    memset(&large, 0, sizeof large);
    brittle_fracture_settings_init(&large.known, sizeof large);
    CHECK(large.known.struct_size == sizeof large && large.newer == 0);
    CHECK(brittle_fracture(mesh, sites, &large.known, &pieces, NULL) == BRITTLE_OK);
    brittle_pieces_free(pieces);
    pieces = NULL;
    large.newer = 1;
    CHECK_ERROR(brittle_fracture(mesh, sites, &large.known, &pieces, &error), BRITTLE_INVALID_ARGUMENT,
                "newer library");
    CHECK(pieces == NULL);
    /* A caller of an older header, and a message that is cut to its buffer. */
    large.known.struct_size = 8;
    CHECK(brittle_fracture(mesh, sites, &large.known, &pieces, NULL) == BRITTLE_OK);
    CHECK_ERROR(brittle_pieces_array(pieces, 0, &array, &error), BRITTLE_INVALID_ARGUMENT, "which is 0");
    CHECK_ERROR(brittle_pieces_surface(pieces, 1000000, NULL, &error), BRITTLE_INVALID_ARGUMENT, "out is NULL");
    {
        brittle_surface* surface = NULL;
        brittle_hulls* hulls = NULL;
        CHECK_ERROR(brittle_pieces_surface(pieces, 1000000, &surface, &error), BRITTLE_INVALID_ARGUMENT, "1000000");
        CHECK_ERROR(brittle_pieces_hulls(pieces, 0, 32, &hulls, &error), BRITTLE_INVALID_SETTING, "max_parts is 0");
        CHECK(surface == NULL && hulls == NULL);
    }
    memset(&small, 7, sizeof small);
    small.struct_size = 16;
    CHECK(brittle_mesh_load(NULL, &mesh, (brittle_error*)(void*)&small) == BRITTLE_INVALID_ARGUMENT);
    CHECK(strcmp(small.message, "path is") == 0 && small.guard[0] == 7);

    CHECK(strcmp(brittle_status_name(BRITTLE_NOT_CLOSED), "not_closed") == 0);
    CHECK(strcmp(brittle_status_name(99), "unknown") == 0 && strcmp(brittle_status_name(-1), "unknown") == 0);
    CHECK(strlen(brittle_version()) >= 5);
    brittle_mesh_free(NULL);
    brittle_sites_free(NULL);
    brittle_pieces_free(NULL);
    brittle_world_free(NULL);
    brittle_events_free(NULL);
    brittle_pieces_free(pieces);
    brittle_sites_free(sites);
    brittle_mesh_free(mesh);
}

/* core_state_hash() makes the same run in C++. */
static uint64_t run_world(uint32_t threads) {
    brittle_world_settings settings;
    brittle_object_settings object;
    brittle_world* world = NULL;
    brittle_mesh* mesh = NULL;
    brittle_events* events = NULL;
    brittle_array added, removed, positions, triangles;
    brittle_transform transforms[200];
    const float point[3] = {0.0f, 1.0f, 1.0f}, inwards[3] = {0.0f, 0.0f, -1.0f};
    const float from[3] = {0.0f, 1.0f, 5.0f}, velocity[3] = {0.0f, 0.0f, -20.0f};
    float position[3], orientation[4];
    uint64_t hash = 0, count = 0;
    uint32_t number = 0, broke = 0, ball = 0, exterior = 0;
    brittle_world_settings_init(&settings, sizeof settings);
    settings.threads = threads;
    CHECK(brittle_world_create(&settings, &world, NULL) == BRITTLE_OK);
    CHECK(brittle_mesh_shape("cube", &mesh, NULL) == BRITTLE_OK);
    brittle_object_settings_init(&object, sizeof object);
    object.position[1] = 1.0f;
    object.roughness = 0.0;
    CHECK(brittle_world_add_breakable(world, mesh, &object, &number, NULL) == BRITTLE_OK);
    CHECK(brittle_world_transforms(world, 1.0f, NULL, 0, &count, NULL) == BRITTLE_OK);
    CHECK(count == 1);
    CHECK(brittle_world_transforms(world, 1.0f, transforms, 200, &count, NULL) == BRITTLE_OK);
    CHECK(transforms[0].position[1] == 1.0f && transforms[0].orientation[3] == 1.0f);
    CHECK(brittle_world_strike(world, transforms[0].piece, point, inwards, 20000.0, &broke, NULL) == BRITTLE_OK);
    CHECK(broke == 1);
    CHECK(brittle_world_shoot(world, from, velocity, 0.2f, 7800.0f, &ball, NULL) == BRITTLE_OK);
    CHECK(brittle_world_step(world, 60, NULL) == BRITTLE_OK);
    CHECK(brittle_world_body(world, ball, position, orientation, NULL) == BRITTLE_OK);
    CHECK(position[2] < 4.0f);
    CHECK(brittle_world_events(world, &events, NULL) == BRITTLE_OK);
    CHECK(brittle_events_array(events, BRITTLE_EVENTS_ADDED, &added, NULL) == BRITTLE_OK);
    CHECK(brittle_events_array(events, BRITTLE_EVENTS_REMOVED, &removed, NULL) == BRITTLE_OK);
    CHECK(added.rows > 2 && added.columns == 5 && removed.rows == 0);
    CHECK(brittle_events_added_array(events, 0, BRITTLE_ADDED_POSITIONS, &positions, &exterior, NULL) == BRITTLE_OK);
    CHECK(brittle_events_added_array(events, 0, BRITTLE_ADDED_TRIANGLES, &triangles, NULL, NULL) == BRITTLE_OK);
    CHECK(positions.rows >= 4 && triangles.rows >= exterior && exterior > 0);
    CHECK(brittle_world_transforms(world, 1.0f, transforms, 200, &count, NULL) == BRITTLE_OK);
    CHECK(count == added.rows);
    CHECK(brittle_world_state_hash(world, &hash, NULL) == BRITTLE_OK);
    CHECK(brittle_world_remove(world, number, NULL) == BRITTLE_OK);
    CHECK_ERROR(brittle_world_remove(world, number, &error), BRITTLE_INVALID_ARGUMENT, "object");
    CHECK(brittle_world_transforms(world, 1.0f, NULL, 0, &count, NULL) == BRITTLE_OK);
    CHECK(count == 0);
    brittle_events_free(events);
    brittle_mesh_free(mesh);
    brittle_world_free(world);
    return hash;
}

static void test_world(void) {
    brittle_world* world = NULL;
    brittle_world_settings settings;
    brittle_object_settings object;
    brittle_mesh* mesh = NULL;
    brittle_pieces* pieces;
    const brittle_anchor foot = {{0.0, -1.0, 0.0}, 0.2}, bad = {{0.0, 0.0, 0.0}, -1.0};
    const float up[3] = {0.0f, 1.0f, 0.0f}, none[3] = {0.0f, 0.0f, 0.0f}, wrong[3] = {NAN, 0.0f, 0.0f};
    uint32_t broke = 0;
    const uint64_t hash = run_world(1);

    CHECK(hash == run_world(2));
    CHECK(hash == core_state_hash());
    brittle_world_settings_init(&settings, sizeof settings);
    settings.step = -1.0f;
    CHECK_ERROR(brittle_world_create(&settings, &world, &error), BRITTLE_INVALID_SETTING, "step");
    settings.step = 0.01f;
    settings.workers = 0;
    CHECK_ERROR(brittle_world_create(&settings, &world, &error), BRITTLE_INVALID_SETTING, "workers");
    CHECK(world == NULL);
    settings.workers = 1;
    settings.bullet = 1;
    CHECK(brittle_world_create(&settings, &world, NULL) == BRITTLE_OK);
    CHECK(brittle_mesh_shape("cube", &mesh, NULL) == BRITTLE_OK);
    pieces = break_mesh(mesh, 10, 0.0);
    brittle_object_settings_init(&object, sizeof object);
    object.material = "cheese";
    CHECK_ERROR(brittle_world_add_bonded(world, pieces, &object, NULL, &error), BRITTLE_INVALID_ARGUMENT, "cheese");
    object.material = "brick";
    object.anchor_count = 1;
    CHECK_ERROR(brittle_world_add_bonded(world, pieces, &object, NULL, &error), BRITTLE_INVALID_ARGUMENT, "anchors");
    object.anchors = &bad;
    CHECK_ERROR(brittle_world_add_bonded(world, pieces, &object, NULL, &error), BRITTLE_INVALID_SETTING, "anchor");
    object.anchors = &foot;
    object.orientation[3] = 0.0f;
    CHECK_ERROR(brittle_world_add_bonded(world, pieces, &object, NULL, &error), BRITTLE_INVALID_SETTING, "orientation");
    object.orientation[3] = 1.0f;
    object.roughness = NAN;
    CHECK_ERROR(brittle_world_add_bonded(world, pieces, &object, NULL, &error), BRITTLE_INVALID_SETTING, "roughness");
    object.roughness = -1.0;
    CHECK(brittle_world_add_bonded(world, pieces, &object, NULL, NULL) == BRITTLE_OK);
    CHECK(brittle_world_step(world, 10, NULL) == BRITTLE_OK);
    CHECK_ERROR(brittle_world_strike(world, 999, up, up, 1.0, &broke, &error), BRITTLE_INVALID_ARGUMENT, "piece 999");
    CHECK_ERROR(brittle_world_strike(world, 0, up, none, 1.0, &broke, &error), BRITTLE_INVALID_ARGUMENT, "direction");
    CHECK_ERROR(brittle_world_strike(world, 0, wrong, up, 1.0, &broke, &error), BRITTLE_INVALID_ARGUMENT, "point[0]");
    CHECK_ERROR(brittle_world_strike(world, 0, up, up, -1.0, &broke, &error), BRITTLE_INVALID_SETTING, "energy");
    CHECK_ERROR(brittle_world_shoot(world, up, up, NAN, 1.0f, NULL, &error), BRITTLE_INVALID_SETTING, "radius");
    CHECK_ERROR(brittle_world_transforms(world, 7.0f, NULL, 0, NULL, &error), BRITTLE_INVALID_SETTING, "alpha");
    CHECK_ERROR(brittle_world_step(NULL, 1, &error), BRITTLE_INVALID_ARGUMENT, "world is NULL");
    brittle_pieces_free(pieces);
    brittle_mesh_free(mesh);
    brittle_world_free(world);
}

static void test_materials(void) {
    brittle_material material;
    uint32_t index;
    memset(&material, 0, sizeof material);
    material.struct_size = sizeof material;
    for (index = 0; index < 6; ++index) {
        CHECK(brittle_material_get(brittle_material_name(index), &material, NULL) == BRITTLE_OK);
        CHECK(strcmp(material.name, brittle_material_name(index)) == 0);
        CHECK(material.density >= 700.0 && material.density <= 2600.0 && material.tensile >= 1e6);
    }
    CHECK(brittle_material_name(6) == NULL && brittle_material_name(0xffffffffu) == NULL);
    CHECK(brittle_material_get("wood", &material, NULL) == BRITTLE_OK);
    CHECK(strcmp(material.pattern, "splinters") == 0 && material.density == 700.0
          && material.pattern_slenderness > 1.0);
    CHECK_ERROR(brittle_material_get("rubber", &material, &error), BRITTLE_INVALID_ARGUMENT, "glass, stone");
    CHECK_ERROR(brittle_material_get(NULL, &material, &error), BRITTLE_INVALID_ARGUMENT, "name is NULL");
    CHECK_ERROR(brittle_material_get("wood", NULL, &error), BRITTLE_INVALID_ARGUMENT, "out is NULL");
    CHECK(strcmp(material.name, "wood") == 0);
}

int main(int count, char** arguments) {
    if (count != 3) {
        fprintf(stderr, "usage: test_c BUNNY MESH, or test_c --hash MESH\n");
        return 2;
    }
    if (strcmp(arguments[1], "--hash") == 0) {
        test_hash(arguments[2]);
        return check_failures > 0;
    }
    test_meshes();
    test_pieces();
    test_bad_arguments();
    test_materials();
    test_world();
    test_hash(arguments[2]);
    {
        FILE* bunny = fopen(arguments[1], "rb");
        if (bunny) {
            fclose(bunny);
            test_hash(arguments[1]);
        } else {
            printf("skipped: the hash of the bunny, because %s is missing (package glmark2-data)\n", arguments[1]);
        }
    }
    printf("%d checks, %d failures\n", checks, check_failures);
    return check_failures > 0;
}
