/**
 * Exact Voronoi fracture of triangle meshes, in browsers, workers and node.
 *
 *     const mesh = await load(await (await fetch("bunny.obj")).arrayBuffer(), ".obj");
 *     const broken = await fracture(mesh, { sites: 100, seed: 1, material: "stone" });
 *     for (const piece of broken) console.log(piece.volume, piece.positions, piece.triangles);
 *
 * Metres; right-handed coordinates. Arrays have their numbers row after row: x, y, z, x, y, z, ... Equal input gives
 * equal pieces, bit for bit, as of the command line. Failures throw a BrittleError. Handles free their memory by
 * dispose(), or when the garbage collector finds them.
 */
export interface Inspection {
    /** The status that fracture() would throw; null where it accepts the mesh. */
    refusal: string | null;
    report: string;
    min: [number, number, number];
    max: [number, number, number];
    area: number;
    volume: number;
    vertices: number;
    triangles: number;
    components: number;
    openEdges: number;
    nonManifoldEdges: number;
    misorientedEdges: number;
    intersections: number;
    holes: number;
}

export class BrittleError extends Error {
    /** For example "not_closed" or "invalid_setting". */
    readonly status: string;
}

/** Empty arrays where a mesh has none. Corner k of triangle t is row 3t + k. */
export interface MeshArrays {
    readonly positions: Float64Array;
    readonly triangles: Uint32Array;
    /** Three numbers for each corner, unit; zero where it has no normal. */
    readonly normals: Float32Array;
    /** Two numbers for each corner; v points down. */
    readonly uv: Float32Array;
    readonly uv2: Float32Array;
    /** Four numbers for each corner: linear, with opacity. */
    readonly colours: Float32Array;
    /** For each triangle: the number of its material in the file, or 2^32 - 1. */
    readonly materials: Uint32Array;
}

export interface Mesh extends MeshArrays {}
export class Mesh {
    /** weld joins vertices at equal positions; uv and materials stay with the corners. Needs init(). */
    constructor(positions: ArrayLike<number>, triangles: ArrayLike<number>,
                options?: { uv?: ArrayLike<number>; materials?: ArrayLike<number>; weld?: boolean });
    inspect(): Inspection;
    /** A closed, oriented manifold, as far as that is possible. */
    repair(): Mesh;
    /** One solid of parts that pass through each other. */
    unite(): Mesh;
    dispose(): void;
}

export type Pattern = "uniform" | "clustered" | "radial" | "grid" | "bricks" | "slices" | "splinters" | "curve"
    | "curvature" | "thickness";
export type Material = "glass" | "stone" | "concrete" | "wood" | "ceramic" | "brick";

export interface FractureSettings {
    /** A number of sites of the pattern (100), or the sites themselves, three numbers each. */
    sites?: number | ArrayLike<number>;
    /** m^2, one a site: larger cells for heavier sites. */
    weights?: ArrayLike<number>;
    seed?: number;
    /** Gives pattern, roughness, grain and detail where they are left out. */
    material?: Material;
    pattern?: Pattern;
    /** m; replaces the number of sites. */
    pieceSize?: number;
    jitter?: number;
    /** 0 to 1 along each side of the box. */
    focus?: [number, number, number];
    axis?: [number, number, number];
    spread?: number;
    slenderness?: number;
    grading?: number;
    cellsPerPiece?: number;
    /** Only sites inside the solid; by default those of uniform and clustered patterns. */
    inside?: boolean;
    /** Of the cuts, 0 (flat) to 1. */
    roughness?: number;
    wavelength?: number;
    grain?: [number, number, number];
    detail?: number;
    /** m^3; smaller pieces join a neighbour. */
    minVolume?: number;
}

export interface Piece {
    index: number;
    positions: Float64Array;
    /** Those of the outside first. */
    triangles: Uint32Array;
    exteriorTriangles: number;
    /** m^3 */
    volume: number;
    /** Centre of mass. */
    centre: Float64Array;
}

export interface SurfacePart {
    /** Of the mesh; null for cuts, and for a mesh without materials. */
    material: number | null;
    interior: boolean;
    /** Relative to the centre of mass. */
    positions: Float32Array;
    normals: Float32Array;
    /** v points down; empty where there are none. */
    uv: Float32Array;
    triangles: Uint32Array;
    /** The vertex of the piece at each of these. */
    vertices: Uint32Array;
}

