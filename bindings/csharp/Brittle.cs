// Brittle for C#: the declarations of brittle.h, which explains all of them.
// Written by tools/declare-bindings. Compile with -unsafe. Text that comes out is UTF-8:
// Marshal.PtrToStringAnsi((IntPtr)text) reads it where it is ASCII, Marshal.PtrToStringUTF8 anywhere.
using System;
using System.Runtime.InteropServices;

public static unsafe class Brittle
{
    private const string Library = "brittle";

    public const int BRITTLE_OK = 0;
    public const int BRITTLE_FILE_NOT_FOUND = 1;
    public const int BRITTLE_UNSUPPORTED_FORMAT = 2;
    public const int BRITTLE_MALFORMED_FILE = 3;
    public const int BRITTLE_EMPTY_MESH = 4;
    public const int BRITTLE_INVALID_MESH = 5;
    public const int BRITTLE_NOT_CLOSED = 6;
    public const int BRITTLE_NON_MANIFOLD = 7;
    public const int BRITTLE_NOT_ORIENTED = 8;
    public const int BRITTLE_INSIDE_OUT = 9;
    public const int BRITTLE_NO_VOLUME = 10;
    public const int BRITTLE_INVERTED_PART = 11;
    public const int BRITTLE_LOST_VOLUME = 12;
    public const int BRITTLE_INVALID_SITES = 13;
    public const int BRITTLE_INVALID_SETTING = 14;
    public const int BRITTLE_CANCELLED = 15;
    public const int BRITTLE_WRITE_FAILED = 16;
    public const int BRITTLE_INVALID_ARGUMENT = 17;
    public const int BRITTLE_OUT_OF_MEMORY = 18;
    public const int BRITTLE_INTERNAL_ERROR = 19;
    public const uint BRITTLE_FLOAT32 = 1;
    public const uint BRITTLE_FLOAT64 = 2;
    public const uint BRITTLE_UINT16 = 3;
    public const uint BRITTLE_UINT32 = 4;
    public const uint BRITTLE_MESH_POSITIONS = 1;
    public const uint BRITTLE_MESH_TRIANGLES = 2;
    public const uint BRITTLE_MESH_NORMALS = 3;
    public const uint BRITTLE_MESH_UV = 4;
    public const uint BRITTLE_MESH_UV2 = 5;
    public const uint BRITTLE_MESH_COLOURS = 6;
    public const uint BRITTLE_MESH_MATERIALS = 7;
    public const uint BRITTLE_SITE_POSITIONS = 1;
    public const uint BRITTLE_SITE_WEIGHTS = 2;
    public const uint BRITTLE_SITE_GROUPS = 3;
    public const uint BRITTLE_PIECES_POSITIONS = 1;
    public const uint BRITTLE_PIECES_TRIANGLES = 2;
    public const uint BRITTLE_PIECES_TRIANGLE_SOURCES = 3;
    public const uint BRITTLE_PIECES_VERTEX_RANGES = 4;
    public const uint BRITTLE_PIECES_TRIANGLE_RANGES = 5;
    public const uint BRITTLE_PIECES_EXTERIOR_TRIANGLES = 6;
    public const uint BRITTLE_PIECES_SITES = 7;
    public const uint BRITTLE_PIECES_VOLUMES = 8;
    public const uint BRITTLE_PIECES_AREAS = 9;
    public const uint BRITTLE_PIECES_CENTRES = 10;
    public const uint BRITTLE_PIECES_INERTIAS = 11;
    public const uint BRITTLE_PIECES_BONDS = 12;
    public const uint BRITTLE_PIECES_BOND_AREAS = 13;
    public const uint BRITTLE_PIECES_BOND_CENTROIDS = 14;
    public const uint BRITTLE_PIECES_BOND_NORMALS = 15;
    public const uint BRITTLE_NO_MATERIAL = 0xffffffff;
    public const uint BRITTLE_SURFACE_POSITIONS = 1;
    public const uint BRITTLE_SURFACE_NORMALS = 2;
    public const uint BRITTLE_SURFACE_UV = 3;
    public const uint BRITTLE_SURFACE_UV2 = 4;
    public const uint BRITTLE_SURFACE_COLOURS = 5;
    public const uint BRITTLE_SURFACE_INDICES = 6;
    public const uint BRITTLE_SURFACE_VERTICES = 7;
    public const uint BRITTLE_HULL_POINTS = 1;
    public const uint BRITTLE_HULL_RANGES = 2;
    public const uint BRITTLE_HULL_PIECES = 3;
    public const uint BRITTLE_HULL_MARGINS = 4;
    public const uint BRITTLE_EVENTS_REMOVED = 1;
    public const uint BRITTLE_EVENTS_ADDED = 2;
    public const uint BRITTLE_EVENTS_FADING = 3;
    public const uint BRITTLE_EVENTS_FADING_SHARES = 4;
    public const uint BRITTLE_ADDED_POSITIONS = 1;
    public const uint BRITTLE_ADDED_TRIANGLES = 2;
    public const uint BRITTLE_ADDED_CENTRE = 3;

