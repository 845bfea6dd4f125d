// The npm package with threads, in node and in Chromium: the same pieces, memory, cancelling, and where threads are refused.
import assert from "node:assert/strict";
import { spawn, spawnSync } from "node:child_process";
import fs from "node:fs";
import { createRequire, syncBuiltinESMExports } from "node:module";
import os from "node:os";
import path from "node:path";
import test from "node:test";
import workerThreads from "node:worker_threads";

import { BrittleWorker } from "../../build/web/brittle-fracture/client.js";

const ROOT = new URL("../../", import.meta.url).pathname, PACKAGE = path.join(ROOT, "build/web/brittle-fracture");
const BUNNY = fs.readFileSync("/usr/share/glmark2/models/bunny.obj");

// Each is a library of its own: init() decides once how many threads it has.
let instances = 0;
const another = () => import(`../../build/web/brittle-fracture/brittle.js?${++instances}`);

/** A library with so many threads, how many workers of it have begun to work, and a mesh. */
async function library(threads) {
    const { Worker } = workerThreads;
    let begun = 0;
    workerThreads.Worker = class extends Worker {
        postMessage(message, ...rest) {
            if (message.cmd === "run") ++begun;
            super.postMessage(message, ...rest);
        }
    };
    syncBuiltinESMExports();
    try {
        const brittle = await another();
        await brittle.init({ threads });
        return { brittle, begun: () => begun, bunny: await brittle.load(BUNNY, ".obj") };
    } finally {
        workerThreads.Worker = Worker;
        syncBuiltinESMExports();
    }
}

const refuses = (work, status, words) => assert.rejects(async () => work(), (error) => {
    assert.equal(error.name, "BrittleError", String(error));
    assert.equal(error.status, status);
    assert.match(error.message, words);
    return true;
});

const [one, two, four] = [await library(1), await library(2), await library(4)];

test("so many threads work as were asked for", async () => {
    for (const [{ brittle, begun, bunny }, count] of [[one, 1], [two, 2], [four, 4]]) {
        (await brittle.fracture(bunny, { sites: 100 })).dispose();
        assert.equal(brittle.threads(), count);
        assert.equal(begun(), count - 1); // the calling thread is one of them
    }
});

for (const settings of [{ sites: 100 }, { sites: 1000, seed: 5 }, { sites: 60, roughness: 0.5 }, { sites: 40, material: "wood" },
                        { sites: 100, cellsPerPiece: 4 }, { sites: 200, minVolume: 1e-6 }]) {
    test(`the pieces are the same with 1, 2 and 4 threads: ${JSON.stringify(settings)}`, async () => {
        const results = [];
        for (const { brittle, bunny } of [one, two, four]) {
            const broken = await brittle.fracture(bunny, settings);
            const last = broken.piece(broken.length - 1), file = broken.toBytes("pieces.ply");
            assert.ok([last.positions, last.triangles, file].every(({ buffer }) => buffer instanceof ArrayBuffer)); // memory of nobody else
            results.push({ certificate: broken.certificate, last, file });
            broken.dispose();
        }
        assert.ok(results[0].certificate.closed);
        assert.deepEqual(results[1], results[0]);
        assert.deepEqual(results[2], results[0]);
    });
}

test("repair and union are the same with threads", async () => {
    const results = [];
    for (const { brittle } of [one, four]) {
        const ball = await brittle.shape("icosphere:4"), positions = [...ball.positions, ...ball.positions.map((x) => x + 0.3)];
        const moved = Array.from(ball.triangles, (v) => v + ball.positions.length / 3);
        const both = new brittle.Mesh(positions, [...ball.triangles, ...moved]).unite();
        const open = new brittle.Mesh(ball.positions, ball.triangles.slice(3)).repair();
        results.push([both, open].map(({ positions, triangles }) => ({ positions, triangles })));
    }
    assert.deepEqual(results[1], results[0]);
});

