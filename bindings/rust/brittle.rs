// Brittle for Rust: the declarations of brittle.h, which explains all of them.
// Written by tools/declare-bindings. Link with: -l brittle
#![allow(non_camel_case_types, dead_code)]
use std::os::raw::{c_char, c_void};

pub const BRITTLE_OK: i32 = 0;
pub const BRITTLE_FILE_NOT_FOUND: i32 = 1;
pub const BRITTLE_UNSUPPORTED_FORMAT: i32 = 2;
pub const BRITTLE_MALFORMED_FILE: i32 = 3;
pub const BRITTLE_EMPTY_MESH: i32 = 4;
pub const BRITTLE_INVALID_MESH: i32 = 5;
pub const BRITTLE_NOT_CLOSED: i32 = 6;
pub const BRITTLE_NON_MANIFOLD: i32 = 7;
pub const BRITTLE_NOT_ORIENTED: i32 = 8;
pub const BRITTLE_INSIDE_OUT: i32 = 9;
pub const BRITTLE_NO_VOLUME: i32 = 10;
pub const BRITTLE_INVERTED_PART: i32 = 11;
pub const BRITTLE_LOST_VOLUME: i32 = 12;
pub const BRITTLE_INVALID_SITES: i32 = 13;
pub const BRITTLE_INVALID_SETTING: i32 = 14;
pub const BRITTLE_CANCELLED: i32 = 15;
pub const BRITTLE_WRITE_FAILED: i32 = 16;
pub const BRITTLE_INVALID_ARGUMENT: i32 = 17;
pub const BRITTLE_OUT_OF_MEMORY: i32 = 18;
pub const BRITTLE_INTERNAL_ERROR: i32 = 19;
pub const BRITTLE_FLOAT32: u32 = 1;
pub const BRITTLE_FLOAT64: u32 = 2;
pub const BRITTLE_UINT16: u32 = 3;
pub const BRITTLE_UINT32: u32 = 4;
pub const BRITTLE_MESH_POSITIONS: u32 = 1;
pub const BRITTLE_MESH_TRIANGLES: u32 = 2;
pub const BRITTLE_MESH_NORMALS: u32 = 3;
pub const BRITTLE_MESH_UV: u32 = 4;
pub const BRITTLE_MESH_UV2: u32 = 5;
pub const BRITTLE_MESH_COLOURS: u32 = 6;
pub const BRITTLE_MESH_MATERIALS: u32 = 7;
pub const BRITTLE_SITE_POSITIONS: u32 = 1;
pub const BRITTLE_SITE_WEIGHTS: u32 = 2;
pub const BRITTLE_SITE_GROUPS: u32 = 3;
pub const BRITTLE_PIECES_POSITIONS: u32 = 1;
pub const BRITTLE_PIECES_TRIANGLES: u32 = 2;
pub const BRITTLE_PIECES_TRIANGLE_SOURCES: u32 = 3;
pub const BRITTLE_PIECES_VERTEX_RANGES: u32 = 4;
pub const BRITTLE_PIECES_TRIANGLE_RANGES: u32 = 5;
pub const BRITTLE_PIECES_EXTERIOR_TRIANGLES: u32 = 6;
pub const BRITTLE_PIECES_SITES: u32 = 7;
pub const BRITTLE_PIECES_VOLUMES: u32 = 8;
pub const BRITTLE_PIECES_AREAS: u32 = 9;
pub const BRITTLE_PIECES_CENTRES: u32 = 10;
pub const BRITTLE_PIECES_INERTIAS: u32 = 11;
pub const BRITTLE_PIECES_BONDS: u32 = 12;
pub const BRITTLE_PIECES_BOND_AREAS: u32 = 13;
pub const BRITTLE_PIECES_BOND_CENTROIDS: u32 = 14;
pub const BRITTLE_PIECES_BOND_NORMALS: u32 = 15;
pub const BRITTLE_NO_MATERIAL: u32 = 0xffffffff;
pub const BRITTLE_SURFACE_POSITIONS: u32 = 1;
pub const BRITTLE_SURFACE_NORMALS: u32 = 2;
pub const BRITTLE_SURFACE_UV: u32 = 3;
pub const BRITTLE_SURFACE_UV2: u32 = 4;
pub const BRITTLE_SURFACE_COLOURS: u32 = 5;
pub const BRITTLE_SURFACE_INDICES: u32 = 6;
pub const BRITTLE_SURFACE_VERTICES: u32 = 7;
pub const BRITTLE_HULL_POINTS: u32 = 1;
pub const BRITTLE_HULL_RANGES: u32 = 2;
pub const BRITTLE_HULL_PIECES: u32 = 3;
pub const BRITTLE_HULL_MARGINS: u32 = 4;
pub const BRITTLE_EVENTS_REMOVED: u32 = 1;
pub const BRITTLE_EVENTS_ADDED: u32 = 2;
pub const BRITTLE_EVENTS_FADING: u32 = 3;
pub const BRITTLE_EVENTS_FADING_SHARES: u32 = 4;
pub const BRITTLE_ADDED_POSITIONS: u32 = 1;
pub const BRITTLE_ADDED_TRIANGLES: u32 = 2;
pub const BRITTLE_ADDED_CENTRE: u32 = 3;