    public struct brittle_mesh { }

    public struct brittle_files { }

    public struct brittle_text { }

    public struct brittle_sites { }

    public struct brittle_pieces { }

    public struct brittle_workspace { }

    public struct brittle_surface { }

    public struct brittle_hulls { }

    public struct brittle_world { }

    public struct brittle_events { }

    public struct brittle_recipe { }

    public struct brittle_run { }

    [StructLayout(LayoutKind.Sequential)]
    public struct brittle_error
    {
        public uint struct_size;
        public int status;
        public fixed byte message[1016];
    }

    [StructLayout(LayoutKind.Sequential)]
    public struct brittle_allocator
    {
        public uint struct_size;
        public IntPtr allocate; // a delegate, by Marshal.GetFunctionPointerForDelegate
        public IntPtr release; // a delegate, by Marshal.GetFunctionPointerForDelegate
        public void* user;
    }

    /// <summary>A table of numbers: `rows` rows of `columns` numbers; row k begins `stride` bytes after row k - 1, at any address. In an input a stride of 0 means rows without gaps, and data may be NULL where rows is 0.</summary>
    [StructLayout(LayoutKind.Sequential)]
    public struct brittle_array
    {
        public uint type;
        public uint columns;
        public ulong rows;
        public ulong stride;
        public void* data;
    }

    /// <summary>Vertex arrays as an engine has them. Unused arrays stay zeroed: {0}.</summary>
    [StructLayout(LayoutKind.Sequential)]
    public struct brittle_mesh_arrays
    {
        public uint struct_size;
        public uint weld;
        public brittle_array positions;
        public brittle_array triangles;
        public brittle_array normals;
        public brittle_array uv;
        public brittle_array materials;
    }

    [StructLayout(LayoutKind.Sequential)]
    public struct brittle_inspection
    {
        public uint struct_size;
        public int refusal;
        public fixed double box_min[3];
        public fixed double box_max[3];
        public double area;
        public double volume;
        public ulong vertices;
        public ulong edges;
        public ulong triangles;
        public ulong components;
        public ulong open_edges;
        public ulong misoriented_edges;
        public ulong non_manifold_edges;
        public ulong non_manifold_vertices;
        public ulong flat_triangles;
        public ulong duplicate_triangles;
        public ulong intersections;
        public ulong holes;
    }

    [StructLayout(LayoutKind.Sequential)]
    public struct brittle_repair_settings
    {
        public uint struct_size;
        public uint remesh_holes;
        public double weld_distance;
        public double close_holes;
        public uint cavities;
        public uint covered_parts;
    }

    [StructLayout(LayoutKind.Sequential)]
    public struct brittle_pattern
    {
        public uint struct_size;
        public uint count;
        public byte* kind;
        public ulong seed;
        public double piece_size;
        public double jitter;
        public fixed double focus[3];
        public fixed double axis[3];
        public double spread;
        public double slenderness;
        public double grading;
        public brittle_array line;
        public uint cells_per_piece;
        public uint inside;
    }

    [StructLayout(LayoutKind.Sequential)]
    public struct brittle_fracture_settings
    {
        public uint struct_size;
        public uint threads;
        public uint sequential;
        public uint rough_detail;
        public double min_volume;
        public double roughness;
        public double rough_wavelength;
        public fixed double rough_grain[3];
        public ulong rough_seed;
        public ulong rough_max_triangles;
        public brittle_workspace* workspace;
        public IntPtr progress; // a delegate, by Marshal.GetFunctionPointerForDelegate
        public IntPtr cancelled; // a delegate, by Marshal.GetFunctionPointerForDelegate
        public void* user;
        public int* cancel_flag;
    }

    [StructLayout(LayoutKind.Sequential)]
    public struct brittle_certificate
    {
        public uint struct_size;
        public uint pieces;
        public uint closed;
        public uint open_pieces;
        public uint negative_pieces;
        public uint cells;
        public double volume_input;
        public double volume_sum;
        public double smallest_piece;
        public double volume_error;
        public ulong triangles_in;
        public ulong triangles_out;
        public ulong cap_triangles;
        public ulong hash;
    }

    [StructLayout(LayoutKind.Sequential)]
    public struct brittle_export_settings
    {
        public uint struct_size;
        public uint per_piece;
        public byte* name;
        public uint hulls;
        public uint rigid_bodies;
        public double density;
        public uint hull_parts;
    }

