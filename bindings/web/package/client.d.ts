/**
 * The library in a worker: the calling thread never waits.
 *
 *     const brittle = new BrittleWorker();
 *     const mesh = await brittle.load(bytes, ".glb");
 *     const pieces = await brittle.fracture(mesh, { sites: 100 }, { hulls: {}, onProgress: show, signal });
 *
 * Calls are done one after another. Bundlers find the worker by `new URL("./worker.js", import.meta.url)`.
 */
import type { FractureSettings, Inspection, Material, MaterialProperties, MeshArrays, Pieces, ThreadCount } from "./brittle.js";

/** A mesh in the worker. */
export interface RemoteMesh {
    inspect(): Promise<Inspection>;
    arrays(): Promise<MeshArrays>;
    repair(control?: { signal?: AbortSignal }): Promise<RemoteMesh>;
    unite(control?: { signal?: AbortSignal }): Promise<RemoteMesh>;
    dispose(): Promise<void>;
}

export interface WorkerControl {
    onProgress?: (share: number) => void;
    /** Ends the work within milliseconds where the page is cross-origin isolated; else a new worker takes the place of
     *  the busy one, and makes its meshes again when they are used. */
    signal?: AbortSignal;
    /** Whether buffers for drawing come along; true if left out. */
    surfaces?: boolean;
    /** Whether collision hulls come along: at most `parts` (1) a piece, of at most `vertices` (64) points. */
    hulls?: { parts?: number; vertices?: number } | null;
}

export class BrittleWorker {
    /** threads: of the library there, 1 if left out; see init(). */
    constructor(options?: { threads?: ThreadCount });
    /** The number of threads that the library uses there. */
    threads(): Promise<number>;
    /** The bytes must not change afterwards. */
    load(bytes: ArrayBuffer | Uint8Array, extension: string, control?: { signal?: AbortSignal }): Promise<RemoteMesh>;
    shape(name: string): Promise<RemoteMesh>;
    materials(): Promise<Record<Material, MaterialProperties>>;
    mesh(positions: ArrayLike<number>, triangles: ArrayLike<number>,
         options?: { uv?: ArrayLike<number>; materials?: ArrayLike<number>; weld?: boolean }): Promise<RemoteMesh>;
    /** milliseconds: of the fracture itself, in the worker. */
    fracture(mesh: RemoteMesh, settings?: FractureSettings, control?: WorkerControl): Promise<Pieces & { milliseconds: number }>;
    /** The pieces as a .glb, .obj, .ply or .stl file. The mesh is cut for it. */
    save(mesh: RemoteMesh, settings?: FractureSettings, name?: string): Promise<Uint8Array>;
    /** Stops the worker; calls that wait for it fail. */
    dispose(): void;
}