#[repr(C)]
pub struct brittle_mesh {
    _private: [u8; 0],
}

#[repr(C)]
pub struct brittle_files {
    _private: [u8; 0],
}

#[repr(C)]
pub struct brittle_text {
    _private: [u8; 0],
}

#[repr(C)]
pub struct brittle_sites {
    _private: [u8; 0],
}

#[repr(C)]
pub struct brittle_pieces {
    _private: [u8; 0],
}

#[repr(C)]
pub struct brittle_workspace {
    _private: [u8; 0],
}

#[repr(C)]
pub struct brittle_surface {
    _private: [u8; 0],
}

#[repr(C)]
pub struct brittle_hulls {
    _private: [u8; 0],
}

#[repr(C)]
pub struct brittle_world {
    _private: [u8; 0],
}

#[repr(C)]
pub struct brittle_events {
    _private: [u8; 0],
}

#[repr(C)]
pub struct brittle_recipe {
    _private: [u8; 0],
}

#[repr(C)]
pub struct brittle_run {
    _private: [u8; 0],
}

#[repr(C)]
#[derive(Clone, Copy)]
pub struct brittle_error {
    pub struct_size: u32,
    pub status: i32,
    pub message: [c_char; 1016],
}

#[repr(C)]
#[derive(Clone, Copy)]
pub struct brittle_allocator {
    pub struct_size: u32,
    pub allocate: Option<unsafe extern "C" fn(user: *mut c_void, size: usize, alignment: usize) -> *mut c_void>,
    pub release: Option<unsafe extern "C" fn(user: *mut c_void, block: *mut c_void, size: usize, alignment: usize)>,
    pub user: *mut c_void,
}

/// A table of numbers: `rows` rows of `columns` numbers; row k begins `stride` bytes after row k - 1, at any address. In an input a stride of 0 means rows without gaps, and data may be NULL where rows is 0.
#[repr(C)]
#[derive(Clone, Copy)]
pub struct brittle_array {
    pub r#type: u32,
    pub columns: u32,
    pub rows: u64,
    pub stride: u64,
    pub data: *const c_void,
}

/// Vertex arrays as an engine has them. Unused arrays stay zeroed: {0}.
#[repr(C)]
#[derive(Clone, Copy)]
pub struct brittle_mesh_arrays {
    pub struct_size: u32,
    pub weld: u32,
    pub positions: brittle_array,
    pub triangles: brittle_array,
    pub normals: brittle_array,
    pub uv: brittle_array,
    pub materials: brittle_array,
}

#[repr(C)]
#[derive(Clone, Copy)]
pub struct brittle_inspection {
    pub struct_size: u32,
    pub refusal: i32,
    pub box_min: [f64; 3],
    pub box_max: [f64; 3],
    pub area: f64,
    pub volume: f64,
    pub vertices: u64,
    pub edges: u64,
    pub triangles: u64,
    pub components: u64,
    pub open_edges: u64,
    pub misoriented_edges: u64,
    pub non_manifold_edges: u64,
    pub non_manifold_vertices: u64,
    pub flat_triangles: u64,
    pub duplicate_triangles: u64,
    pub intersections: u64,
    pub holes: u64,
}