    /// <summary>Handbook values of a material, and how it breaks and looks.</summary>
    [StructLayout(LayoutKind.Sequential)]
    public struct brittle_material
    {
        public uint struct_size;
        public uint rough_detail;
        public byte* name;
        public double density;
        public double friction;
        public double restitution;
        public double tensile;
        public double compressive;
        public double shear;
        public double fracture_toughness;
        public double fracture_energy;
        public byte* pattern;
        public double pattern_jitter;
        public double pattern_spread;
        public double pattern_slenderness;
        public fixed double pattern_axis[3];
        public double roughness;
        public fixed double rough_grain[3];
        public fixed double exterior[3];
        public fixed double interior[3];
    }

    [StructLayout(LayoutKind.Sequential)]
    public struct brittle_world_settings
    {
        public uint struct_size;
        public uint bullet;
        public uint threads;
        public uint workers;
        public uint max_pieces;
        public uint latency;
        public uint has_ground;
        public float ground_height;
        public fixed float gravity[3];
        public float step;
    }

    /// <summary>A ball in which the world holds an object: pieces that reach into it are fixed.</summary>
    [StructLayout(LayoutKind.Sequential)]
    public struct brittle_anchor
    {
        public fixed double centre[3];
        public double radius;
    }

    [StructLayout(LayoutKind.Sequential)]
    public struct brittle_object_settings
    {
        public uint struct_size;
        public uint max_pieces;
        public byte* material;
        public double strength;
        public double min_size;
        public double roughness;
        public ulong seed;
        public fixed float position[3];
        public fixed float orientation[4];
        public fixed float linear_velocity[3];
        public fixed float angular_velocity[3];
        public brittle_anchor* anchors;
        public uint anchor_count;
    }

    [StructLayout(LayoutKind.Sequential)]
    public struct brittle_transform
    {
        public uint piece;
        public uint slot;
        public fixed float position[3];
        public fixed float orientation[4];
    }

    /// <summary>Long calls of recipes, runs and replays.</summary>
    [StructLayout(LayoutKind.Sequential)]
    public struct brittle_load_settings
    {
        public uint struct_size;
        public uint threads;
        public IntPtr progress; // a delegate, by Marshal.GetFunctionPointerForDelegate
        public IntPtr cancelled; // a delegate, by Marshal.GetFunctionPointerForDelegate
        public IntPtr report; // a delegate, by Marshal.GetFunctionPointerForDelegate
        public void* user;
        public int* cancel_flag;
    }

    [StructLayout(LayoutKind.Sequential)]
    public struct brittle_ball
    {
        public fixed float position[3];
        public fixed float orientation[4];
        public float radius;
    }

    /// <summary>An object of the run at its start; a recipe of one mesh has one. The texts are borrowed from the run.</summary>
    [StructLayout(LayoutKind.Sequential)]
    public struct brittle_run_object
    {
        public uint struct_size;
        public uint is_fixed;
        public byte* name;
        public byte* material;
        public fixed float position[3];
        public fixed float orientation[4];
        public uint piece_count;
    }

    [StructLayout(LayoutKind.Sequential)]
    public struct brittle_replay_result
    {
        public uint struct_size;
        public uint is_equal;
        public ulong steps;
        public ulong actions;
        public ulong first_difference;
        public ulong state_hash;
        public fixed byte difference[1016];
    }

    /// <summary>"malformed_file" for BRITTLE_MALFORMED_FILE; "unknown" for any other number. The text is static.</summary>
    [DllImport(Library, CallingConvention = CallingConvention.Cdecl)]
    public static extern byte* brittle_status_name(int status);

    /// <summary>The version of the library, for example "0.1.0". The text is static.</summary>
    [DllImport(Library, CallingConvention = CallingConvention.Cdecl)]
    public static extern byte* brittle_version();

    /// <summary>Gives the library an allocator for the blocks that it asks for from now on; NULL: that of the C library. A block goes back to the allocator that it came from, so handles stay valid, and an allocator must stay valid until all of its blocks came back. Both functions are called by any thread, several at a time, and must not call the library. Where `allocate` returns NULL, the call returns out_of_memory; but functions that load or save meshes and pieces, and those of recipes and runs, take from the C library what it refuses. oneTBB and Bullet (where hulls are made, and in worlds with its engine) have memory of their own. Errors: invalid_argument where only one of the functions is NULL.</summary>
    [DllImport(Library, CallingConvention = CallingConvention.Cdecl)]
    public static extern int brittle_set_allocator(brittle_allocator* allocator, brittle_error* error);

    /// <summary>Makes a mesh. Errors: invalid_argument (type, columns or rows of an array), invalid_mesh (a coordinate that is not finite or exceeds 1e50, an index out of range), empty_mesh. An open or misoriented mesh is accepted: see brittle_mesh_inspect() and brittle_mesh_repair().</summary>
    [DllImport(Library, CallingConvention = CallingConvention.Cdecl)]
    public static extern int brittle_mesh_from_arrays(brittle_mesh_arrays* arrays, brittle_mesh** @out, brittle_error* error);

