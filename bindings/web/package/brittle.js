// Brittle for JavaScript: see brittle.d.ts. The arrays that come out are copies; handles free their memory by dispose(),
// or when the garbage collector finds them.
import start from "./brittle_wasm.mjs";
import { BrittleError } from "./error.js";
import { ARRAYS, Pieces } from "./pieces.js";
import { autoThreads, checkThreads } from "./threads.js";

export { BrittleError, Pieces };

const IN_NODE = typeof process === "object" && Boolean(process.versions?.node);

let module = null;
let starting = null;
let asked = 1; // what the first init() was given
let running = 1;

/** Loads the library, with one thread or more. Everything else waits for it or needs it. */
export async function init(options = {}) {
    const { threads, ...unknown } = options;
    for (const name of Object.keys(unknown)) throw new BrittleError("invalid_setting", `init() has no option ${name}; it has threads`);
    if (threads !== undefined) {
        checkThreads(threads);
        if (threads !== 1 && threads !== "auto" && globalThis.window)
            throw new BrittleError("invalid_argument", "a page cannot wait for threads: with more than one thread, use the library in a worker, "
                + "by BrittleWorker of brittle-fracture/worker");
        if (starting && threads !== asked)
            throw new BrittleError("invalid_argument", `the library was loaded with threads ${asked}, and cannot change to ${threads}; `
                + "call init() before everything else");
    }
    if (!starting) {
        asked = threads ?? 1;
        starting = startModule();
    }
    return starting;
}

async function startModule() {
    const wanted = asked === "auto" ? await autoThreads() : asked;
    if (wanted > 1) {
        try {
            module = await startThreads(wanted);
            running = wanted;
            return;
        } catch (error) {
            if (asked !== "auto") throw error; // no room for workers, for example
        }
    }
    module = await start(await surroundings("brittle_wasm.wasm"));
}

/** Options of the module: its machine code, where it cannot be fetched. */
async function surroundings(file) {
    return IN_NODE ? { wasmBinary: await (await import("node:fs/promises")).readFile(new URL(file, import.meta.url)) } : {};
}

async function startThreads(threads) {
    const { default: start } = await import("./brittle_wasm_threads.mjs");
    const node = IN_NODE ? await import("node:worker_threads") : null, workers = [];
    let fail;
    const failed = new Promise((_, reject) => fail = (error) => reject(new BrittleError("internal_error",
        `a thread did not start: ${error.message ?? "its script thread.js could not be loaded"}`)));
    const newThread = () => {
        const worker = node ? new node.Worker(new URL("./thread.js", import.meta.url))
            : new Worker(new URL("./thread.js", import.meta.url), { type: "module" });
        if (node) {
            worker.on("message", (data) => worker.onmessage({ data }));
            worker.on("error", fail);
        } else {
            worker.addEventListener("error", fail);
        }
        workers.push(worker);
        return worker;
    };
    try {
        const started = await Promise.race([start({ ...await surroundings("brittle_wasm_threads.wasm"), threads, newThread }), failed]);
        for (const worker of workers) worker.unref?.(); // node ends when only they are left
        return started;
    } catch (error) {
        for (const worker of workers) worker.terminate();
        throw error;
    }
}

/** The number of threads that the library uses. */
export function threads() {
    need();
    return running;
}

function need() {
    if (!module) throw new BrittleError("invalid_argument", "the library is not loaded; await init() first");
    return module;
}

/** The memory of the library as it is now: another thread may have made it larger. */
const memory = () => module.wasmMemory ? module.wasmMemory.buffer : module.HEAPU8.buffer;

function refusal() {
    return new BrittleError(module.UTF8ToString(module._web_status()), module.UTF8ToString(module._web_message()));
}