#[repr(C)]
#[derive(Clone, Copy)]
pub struct brittle_repair_settings {
    pub struct_size: u32,
    pub remesh_holes: u32,
    pub weld_distance: f64,
    pub close_holes: f64,
    pub cavities: u32,
    pub covered_parts: u32,
}

#[repr(C)]
#[derive(Clone, Copy)]
pub struct brittle_pattern {
    pub struct_size: u32,
    pub count: u32,
    pub kind: *const c_char,
    pub seed: u64,
    pub piece_size: f64,
    pub jitter: f64,
    pub focus: [f64; 3],
    pub axis: [f64; 3],
    pub spread: f64,
    pub slenderness: f64,
    pub grading: f64,
    pub line: brittle_array,
    pub cells_per_piece: u32,
    pub inside: u32,
}

#[repr(C)]
#[derive(Clone, Copy)]
pub struct brittle_fracture_settings {
    pub struct_size: u32,
    pub threads: u32,
    pub sequential: u32,
    pub rough_detail: u32,
    pub min_volume: f64,
    pub roughness: f64,
    pub rough_wavelength: f64,
    pub rough_grain: [f64; 3],
    pub rough_seed: u64,
    pub rough_max_triangles: u64,
    pub workspace: *mut brittle_workspace,
    pub progress: Option<unsafe extern "C" fn(user: *mut c_void, share: f64)>,
    pub cancelled: Option<unsafe extern "C" fn(user: *mut c_void) -> i32>,
    pub user: *mut c_void,
    pub cancel_flag: *const i32,
}

#[repr(C)]
#[derive(Clone, Copy)]
pub struct brittle_certificate {
    pub struct_size: u32,
    pub pieces: u32,
    pub closed: u32,
    pub open_pieces: u32,
    pub negative_pieces: u32,
    pub cells: u32,
    pub volume_input: f64,
    pub volume_sum: f64,
    pub smallest_piece: f64,
    pub volume_error: f64,
    pub triangles_in: u64,
    pub triangles_out: u64,
    pub cap_triangles: u64,
    pub hash: u64,
}

#[repr(C)]
#[derive(Clone, Copy)]
pub struct brittle_export_settings {
    pub struct_size: u32,
    pub per_piece: u32,
    pub name: *const c_char,
    pub hulls: u32,
    pub rigid_bodies: u32,
    pub density: f64,
    pub hull_parts: u32,
}

/// Handbook values of a material, and how it breaks and looks.
#[repr(C)]
#[derive(Clone, Copy)]
pub struct brittle_material {
    pub struct_size: u32,
    pub rough_detail: u32,
    pub name: *const c_char,
    pub density: f64,
    pub friction: f64,
    pub restitution: f64,
    pub tensile: f64,
    pub compressive: f64,
    pub shear: f64,
    pub fracture_toughness: f64,
    pub fracture_energy: f64,
    pub pattern: *const c_char,
    pub pattern_jitter: f64,
    pub pattern_spread: f64,
    pub pattern_slenderness: f64,
    pub pattern_axis: [f64; 3],
    pub roughness: f64,
    pub rough_grain: [f64; 3],
    pub exterior: [f64; 3],
    pub interior: [f64; 3],
}

#[repr(C)]
#[derive(Clone, Copy)]
pub struct brittle_world_settings {
    pub struct_size: u32,
    pub bullet: u32,
    pub threads: u32,
    pub workers: u32,
    pub max_pieces: u32,
    pub latency: u32,
    pub has_ground: u32,
    pub ground_height: f32,
    pub gravity: [f32; 3],
    pub step: f32,
}

/// A ball in which the world holds an object: pieces that reach into it are fixed.
#[repr(C)]
#[derive(Clone, Copy)]
pub struct brittle_anchor {
    pub centre: [f64; 3],
    pub radius: f64,
}

#[repr(C)]
#[derive(Clone, Copy)]
pub struct brittle_object_settings {
    pub struct_size: u32,
    pub max_pieces: u32,
    pub material: *const c_char,
    pub strength: f64,
    pub min_size: f64,
    pub roughness: f64,
    pub seed: u64,
    pub position: [f32; 3],
    pub orientation: [f32; 4],
    pub linear_velocity: [f32; 3],
    pub angular_velocity: [f32; 3],
    pub anchors: *const brittle_anchor,
    pub anchor_count: u32,
}