    /// <summary>Reads .obj, .stl, .ply, .off, .glb, .gltf or .3ds with materials and textures; vertices at equal positions are welded. Errors: file_not_found, unsupported_format, malformed_file, empty_mesh.</summary>
    [DllImport(Library, CallingConvention = CallingConvention.Cdecl)]
    public static extern int brittle_mesh_load([MarshalAs(UnmanagedType.LPUTF8Str)] string path, brittle_mesh** @out, brittle_error* error);

    /// <summary>The same from the bytes of a file; `extension` names the format, for example ".glb". Files beside it are not read.</summary>
    [DllImport(Library, CallingConvention = CallingConvention.Cdecl)]
    public static extern int brittle_mesh_load_memory(void* bytes, UIntPtr size, [MarshalAs(UnmanagedType.LPUTF8Str)] string extension, brittle_mesh** @out, brittle_error* error);

    /// <summary>A procedural shape: "cube", "icosphere:4", "torus", "animal", "statue", ... An unknown name is an invalid_argument, and the message lists all names.</summary>
    [DllImport(Library, CallingConvention = CallingConvention.Cdecl)]
    public static extern int brittle_mesh_shape([MarshalAs(UnmanagedType.LPUTF8Str)] string name, brittle_mesh** @out, brittle_error* error);

    /// <summary>A box around the origin, of the given size in metres (three numbers above 0).</summary>
    [DllImport(Library, CallingConvention = CallingConvention.Cdecl)]
    public static extern int brittle_mesh_box(double* size, brittle_mesh** @out, brittle_error* error);

    [DllImport(Library, CallingConvention = CallingConvention.Cdecl)]
    public static extern void brittle_mesh_free(brittle_mesh* mesh);

    /// <summary>Writes .glb, .obj, .ply or .stl, by the extension. Errors: unsupported_format, write_failed.</summary>
    [DllImport(Library, CallingConvention = CallingConvention.Cdecl)]
    public static extern int brittle_mesh_save(brittle_mesh* mesh, [MarshalAs(UnmanagedType.LPUTF8Str)] string path, brittle_error* error);

    /// <summary>The same into memory; `name` is that of the file, with its extension.</summary>
    [DllImport(Library, CallingConvention = CallingConvention.Cdecl)]
    public static extern int brittle_mesh_save_memory(brittle_mesh* mesh, [MarshalAs(UnmanagedType.LPUTF8Str)] string name, brittle_files** @out, brittle_error* error);

    [DllImport(Library, CallingConvention = CallingConvention.Cdecl)]
    public static extern int brittle_mesh_array(brittle_mesh* mesh, uint which, brittle_array* @out, brittle_error* error);

    /// <summary>Lists the flaws of a mesh. out-&gt;struct_size must be set. `report`, which may be NULL, receives a text for people.</summary>
    [DllImport(Library, CallingConvention = CallingConvention.Cdecl)]
    public static extern int brittle_mesh_inspect(brittle_mesh* mesh, brittle_inspection* @out, brittle_text** report, brittle_error* error);

    [DllImport(Library, CallingConvention = CallingConvention.Cdecl)]
    public static extern void brittle_repair_settings_init(brittle_repair_settings* settings, UIntPtr struct_size);

    /// <summary>Returns a mesh that is closed, oriented and manifold, as far as that is possible; the input stays. `settings` NULL: defaults. `report`, which may be NULL, receives what was done, empty where nothing was.</summary>
    [DllImport(Library, CallingConvention = CallingConvention.Cdecl)]
    public static extern int brittle_mesh_repair(brittle_mesh* mesh, brittle_repair_settings* settings, brittle_mesh** @out, brittle_text** report, brittle_error* error);

    /// <summary>Returns one solid of parts that pass through each other. The mesh must be closed. threads: 0 for one per core. Errors: not_closed and the like; no_volume or inside_out where the union is empty.</summary>
    [DllImport(Library, CallingConvention = CallingConvention.Cdecl)]
    public static extern int brittle_mesh_unite(brittle_mesh* mesh, uint threads, brittle_mesh** @out, brittle_text** report, brittle_error* error);

    [DllImport(Library, CallingConvention = CallingConvention.Cdecl)]
    public static extern byte* brittle_text_get(brittle_text* text);

    /// <summary>"" for NULL</summary>
    [DllImport(Library, CallingConvention = CallingConvention.Cdecl)]
    public static extern void brittle_text_free(brittle_text* text);

    [DllImport(Library, CallingConvention = CallingConvention.Cdecl)]
    public static extern ulong brittle_files_count(brittle_files* files);

    /// <summary>File k: its name, bytes and size, each of which may be NULL. The file to open is number 0.</summary>
    [DllImport(Library, CallingConvention = CallingConvention.Cdecl)]
    public static extern int brittle_files_get(brittle_files* files, ulong k, byte** name, void** bytes, UIntPtr* size, brittle_error* error);

    [DllImport(Library, CallingConvention = CallingConvention.Cdecl)]
    public static extern void brittle_files_free(brittle_files* files);