/** Runs work(allocate) and frees what it allocates. */
function scoped(work) {
    const m = need(), addresses = [];
    const allocate = (size) => {
        const at = m._malloc(Math.max(size, 1));
        if (at === 0) throw new BrittleError("out_of_memory", `there is no memory for ${size} bytes`);
        addresses.push(at);
        return at;
    };
    try {
        return work({
            room: allocate,
            bytes(array) {
                const view = new Uint8Array(array.buffer, array.byteOffset, array.byteLength), at = allocate(view.length);
                new Uint8Array(memory()).set(view, at);
                return at;
            },
            text(string) {
                const size = m.lengthBytesUTF8(string) + 1, at = allocate(size);
                m.stringToUTF8(string, at, size);
                return at;
            },
        });
    } finally {
        for (const at of addresses) m._free(at);
    }
}

const registry = new FinalizationRegistry(({ address, free }) => module[free](address));

class Handle {
    #address;
    #free;
    constructor(address, free) {
        this.#address = address;
        this.#free = free;
        registry.register(this, { address, free }, this);
    }
    get address() {
        if (this.#address === 0) throw new BrittleError("invalid_argument", "it was disposed of");
        return this.#address;
    }
    dispose() {
        if (this.#address === 0) return;
        registry.unregister(this);
        module[this.#free](this.#address);
        this.#address = 0;
    }
}

const TYPES = [null, Float32Array, Float64Array, Uint16Array, Uint32Array];

/** A copy of an array of the library, row after row. */
function array(name, ...given) {
    const m = need();
    return scoped(({ room }) => {
        const at = room(20);
        if (!m[name](...given, at)) throw refusal();
        const [data, rows, columns, stride, type] = new Uint32Array(memory(), at, 5);
        const Type = TYPES[type], out = new Type(rows * columns), size = Type.BYTES_PER_ELEMENT;
        if (stride === columns * size) {
            out.set(new Type(memory(), data, out.length));
        } else {
            for (let row = 0; row < rows; ++row)
                out.set(new Type(memory(), data + row * stride, columns), row * columns);
        }
        return out;
    });
}

function count(value, name) {
    if (!Number.isInteger(value) || value < 0 || value > 0xffffffff)
        throw new BrittleError("invalid_argument", `${name} is ${value}; it must be an integer from 0 to 2^32 - 1`);
    return value;
}

function rows(values, columns, name, Type) {
    if (values == null || typeof values.length !== "number" || values.length % columns !== 0)
        throw new BrittleError("invalid_argument", `${name} must be an array with ${columns} numbers a row`);
    if (Type === Uint32Array && !(values instanceof Uint32Array || values instanceof Uint16Array))
        for (const value of values) count(value, name);
    return values instanceof Type ? values : Type.from(values);
}

/** A triangle mesh. It never changes; repair() and unite() return another one. */
export class Mesh {
    #handle;
    constructor(positions, triangles, { uv, materials, weld = false } = {}) {
        if (positions instanceof Handle) {
            this.#handle = positions;
            return;
        }
        const points = rows(positions, 3, "positions", Float64Array);
        const indices = rows(triangles, 3, "triangles", Uint32Array);
        const corners = uv == null ? null : rows(uv, 2, "uv", Float32Array);
        const numbers = materials == null ? null : rows(materials, 1, "materials", Uint32Array);
        if (corners && corners.length !== (points.length / 3) * 2)
            throw new BrittleError("invalid_argument", "uv must have two numbers for each vertex");
        if (numbers && numbers.length !== indices.length / 3)
            throw new BrittleError("invalid_argument", "materials must have a number for each triangle");
        this.#handle = scoped(({ bytes }) =>
            made(need()._web_mesh(bytes(points), points.length / 3, bytes(indices), indices.length / 3,
                corners ? bytes(corners) : 0, numbers ? bytes(numbers) : 0, weld ? 1 : 0), "_web_mesh_free"));
    }
    get address() { return this.#handle.address; }
    get positions() { return array("_web_mesh_array", this.address, 1); }
    get triangles() { return array("_web_mesh_array", this.address, 2); }
    get normals() { return array("_web_mesh_array", this.address, 3); }
    get uv() { return array("_web_mesh_array", this.address, 4); }
    get uv2() { return array("_web_mesh_array", this.address, 5); }
    get colours() { return array("_web_mesh_array", this.address, 6); }
    get materials() { return array("_web_mesh_array", this.address, 7); }
    inspect() { return answer(need()._web_mesh_inspect(this.address)); }
    repair() { return new Mesh(made(need()._web_mesh_repair(this.address), "_web_mesh_free")); }
    unite() { return new Mesh(made(need()._web_mesh_unite(this.address), "_web_mesh_free")); }
    dispose() { this.#handle.dispose(); }
}

function made(address, free) {
    if (address === 0) throw refusal();
    return new Handle(address, free);
}

function answer(address) {
    if (address === 0) throw refusal();
    return JSON.parse(module.UTF8ToString(address));
}

/** Reads the bytes of a mesh file; `extension` names the format: ".glb", ".obj", ".stl", ".ply", ".off" or ".3ds". */
export async function load(bytes, extension) {
    await init();
    const data = bytes instanceof Uint8Array ? bytes : new Uint8Array(bytes);
    return scoped((m) => new Mesh(made(need()._web_mesh_load(m.bytes(data), data.length, m.text(extension)),
        "_web_mesh_free")));
}

/** A procedural shape: "cube", "icosphere:4", "torus", "animal", "statue", ... */
export async function shape(name) {
    await init();
    return scoped(({ text }) => new Mesh(made(need()._web_mesh_shape(text(name)), "_web_mesh_free")));
}

/** The pieces of a fracture, in the memory of the library; what is asked for is copied once. */
export class Fracture extends Pieces {
    #handle;
    #copies = new Map();
    constructor(handle) {
        super({});
        this.#handle = handle;
    }
    get address() { return this.#handle.address; }
    #once(name, make) {
        if (!this.#copies.has(name)) this.#copies.set(name, make());
        return this.#copies.get(name);
    }
    array(name) { return this.#once(name, () => array("_web_pieces_array", this.address, ARRAYS[name])); }
    get certificate() { return this.#once("certificate", () => answer(need()._web_certificate(this.address))); }
    get surfaces() { return this.#once("surfaces", () => joinedSurfaces(this.address, this.length)); }
    makeHulls({ parts = 1, vertices = 64 } = {}) {
        const handle = made(need()._web_hulls(this.address, count(parts, "parts"), count(vertices, "vertices")),
            "_web_hulls_free");
        try {
            const [points, ranges, pieces, margins] = [1, 2, 3, 4].map((which) => array("_web_hulls_array", handle.address, which));
            return { points, ranges, pieces, margins };
        } finally {
            handle.dispose();
        }
    }
    get hullArrays() { return this.#once("hulls", () => this.makeHulls()); }
    /** Everything in plain arrays, which can be sent to another thread. */
    toData({ surfaces = true, hulls = null } = {}) {
        const data = { certificate: this.certificate, arrays: {} };
        for (const name of Object.keys(ARRAYS)) data.arrays[name] = this.array(name);
        if (surfaces) data.surfaces = this.surfaces;
        if (hulls) data.hulls = this.makeHulls(hulls);
        return data;
    }
    toBytes(name = "pieces.glb") {
        const m = need();
        const handle = scoped(({ text }) => made(m._web_save(this.address, text(name)), "_web_files_free"));
        try {
            return scoped(({ room }) => {
                const at = room(8);
                if (!m._web_file(handle.address, at)) throw refusal();
                const [data, size] = new Uint32Array(memory(), at, 2);
                return new Uint8Array(memory()).slice(data, data + size);
            });
        } finally {
            handle.dispose();
        }
    }
    dispose() { this.#handle.dispose(); }
}

/** The surfaces of all pieces one after another, and a table with a row for each part of one material. */
function joinedSurfaces(pieces, count) {
    const m = need(), rows = [], all = { positions: [], normals: [], uv: [], triangles: [], vertices: [] };
    let vertex = 0, triangle = 0;
    for (let piece = 0; piece < count; ++piece) {
        const handle = made(m._web_surface(pieces, piece), "_web_surface_free");
        try {
            for (let part = 0; part < m._web_surface_parts(handle.address); ++part) {
                const [material, interior] = scoped(({ room }) => {
                    const at = room(8);
                    if (!m._web_surface_part(handle.address, part, at)) throw refusal();
                    return new Uint32Array(memory(), at, 2).slice();
                });
                const [positions, normals, uv, triangles, vertices] =
                    [1, 2, 3, 6, 7].map((which) => array("_web_surface_array", handle.address, part, which));
                rows.push(piece, material, interior, vertex, vertices.length, triangle, triangles.length / 3,
                    uv.length > 0 ? 1 : 0);
                vertex += vertices.length;
                triangle += triangles.length / 3;
                all.positions.push(positions);
                all.normals.push(normals);
                all.uv.push(uv.length > 0 ? uv : new Float32Array(2 * vertices.length));
                all.triangles.push(triangles);
                all.vertices.push(vertices);
            }
        } finally {
            handle.dispose();
        }
    }
    const join = (arrays, Type) => {
        const out = new Type(arrays.reduce((sum, given) => sum + given.length, 0));
        arrays.reduce((at, given) => (out.set(given, at), at + given.length), 0);
        return out;
    };
    return { parts: Uint32Array.from(rows), positions: join(all.positions, Float32Array),
             normals: join(all.normals, Float32Array), uv: join(all.uv, Float32Array),
             triangles: join(all.triangles, Uint32Array), vertices: join(all.vertices, Uint32Array) };
}

/**
 * Cuts a closed mesh into watertight pieces, on this thread. onProgress gets the completed share; a signal that is
 * aborted by it, or by another thread through isCancelled, ends the work.
 */
export async function fracture(mesh, settings = {}, { onProgress, signal, isCancelled } = {}) {
    await init();
    signal?.throwIfAborted();
    if (!(mesh instanceof Mesh))
        throw new BrittleError("invalid_argument", "the first argument must be a Mesh, of load(), shape() or new Mesh()");
    const { sites = 100, weights, ...rest } = settings;
    const placed = typeof sites === "number" ? null : rows(sites, 3, "sites", Float64Array);
    const heavier = weights == null ? null : rows(weights, 1, "weights", Float64Array);
    if (heavier && (!placed || heavier.length !== placed.length / 3))
        throw new BrittleError("invalid_argument", "weights must have a number for each site");
    for (const [name, value] of Object.entries({ ...rest, sites: placed ? 1 : sites })) check(name, value);
    if (!placed) rest.sites = sites;
    need().tell = (share) => {
        if (share >= 0) onProgress?.(share);
        return signal?.aborted || isCancelled?.() ? 1 : 0;
    };
    try {
        return scoped(({ text, bytes }) => new Fracture(made(module._web_fracture(mesh.address, text(JSON.stringify(rest)),
            placed ? bytes(placed) : 0, heavier ? bytes(heavier) : 0, placed ? placed.length / 3 : 0), "_web_pieces_free")));
    } catch (error) {
        signal?.throwIfAborted();
        throw error;
    } finally {
        module.tell = null;
    }
}

const KINDS = { sites: "count", seed: "count", cellsPerPiece: "count", detail: "count", pieceSize: "number",
                jitter: "number", spread: "number", slenderness: "number", grading: "number", roughness: "number",
                wavelength: "number", minVolume: "number", pattern: "string", material: "string", inside: "boolean",
                focus: "vector", axis: "vector", grain: "vector" };

function check(name, value) {
    const kind = KINDS[name];
    if (kind === undefined)
        throw new BrittleError("invalid_setting",
            `there is no setting ${name}; the settings are: ${Object.keys(KINDS).join(", ")}, weights`);
    if (kind === "count") count(value, name);
    else if (kind === "vector" ? !(Array.isArray(value) && value.length === 3 && value.every(Number.isFinite))
        : kind === "number" ? !Number.isFinite(value) : typeof value !== kind)
        throw new BrittleError("invalid_setting",
            `${name} is ${value}; it must be a ${kind === "vector" ? "list of three numbers" : kind}`);
}

/** The materials by name: how they break, weigh and look. */
export async function materials() {
    await init();
    return answer(module._web_materials());
}

/** Bytes of memory that the library holds. They grow as needed, and never shrink. */
export function heapBytes() {
    need();
    return memory().byteLength;
}

/** The version of the library. */
export async function version() {
    await init();
    return module.UTF8ToString(module._web_version());
}
