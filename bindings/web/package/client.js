// The library in a worker: see client.d.ts. The calling thread only sends and receives arrays.
import { BrittleError } from "./error.js";
import { Pieces } from "./pieces.js";
import { checkThreads, sharesMemory } from "./threads.js";

/** What calls in flight meet when their worker was replaced: they begin again. */
const RESTARTED = Symbol("restarted");

/** A mesh in the worker. Where the worker had to be stopped, its successor makes the mesh again from `origin`. */
class RemoteMesh {
    #client;
    constructor(client, origin) {
        this.#client = client;
        this.origin = origin;
        this.id = 0;
    }
    inspect() { return this.#client.call("inspect", { of: this }); }
    arrays() { return this.#client.call("mesh", { of: this }); }
    repair({ signal } = {}) { return this.#client.make({ work: "repair", of: this }, signal); }
    unite({ signal } = {}) { return this.#client.make({ work: "unite", of: this }, signal); }
    dispose() { return this.#client.forget(this); }
}

export class BrittleWorker {
    #worker = null;
    #meshes = 0;
    #calls = 0;
    #waiting = new Map();
    #disposed = false;
    #threads;

    constructor(options = {}) {
        const { threads = 1, ...unknown } = options;
        for (const name of Object.keys(unknown)) throw new BrittleError("invalid_setting", `BrittleWorker has no option ${name}; it has threads`);
        checkThreads(threads);
        this.#threads = threads;
    }

    /** How many threads the library uses there. */
    threads() { return this.call("threads", {}); }
    load(bytes, extension, { signal } = {}) {
        return this.make({ work: "load", bytes: new Uint8Array(bytes), extension }, signal);
    }
    shape(name) { return this.make({ work: "shape", name }); }
    materials() { return this.call("materials", {}); }
    mesh(positions, triangles, options = {}) { return this.make({ work: "arrays", positions, triangles, options }); }

    async fracture(mesh, settings = {}, { signal, onProgress, surfaces = true, hulls = null } = {}) {
        const flag = sharesMemory() ? new Int32Array(new SharedArrayBuffer(4)) : null;
        const values = { of: mesh, settings, want: { surfaces, hulls }, flag };
        const data = await this.#abortable(signal, flag, () => this.call("fracture", values, { onProgress, signal }));
        return Object.assign(new Pieces(data), { milliseconds: data.milliseconds });
    }

    async save(mesh, settings = {}, name = "pieces.glb") { return this.call("save", { of: mesh, settings, name }); }

    /** Stops the worker; calls that wait for it fail. */
    dispose() {
        this.#disposed = true;
        this.#restart(new BrittleError("cancelled", "the worker was disposed of"));
    }

    // What follows is for RemoteMesh.

    async make(origin, signal) {
        const mesh = new RemoteMesh(this, origin);
        return this.#abortable(signal, null, async () => {
            for (;;) {
                try {
                    await this.#ensure(mesh, await this.#start());
                    return mesh;
                } catch (error) {
                    if (error !== RESTARTED || signal?.aborted) throw error;
                }
            }
        });
    }

    async call(work, values, { onProgress, signal } = {}) {
        for (;;) {
            try {
                const worker = await this.#start();
                if ("of" in values) await this.#ensure(values.of, worker);
                signal?.throwIfAborted();
                return await this.#send(worker, { work, ...values, of: values.of?.id }, onProgress);
            } catch (error) {
                if (error !== RESTARTED || signal?.aborted) throw error;
            }
        }
    }

    async forget(mesh) {
        mesh.origin = null;
        const worker = this.#worker && await this.#worker;
        if (!worker || mesh.worker !== worker) return;
        try {
            await this.#send(worker, { work: "dispose", of: mesh.id });
        } catch (error) {
            if (error !== RESTARTED) throw error; // the mesh went with the old worker
        }
    }

    /** Ends what a signal aborts: by the flag in shared memory, or else a new worker takes the place of the busy one. */
    async #abortable(signal, flag, run) {
        signal?.throwIfAborted();
        const cancel = () => flag ? Atomics.store(flag, 0, 1) : this.#restart(RESTARTED);
        signal?.addEventListener("abort", cancel, { once: true });
        try {
            return await run();
        } catch (error) {
            signal?.throwIfAborted();
            throw error;
        } finally {
            signal?.removeEventListener("abort", cancel);
        }
    }

    async #ensure(mesh, worker) {
        if (!(mesh instanceof RemoteMesh))
            throw new BrittleError("invalid_argument", "the first argument must be a mesh of this worker");
        if (!mesh.origin) throw new BrittleError("invalid_argument", "it was disposed of");
        if (mesh.worker === worker) return mesh.made;
        mesh.worker = worker;
        mesh.id = ++this.#meshes;
        const { of, ...origin } = mesh.origin;
        mesh.made = (async () => {
            if (of) await this.#ensure(of, worker);
            await this.#send(worker, { ...origin, id: mesh.id, of: of?.id });
        })();
        return mesh.made;
    }

    #start() {
        if (this.#disposed) throw new BrittleError("cancelled", "the worker was disposed of");
        this.#worker ??= (async () => {
            const address = new URL("./worker.js", import.meta.url);
            const receive = (message) => this.#receive(message);
            const fail = (error) => this.#restart(new BrittleError("internal_error",
                `the worker ended: ${error.message ?? "its script could not be loaded"}`));
            if (typeof Worker === "function") {
                const worker = new Worker(address, { type: "module" });
                worker.onmessage = ({ data }) => receive(data);
                worker.onerror = fail;
                return worker;
            }
            const threads = await import("node:worker_threads");
            const worker = new threads.Worker(address);
            worker.on("message", receive);
            worker.on("error", fail);
            worker.unref();
            return worker;
        })();
        return this.#worker;
    }

    #send(worker, message, onProgress) {
        const call = ++this.#calls;
        return new Promise((resolve, reject) => {
            this.#waiting.set(call, { resolve, reject, onProgress });
            if (this.#waiting.size === 1) worker.ref?.();
            worker.postMessage({ ...message, call, threads: this.#threads });
        }).finally(() => {
            if (this.#waiting.size === 0) worker.unref?.();
        });
    }

    #receive({ call, value, error, share }) {
        const waiting = this.#waiting.get(call);
        if (!waiting) return;
        if (share !== undefined) return waiting.onProgress?.(share);
        this.#waiting.delete(call);
        // After a trap the memory of the library is not to be trusted.
        if (error?.trapped) this.#restart(RESTARTED);
        if (error) waiting.reject(new BrittleError(error.status, error.message));
        else waiting.resolve(value);
    }

    #restart(error) {
        const worker = this.#worker;
        this.#worker = null;
        worker?.then((running) => running.terminate());
        for (const { reject } of this.#waiting.values()) reject(error);
        this.#waiting.clear();
    }
}
