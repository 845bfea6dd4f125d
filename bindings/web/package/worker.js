// The side of the worker: answers the calls of client.js, one after another.
import { Mesh, fracture, init, load, materials, shape, threads } from "./brittle.js";

const port = typeof self === "object" && self.postMessage ? self : (await import("node:worker_threads")).parentPort;
const meshes = new Map();

const WORK = {
    async load({ id, bytes, extension }) { meshes.set(id, await load(bytes, extension)); },
    async shape({ id, name }) { meshes.set(id, await shape(name)); },
    async threads() { return [threads()]; },
    async arrays({ id, positions, triangles, options }) {
        meshes.set(id, new Mesh(positions, triangles, options));
    },
    async repair({ id, of }) { meshes.set(id, meshes.get(of).repair()); },
    async unite({ id, of }) { meshes.set(id, meshes.get(of).unite()); },
    async materials() { return [await materials()]; },
    async inspect({ of }) { return [meshes.get(of).inspect()]; },
    async mesh({ of }) {
        const { positions, triangles, normals, uv, uv2, colours, materials } = meshes.get(of);
        const arrays = { positions, triangles, normals, uv, uv2, colours, materials };
        return [arrays, Object.values(arrays).map(({ buffer }) => buffer)];
    },
    async dispose({ of }) {
        meshes.get(of)?.dispose();
        meshes.delete(of);
    },
    async fracture({ of, settings, want, flag, call }) {
        const begin = performance.now();
        const broken = await fracture(meshes.get(of), settings, {
            onProgress: (share) => port.postMessage({ call, share }),
            isCancelled: flag ? () => Atomics.load(flag, 0) !== 0 : undefined,
        });
        try {
            const milliseconds = performance.now() - begin;
            const data = { ...broken.toData(want), milliseconds };
            const buffers = new Set();
            for (const group of [data.arrays, data.surfaces ?? {}, data.hulls ?? {}])
                for (const value of Object.values(group)) buffers.add(value.buffer);
            return [data, [...buffers]];
        } finally {
            broken.dispose();
        }
    },
    async save({ of, settings, name }) {
        const broken = await fracture(meshes.get(of), settings);
        try {
            const bytes = broken.toBytes(name);
            return [bytes, [bytes.buffer]];
        } finally {
            broken.dispose();
        }
    },
};

let ready = null; // the first message says with how many threads
let last = Promise.resolve();
const answer = (message) => {
    last = last.then(async () => {
        try {
            await (ready ??= init({ threads: message.threads ?? 1 }));
            const [value, buffers = []] = await WORK[message.work](message) ?? [];
            port.postMessage({ call: message.call, value }, buffers);
        } catch (error) {
            // Emscripten throws a word where another thread crashed.
            const { status = "internal_error", message: text = "a thread of the library crashed" } = error;
            const trapped = error instanceof WebAssembly.RuntimeError || error === "unwind";
            port.postMessage({ call: message.call, error: { status, message: text, trapped } });
        }
    });
};
if (port.on) port.on("message", answer);
else port.onmessage = ({ data }) => answer(data);