#[repr(C)]
#[derive(Clone, Copy)]
pub struct brittle_transform {
    pub piece: u32,
    pub slot: u32,
    pub position: [f32; 3],
    pub orientation: [f32; 4],
}

/// Long calls of recipes, runs and replays.
#[repr(C)]
#[derive(Clone, Copy)]
pub struct brittle_load_settings {
    pub struct_size: u32,
    pub threads: u32,
    pub progress: Option<unsafe extern "C" fn(user: *mut c_void, share: f64)>,
    pub cancelled: Option<unsafe extern "C" fn(user: *mut c_void) -> i32>,
    pub report: Option<unsafe extern "C" fn(user: *mut c_void, text: *const c_char)>,
    pub user: *mut c_void,
    pub cancel_flag: *const i32,
}

#[repr(C)]
#[derive(Clone, Copy)]
pub struct brittle_ball {
    pub position: [f32; 3],
    pub orientation: [f32; 4],
    pub radius: f32,
}

/// An object of the run at its start; a recipe of one mesh has one. The texts are borrowed from the run.
#[repr(C)]
#[derive(Clone, Copy)]
pub struct brittle_run_object {
    pub struct_size: u32,
    pub is_fixed: u32,
    pub name: *const c_char,
    pub material: *const c_char,
    pub position: [f32; 3],
    pub orientation: [f32; 4],
    pub piece_count: u32,
}

#[repr(C)]
#[derive(Clone, Copy)]
pub struct brittle_replay_result {
    pub struct_size: u32,
    pub is_equal: u32,
    pub steps: u64,
    pub actions: u64,
    pub first_difference: u64,
    pub state_hash: u64,
    pub difference: [c_char; 1016],
}