    [DllImport(Library, CallingConvention = CallingConvention.Cdecl)]
    public static extern void brittle_pattern_init(brittle_pattern* pattern, UIntPtr struct_size);

    /// <summary>Makes the sites of a pattern for a mesh; `pattern` NULL: 20 uniform sites inside the solid. Errors: invalid_setting, with the field, its value and its range; invalid_argument for an unknown kind; not_closed and its like where the mesh has no inside.</summary>
    [DllImport(Library, CallingConvention = CallingConvention.Cdecl)]
    public static extern int brittle_sites_pattern(brittle_pattern* pattern, brittle_mesh* mesh, brittle_sites** @out, brittle_error* error);

    /// <summary>Sites of the caller's. `weights` (n x 1 FLOAT32 or FLOAT64, m^2) and `groups` (n x 1 UINT16 or UINT32) may be NULL. A heavier site has a larger cell; the cells of one group become one piece where they touch.</summary>
    [DllImport(Library, CallingConvention = CallingConvention.Cdecl)]
    public static extern int brittle_sites_from_arrays(brittle_array* positions, brittle_array* weights, brittle_array* groups, brittle_sites** @out, brittle_error* error);

    /// <summary>Reads a text file with a site a line: x y z, or x y z radius.</summary>
    [DllImport(Library, CallingConvention = CallingConvention.Cdecl)]
    public static extern int brittle_sites_load([MarshalAs(UnmanagedType.LPUTF8Str)] string path, brittle_sites** @out, brittle_error* error);

    [DllImport(Library, CallingConvention = CallingConvention.Cdecl)]
    public static extern int brittle_sites_array(brittle_sites* sites, uint which, brittle_array* @out, brittle_error* error);

    [DllImport(Library, CallingConvention = CallingConvention.Cdecl)]
    public static extern void brittle_sites_free(brittle_sites* sites);

    [DllImport(Library, CallingConvention = CallingConvention.Cdecl)]
    public static extern int brittle_workspace_create(brittle_workspace** @out, brittle_error* error);

    [DllImport(Library, CallingConvention = CallingConvention.Cdecl)]
    public static extern void brittle_workspace_free(brittle_workspace* workspace);

    [DllImport(Library, CallingConvention = CallingConvention.Cdecl)]
    public static extern void brittle_fracture_settings_init(brittle_fracture_settings* settings, UIntPtr struct_size);

    /// <summary>Cuts the mesh into the watertight pieces of the Voronoi cells of the sites. `settings` NULL: defaults. Errors: those of meshes and sites above, invalid_setting, cancelled.</summary>
    [DllImport(Library, CallingConvention = CallingConvention.Cdecl)]
    public static extern int brittle_fracture(brittle_mesh* mesh, brittle_sites* sites, brittle_fracture_settings* settings, brittle_pieces** @out, brittle_error* error);

    [DllImport(Library, CallingConvention = CallingConvention.Cdecl)]
    public static extern void brittle_pieces_free(brittle_pieces* pieces);

    [DllImport(Library, CallingConvention = CallingConvention.Cdecl)]
    public static extern int brittle_pieces_array(brittle_pieces* pieces, uint which, brittle_array* @out, brittle_error* error);

    /// <summary>What certifies the pieces, computed from them alone. out-&gt;struct_size must be set.</summary>
    [DllImport(Library, CallingConvention = CallingConvention.Cdecl)]
    public static extern int brittle_pieces_certificate(brittle_pieces* pieces, brittle_certificate* @out, brittle_error* error);

    /// <summary>The surface of one piece for drawing, in parts of one material each: those of the outside, then the cuts.</summary>
    [DllImport(Library, CallingConvention = CallingConvention.Cdecl)]
    public static extern int brittle_pieces_surface(brittle_pieces* pieces, uint piece, brittle_surface** @out, brittle_error* error);

    [DllImport(Library, CallingConvention = CallingConvention.Cdecl)]
    public static extern ulong brittle_surface_parts(brittle_surface* surface);

    /// <summary>material: the number in the mesh, BRITTLE_NO_MATERIAL for cuts and for a mesh without. interior: 1 for the cuts.</summary>
    [DllImport(Library, CallingConvention = CallingConvention.Cdecl)]
    public static extern int brittle_surface_part(brittle_surface* surface, ulong part, uint* material, uint* interior, brittle_error* error);

    [DllImport(Library, CallingConvention = CallingConvention.Cdecl)]
    public static extern int brittle_surface_array(brittle_surface* surface, ulong part, uint which, brittle_array* @out, brittle_error* error);

    [DllImport(Library, CallingConvention = CallingConvention.Cdecl)]
    public static extern void brittle_surface_free(brittle_surface* surface);

