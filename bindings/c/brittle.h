/* Brittle in C: Voronoi fracture of closed triangle meshes, and destruction while a simulation runs.
 *
 *     brittle_error error = {sizeof error};
 *     brittle_mesh* mesh = NULL;
 *     brittle_sites* sites = NULL;
 *     brittle_pieces* pieces = NULL;
 *     brittle_pattern pattern;
 *     brittle_pattern_init(&pattern, sizeof pattern);
 *     pattern.count = 100;
 *     if (brittle_mesh_load("bunny.obj", &mesh, &error) || brittle_sites_pattern(&pattern, mesh, &sites, &error)
 *         || brittle_fracture(mesh, sites, NULL, &pieces, &error))
 *         fputs(error.message, stderr);
 *
 * Conventions. Right-handed coordinates, Y up, metres, kilograms, seconds. Triangles are counter-clockwise seen from
 * outside. Quaternions are x, y, z, w. Text is UTF-8. Equal input gives equal output, bit for bit, with any number of
 * threads.
 *
 * Errors. A function that can fail returns a status, 0 for success. `error`, the last argument, may be NULL; else it
 * receives status and message on failure, and is left alone on success. A NULL pointer, a NaN, a count or an index out
 * of range is refused with a message that names it. No exception passes this border. After a failure every output is
 * unchanged, unless stated. A world, a run or a workspace that served a call which returned out_of_memory can only be
 * freed.
 *
 * Ownership. Each handle that a function gives out belongs to the caller, who frees it with the free function of its
 * type; NULL is accepted there. Handles do not depend on each other: a mesh may be freed while its pieces live. An array
 * or a text that a handle gives out is borrowed: it is valid, and does not change, until the handle is freed.
 * Arguments are read during the call only.
 *
 * Threads. Meshes, sites, pieces, surfaces, hulls, files, recipes and events never change after they were made: any number of
 * threads may read one at a time. A world, a run and a workspace serve one thread at a time. Everything else is
 * reentrant.
 *
 * Growth. Structures begin with struct_size, their size in the header that the caller was compiled with. A library
 * gives fields that the caller does not know their defaults, and refuses fields that it does not know itself unless
 * they are zero. The init functions set struct_size and the defaults. */
#ifndef BRITTLE_H
#define BRITTLE_H

#include <stddef.h>
#include <stdint.h>

#if defined(__GNUC__)
#define BRITTLE_API __attribute__((visibility("default")))
#else
#define BRITTLE_API
#endif