export interface Certificate {
    pieces: number;
    closed: boolean;
    openPieces: number;
    cells: number;
    volumeInput: number;
    volumeSum: number;
    volumeError: number;
    smallestPiece: number;
    trianglesIn: number;
    trianglesOut: number;
    hash: string;
}

export interface Hull {
    /** Relative to the centre of mass of the piece. */
    points: Float32Array;
    /** m: thickness of the collision shell around the points. */
    margin: number;
}

/** Surfaces of all pieces one after another. A row of `parts` for each part: piece, material (2^32 - 1 for none), 1 for
 *  cuts, first vertex, vertices, first triangle, triangles, 1 where it has texture coordinates. */
export interface Surfaces {
    parts: Uint32Array;
    positions: Float32Array;
    normals: Float32Array;
    uv: Float32Array;
    triangles: Uint32Array;
    vertices: Uint32Array;
}

/** The pieces of a fracture. */
export class Pieces implements Iterable<Piece> {
    readonly length: number;
    readonly volumes: Float64Array;
    readonly areas: Float64Array;
    readonly centres: Float64Array;
    /** Nine numbers each, about the centre at density 1, m^5. */
    readonly inertias: Float64Array;
    readonly sites: Uint32Array;
    /** Two pieces each, the lower number first. */
    readonly bonds: Uint32Array;
    readonly bondAreas: Float64Array;
    readonly bondCentroids: Float64Array;
    /** From the first piece to the second. */
    readonly bondNormals: Float64Array;
    readonly certificate: Certificate;
    readonly hash: string;
    readonly surfaces: Surfaces;
    piece(index: number): Piece;
    [Symbol.iterator](): Iterator<Piece>;
    /** Buffers for drawing: a part for each material, then the cuts. */
    surface(index: number): SurfacePart[];
    /** Convex hulls for collisions; those of a Fracture have 64 points at most, one hull a piece. */
    hulls(index: number): Hull[];
}

/** Pieces in the memory of the library. Arrays are copied out when they are asked for first. */
export class Fracture extends Pieces {
    /** A .glb, .obj, .ply or .stl file. */
    toBytes(name?: string): Uint8Array;
    dispose(): void;
}

/** A number from 1 to 64; "auto" is one thread a core, 8 at most, and one where threads are not possible. */
export type ThreadCount = number | "auto";

/**
 * Loads the library. The other functions do it when they are called; `new Mesh()` needs it. `threads`: 1 if left out. More
 * than one needs shared memory: node, or a worker of a page that is cross-origin isolated, which a server makes it by the
 * headers `Cross-Origin-Opener-Policy: same-origin` and `Cross-Origin-Embedder-Policy: require-corp`. Pieces are the same.
 * The first call decides.
 */
export function init(options?: { threads?: ThreadCount }): Promise<void>;
/** The number of threads that the library uses. Needs init(). */
export function threads(): number;

export interface MaterialProperties {
    /** kg/m^3 */
    density: number;
    friction: number;
    restitution: number;
    /** Of cuts, as in FractureSettings. */
    roughness: number;
    pattern: Pattern;
    /** Strength, Pa. */
    tensile: number;
    /** Linear colours of the original surface and of cuts. */
    exterior: [number, number, number];
    interior: [number, number, number];
}

/** The materials by name. */
export function materials(): Promise<Record<Material, MaterialProperties>>;
/** Bytes of memory that the library holds. They grow as needed, and never shrink. */
export function heapBytes(): number;
export function version(): Promise<string>;

/** Reads the bytes of a mesh file; `extension` names the format: ".glb", ".obj", ".stl", ".ply", ".off" or ".3ds". */
export function load(bytes: ArrayBuffer | Uint8Array, extension: string): Promise<Mesh>;
/** A procedural shape: "cube", "icosphere:4", "torus", "animal", "statue", ... */
export function shape(name: string): Promise<Mesh>;

export interface FractureControl {
    /** The completed share of the work, 0 to 1. */
    onProgress?: (share: number) => void;
    /** Ends the work with its reason. The call blocks its thread, so only onProgress can abort it. */
    signal?: AbortSignal;
    /** Asked often; true ends the work with the status cancelled. It may read shared memory. */
    isCancelled?: () => boolean;
}

/** Cuts a closed mesh into watertight pieces, on this thread. `brittle-fracture/worker` does it on another one. */
export function fracture(mesh: Mesh, settings?: FractureSettings, control?: FractureControl): Promise<Fracture>;