    /// <summary>Convex hulls of all pieces. max_parts: hulls of one piece at most, 1 to 256; 1 gives one hull a piece, more follow pieces that are not convex. max_vertices: of one hull, 8 to 255. Hulls lie a small margin inside their pieces, and have no corner that reaches less than 5 thousandths of their extent: engines in single precision push pieces apart along the narrow faces beside such corners.</summary>
    [DllImport(Library, CallingConvention = CallingConvention.Cdecl)]
    public static extern int brittle_pieces_hulls(brittle_pieces* pieces, uint max_parts, uint max_vertices, brittle_hulls** @out, brittle_error* error);

    [DllImport(Library, CallingConvention = CallingConvention.Cdecl)]
    public static extern int brittle_hulls_array(brittle_hulls* hulls, uint which, brittle_array* @out, brittle_error* error);

    [DllImport(Library, CallingConvention = CallingConvention.Cdecl)]
    public static extern void brittle_hulls_free(brittle_hulls* hulls);

    [DllImport(Library, CallingConvention = CallingConvention.Cdecl)]
    public static extern void brittle_export_settings_init(brittle_export_settings* settings, UIntPtr struct_size);

    /// <summary>Writes .glb, .obj, .ply or .stl. The materials and textures of the mesh carry over. `settings` NULL: defaults.</summary>
    [DllImport(Library, CallingConvention = CallingConvention.Cdecl)]
    public static extern int brittle_pieces_save(brittle_pieces* pieces, [MarshalAs(UnmanagedType.LPUTF8Str)] string path, brittle_export_settings* settings, brittle_error* error);

    /// <summary>The same into memory; `name` is that of the file, with its extension.</summary>
    [DllImport(Library, CallingConvention = CallingConvention.Cdecl)]
    public static extern int brittle_pieces_save_memory(brittle_pieces* pieces, [MarshalAs(UnmanagedType.LPUTF8Str)] string name, brittle_export_settings* settings, brittle_files** @out, brittle_error* error);

    /// <summary>"glass", "stone", "concrete", "wood", "ceramic" and "brick" for 0 to 5; NULL beyond. The text is static.</summary>
    [DllImport(Library, CallingConvention = CallingConvention.Cdecl)]
    public static extern byte* brittle_material_name(uint index);

    /// <summary>out-&gt;struct_size must be set. An unknown name is an invalid_argument, and the message lists all names.</summary>
    [DllImport(Library, CallingConvention = CallingConvention.Cdecl)]
    public static extern int brittle_material_get([MarshalAs(UnmanagedType.LPUTF8Str)] string name, brittle_material* @out, brittle_error* error);

    [DllImport(Library, CallingConvention = CallingConvention.Cdecl)]
    public static extern void brittle_world_settings_init(brittle_world_settings* settings, UIntPtr struct_size);

    [DllImport(Library, CallingConvention = CallingConvention.Cdecl)]
    public static extern int brittle_world_create(brittle_world_settings* settings, brittle_world** @out, brittle_error* error);

    [DllImport(Library, CallingConvention = CallingConvention.Cdecl)]
    public static extern void brittle_world_free(brittle_world* world);

    [DllImport(Library, CallingConvention = CallingConvention.Cdecl)]
    public static extern void brittle_object_settings_init(brittle_object_settings* settings, UIntPtr struct_size);

    /// <summary>Adds a whole object that blows break. `object`, which may be NULL, receives its number. Errors: those of brittle_fracture() for the mesh; invalid_setting.</summary>
    [DllImport(Library, CallingConvention = CallingConvention.Cdecl)]
    public static extern int brittle_world_add_breakable(brittle_world* world, brittle_mesh* mesh, brittle_object_settings* settings, uint* @object, brittle_error* error);

    /// <summary>Adds the pieces of a fracture, bonded where they touch. Blows break bonds, and then pieces.</summary>
    [DllImport(Library, CallingConvention = CallingConvention.Cdecl)]
    public static extern int brittle_world_add_bonded(brittle_world* world, brittle_pieces* pieces, brittle_object_settings* settings, uint* @object, brittle_error* error);

    /// <summary>Removes an object with all its pieces.</summary>
    [DllImport(Library, CallingConvention = CallingConvention.Cdecl)]
    public static extern int brittle_world_remove(brittle_world* world, uint @object, brittle_error* error);

    /// <summary>Strikes a piece at a point (three floats, m) along a direction into it (three floats), as a hammer of one kilogram does with this energy in joules, above 0. The pieces get no impulse. `broke`, which may be NULL, receives 1 where the blow breaks the piece; the new pieces come some steps later.</summary>
    [DllImport(Library, CallingConvention = CallingConvention.Cdecl)]
    public static extern int brittle_world_strike(brittle_world* world, uint piece, float* point, float* direction, double energy, uint* broke, brittle_error* error);

    /// <summary>Adds a ball: where it is (m), its velocity (m/s), radius (m) and density (kg/m^3). `body` may be NULL.</summary>
    [DllImport(Library, CallingConvention = CallingConvention.Cdecl)]
    public static extern int brittle_world_shoot(brittle_world* world, float* from, float* velocity, float radius, float density, uint* body, brittle_error* error);