test("memory stays constant over 300 fractures with threads", async () => {
    const { brittle } = await library(2), cube = await brittle.shape("icosphere:3");
    const work = async (times) => {
        for (let seed = 0; seed < times; ++seed) (await brittle.fracture(cube, { sites: 50, seed })).dispose();
    };
    await work(100);
    const before = brittle.heapBytes();
    await work(300);
    assert.equal(brittle.heapBytes(), before);
    const kept = []; // without dispose() the same work needs more
    while (brittle.heapBytes() === before && kept.length < 3000) kept.push(await brittle.fracture(cube, { sites: 50, seed: kept.length }));
    assert.ok(brittle.heapBytes() > before);
});

test("the calling thread cancels work of several threads", async () => {
    for (const { brittle } of [two, four]) {
        const statue = await brittle.shape("statue"), expected = (await brittle.fracture(statue, { sites: 10 })).hash;
        const control = new AbortController();
        await assert.rejects(brittle.fracture(statue, { sites: 500 }, { signal: control.signal, onProgress: () => control.abort() }),
            { name: "AbortError" });
        let asked = 0;
        await refuses(() => brittle.fracture(statue, { sites: 20000 }, { isCancelled: () => ++asked > 20 }), "cancelled", /./);
        assert.equal((await brittle.fracture(statue, { sites: 10 })).hash, expected);
    }
});

test("refusals keep their status with threads", async () => {
    const { brittle } = two, cube = await brittle.shape("cube");
    await refuses(() => brittle.fracture(cube, { roughness: 7 }), "invalid_setting", /roughness/);
    await refuses(() => brittle.load(new Uint8Array([1, 2, 3]), ".glb"), "malformed_file", /./);
    await refuses(() => brittle.shape("duck"), "invalid_argument", /torus/);
    await refuses(() => brittle.fracture(new brittle.Mesh(cube.positions, cube.triangles.slice(3))), "not_closed", /open edges.*repair/);
});

test("a worker with threads: progress, pieces, cancelling in the middle", async () => {
    const worker = new BrittleWorker({ threads: 4 });
    try {
        assert.equal(await worker.threads(), 4);
        const statue = await worker.shape("statue"), shares = [];
        const there = await worker.fracture(statue, { sites: 200, seed: 3 }, { hulls: {}, onProgress: (share) => shares.push(share) });
        const here = await one.brittle.fracture(await one.brittle.shape("statue"), { sites: 200, seed: 3 });
        assert.equal(there.hash, here.hash);
        assert.deepEqual(there.surface(0), here.surface(0));
        assert.ok(shares.length > 1 && shares.every((share, k) => share >= (shares[k - 1] ?? 0) && share <= 1));
        const control = new AbortController();
        const long = worker.fracture(statue, { sites: 20000, roughness: 1 }, { signal: control.signal, onProgress: () => control.abort() });
        await assert.rejects(long, { name: "AbortError" });
        assert.equal((await worker.fracture(statue, { sites: 200, seed: 3 })).hash, here.hash);
    } finally {
        worker.dispose();
    }
});

test("a program with threads ends when its work is done", () => {
    const folder = fs.mkdtempSync(path.join(os.tmpdir(), "brittle-")), program = path.join(folder, "program.mjs");
    fs.writeFileSync(program, `import { fracture, init, shape } from "${PACKAGE}/brittle.js";
        import { BrittleWorker } from "${PACKAGE}/client.js";
        await init({ threads: 3 });
        const worker = new BrittleWorker({ threads: 2 });
        const there = await worker.fracture(await worker.shape("torus"), { sites: 50 });
        console.log((await fracture(await shape("torus"), { sites: 50 })).hash === there.hash);`);
    try {
        const { status, stdout, stderr } = spawnSync("node", [program], { encoding: "utf8", timeout: 60_000 });
        assert.deepEqual({ status, stdout, stderr }, { status: 0, stdout: "true\n", stderr: "" });
    } finally {
        fs.rmSync(folder, { recursive: true });
    }
});

