/* Gives the library allocators that count, and allocators that fail. Prints each check that fails; exit code 1 if there
 * is one.
 *   test_memory MESH */
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "brittle.h"
#include "checks.h"

/* ---- Allocators ------------------------------------------------------------------------------------------------ */

typedef struct counts {
    long blocks, bytes; /* that live */
    long calls, wrong;  /* wrong: blocks that came back with another size or alignment, or to another allocator */
    long left;          /* calls until the first that fails; below 0: none fails */
} counts;

/* Before each block: what it was asked for. */
typedef union ticket {
    struct {
        counts* from;
        size_t size, alignment;
        void* start;
    } of;
    char room[64];
} ticket;

static long add(long* number, long amount) {
    return __atomic_add_fetch(number, amount, __ATOMIC_SEQ_CST);
}

static void* allocate(void* user, size_t size, size_t alignment) {
    counts* all = user;
    char *start, *block;
    ticket* t;
    add(&all->calls, 1);
    if (__atomic_load_n(&all->left, __ATOMIC_SEQ_CST) >= 0 && add(&all->left, -1) < 0) {
        __atomic_store_n(&all->left, 0, __ATOMIC_SEQ_CST); /* all later calls fail too */
        return NULL;
    }
    if (alignment == 0 || (alignment & (alignment - 1)) != 0) add(&all->wrong, 1);
    start = malloc(sizeof(ticket) + alignment + size);
    if (!start) return NULL;
    block = start + sizeof(ticket);
    block += (alignment - (uintptr_t)block % alignment) % alignment;
    t = (ticket*)(block - sizeof(ticket));
    t->of.from = all;
    t->of.size = size;
    t->of.alignment = alignment;
    t->of.start = start;
    add(&all->blocks, 1);
    add(&all->bytes, (long)size);
    return block;
}

static void release(void* user, void* block, size_t size, size_t alignment) {
    counts* all = user;
    ticket* t = (ticket*)((char*)block - sizeof(ticket));
    if (t->of.from != all || t->of.size != size || t->of.alignment != alignment) add(&all->wrong, 1);
    add(&all->blocks, -1);
    add(&all->bytes, -(long)size);
    free(t->of.start);
}

static void use(counts* all) {
    brittle_allocator allocator;
    memset(&allocator, 0, sizeof allocator);
    allocator.struct_size = sizeof allocator;
    allocator.allocate = allocate;
    allocator.release = release;
    allocator.user = all;
    CHECK(brittle_set_allocator(&allocator, NULL) == BRITTLE_OK);
}

static void use_default(void) {
    CHECK(brittle_set_allocator(NULL, NULL) == BRITTLE_OK);
}

static counts none_yet(void) {
    counts all;
    memset(&all, 0, sizeof all);
    all.left = -1;
    return all;
}

/* ---- Work for the library -------------------------------------------------------------------------------------- */

/* Each job frees all that it made, and returns the first failure. */
typedef brittle_status (*job)(const char* path, brittle_error* error);

static brittle_status read_and_repair(const char* path, brittle_error* error) {
    brittle_mesh *mesh = NULL, *repaired = NULL, *united = NULL;
    brittle_inspection inspection;
    brittle_text* report = NULL;
    brittle_status status = brittle_mesh_load(path, &mesh, error);
    memset(&inspection, 0, sizeof inspection);
    inspection.struct_size = sizeof inspection;
    if (!status) status = brittle_mesh_inspect(mesh, &inspection, &report, error);
    if (!status) status = brittle_mesh_repair(mesh, NULL, &repaired, NULL, error);
    if (!status) status = brittle_mesh_unite(mesh, 2, &united, NULL, error);
    brittle_text_free(report);
    brittle_mesh_free(united);
    brittle_mesh_free(repaired);
    brittle_mesh_free(mesh);
    return status;
}

static brittle_status break_a_mesh(const char* path, double roughness, brittle_error* error) {
    brittle_mesh* mesh = NULL;
    brittle_sites* sites = NULL;
    brittle_pieces* pieces = NULL;
    brittle_surface* surface = NULL;
    brittle_fracture_settings settings;
    brittle_certificate certificate;
    brittle_status status = brittle_mesh_load(path, &mesh, error);
    brittle_fracture_settings_init(&settings, sizeof settings);
    settings.threads = 2;
    settings.roughness = roughness;
    memset(&certificate, 0, sizeof certificate);
    certificate.struct_size = sizeof certificate;
    if (!status) status = brittle_sites_pattern(NULL, mesh, &sites, error);
    if (!status) status = brittle_fracture(mesh, sites, &settings, &pieces, error);
    if (!status) status = brittle_pieces_certificate(pieces, &certificate, error);
    if (!status) CHECK(certificate.closed && certificate.pieces > 1);
    if (!status) status = brittle_pieces_surface(pieces, 0, &surface, error);
    brittle_surface_free(surface);
    brittle_pieces_free(pieces);
    brittle_sites_free(sites);
    brittle_mesh_free(mesh);
    return status;
}

static brittle_status break_flat(const char* path, brittle_error* error) {
    return break_a_mesh(path, 0.0, error);
}

static brittle_status break_rough(const char* path, brittle_error* error) {
    return break_a_mesh(path, 0.3, error);
}

static brittle_status write_and_read(const char* path, brittle_error* error) {
    brittle_mesh *mesh = NULL, *again = NULL;
    brittle_files* files = NULL;
    const void* bytes = NULL;
    size_t size = 0;
    brittle_status status = brittle_mesh_load(path, &mesh, error);
    if (!status) status = brittle_mesh_save_memory(mesh, "mesh.glb", &files, error);
    if (!status) status = brittle_files_get(files, 0, NULL, &bytes, &size, error);
    if (!status) status = brittle_mesh_load_memory(bytes, size, ".glb", &again, error);
    brittle_mesh_free(again);
    brittle_files_free(files);
    brittle_mesh_free(mesh);
    return status;
}