    /// <summary>The pose of a body that brittle_world_shoot() added: position (three floats) and orientation (four floats).</summary>
    [DllImport(Library, CallingConvention = CallingConvention.Cdecl)]
    public static extern int brittle_world_body(brittle_world* world, uint body, float* position, float* orientation, brittle_error* error);

    /// <summary>Takes `steps` steps of the world's time step.</summary>
    [DllImport(Library, CallingConvention = CallingConvention.Cdecl)]
    public static extern int brittle_world_step(brittle_world* world, uint steps, brittle_error* error);

    /// <summary>A hash of the whole state: equal runs give equal hashes, with any number of threads.</summary>
    [DllImport(Library, CallingConvention = CallingConvention.Cdecl)]
    public static extern int brittle_world_state_hash(brittle_world* world, ulong* @out, brittle_error* error);

    /// <summary>The poses of all pieces, in ascending order of the piece. alpha: from 0, the state before the last step, to 1, the state after it. `count` receives their number; `out` may be NULL to ask for it, and receives at most `capacity`.</summary>
    [DllImport(Library, CallingConvention = CallingConvention.Cdecl)]
    public static extern int brittle_world_transforms(brittle_world* world, float alpha, brittle_transform* @out, ulong capacity, ulong* count, brittle_error* error);

    /// <summary>What changed since the last call. Apply removals before additions, because slots are used again.</summary>
    [DllImport(Library, CallingConvention = CallingConvention.Cdecl)]
    public static extern int brittle_world_events(brittle_world* world, brittle_events** @out, brittle_error* error);

    [DllImport(Library, CallingConvention = CallingConvention.Cdecl)]
    public static extern int brittle_events_array(brittle_events* events, uint which, brittle_array* @out, brittle_error* error);

    /// <summary>The mesh of the added piece in row `row`. exterior_triangles, which may be NULL: how many lie outside.</summary>
    [DllImport(Library, CallingConvention = CallingConvention.Cdecl)]
    public static extern int brittle_events_added_array(brittle_events* events, ulong row, uint which, brittle_array* @out, uint* exterior_triangles, brittle_error* error);

    [DllImport(Library, CallingConvention = CallingConvention.Cdecl)]
    public static extern void brittle_events_free(brittle_events* events);

    [DllImport(Library, CallingConvention = CallingConvention.Cdecl)]
    public static extern void brittle_load_settings_init(brittle_load_settings* settings, UIntPtr struct_size);

    /// <summary>Reads a recipe; paths in it count from its folder. Errors: file_not_found, malformed_file with a message that names the file, the place in it and the expected value.</summary>
    [DllImport(Library, CallingConvention = CallingConvention.Cdecl)]
    public static extern int brittle_recipe_load([MarshalAs(UnmanagedType.LPUTF8Str)] string path, brittle_recipe** @out, brittle_error* error);

    /// <summary>The same from JSON text of at most 1 MiB. Paths in it count from `folder`; NULL: the working folder.</summary>
    [DllImport(Library, CallingConvention = CallingConvention.Cdecl)]
    public static extern int brittle_recipe_parse([MarshalAs(UnmanagedType.LPUTF8Str)] string json, [MarshalAs(UnmanagedType.LPUTF8Str)] string folder, brittle_recipe** @out, brittle_error* error);

    /// <summary>The recipe with all its settings, as JSON; paths count from the working folder.</summary>
    [DllImport(Library, CallingConvention = CallingConvention.Cdecl)]
    public static extern int brittle_recipe_text(brittle_recipe* recipe, brittle_text** @out, brittle_error* error);

    /// <summary>Writes it; paths count from the folder of the file. Errors: write_failed.</summary>
    [DllImport(Library, CallingConvention = CallingConvention.Cdecl)]
    public static extern int brittle_recipe_save(brittle_recipe* recipe, [MarshalAs(UnmanagedType.LPUTF8Str)] string path, brittle_error* error);

    /// <summary>Breaks the mesh of a recipe, in the coordinates of its file: the pieces of `brittle fracture RECIPE`, with the same hash. A scene is refused with invalid_setting: see brittle_run_start(). Errors: those of meshes and of brittle_fracture().</summary>
    [DllImport(Library, CallingConvention = CallingConvention.Cdecl)]
    public static extern int brittle_recipe_fracture(brittle_recipe* recipe, brittle_load_settings* settings, brittle_pieces** @out, brittle_error* error);

    [DllImport(Library, CallingConvention = CallingConvention.Cdecl)]
    public static extern void brittle_recipe_free(brittle_recipe* recipe);

    /// <summary>Loads, breaks and prepares what the recipe holds. Errors: those of meshes and of brittle_fracture(). A mesh of a scene that cannot be broken becomes a fixed object: see brittle_run_notes().</summary>
    [DllImport(Library, CallingConvention = CallingConvention.Cdecl)]
    public static extern int brittle_run_start(brittle_recipe* recipe, brittle_load_settings* settings, brittle_run** @out, brittle_error* error);