extern "C" {
    /// "malformed_file" for BRITTLE_MALFORMED_FILE; "unknown" for any other number. The text is static.
    pub fn brittle_status_name(status: i32) -> *const c_char;
    /// The version of the library, for example "0.1.0". The text is static.
    pub fn brittle_version() -> *const c_char;
    /// Gives the library an allocator for the blocks that it asks for from now on; NULL: that of the C library. A block goes back to the allocator that it came from, so handles stay valid, and an allocator must stay valid until all of its blocks came back. Both functions are called by any thread, several at a time, and must not call the library. Where `allocate` returns NULL, the call returns out_of_memory; but functions that load or save meshes and pieces, and those of recipes and runs, take from the C library what it refuses. oneTBB and Bullet (where hulls are made, and in worlds with its engine) have memory of their own. Errors: invalid_argument where only one of the functions is NULL.
    pub fn brittle_set_allocator(allocator: *const brittle_allocator, error: *mut brittle_error) -> i32;
    /// Makes a mesh. Errors: invalid_argument (type, columns or rows of an array), invalid_mesh (a coordinate that is not finite or exceeds 1e50, an index out of range), empty_mesh. An open or misoriented mesh is accepted: see brittle_mesh_inspect() and brittle_mesh_repair().
    pub fn brittle_mesh_from_arrays(arrays: *const brittle_mesh_arrays, out: *mut *mut brittle_mesh, error: *mut brittle_error) -> i32;
    /// Reads .obj, .stl, .ply, .off, .glb, .gltf or .3ds with materials and textures; vertices at equal positions are welded. Errors: file_not_found, unsupported_format, malformed_file, empty_mesh.
    pub fn brittle_mesh_load(path: *const c_char, out: *mut *mut brittle_mesh, error: *mut brittle_error) -> i32;
    /// The same from the bytes of a file; `extension` names the format, for example ".glb". Files beside it are not read.
    pub fn brittle_mesh_load_memory(bytes: *const c_void, size: usize, extension: *const c_char, out: *mut *mut brittle_mesh, error: *mut brittle_error) -> i32;
    /// A procedural shape: "cube", "icosphere:4", "torus", "animal", "statue", ... An unknown name is an invalid_argument, and the message lists all names.
    pub fn brittle_mesh_shape(name: *const c_char, out: *mut *mut brittle_mesh, error: *mut brittle_error) -> i32;
    /// A box around the origin, of the given size in metres (three numbers above 0).
    pub fn brittle_mesh_box(size: *const f64, out: *mut *mut brittle_mesh, error: *mut brittle_error) -> i32;
    pub fn brittle_mesh_free(mesh: *mut brittle_mesh);
    /// Writes .glb, .obj, .ply or .stl, by the extension. Errors: unsupported_format, write_failed.
    pub fn brittle_mesh_save(mesh: *const brittle_mesh, path: *const c_char, error: *mut brittle_error) -> i32;
    /// The same into memory; `name` is that of the file, with its extension.
    pub fn brittle_mesh_save_memory(mesh: *const brittle_mesh, name: *const c_char, out: *mut *mut brittle_files, error: *mut brittle_error) -> i32;
    pub fn brittle_mesh_array(mesh: *const brittle_mesh, which: u32, out: *mut brittle_array, error: *mut brittle_error) -> i32;
    /// Lists the flaws of a mesh. out->struct_size must be set. `report`, which may be NULL, receives a text for people.
    pub fn brittle_mesh_inspect(mesh: *const brittle_mesh, out: *mut brittle_inspection, report: *mut *mut brittle_text, error: *mut brittle_error) -> i32;
    pub fn brittle_repair_settings_init(settings: *mut brittle_repair_settings, struct_size: usize);
    /// Returns a mesh that is closed, oriented and manifold, as far as that is possible; the input stays. `settings` NULL: defaults. `report`, which may be NULL, receives what was done, empty where nothing was.
    pub fn brittle_mesh_repair(mesh: *const brittle_mesh, settings: *const brittle_repair_settings, out: *mut *mut brittle_mesh, report: *mut *mut brittle_text, error: *mut brittle_error) -> i32;
    /// Returns one solid of parts that pass through each other. The mesh must be closed. threads: 0 for one per core. Errors: not_closed and the like; no_volume or inside_out where the union is empty.
    pub fn brittle_mesh_unite(mesh: *const brittle_mesh, threads: u32, out: *mut *mut brittle_mesh, report: *mut *mut brittle_text, error: *mut brittle_error) -> i32;
    pub fn brittle_text_get(text: *const brittle_text) -> *const c_char;
    /// "" for NULL
    pub fn brittle_text_free(text: *mut brittle_text);
    pub fn brittle_files_count(files: *const brittle_files) -> u64;
    /// File k: its name, bytes and size, each of which may be NULL. The file to open is number 0.
    pub fn brittle_files_get(files: *const brittle_files, k: u64, name: *mut *const c_char, bytes: *mut *const c_void, size: *mut usize, error: *mut brittle_error) -> i32;
    pub fn brittle_files_free(files: *mut brittle_files);
    pub fn brittle_pattern_init(pattern: *mut brittle_pattern, struct_size: usize);
    /// Makes the sites of a pattern for a mesh; `pattern` NULL: 20 uniform sites inside the solid. Errors: invalid_setting, with the field, its value and its range; invalid_argument for an unknown kind; not_closed and its like where the mesh has no inside.
    pub fn brittle_sites_pattern(pattern: *const brittle_pattern, mesh: *const brittle_mesh, out: *mut *mut brittle_sites, error: *mut brittle_error) -> i32;
    /// Sites of the caller's. `weights` (n x 1 FLOAT32 or FLOAT64, m^2) and `groups` (n x 1 UINT16 or UINT32) may be NULL. A heavier site has a larger cell; the cells of one group become one piece where they touch.
    pub fn brittle_sites_from_arrays(positions: *const brittle_array, weights: *const brittle_array, groups: *const brittle_array, out: *mut *mut brittle_sites, error: *mut brittle_error) -> i32;
    /// Reads a text file with a site a line: x y z, or x y z radius.
    pub fn brittle_sites_load(path: *const c_char, out: *mut *mut brittle_sites, error: *mut brittle_error) -> i32;
    pub fn brittle_sites_array(sites: *const brittle_sites, which: u32, out: *mut brittle_array, error: *mut brittle_error) -> i32;
    pub fn brittle_sites_free(sites: *mut brittle_sites);
    pub fn brittle_workspace_create(out: *mut *mut brittle_workspace, error: *mut brittle_error) -> i32;
    pub fn brittle_workspace_free(workspace: *mut brittle_workspace);
    pub fn brittle_fracture_settings_init(settings: *mut brittle_fracture_settings, struct_size: usize);
    /// Cuts the mesh into the watertight pieces of the Voronoi cells of the sites. `settings` NULL: defaults. Errors: those of meshes and sites above, invalid_setting, cancelled.
    pub fn brittle_fracture(mesh: *const brittle_mesh, sites: *const brittle_sites, settings: *const brittle_fracture_settings, out: *mut *mut brittle_pieces, error: *mut brittle_error) -> i32;
    pub fn brittle_pieces_free(pieces: *mut brittle_pieces);
    pub fn brittle_pieces_array(pieces: *const brittle_pieces, which: u32, out: *mut brittle_array, error: *mut brittle_error) -> i32;
    /// What certifies the pieces, computed from them alone. out->struct_size must be set.
    pub fn brittle_pieces_certificate(pieces: *const brittle_pieces, out: *mut brittle_certificate, error: *mut brittle_error) -> i32;
    /// The surface of one piece for drawing, in parts of one material each: those of the outside, then the cuts.
    pub fn brittle_pieces_surface(pieces: *const brittle_pieces, piece: u32, out: *mut *mut brittle_surface, error: *mut brittle_error) -> i32;
    pub fn brittle_surface_parts(surface: *const brittle_surface) -> u64;
    /// material: the number in the mesh, BRITTLE_NO_MATERIAL for cuts and for a mesh without. interior: 1 for the cuts.
    pub fn brittle_surface_part(surface: *const brittle_surface, part: u64, material: *mut u32, interior: *mut u32, error: *mut brittle_error) -> i32;
    pub fn brittle_surface_array(surface: *const brittle_surface, part: u64, which: u32, out: *mut brittle_array, error: *mut brittle_error) -> i32;
    pub fn brittle_surface_free(surface: *mut brittle_surface);
    /// Convex hulls of all pieces. max_parts: hulls of one piece at most, 1 to 256; 1 gives one hull a piece, more follow pieces that are not convex. max_vertices: of one hull, 8 to 255. Hulls lie a small margin inside their pieces, and have no corner that reaches less than 5 thousandths of their extent: engines in single precision push pieces apart along the narrow faces beside such corners.
    pub fn brittle_pieces_hulls(pieces: *const brittle_pieces, max_parts: u32, max_vertices: u32, out: *mut *mut brittle_hulls, error: *mut brittle_error) -> i32;
    pub fn brittle_hulls_array(hulls: *const brittle_hulls, which: u32, out: *mut brittle_array, error: *mut brittle_error) -> i32;
    pub fn brittle_hulls_free(hulls: *mut brittle_hulls);
    pub fn brittle_export_settings_init(settings: *mut brittle_export_settings, struct_size: usize);
    /// Writes .glb, .obj, .ply or .stl. The materials and textures of the mesh carry over. `settings` NULL: defaults.
    pub fn brittle_pieces_save(pieces: *const brittle_pieces, path: *const c_char, settings: *const brittle_export_settings, error: *mut brittle_error) -> i32;
    /// The same into memory; `name` is that of the file, with its extension.
    pub fn brittle_pieces_save_memory(pieces: *const brittle_pieces, name: *const c_char, settings: *const brittle_export_settings, out: *mut *mut brittle_files, error: *mut brittle_error) -> i32;
    /// "glass", "stone", "concrete", "wood", "ceramic" and "brick" for 0 to 5; NULL beyond. The text is static.
    pub fn brittle_material_name(index: u32) -> *const c_char;
    /// out->struct_size must be set. An unknown name is an invalid_argument, and the message lists all names.
    pub fn brittle_material_get(name: *const c_char, out: *mut brittle_material, error: *mut brittle_error) -> i32;
    pub fn brittle_world_settings_init(settings: *mut brittle_world_settings, struct_size: usize);
    pub fn brittle_world_create(settings: *const brittle_world_settings, out: *mut *mut brittle_world, error: *mut brittle_error) -> i32;
    pub fn brittle_world_free(world: *mut brittle_world);
    pub fn brittle_object_settings_init(settings: *mut brittle_object_settings, struct_size: usize);
    /// Adds a whole object that blows break. `object`, which may be NULL, receives its number. Errors: those of brittle_fracture() for the mesh; invalid_setting.
    pub fn brittle_world_add_breakable(world: *mut brittle_world, mesh: *const brittle_mesh, settings: *const brittle_object_settings, object: *mut u32, error: *mut brittle_error) -> i32;
    /// Adds the pieces of a fracture, bonded where they touch. Blows break bonds, and then pieces.
    pub fn brittle_world_add_bonded(world: *mut brittle_world, pieces: *const brittle_pieces, settings: *const brittle_object_settings, object: *mut u32, error: *mut brittle_error) -> i32;
    /// Removes an object with all its pieces.
    pub fn brittle_world_remove(world: *mut brittle_world, object: u32, error: *mut brittle_error) -> i32;
    /// Strikes a piece at a point (three floats, m) along a direction into it (three floats), as a hammer of one kilogram does with this energy in joules, above 0. The pieces get no impulse. `broke`, which may be NULL, receives 1 where the blow breaks the piece; the new pieces come some steps later.
    pub fn brittle_world_strike(world: *mut brittle_world, piece: u32, point: *const f32, direction: *const f32, energy: f64, broke: *mut u32, error: *mut brittle_error) -> i32;
    /// Adds a ball: where it is (m), its velocity (m/s), radius (m) and density (kg/m^3). `body` may be NULL.
    pub fn brittle_world_shoot(world: *mut brittle_world, from: *const f32, velocity: *const f32, radius: f32, density: f32, body: *mut u32, error: *mut brittle_error) -> i32;
    /// The pose of a body that brittle_world_shoot() added: position (three floats) and orientation (four floats).
    pub fn brittle_world_body(world: *const brittle_world, body: u32, position: *mut f32, orientation: *mut f32, error: *mut brittle_error) -> i32;
    /// Takes `steps` steps of the world's time step.
    pub fn brittle_world_step(world: *mut brittle_world, steps: u32, error: *mut brittle_error) -> i32;
    /// A hash of the whole state: equal runs give equal hashes, with any number of threads.
    pub fn brittle_world_state_hash(world: *const brittle_world, out: *mut u64, error: *mut brittle_error) -> i32;
    /// The poses of all pieces, in ascending order of the piece. alpha: from 0, the state before the last step, to 1, the state after it. `count` receives their number; `out` may be NULL to ask for it, and receives at most `capacity`.
    pub fn brittle_world_transforms(world: *const brittle_world, alpha: f32, out: *mut brittle_transform, capacity: u64, count: *mut u64, error: *mut brittle_error) -> i32;
    /// What changed since the last call. Apply removals before additions, because slots are used again.
    pub fn brittle_world_events(world: *mut brittle_world, out: *mut *mut brittle_events, error: *mut brittle_error) -> i32;
    pub fn brittle_events_array(events: *const brittle_events, which: u32, out: *mut brittle_array, error: *mut brittle_error) -> i32;
    /// The mesh of the added piece in row `row`. exterior_triangles, which may be NULL: how many lie outside.
    pub fn brittle_events_added_array(events: *const brittle_events, row: u64, which: u32, out: *mut brittle_array, exterior_triangles: *mut u32, error: *mut brittle_error) -> i32;
    pub fn brittle_events_free(events: *mut brittle_events);
    pub fn brittle_load_settings_init(settings: *mut brittle_load_settings, struct_size: usize);
    /// Reads a recipe; paths in it count from its folder. Errors: file_not_found, malformed_file with a message that names the file, the place in it and the expected value.
    pub fn brittle_recipe_load(path: *const c_char, out: *mut *mut brittle_recipe, error: *mut brittle_error) -> i32;
    /// The same from JSON text of at most 1 MiB. Paths in it count from `folder`; NULL: the working folder.
    pub fn brittle_recipe_parse(json: *const c_char, folder: *const c_char, out: *mut *mut brittle_recipe, error: *mut brittle_error) -> i32;
    /// The recipe with all its settings, as JSON; paths count from the working folder.
    pub fn brittle_recipe_text(recipe: *const brittle_recipe, out: *mut *mut brittle_text, error: *mut brittle_error) -> i32;
    /// Writes it; paths count from the folder of the file. Errors: write_failed.
    pub fn brittle_recipe_save(recipe: *const brittle_recipe, path: *const c_char, error: *mut brittle_error) -> i32;
    /// Breaks the mesh of a recipe, in the coordinates of its file: the pieces of `brittle fracture RECIPE`, with the same hash. A scene is refused with invalid_setting: see brittle_run_start(). Errors: those of meshes and of brittle_fracture().
    pub fn brittle_recipe_fracture(recipe: *const brittle_recipe, settings: *const brittle_load_settings, out: *mut *mut brittle_pieces, error: *mut brittle_error) -> i32;
    pub fn brittle_recipe_free(recipe: *mut brittle_recipe);
    /// Loads, breaks and prepares what the recipe holds. Errors: those of meshes and of brittle_fracture(). A mesh of a scene that cannot be broken becomes a fixed object: see brittle_run_notes().
    pub fn brittle_run_start(recipe: *const brittle_recipe, settings: *const brittle_load_settings, out: *mut *mut brittle_run, error: *mut brittle_error) -> i32;
    pub fn brittle_run_free(run: *mut brittle_run);
    /// Lines for people about objects that the scene could not take as the recipe says; often empty.
    pub fn brittle_run_notes(run: *const brittle_run, out: *mut *mut brittle_text, error: *mut brittle_error) -> i32;
    pub fn brittle_run_step(run: *mut brittle_run, steps: u32, error: *mut brittle_error) -> i32;
    /// Steps since the start, and the length of one, s. Either may be NULL.
    pub fn brittle_run_time(run: *const brittle_run, steps: *mut u64, step_seconds: *mut f64, error: *mut brittle_error) -> i32;
    /// Takes an action between two steps, written as in a replay log (docs/replay.md, assets/replay.schema.json): {"shoot": {"from": [0, 1, 3], "velocity": [0, 0, -20], "radius": 0.1, "density": 7800}} Errors: malformed_file with the field that is wrong.
    pub fn brittle_run_act(run: *mut brittle_run, action: *const c_char, error: *mut brittle_error) -> i32;
    /// A hash of the whole state, that of a replay log: equal runs give equal hashes, with any number of threads.
    pub fn brittle_run_state_hash(run: *const brittle_run, out: *mut u64, error: *mut brittle_error) -> i32;
    /// The poses of all pieces after the last step, as brittle_world_transforms() gives them. Where the recipe is not breakable, a piece keeps its number and its slot is the same.
    pub fn brittle_run_transforms(run: *const brittle_run, out: *mut brittle_transform, capacity: u64, count: *mut u64, error: *mut brittle_error) -> i32;
    /// Balls that were shot, and links of chains, after the last step. `out` may be NULL to ask for their number.
    pub fn brittle_run_balls(run: *const brittle_run, out: *mut brittle_ball, capacity: u64, count: *mut u64, error: *mut brittle_error) -> i32;
    /// What changed since the last call, as brittle_world_events() says it: in the first call all pieces of the start. No events where the recipe is not breakable: the pieces stay those of brittle_run_object_pieces().
    pub fn brittle_run_events(run: *mut brittle_run, out: *mut *mut brittle_events, error: *mut brittle_error) -> i32;
    pub fn brittle_run_object_count(run: *const brittle_run, out: *mut u32, error: *mut brittle_error) -> i32;
    /// out->struct_size must be set.
    pub fn brittle_run_object_get(run: *const brittle_run, object: u32, out: *mut brittle_run_object, error: *mut brittle_error) -> i32;
    /// The pieces of an object at the start, in its coordinates. A fixed object is refused with invalid_argument.
    pub fn brittle_run_object_pieces(run: *const brittle_run, object: u32, out: *mut *mut brittle_pieces, error: *mut brittle_error) -> i32;
    /// The unbroken mesh of an object, in its coordinates.
    pub fn brittle_run_object_mesh(run: *const brittle_run, object: u32, out: *mut *mut brittle_mesh, error: *mut brittle_error) -> i32;
    /// Writes the replay log of the run so far. Errors: write_failed.
    pub fn brittle_run_save_log(run: *const brittle_run, path: *const c_char, error: *mut brittle_error) -> i32;
    /// Repeats the run of a replay log up to its end or the first difference. A difference is no error. Where the recipe now gives other pieces than those of the log, no step is taken and no action applied. Errors: malformed_file with line and field, those of brittle_run_start(). out->struct_size must be set.
    pub fn brittle_replay(path: *const c_char, settings: *const brittle_load_settings, out: *mut brittle_replay_result, error: *mut brittle_error) -> i32;
}