test("a number of threads that cannot be is refused", async () => {
    const brittle = await another();
    for (const threads of [0, -1, 1.5, 65, 1e9, NaN, Infinity, "2", "many", null, {}, Symbol("two")]) {
        await refuses(() => brittle.init({ threads }), "invalid_argument", /threads is .*from 1 to 64, or "auto"/);
        await refuses(() => new BrittleWorker({ threads }), "invalid_argument", /threads is .*from 1 to 64, or "auto"/);
    }
    await refuses(() => brittle.init({ thread: 2 }), "invalid_setting", /no option thread;/);
    await refuses(() => new BrittleWorker({ thread: 2 }), "invalid_setting", /no option thread;/);
    await brittle.init({ threads: 2 }); // a refusal leaves everything open
    await brittle.init();
    await brittle.init({ threads: 2 });
    await refuses(() => brittle.init({ threads: 3 }), "invalid_argument", /loaded with threads 2.*before/);
    assert.equal(brittle.threads(), 2);
});

test("without shared memory threads are refused, and auto is one", async () => {
    const memory = globalThis.SharedArrayBuffer, brittle = await another();
    delete globalThis.SharedArrayBuffer;
    try {
        for (const work of [() => brittle.init({ threads: 2 }), () => new BrittleWorker({ threads: 2 })])
            await refuses(work, "invalid_argument", /Cross-Origin-Opener-Policy: same-origin.*Cross-Origin-Embedder-Policy: require-corp/);
        await brittle.init({ threads: "auto" });
        assert.equal(brittle.threads(), 1);
    } finally {
        globalThis.SharedArrayBuffer = memory;
    }
});

test("where a thread cannot start, init() says so, and auto is one thread", async () => {
    const copy = fs.mkdtempSync(path.join(os.tmpdir(), "brittle-"));
    fs.cpSync(PACKAGE, copy, { recursive: true });
    fs.rmSync(path.join(copy, "thread.js"));
    try {
        await refuses(async () => (await import(path.join(copy, "brittle.js"))).init({ threads: 3 }), "internal_error", /a thread did not start.*thread\.js/);
        const brittle = await import(`${copy}/brittle.js?auto`);
        await brittle.init({ threads: "auto" });
        assert.equal(brittle.threads(), 1);
        assert.equal((await brittle.fracture(await brittle.shape("cube"), { sites: 20 })).certificate.closed, true);
    } finally {
        fs.rmSync(copy, { recursive: true });
    }
});

test("a thread that crashes ends the call, and the worker goes on", { timeout: 120_000 }, async () => {
    const copy = fs.mkdtempSync(path.join(os.tmpdir(), "brittle-")), glue = path.join(copy, "brittle_wasm_threads.mjs");
    fs.cpSync(PACKAGE, copy, { recursive: true });
    const growth = "function _emscripten_resize_heap(requestedSize){", text = fs.readFileSync(glue, "utf8");
    assert.ok(text.includes(growth));
    fs.writeFileSync(glue, text.replace(growth, `${growth}if(ENVIRONMENT_IS_PTHREAD)throw new WebAssembly.RuntimeError("a trap");`));
    try {
        const { BrittleWorker } = await import(path.join(copy, "client.js"));
        let crashes = 0;
        for (let k = 0; k < 5 && crashes === 0; ++k) { // memory may happen to grow on the calling thread alone
            const worker = new BrittleWorker({ threads: 4 }), ball = await worker.shape("icosphere:5");
            await worker.fracture(ball, { sites: 20000 }).catch((error) => {
                assert.equal(error.status, "internal_error");
                ++crashes;
            });
            assert.ok((await worker.fracture(ball, { sites: 20 })).length > 10);
            worker.dispose();
        }
        assert.equal(crashes, 1);
    } finally {
        fs.rmSync(copy, { recursive: true });
    }
});