    [DllImport(Library, CallingConvention = CallingConvention.Cdecl)]
    public static extern void brittle_run_free(brittle_run* run);

    /// <summary>Lines for people about objects that the scene could not take as the recipe says; often empty.</summary>
    [DllImport(Library, CallingConvention = CallingConvention.Cdecl)]
    public static extern int brittle_run_notes(brittle_run* run, brittle_text** @out, brittle_error* error);

    [DllImport(Library, CallingConvention = CallingConvention.Cdecl)]
    public static extern int brittle_run_step(brittle_run* run, uint steps, brittle_error* error);

    /// <summary>Steps since the start, and the length of one, s. Either may be NULL.</summary>
    [DllImport(Library, CallingConvention = CallingConvention.Cdecl)]
    public static extern int brittle_run_time(brittle_run* run, ulong* steps, double* step_seconds, brittle_error* error);

    /// <summary>Takes an action between two steps, written as in a replay log (docs/replay.md, assets/replay.schema.json): {"shoot": {"from": [0, 1, 3], "velocity": [0, 0, -20], "radius": 0.1, "density": 7800}} Errors: malformed_file with the field that is wrong.</summary>
    [DllImport(Library, CallingConvention = CallingConvention.Cdecl)]
    public static extern int brittle_run_act(brittle_run* run, [MarshalAs(UnmanagedType.LPUTF8Str)] string action, brittle_error* error);

    /// <summary>A hash of the whole state, that of a replay log: equal runs give equal hashes, with any number of threads.</summary>
    [DllImport(Library, CallingConvention = CallingConvention.Cdecl)]
    public static extern int brittle_run_state_hash(brittle_run* run, ulong* @out, brittle_error* error);

    /// <summary>The poses of all pieces after the last step, as brittle_world_transforms() gives them. Where the recipe is not breakable, a piece keeps its number and its slot is the same.</summary>
    [DllImport(Library, CallingConvention = CallingConvention.Cdecl)]
    public static extern int brittle_run_transforms(brittle_run* run, brittle_transform* @out, ulong capacity, ulong* count, brittle_error* error);

    /// <summary>Balls that were shot, and links of chains, after the last step. `out` may be NULL to ask for their number.</summary>
    [DllImport(Library, CallingConvention = CallingConvention.Cdecl)]
    public static extern int brittle_run_balls(brittle_run* run, brittle_ball* @out, ulong capacity, ulong* count, brittle_error* error);

    /// <summary>What changed since the last call, as brittle_world_events() says it: in the first call all pieces of the start. No events where the recipe is not breakable: the pieces stay those of brittle_run_object_pieces().</summary>
    [DllImport(Library, CallingConvention = CallingConvention.Cdecl)]
    public static extern int brittle_run_events(brittle_run* run, brittle_events** @out, brittle_error* error);

    [DllImport(Library, CallingConvention = CallingConvention.Cdecl)]
    public static extern int brittle_run_object_count(brittle_run* run, uint* @out, brittle_error* error);

    /// <summary>out-&gt;struct_size must be set.</summary>
    [DllImport(Library, CallingConvention = CallingConvention.Cdecl)]
    public static extern int brittle_run_object_get(brittle_run* run, uint @object, brittle_run_object* @out, brittle_error* error);

    /// <summary>The pieces of an object at the start, in its coordinates. A fixed object is refused with invalid_argument.</summary>
    [DllImport(Library, CallingConvention = CallingConvention.Cdecl)]
    public static extern int brittle_run_object_pieces(brittle_run* run, uint @object, brittle_pieces** @out, brittle_error* error);

    /// <summary>The unbroken mesh of an object, in its coordinates.</summary>
    [DllImport(Library, CallingConvention = CallingConvention.Cdecl)]
    public static extern int brittle_run_object_mesh(brittle_run* run, uint @object, brittle_mesh** @out, brittle_error* error);

    /// <summary>Writes the replay log of the run so far. Errors: write_failed.</summary>
    [DllImport(Library, CallingConvention = CallingConvention.Cdecl)]
    public static extern int brittle_run_save_log(brittle_run* run, [MarshalAs(UnmanagedType.LPUTF8Str)] string path, brittle_error* error);

    /// <summary>Repeats the run of a replay log up to its end or the first difference. A difference is no error. Where the recipe now gives other pieces than those of the log, no step is taken and no action applied. Errors: malformed_file with line and field, those of brittle_run_start(). out-&gt;struct_size must be set.</summary>
    [DllImport(Library, CallingConvention = CallingConvention.Cdecl)]
    public static extern int brittle_replay([MarshalAs(UnmanagedType.LPUTF8Str)] string path, brittle_load_settings* settings, brittle_replay_result* @out, brittle_error* error);
}