#ifdef __cplusplus
extern "C" {
#endif

/* ---- Status ---------------------------------------------------------------------------------------------------- */

typedef int32_t brittle_status;
enum {
    BRITTLE_OK = 0,
    BRITTLE_FILE_NOT_FOUND = 1,     /* the file does not exist, or may not be read */
    BRITTLE_UNSUPPORTED_FORMAT = 2, /* no reader or writer has this file extension */
    BRITTLE_MALFORMED_FILE = 3,     /* the file is damaged, truncated or of another format than its extension says */
    BRITTLE_EMPTY_MESH = 4,         /* there are no triangles */
    BRITTLE_INVALID_MESH = 5,       /* a coordinate is not finite, an index out of range, a vertex repeated */
    BRITTLE_NOT_CLOSED = 6,         /* an edge belongs to one triangle only */
    BRITTLE_NON_MANIFOLD = 7,       /* an edge belongs to three triangles or more */
    BRITTLE_NOT_ORIENTED = 8,       /* adjacent triangles have opposite orientations */
    BRITTLE_INSIDE_OUT = 9,         /* the triangles face inwards */
    BRITTLE_NO_VOLUME = 10,         /* the enclosed volume is zero up to rounding */
    BRITTLE_INVERTED_PART = 11,     /* a piece has negative volume */
    BRITTLE_LOST_VOLUME = 12,       /* the pieces miss more of the volume than rounding explains */
    BRITTLE_INVALID_SITES = 13,     /* there are no sites, or one is not finite or too far away */
    BRITTLE_INVALID_SETTING = 14,   /* a setting is outside its documented range */
    BRITTLE_CANCELLED = 15,         /* the caller cancelled the call */
    BRITTLE_WRITE_FAILED = 16,      /* the output could not be written; an existing file is unchanged */
    BRITTLE_INVALID_ARGUMENT = 17,  /* NULL where it is not allowed, a wrong size, type, index or name */
    BRITTLE_OUT_OF_MEMORY = 18,
    BRITTLE_INTERNAL_ERROR = 19 /* a fault of the library; please report the message */
};

typedef struct brittle_error {
    uint32_t struct_size;
    brittle_status status;
    char message[1016]; /* the fault, its place and the remedy; cut to fit, always terminated */
} brittle_error;

/* "malformed_file" for BRITTLE_MALFORMED_FILE; "unknown" for any other number. The text is static. */
BRITTLE_API const char* brittle_status_name(brittle_status status);
/* The version of the library, for example "0.1.0". The text is static. */
BRITTLE_API const char* brittle_version(void);

/* ---- Memory ---------------------------------------------------------------------------------------------------- */

typedef struct brittle_allocator {
    uint32_t struct_size;
    /* Returns `size` bytes at a multiple of `alignment`, a power of two; or NULL where there are none. */
    void* (*allocate)(void* user, size_t size, size_t alignment);
    /* Takes a block back, with the size and the alignment that it was asked for. */
    void (*release)(void* user, void* block, size_t size, size_t alignment);
    void* user; /* for both */
} brittle_allocator;

/* Gives the library an allocator for the blocks that it asks for from now on; NULL: that of the C library. A block goes
 * back to the allocator that it came from, so handles stay valid, and an allocator must stay valid until all of its
 * blocks came back. Both functions are called by any thread, several at a time, and must not call the library. Where
 * `allocate` returns NULL, the call returns out_of_memory; but functions that load or save meshes and pieces, and those
 * of recipes and runs, take from the C library what it refuses. oneTBB and Bullet (where hulls are made, and in worlds
 * with its engine) have memory of their own. Errors: invalid_argument where only one of the functions is NULL. */
BRITTLE_API brittle_status brittle_set_allocator(const brittle_allocator* allocator, brittle_error* error);

/* ---- Arrays ---------------------------------------------------------------------------------------------------- */

enum { BRITTLE_FLOAT32 = 1, BRITTLE_FLOAT64 = 2, BRITTLE_UINT16 = 3, BRITTLE_UINT32 = 4 };

/* A table of numbers: `rows` rows of `columns` numbers; row k begins `stride` bytes after row k - 1, at any address.
 * In an input a stride of 0 means rows without gaps, and data may be NULL where rows is 0. */
typedef struct brittle_array {
    uint32_t type; /* BRITTLE_FLOAT32, ... */
    uint32_t columns;
    uint64_t rows;
    uint64_t stride;
    const void* data;
} brittle_array;

/* ---- Meshes ---------------------------------------------------------------------------------------------------- */

typedef struct brittle_mesh brittle_mesh;
typedef struct brittle_files brittle_files; /* files in memory */
typedef struct brittle_text brittle_text;

/* Vertex arrays as an engine has them. Unused arrays stay zeroed: {0}. */
typedef struct brittle_mesh_arrays {
    uint32_t struct_size;
    /* 1: vertices at bit-equal positions become one, which closes the seams of normals and texture coordinates; their
     * attributes stay with the corners of the triangles. 0: vertices stay as they are. */
    uint32_t weld;
    brittle_array positions; /* n x 3, FLOAT32 or FLOAT64, metres */
    /* t x 3 or 3t x 1, UINT16 or UINT32. Without rows: each three positions are a triangle. */
    brittle_array triangles;
    brittle_array normals;   /* none, or n x 3, FLOAT32 or FLOAT64 */
    brittle_array uv;        /* none, or n x 2, FLOAT32 or FLOAT64; v points down */
    brittle_array materials; /* none, or t x 1, UINT16 or UINT32: a number of the caller's per triangle, below 65536 */
} brittle_mesh_arrays;

/* Makes a mesh. Errors: invalid_argument (type, columns or rows of an array), invalid_mesh (a coordinate that is not
 * finite or exceeds 1e50, an index out of range), empty_mesh. An open or misoriented mesh is accepted: see
 * brittle_mesh_inspect() and brittle_mesh_repair(). */
BRITTLE_API brittle_status brittle_mesh_from_arrays(const brittle_mesh_arrays* arrays, brittle_mesh** out,
                                                    brittle_error* error);
/* Reads .obj, .stl, .ply, .off, .glb, .gltf or .3ds with materials and textures; vertices at equal positions are welded.
 * Errors: file_not_found, unsupported_format, malformed_file, empty_mesh. */
BRITTLE_API brittle_status brittle_mesh_load(const char* path, brittle_mesh** out, brittle_error* error);
/* The same from the bytes of a file; `extension` names the format, for example ".glb". Files beside it are not read. */
BRITTLE_API brittle_status brittle_mesh_load_memory(const void* bytes, size_t size, const char* extension,
                                                    brittle_mesh** out, brittle_error* error);
/* A procedural shape: "cube", "icosphere:4", "torus", "animal", "statue", ... An unknown name is an invalid_argument,
 * and the message lists all names. */
BRITTLE_API brittle_status brittle_mesh_shape(const char* name, brittle_mesh** out, brittle_error* error);
/* A box around the origin, of the given size in metres (three numbers above 0). */
BRITTLE_API brittle_status brittle_mesh_box(const double* size, brittle_mesh** out, brittle_error* error);
BRITTLE_API void brittle_mesh_free(brittle_mesh* mesh);

/* Writes .glb, .obj, .ply or .stl, by the extension. Errors: unsupported_format, write_failed. */
BRITTLE_API brittle_status brittle_mesh_save(const brittle_mesh* mesh, const char* path, brittle_error* error);
/* The same into memory; `name` is that of the file, with its extension. */
BRITTLE_API brittle_status brittle_mesh_save_memory(const brittle_mesh* mesh, const char* name, brittle_files** out,
                                                    brittle_error* error);

enum {
    BRITTLE_MESH_POSITIONS = 1, /* n x 3 FLOAT64, m */
    BRITTLE_MESH_TRIANGLES = 2, /* t x 3 UINT32 */
    /* Of the corners of the triangles: corner k of triangle t is row 3t + k. No rows where there are none. */
    BRITTLE_MESH_NORMALS = 3, /* 3t x 3 FLOAT32, unit; zero where a corner has none */
    BRITTLE_MESH_UV = 4,      /* 3t x 2 FLOAT32, v down */
    BRITTLE_MESH_UV2 = 5,     /* 3t x 2 FLOAT32, v down */
    BRITTLE_MESH_COLOURS = 6, /* 3t x 4 FLOAT32, linear, with opacity */
    /* t x 1 UINT32: the number of the material in the file or the arrays, or BRITTLE_NO_MATERIAL; no rows where no
     * triangle has one */
    BRITTLE_MESH_MATERIALS = 7
};
BRITTLE_API brittle_status brittle_mesh_array(const brittle_mesh* mesh, uint32_t which, brittle_array* out,
                                              brittle_error* error);

typedef struct brittle_inspection {
    uint32_t struct_size;
    brittle_status refusal; /* the status that brittle_fracture() would return; BRITTLE_OK where it accepts the mesh */
    double box_min[3], box_max[3]; /* m */
    double area;                   /* m^2 */
    double volume;                 /* m^3; meaningless where the mesh is open */
    uint64_t vertices, edges, triangles, components;
    uint64_t open_edges, misoriented_edges, non_manifold_edges, non_manifold_vertices;
    uint64_t flat_triangles, duplicate_triangles;
    uint64_t intersections; /* pairs of triangles that cross, touch or lie on each other */
    uint64_t holes;
} brittle_inspection;

/* Lists the flaws of a mesh. out->struct_size must be set. `report`, which may be NULL, receives a text for people. */
BRITTLE_API brittle_status brittle_mesh_inspect(const brittle_mesh* mesh, brittle_inspection* out,
                                                brittle_text** report, brittle_error* error);

typedef struct brittle_repair_settings {
    uint32_t struct_size;
    uint32_t remesh_holes;  /* new vertices in holes: 0 only where needed, 1 flat, 2 smooth */
    double weld_distance;   /* m, of vertices on rims; negative: 1e-6 of the diagonal; 0: equal positions only */
    double close_holes;     /* m, the longest rim that is closed; infinite by default */
    uint32_t cavities;      /* 1: closed parts inside others are turned inwards */
    uint32_t covered_parts; /* 1: parts wholly inside others are dropped */
} brittle_repair_settings;
BRITTLE_API void brittle_repair_settings_init(brittle_repair_settings* settings, size_t struct_size);

/* Returns a mesh that is closed, oriented and manifold, as far as that is possible; the input stays. `settings` NULL:
 * defaults. `report`, which may be NULL, receives what was done, empty where nothing was. */
BRITTLE_API brittle_status brittle_mesh_repair(const brittle_mesh* mesh, const brittle_repair_settings* settings,
                                               brittle_mesh** out, brittle_text** report, brittle_error* error);
/* Returns one solid of parts that pass through each other. The mesh must be closed. threads: 0 for one per core.
 * Errors: not_closed and the like; no_volume or inside_out where the union is empty. */
BRITTLE_API brittle_status brittle_mesh_unite(const brittle_mesh* mesh, uint32_t threads, brittle_mesh** out,
                                              brittle_text** report, brittle_error* error);

BRITTLE_API const char* brittle_text_get(const brittle_text* text); /* "" for NULL */
BRITTLE_API void brittle_text_free(brittle_text* text);
BRITTLE_API uint64_t brittle_files_count(const brittle_files* files); /* 0 for NULL */
/* File k: its name, bytes and size, each of which may be NULL. The file to open is number 0. */
BRITTLE_API brittle_status brittle_files_get(const brittle_files* files, uint64_t k, const char** name,
                                             const void** bytes, size_t* size, brittle_error* error);
BRITTLE_API void brittle_files_free(brittle_files* files);

/* ---- Sites ----------------------------------------------------------------------------------------------------- */

typedef struct brittle_sites brittle_sites;

typedef struct brittle_pattern {
    uint32_t struct_size;
    uint32_t count;   /* sites */
    const char* kind; /* "uniform", "clustered", "radial", "grid", "bricks", "slices", "splinters", "curve",
                             "curvature" or "thickness"; NULL: "uniform" */
    uint64_t seed;
    double piece_size; /* m; above 0 it replaces count: the intended edge of a piece */
    double jitter;     /* 0 to 1; negative: the default of the kind */
    double focus[3];   /* 0 to 1 along each side of the mesh's box */
    double axis[3];
    double spread;      /* clustered: standard deviation, as a fraction of the box's diagonal */
    double slenderness; /* splinters: length by width */
    double grading;     /* spread of the sizes of cells, 0 to 1 */
    brittle_array line; /* curve: at least two points, k x 3, in the coordinates of focus; without rows: the default */
    uint32_t cells_per_piece; /* 1 to 1000 */
    uint32_t inside;          /* 1, the default: only sites inside the solid; 0: anywhere in its box */
} brittle_pattern;
BRITTLE_API void brittle_pattern_init(brittle_pattern* pattern, size_t struct_size);

/* Makes the sites of a pattern for a mesh; `pattern` NULL: 20 uniform sites inside the solid. Errors: invalid_setting,
 * with the field, its value and its range; invalid_argument for an unknown kind; not_closed and its like where the mesh
 * has no inside. */
BRITTLE_API brittle_status brittle_sites_pattern(const brittle_pattern* pattern, const brittle_mesh* mesh,
                                                 brittle_sites** out, brittle_error* error);
/* Sites of the caller's. `weights` (n x 1 FLOAT32 or FLOAT64, m^2) and `groups` (n x 1 UINT16 or UINT32) may be NULL.
 * A heavier site has a larger cell; the cells of one group become one piece where they touch. */
BRITTLE_API brittle_status brittle_sites_from_arrays(const brittle_array* positions, const brittle_array* weights,
                                                     const brittle_array* groups, brittle_sites** out,
                                                     brittle_error* error);
/* Reads a text file with a site a line: x y z, or x y z radius. */
BRITTLE_API brittle_status brittle_sites_load(const char* path, brittle_sites** out, brittle_error* error);

enum {
    BRITTLE_SITE_POSITIONS = 1, /* n x 3 FLOAT64, m */
    BRITTLE_SITE_WEIGHTS = 2,   /* n x 1 FLOAT64, m^2; no rows where there are none */
    BRITTLE_SITE_GROUPS = 3     /* n x 1 UINT32; no rows where there are none */
};
BRITTLE_API brittle_status brittle_sites_array(const brittle_sites* sites, uint32_t which, brittle_array* out,
                                               brittle_error* error);
BRITTLE_API void brittle_sites_free(brittle_sites* sites);

/* ---- Fracture -------------------------------------------------------------------------------------------------- */

typedef struct brittle_pieces brittle_pieces;
/* Memory that calls of brittle_fracture() reuse. It serves one call at a time. */
typedef struct brittle_workspace brittle_workspace;
BRITTLE_API brittle_status brittle_workspace_create(brittle_workspace** out, brittle_error* error);
BRITTLE_API void brittle_workspace_free(brittle_workspace* workspace);

typedef struct brittle_fracture_settings {
    uint32_t struct_size;
    uint32_t threads;    /* 0: one per core; at most 1024 */
    uint32_t sequential; /* 1: the algorithm of the paper, without min_volume, groups, roughness and bonds */
    /* Octaves of noise on rough cuts, 1 to 6; each one more makes four times as many triangles. */
    uint32_t rough_detail;
    double min_volume;       /* m^3; smaller pieces join a neighbour; 0 keeps all */
    double roughness;        /* of the cuts, from 0 (flat) to 1 */
    double rough_wavelength; /* m, the largest; 0: the typical distance of sites */
    double rough_grain[3];   /* direction of the grain, its length the stretch, 1/16 to 16; zero: none */
    uint64_t rough_seed;
    uint64_t rough_max_triangles; /* a bound of the triangles that roughness adds; octaves are left out for it */
    brittle_workspace* workspace; /* or NULL */
    /* Called with the completed share of the work, 0 to 1, by one thread at a time, on any thread; or NULL. */
    void (*progress)(void* user, double share);
    /* Asked many times, by one thread at a time, on any thread; other than 0 cancels within milliseconds. Or NULL. */
    int32_t (*cancelled)(void* user);
    void* user; /* for both */
    /* Cancels as soon as it is other than 0. Any thread may set it during the call, by an atomic store. Or NULL. */
    const int32_t* cancel_flag;
} brittle_fracture_settings;
BRITTLE_API void brittle_fracture_settings_init(brittle_fracture_settings* settings, size_t struct_size);

/* Cuts the mesh into the watertight pieces of the Voronoi cells of the sites. `settings` NULL: defaults. Errors: those
 * of meshes and sites above, invalid_setting, cancelled. */
BRITTLE_API brittle_status brittle_fracture(const brittle_mesh* mesh, const brittle_sites* sites,
                                            const brittle_fracture_settings* settings, brittle_pieces** out,
                                            brittle_error* error);
BRITTLE_API void brittle_pieces_free(brittle_pieces* pieces);

/* The vertices of piece p are rows vertex_range[p][0] .. vertex_range[p][1] - 1 of the positions. Its triangles are the
 * rows of its triangle range, with indices from 0 at the first of its vertices; those of the outside come first. */
enum {
    BRITTLE_PIECES_POSITIONS = 1,        /* v x 3 FLOAT64, m, of all pieces */
    BRITTLE_PIECES_TRIANGLES = 2,        /* t x 3 UINT32, of all pieces */
    BRITTLE_PIECES_TRIANGLE_SOURCES = 3, /* t x 1 UINT32: outside, the triangle of the mesh; on a cut, the other site */
    BRITTLE_PIECES_VERTEX_RANGES = 4,    /* p x 2 UINT32 */
    BRITTLE_PIECES_TRIANGLE_RANGES = 5,  /* p x 2 UINT32 */
    BRITTLE_PIECES_EXTERIOR_TRIANGLES = 6, /* p x 1 UINT32: how many of the first triangles are outside */
    BRITTLE_PIECES_SITES = 7,              /* p x 1 UINT32 */
    BRITTLE_PIECES_VOLUMES = 8,            /* p x 1 FLOAT64, m^3 */
    BRITTLE_PIECES_AREAS = 9,              /* p x 1 FLOAT64, m^2 */
    BRITTLE_PIECES_CENTRES = 10,           /* p x 3 FLOAT64, centres of mass, m */
    BRITTLE_PIECES_INERTIAS = 11,          /* p x 9 FLOAT64, symmetric 3 x 3 about the centre at density 1, m^5 */
    BRITTLE_PIECES_BONDS = 12,             /* b x 2 UINT32: the two pieces, the lower number first */
    BRITTLE_PIECES_BOND_AREAS = 13,        /* b x 1 FLOAT64, m^2 */
    BRITTLE_PIECES_BOND_CENTROIDS = 14,    /* b x 3 FLOAT64, m */
    BRITTLE_PIECES_BOND_NORMALS = 15       /* b x 3 FLOAT64, unit, from the first to the second piece */
};
BRITTLE_API brittle_status brittle_pieces_array(const brittle_pieces* pieces, uint32_t which, brittle_array* out,
                                                brittle_error* error);

typedef struct brittle_certificate {
    uint32_t struct_size;
    uint32_t pieces;
    uint32_t closed; /* 1: every piece is closed, manifold and oriented */
    uint32_t open_pieces, negative_pieces;
    uint32_t cells;                                  /* sites with at least one piece */
    double volume_input, volume_sum, smallest_piece; /* m^3 */
    double volume_error;                             /* relative */
    uint64_t triangles_in, triangles_out, cap_triangles;
    uint64_t hash; /* of all positions, triangles and pieces; equal on every machine */
} brittle_certificate;
/* What certifies the pieces, computed from them alone. out->struct_size must be set. */
BRITTLE_API brittle_status brittle_pieces_certificate(const brittle_pieces* pieces, brittle_certificate* out,
                                                      brittle_error* error);

/* ---- Render buffers -------------------------------------------------------------------------------------------- */

typedef struct brittle_surface brittle_surface;
#define BRITTLE_NO_MATERIAL 0xffffffffu

/* The surface of one piece for drawing, in parts of one material each: those of the outside, then the cuts. */
BRITTLE_API brittle_status brittle_pieces_surface(const brittle_pieces* pieces, uint32_t piece, brittle_surface** out,
                                                  brittle_error* error);
BRITTLE_API uint64_t brittle_surface_parts(const brittle_surface* surface); /* 0 for NULL */
/* material: the number in the mesh, BRITTLE_NO_MATERIAL for cuts and for a mesh without. interior: 1 for the cuts. */
BRITTLE_API brittle_status brittle_surface_part(const brittle_surface* surface, uint64_t part, uint32_t* material,
                                                uint32_t* interior, brittle_error* error);
enum {
    BRITTLE_SURFACE_POSITIONS = 1, /* v x 3 FLOAT32, m, relative to the centre of mass of the piece */
    BRITTLE_SURFACE_NORMALS = 2,   /* v x 3 FLOAT32, unit */
    BRITTLE_SURFACE_UV = 3,        /* v x 2 FLOAT32, v down; on cuts in metres; no rows where there are none */
    BRITTLE_SURFACE_UV2 = 4,       /* v x 2 FLOAT32, or no rows */
    BRITTLE_SURFACE_COLOURS = 5,   /* v x 4 FLOAT32, linear, or no rows */
    BRITTLE_SURFACE_INDICES = 6,   /* t x 3 UINT32 */
    BRITTLE_SURFACE_VERTICES = 7   /* v x 1 UINT32: the vertex of the piece, counted from its first */
};
BRITTLE_API brittle_status brittle_surface_array(const brittle_surface* surface, uint64_t part, uint32_t which,
                                                 brittle_array* out, brittle_error* error);
BRITTLE_API void brittle_surface_free(brittle_surface* surface);

/* ---- Collision hulls ------------------------------------------------------------------------------------------- */

typedef struct brittle_hulls brittle_hulls;
/* Convex hulls of all pieces. max_parts: hulls of one piece at most, 1 to 256; 1 gives one hull a piece, more follow
 * pieces that are not convex. max_vertices: of one hull, 8 to 255. Hulls lie a small margin inside their pieces, and
 * have no corner that reaches less than 5 thousandths of their extent: engines in single precision push pieces apart
 * along the narrow faces beside such corners. */
BRITTLE_API brittle_status brittle_pieces_hulls(const brittle_pieces* pieces, uint32_t max_parts, uint32_t max_vertices,
                                                brittle_hulls** out, brittle_error* error);
enum {
    BRITTLE_HULL_POINTS = 1, /* n x 3 FLOAT32, m, relative to the centre of mass of the piece */
    BRITTLE_HULL_RANGES = 2, /* h x 2 UINT32: the points of each hull, first and end */
    BRITTLE_HULL_PIECES = 3, /* h x 1 UINT32, ascending: the piece of each hull */
    BRITTLE_HULL_MARGINS = 4 /* h x 1 FLOAT32, m: thickness of the collision shell around the points */
};
BRITTLE_API brittle_status brittle_hulls_array(const brittle_hulls* hulls, uint32_t which, brittle_array* out,
                                               brittle_error* error);
BRITTLE_API void brittle_hulls_free(brittle_hulls* hulls);

/* ---- Export ---------------------------------------------------------------------------------------------------- */

typedef struct brittle_export_settings {
    uint32_t struct_size;
    uint32_t per_piece;    /* 1: a file a piece, NAME_000.glb, ... */
    const char* name;      /* of the root node, and the start of each piece's name; NULL: "mesh" */
    uint32_t hulls;        /* GLB: names by which 0 no engine, 1 Godot, 2 Unreal makes bodies of the pieces */
    uint32_t rigid_bodies; /* GLB: 1 for masses and hulls with KHR_physics_rigid_bodies, a draft */
    double density;        /* kg/m^3, for rigid_bodies */
    uint32_t hull_parts;   /* hulls of one piece at most, 1 to 256, for Unreal and rigid_bodies */
} brittle_export_settings;
BRITTLE_API void brittle_export_settings_init(brittle_export_settings* settings, size_t struct_size);
/* Writes .glb, .obj, .ply or .stl. The materials and textures of the mesh carry over. `settings` NULL: defaults. */
BRITTLE_API brittle_status brittle_pieces_save(const brittle_pieces* pieces, const char* path,
                                               const brittle_export_settings* settings, brittle_error* error);
/* The same into memory; `name` is that of the file, with its extension. */
BRITTLE_API brittle_status brittle_pieces_save_memory(const brittle_pieces* pieces, const char* name,
                                                      const brittle_export_settings* settings, brittle_files** out,
                                                      brittle_error* error);

/* ---- Materials ------------------------------------------------------------------------------------------------- */

/* Handbook values of a material, and how it breaks and looks. */
typedef struct brittle_material {
    uint32_t struct_size;
    uint32_t rough_detail; /* as in brittle_fracture_settings */
    const char* name;      /* static text */
    double density;        /* kg/m^3 */
    double friction, restitution;
    double tensile, compressive, shear; /* strengths, Pa */
    double fracture_toughness;          /* K_IC, Pa m^1/2 */
    double fracture_energy;             /* J/m^2, that a blow spends on new surface */
    const char* pattern;                /* kind of brittle_pattern, static text; the next four are its fields */
    double pattern_jitter, pattern_spread, pattern_slenderness;
    double pattern_axis[3];
    double roughness, rough_grain[3]; /* as in brittle_fracture_settings */
    double exterior[3], interior[3];  /* linear colours of the original surface and of cuts */
} brittle_material;
/* "glass", "stone", "concrete", "wood", "ceramic" and "brick" for 0 to 5; NULL beyond. The text is static. */
BRITTLE_API const char* brittle_material_name(uint32_t index);
/* out->struct_size must be set. An unknown name is an invalid_argument, and the message lists all names. */
BRITTLE_API brittle_status brittle_material_get(const char* name, brittle_material* out, brittle_error* error);

/* ---- Destruction ----------------------------------------------------------------------------------------------- */

typedef struct brittle_world brittle_world;
typedef struct brittle_events brittle_events;

typedef struct brittle_world_settings {
    uint32_t struct_size;
    uint32_t bullet;     /* 1: stock Bullet in place of Brittle's own solver */
    uint32_t threads;    /* of a step; 0: one per core */
    uint32_t workers;    /* threads that cut, 1 to 64 */
    uint32_t max_pieces; /* of debris; beyond it the oldest and smallest pieces fade away */
    uint32_t latency;    /* steps from a blow to its pieces, at least 1 */
    uint32_t has_ground; /* 1: a plane y = ground_height */
    float ground_height; /* m */
    float gravity[3];    /* m/s^2 */
    float step;          /* s */
} brittle_world_settings;
BRITTLE_API void brittle_world_settings_init(brittle_world_settings* settings, size_t struct_size);
BRITTLE_API brittle_status brittle_world_create(const brittle_world_settings* settings, brittle_world** out,
                                                brittle_error* error);
BRITTLE_API void brittle_world_free(brittle_world* world);

/* A ball in which the world holds an object: pieces that reach into it are fixed. */
typedef struct brittle_anchor {
    double centre[3]; /* m, in the coordinates of the mesh */
    double radius;    /* m, above 0 */
} brittle_anchor;

typedef struct brittle_object_settings {
    uint32_t struct_size;
    uint32_t max_pieces;  /* of one blow, 2 to 10000 */
    const char* material; /* "glass", "stone", "concrete", "wood", "ceramic" or "brick"; NULL: "stone" */
    double strength;      /* share of the material's handbook strength, above 0; flaws leave 0.1 */
    double min_size;      /* m, cube root of the smallest piece's volume */
    double roughness;     /* of the cuts, 0 to 1; negative: that of the material */
    uint64_t seed;
    float position[3];                             /* m, of the mesh's origin in the world */
    float orientation[4];                          /* unit quaternion x, y, z, w */
    float linear_velocity[3], angular_velocity[3]; /* m/s, rad/s */
    const brittle_anchor* anchors;
    uint32_t anchor_count;
} brittle_object_settings;
BRITTLE_API void brittle_object_settings_init(brittle_object_settings* settings, size_t struct_size);

/* Adds a whole object that blows break. `object`, which may be NULL, receives its number. Errors: those of
 * brittle_fracture() for the mesh; invalid_setting. */
BRITTLE_API brittle_status brittle_world_add_breakable(brittle_world* world, const brittle_mesh* mesh,
                                                       const brittle_object_settings* settings, uint32_t* object,
                                                       brittle_error* error);
/* Adds the pieces of a fracture, bonded where they touch. Blows break bonds, and then pieces. */
BRITTLE_API brittle_status brittle_world_add_bonded(brittle_world* world, const brittle_pieces* pieces,
                                                    const brittle_object_settings* settings, uint32_t* object,
                                                    brittle_error* error);
/* Removes an object with all its pieces. */
BRITTLE_API brittle_status brittle_world_remove(brittle_world* world, uint32_t object, brittle_error* error);
/* Strikes a piece at a point (three floats, m) along a direction into it (three floats), as a hammer of one kilogram
 * does with this energy in joules, above 0. The pieces get no impulse. `broke`, which may be NULL, receives 1 where the
 * blow breaks the piece; the new pieces come some steps later. */
BRITTLE_API brittle_status brittle_world_strike(brittle_world* world, uint32_t piece, const float* point,
                                                const float* direction, double energy, uint32_t* broke,
                                                brittle_error* error);
/* Adds a ball: where it is (m), its velocity (m/s), radius (m) and density (kg/m^3). `body` may be NULL. */
BRITTLE_API brittle_status brittle_world_shoot(brittle_world* world, const float* from, const float* velocity,
                                               float radius, float density, uint32_t* body, brittle_error* error);
/* The pose of a body that brittle_world_shoot() added: position (three floats) and orientation (four floats). */
BRITTLE_API brittle_status brittle_world_body(const brittle_world* world, uint32_t body, float* position,
                                              float* orientation, brittle_error* error);
/* Takes `steps` steps of the world's time step. */
BRITTLE_API brittle_status brittle_world_step(brittle_world* world, uint32_t steps, brittle_error* error);

/* A hash of the whole state: equal runs give equal hashes, with any number of threads. */
BRITTLE_API brittle_status brittle_world_state_hash(const brittle_world* world, uint64_t* out, brittle_error* error);

typedef struct brittle_transform {
    uint32_t piece;
    uint32_t slot;        /* a small index of the piece, used again once the piece is gone */
    float position[3];    /* m, of the centre of mass */
    float orientation[4]; /* x, y, z, w */
} brittle_transform;
/* The poses of all pieces, in ascending order of the piece. alpha: from 0, the state before the last step, to 1, the
 * state after it. `count` receives their number; `out` may be NULL to ask for it, and receives at most `capacity`. */
BRITTLE_API brittle_status brittle_world_transforms(const brittle_world* world, float alpha, brittle_transform* out,
                                                    uint64_t capacity, uint64_t* count, brittle_error* error);

/* What changed since the last call. Apply removals before additions, because slots are used again. */
BRITTLE_API brittle_status brittle_world_events(brittle_world* world, brittle_events** out, brittle_error* error);
enum {
    BRITTLE_EVENTS_REMOVED = 1,      /* r x 2 UINT32: piece, slot */
    BRITTLE_EVENTS_ADDED = 2,        /* a x 5 UINT32: piece, object, slot, depth (cuts so far), parent or 0xffffffff */
    BRITTLE_EVENTS_FADING = 3,       /* f x 2 UINT32: piece, slot */
    BRITTLE_EVENTS_FADING_SHARES = 4 /* f x 1 FLOAT32: visible share, falling from 1 to 0 */
};
BRITTLE_API brittle_status brittle_events_array(const brittle_events* events, uint32_t which, brittle_array* out,
                                                brittle_error* error);
enum {
    BRITTLE_ADDED_POSITIONS = 1, /* v x 3 FLOAT32, m, relative to the centre of mass */
    BRITTLE_ADDED_TRIANGLES = 2, /* t x 3 UINT32, those of the outside first */
    BRITTLE_ADDED_CENTRE = 3     /* 1 x 3 FLOAT64, m, centre of mass in the coordinates of the unbroken object */
};
/* The mesh of the added piece in row `row`. exterior_triangles, which may be NULL: how many lie outside. */
BRITTLE_API brittle_status brittle_events_added_array(const brittle_events* events, uint64_t row, uint32_t which,
                                                      brittle_array* out, uint32_t* exterior_triangles,
                                                      brittle_error* error);
BRITTLE_API void brittle_events_free(brittle_events* events);

/* ---- Recipes --------------------------------------------------------------------------------------------------- */

/* A recipe (docs/scenes.md, assets/recipe.schema.json): a mesh or a scene, how it breaks, and its world. It never
 * changes after it was made. */
typedef struct brittle_recipe brittle_recipe;

/* Long calls of recipes, runs and replays. */
typedef struct brittle_load_settings {
    uint32_t struct_size;
    uint32_t threads; /* 0: one per core; at most 1024 */
    /* Called with the completed share of the work, 0 to 1, by one thread at a time, on any thread; or NULL. */
    void (*progress)(void* user, double share);
    /* Asked many times, on any thread, also at once; other than 0 cancels. Or NULL. */
    int32_t (*cancelled)(void* user);
    /* Told what was done to a mesh (repair, union), in lines without the last end; or NULL. */
    void (*report)(void* user, const char* text);
    void* user; /* for all three */
    /* Cancels as soon as it is other than 0. Any thread may set it during the call, by an atomic store. Or NULL. */
    const int32_t* cancel_flag;
} brittle_load_settings;
BRITTLE_API void brittle_load_settings_init(brittle_load_settings* settings, size_t struct_size);

/* Reads a recipe; paths in it count from its folder. Errors: file_not_found, malformed_file with a message that names
 * the file, the place in it and the expected value. */
BRITTLE_API brittle_status brittle_recipe_load(const char* path, brittle_recipe** out, brittle_error* error);
/* The same from JSON text of at most 1 MiB. Paths in it count from `folder`; NULL: the working folder. */
BRITTLE_API brittle_status brittle_recipe_parse(const char* json, const char* folder, brittle_recipe** out,
                                                brittle_error* error);
/* The recipe with all its settings, as JSON; paths count from the working folder. */
BRITTLE_API brittle_status brittle_recipe_text(const brittle_recipe* recipe, brittle_text** out, brittle_error* error);
/* Writes it; paths count from the folder of the file. Errors: write_failed. */
BRITTLE_API brittle_status brittle_recipe_save(const brittle_recipe* recipe, const char* path, brittle_error* error);
/* Breaks the mesh of a recipe, in the coordinates of its file: the pieces of `brittle fracture RECIPE`, with the same
 * hash. A scene is refused with invalid_setting: see brittle_run_start(). Errors: those of meshes and of
 * brittle_fracture(). */
BRITTLE_API brittle_status brittle_recipe_fracture(const brittle_recipe* recipe, const brittle_load_settings* settings,
                                                   brittle_pieces** out, brittle_error* error);
BRITTLE_API void brittle_recipe_free(brittle_recipe* recipe);

/* ---- Runs ------------------------------------------------------------------------------------------------------ */

/* The simulation of a recipe, as `brittle render` and `brittle replay` run it: steps of 1/120 s, its shots at their
 * times, and a log of all that happens. A single mesh stands on the stage as in pictures, 2 m large unless the recipe
 * has units. It serves one thread at a time. */
typedef struct brittle_run brittle_run;

/* Loads, breaks and prepares what the recipe holds. Errors: those of meshes and of brittle_fracture(). A mesh of a scene
 * that cannot be broken becomes a fixed object: see brittle_run_notes(). */
BRITTLE_API brittle_status brittle_run_start(const brittle_recipe* recipe, const brittle_load_settings* settings,
                                             brittle_run** out, brittle_error* error);
BRITTLE_API void brittle_run_free(brittle_run* run);
/* Lines for people about objects that the scene could not take as the recipe says; often empty. */
BRITTLE_API brittle_status brittle_run_notes(const brittle_run* run, brittle_text** out, brittle_error* error);
BRITTLE_API brittle_status brittle_run_step(brittle_run* run, uint32_t steps, brittle_error* error);
/* Steps since the start, and the length of one, s. Either may be NULL. */
BRITTLE_API brittle_status brittle_run_time(const brittle_run* run, uint64_t* steps, double* step_seconds,
                                            brittle_error* error);
/* Takes an action between two steps, written as in a replay log (docs/replay.md, assets/replay.schema.json):
 *     {"shoot": {"from": [0, 1, 3], "velocity": [0, 0, -20], "radius": 0.1, "density": 7800}}
 * Errors: malformed_file with the field that is wrong. */
BRITTLE_API brittle_status brittle_run_act(brittle_run* run, const char* action, brittle_error* error);
/* A hash of the whole state, that of a replay log: equal runs give equal hashes, with any number of threads. */
BRITTLE_API brittle_status brittle_run_state_hash(const brittle_run* run, uint64_t* out, brittle_error* error);
/* The poses of all pieces after the last step, as brittle_world_transforms() gives them. Where the recipe is not
 * breakable, a piece keeps its number and its slot is the same. */
BRITTLE_API brittle_status brittle_run_transforms(const brittle_run* run, brittle_transform* out, uint64_t capacity,
                                                  uint64_t* count, brittle_error* error);
typedef struct brittle_ball {
    float position[3];    /* m */
    float orientation[4]; /* x, y, z, w */
    float radius;         /* m */
} brittle_ball;
/* Balls that were shot, and links of chains, after the last step. `out` may be NULL to ask for their number. */
BRITTLE_API brittle_status brittle_run_balls(const brittle_run* run, brittle_ball* out, uint64_t capacity,
                                             uint64_t* count, brittle_error* error);
/* What changed since the last call, as brittle_world_events() says it: in the first call all pieces of the start. No
 * events where the recipe is not breakable: the pieces stay those of brittle_run_object_pieces(). */
BRITTLE_API brittle_status brittle_run_events(brittle_run* run, brittle_events** out, brittle_error* error);

/* An object of the run at its start; a recipe of one mesh has one. The texts are borrowed from the run. */
typedef struct brittle_run_object {
    uint32_t struct_size;
    uint32_t is_fixed; /* 1: a surface that never moves */
    const char* name;
    const char* material; /* "" for none */
    float position[3];    /* m, of the object's origin in the world, at the start */
    float orientation[4]; /* x, y, z, w */
    uint32_t piece_count; /* at the start; 1 where it is fixed */
} brittle_run_object;
BRITTLE_API brittle_status brittle_run_object_count(const brittle_run* run, uint32_t* out, brittle_error* error);
/* out->struct_size must be set. */
BRITTLE_API brittle_status brittle_run_object_get(const brittle_run* run, uint32_t object, brittle_run_object* out,
                                                  brittle_error* error);
/* The pieces of an object at the start, in its coordinates. A fixed object is refused with invalid_argument. */
BRITTLE_API brittle_status brittle_run_object_pieces(const brittle_run* run, uint32_t object, brittle_pieces** out,
                                                     brittle_error* error);
/* The unbroken mesh of an object, in its coordinates. */
BRITTLE_API brittle_status brittle_run_object_mesh(const brittle_run* run, uint32_t object, brittle_mesh** out,
                                                   brittle_error* error);
/* Writes the replay log of the run so far. Errors: write_failed. */
BRITTLE_API brittle_status brittle_run_save_log(const brittle_run* run, const char* path, brittle_error* error);

typedef struct brittle_replay_result {
    uint32_t struct_size;
    uint32_t is_equal;         /* 1: every state was that of the log */
    uint64_t steps, actions;   /* of the log */
    uint64_t first_difference; /* the first step whose state differs; 0: the start, such as other pieces */
    uint64_t state_hash;       /* of the last state that was reached */
    char difference[1016];     /* what differs, for people; "" where nothing does */
} brittle_replay_result;
/* Repeats the run of a replay log up to its end or the first difference. A difference is no error. Where the recipe now
 * gives other pieces than those of the log, no step is taken and no action applied. Errors: malformed_file with line
 * and field, those of brittle_run_start(). out->struct_size must be set. */
BRITTLE_API brittle_status brittle_replay(const char* path, const brittle_load_settings* settings,
                                          brittle_replay_result* out, brittle_error* error);

#ifdef __cplusplus
}
#endif

#endif