/** Serves a folder and opens Chromium there. */
async function inChromium(folder, options, work) {
    const { chromium } = createRequire(path.join(ROOT, "build/web/package.json"))("playwright-core");
    const server = spawn("node", ["bindings/web/page/serve.mjs", "build/web", folder, "0", ...options], { cwd: ROOT, stdio: ["ignore", "pipe", "inherit"] });
    const address = await new Promise((resolve) => server.stdout.once("data", (text) => resolve(String(text).trim())));
    const browser = await chromium.launch({ executablePath: "/usr/bin/chromium", args: ["--no-sandbox", "--disable-dev-shm-usage", "--disable-gpu"] });
    try {
        const page = await browser.newPage();
        page.setDefaultTimeout(60_000);
        page.requests = [];
        page.on("request", (request) => page.requests.push(request.url().slice(address.length)));
        await page.goto(`${address}package.json`);
        await work(page);
    } finally {
        await browser.close();
        server.kill();
    }
}

/** Breaks the animal in a worker of the page, if it can. */
const breakThere = (page, options) => page.evaluate(async (given) => {
    const { BrittleWorker } = await import("/client.js");
    let worker = null;
    try {
        worker = new BrittleWorker(given);
        const broken = await worker.fracture(await worker.shape("animal"), { sites: 80 });
        const control = new AbortController();
        let cancelled = "";
        await worker.fracture(await worker.shape("icosphere:5"), { sites: 20000 }, { signal: control.signal, onProgress: () => control.abort() })
            .catch(({ name }) => cancelled = name);
        return { hash: broken.hash, threads: await worker.threads(), cancelled, after: (await worker.fracture(await worker.shape("animal"), { sites: 80 })).hash };
    } catch ({ status, message }) {
        return { status, message };
    } finally {
        worker?.dispose();
    }
}, options);

test("a page that is cross-origin isolated has threads in its workers", async () => {
    const { hash } = await one.brittle.fracture(await one.brittle.shape("animal"), { sites: 80 });
    await inChromium("build/web/brittle-fracture", [], async (page) => {
        for (const threads of [1, 2, 4, "auto"]) {
            page.requests.length = 0;
            const found = await breakThere(page, { threads });
            assert.deepEqual({ ...found, threads: 0 }, { hash, threads: 0, cancelled: "AbortError", after: hash });
            const cores = await page.evaluate(() => navigator.hardwareConcurrency);
            assert.equal(found.threads, threads === "auto" ? Math.min(cores, 8) : threads);
            const modules = page.requests.filter((url) => url.endsWith(".wasm"));
            assert.deepEqual(modules, [found.threads > 1 ? "brittle_wasm_threads.wasm" : "brittle_wasm.wasm"]);
        }
        const refusal = await page.evaluate(async () => (await import("/brittle.js")).init({ threads: 2 }).catch(({ message }) => message));
        assert.match(refusal, /page cannot wait.*BrittleWorker/);
        const auto = await page.evaluate(async () => {
            const brittle = await import("/brittle.js");
            await brittle.init({ threads: "auto" });
            return brittle.threads();
        });
        assert.equal(auto, 1);
    });
});

test("a page that is not isolated has one thread, and says how to have more", async () => {
    const { hash } = await one.brittle.fracture(await one.brittle.shape("animal"), { sites: 80 });
    await inChromium("build/web/brittle-fracture", ["--not-isolated"], async (page) => {
        for (const options of [undefined, { threads: "auto" }])
            assert.deepEqual(await breakThere(page, options), { hash, threads: 1, cancelled: "AbortError", after: hash });
        assert.deepEqual(page.requests.filter((url) => url.includes("threads.wasm") || url.endsWith("thread.js")), []);
        const { status, message } = await breakThere(page, { threads: 2 });
        assert.equal(status, "invalid_argument");
        assert.match(message, /Cross-Origin-Opener-Policy: same-origin.*Cross-Origin-Embedder-Policy: require-corp/);
    });
});