static brittle_status simulate(const char* path, brittle_error* error) {
    brittle_mesh* mesh = NULL;
    brittle_world* world = NULL;
    brittle_world_settings settings;
    const float from[3] = {0.0f, 0.4f, 3.0f}, velocity[3] = {0.0f, 0.0f, -30.0f};
    brittle_status status = brittle_mesh_load(path, &mesh, error);
    brittle_world_settings_init(&settings, sizeof settings);
    settings.threads = 2;
    if (!status) status = brittle_world_create(&settings, &world, error);
    if (!status) status = brittle_world_add_breakable(world, mesh, NULL, NULL, error);
    if (!status) status = brittle_world_shoot(world, from, velocity, 0.1f, 7800.0f, NULL, error);
    if (!status) status = brittle_world_step(world, 20, error);
    brittle_world_free(world);
    brittle_mesh_free(mesh);
    return status;
}

/* ---- Tests ----------------------------------------------------------------------------------------------------- */

static void test_balance(job work, const char* path) {
    counts all = none_yet();
    long kept;
    CHECK(work(path, NULL) == BRITTLE_OK);
    use(&all);
    CHECK(work(path, NULL) == BRITTLE_OK); /* what the library keeps for good is there now */
    kept = all.blocks;
    CHECK(all.calls > 100);
    CHECK(work(path, NULL) == BRITTLE_OK);
    CHECK(all.blocks == kept);
    use_default();
    CHECK(kept == 0 && all.bytes == 0);
    CHECK(all.wrong == 0);
}

static void test_change(const char* path) {
    static counts first, second; /* the library may use them until the program ends */
    brittle_mesh *a = NULL, *b = NULL, *c = NULL;
    brittle_allocator half;
    long calls;
    first = second = none_yet();
    use(&first);
    CHECK(brittle_mesh_load(path, &a, NULL) == BRITTLE_OK);
    use(&second);
    CHECK(brittle_mesh_load(path, &b, NULL) == BRITTLE_OK);
    CHECK(first.blocks > 0 && second.blocks > 0);
    calls = second.calls;
    use_default();
    CHECK(brittle_mesh_load(path, &c, NULL) == BRITTLE_OK);
    CHECK(second.calls == calls);
    brittle_mesh_free(a);
    CHECK(first.blocks == 0);
    use(&first);
    brittle_mesh_free(b);
    brittle_mesh_free(c);
    use_default();
    CHECK(first.blocks == 0 && second.blocks == 0 && first.wrong == 0 && second.wrong == 0);

    memset(&half, 0, sizeof half);
    half.struct_size = sizeof half;
    half.allocate = allocate;
    CHECK_ERROR(brittle_set_allocator(&half, &error), BRITTLE_INVALID_ARGUMENT, "allocator.release is NULL");
}

/* Fails one allocation after the other, and all that follow it. */
static void test_failures(const char* name, job work, const char* path, long tries, brittle_status expected) {
    static counts all; /* of each work in turn: none keeps a block */
    long k, total, refused = 0, ended = 0;
    all = none_yet();
    use(&all);
    CHECK(work(path, NULL) == BRITTLE_OK);
    total = all.calls;
    if (tries > total) tries = total;
    for (k = 0; k < tries; ++k) {
        brittle_error error;
        brittle_status status;
        memset(&error, 0, sizeof error);
        error.struct_size = sizeof error;
        all.left = (long)((double)total / (double)tries * (double)k);
        status = work(path, &error);
        refused += all.left == 0; /* threads make the number of allocations vary a little */
        all.left = -1;
        ended += status != BRITTLE_OK;
        if ((status == BRITTLE_OK || status == expected) && error.status == status && all.blocks == 0) continue;
        fprintf(stderr, "%s, try %ld of %ld: %s, %ld blocks left; %s\n", name, k, tries, brittle_status_name(status),
                all.blocks, error.message);
        CHECK(0);
        break;
    }
    printf("%s: %ld allocations, one refused in %ld of %ld runs, %ld failed\n", name, total, refused, tries, ended);
    CHECK(refused > tries * 9 / 10);
    CHECK(expected == BRITTLE_OK ? ended == 0 : ended > tries * 8 / 10);
    CHECK(work(path, NULL) == BRITTLE_OK); /* nothing is broken for later calls */
    CHECK(all.wrong == 0);
    use_default();
}

int main(int count, char** arguments) {
    const char* path = count == 2 ? arguments[1] : NULL;
    setvbuf(stdout, NULL, _IOLBF, 0);
    if (!path) {
        fprintf(stderr, "usage: test_memory MESH\n");
        return 2;
    }
    test_balance(read_and_repair, path);
    test_balance(break_flat, path);
    test_balance(break_rough, path);
    test_balance(simulate, path);
    test_balance(write_and_read, path);
    test_change(path);
    test_failures("repair", read_and_repair, path, 300, BRITTLE_OUT_OF_MEMORY);
    test_failures("break flat", break_flat, path, 300, BRITTLE_OUT_OF_MEMORY);
    test_failures("break rough", break_rough, path, 200, BRITTLE_OUT_OF_MEMORY);
    test_failures("simulate", simulate, path, 200, BRITTLE_OUT_OF_MEMORY);
    test_failures("write and read", write_and_read, path, 300, BRITTLE_OK);
    printf("%d checks, %d failures\n", checks, check_failures);
    return check_failures > 0;
}
