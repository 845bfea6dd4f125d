// How many threads the library may have here.
import { BrittleError } from "./error.js";

const MAX_THREADS = 64, MAX_AUTO = 8; // each thread is a worker of some megabytes

/** Whether workers can share memory: in pages that are cross-origin isolated, in their workers, and in node. */
export const sharesMemory = () => globalThis.crossOriginIsolated ?? typeof SharedArrayBuffer === "function";

/** Throws where `threads` is no number of threads, or more than this place can have. */
export function checkThreads(threads) {
    if (threads === "auto") return;
    if (!Number.isInteger(threads) || threads < 1 || threads > MAX_THREADS)
        throw new BrittleError("invalid_argument",
            `threads is ${String(threads)}; it must be an integer from 1 to ${MAX_THREADS}, or "auto"`);
    if (threads > 1 && !sharesMemory())
        throw new BrittleError("invalid_argument", `${threads} threads need shared memory, which browsers give only to pages that `
            + "are cross-origin isolated: serve the page and its scripts with the headers "
            + "\"Cross-Origin-Opener-Policy: same-origin\" and \"Cross-Origin-Embedder-Policy: require-corp\", or set threads to \"auto\"");
}

/** The number for "auto": one a core where that is possible. */
export async function autoThreads() {
    if (!sharesMemory() || globalThis.window) return 1;
    const cores = globalThis.navigator?.hardwareConcurrency ?? (await import("node:os")).cpus().length;
    return Math.min(Math.max(cores, 1), MAX_AUTO);
}
