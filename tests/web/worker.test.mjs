// The worker wrapper and the helpers for three.js, in node.
import assert from "node:assert/strict";
import { createRequire } from "node:module";
import path from "node:path";
import test from "node:test";

import { fracture, load, shape } from "../../build/web/brittle-fracture/brittle.js";
import { BrittleWorker } from "../../build/web/brittle-fracture/client.js";

const worker = new BrittleWorker();
test.after(() => worker.dispose());

test("a worker gives the pieces of the library", async () => {
    const here = await fracture(await shape("statue"), { sites: 40, seed: 3 });
    let last = 0, calls = 0;
    const there = await worker.fracture(await worker.shape("statue"), { sites: 40, seed: 3 }, {
        hulls: { parts: 2, vertices: 24 },
        onProgress(share) {
            assert.ok(share >= last && share <= 1);
            last = share;
            ++calls;
        },
    });
    assert.ok(calls > 1);
    assert.equal(there.hash, here.hash);
    assert.equal(there.length, here.length);
    assert.deepEqual(there.bonds, here.bonds);
    for (const piece of here) {
        assert.deepEqual(there.piece(piece.index), piece);
        assert.deepEqual(there.surface(piece.index), here.surface(piece.index));
    }
});

test("hulls lie in their pieces", async () => {
    const mesh = await shape("cube"), broken = await fracture(mesh, { sites: 20 });
    for (const piece of broken) {
        const hulls = broken.hulls(piece.index);
        assert.equal(hulls.length, 1);
        for (const { points, margin } of hulls) {
            assert.ok(points.length >= 12 && margin > 0);
            for (let k = 0; k < 3; ++k) {
                const of = (array, moved) => array.filter((_, at) => at % 3 === k).map((x) => x + moved);
                const inside = of(points, piece.centre[k]), around = of(piece.positions, 0);
                assert.ok(Math.min(...inside) >= Math.min(...around) && Math.max(...inside) <= Math.max(...around));
            }
        }
    }
    assert.throws(() => broken.hulls(99), /there is no piece 99/);
});

test("without hulls there are none", async () => {
    const broken = await worker.fracture(await worker.shape("cube"), { sites: 5 }, { surfaces: false });
    assert.throws(() => broken.hulls(0), /came without hulls/);
    assert.throws(() => broken.surface(0), /came without surfaces/);
});

test("materials have their properties", async () => {
    const { glass, stone } = await worker.materials();
    assert.equal(glass.roughness, 0);
    assert.ok(stone.density > 2000 && stone.tensile > 1e6);
    assert.equal(stone.exterior.length, 3);
    assert.equal(glass.pattern, "radial");
});

test("meshes are made of arrays, repaired and sent back", async () => {
    const open = await worker.mesh([0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 1], [0, 1, 3, 1, 2, 3, 2, 0, 3]);
    assert.equal((await open.inspect()).refusal, "not_closed");
    await assert.rejects(worker.fracture(open), { name: "BrittleError", status: "not_closed" });
    const closed = await open.repair();
    assert.equal((await closed.inspect()).refusal, null);
    const { positions, triangles } = await closed.arrays();
    assert.equal(triangles.length, 12);
    assert.equal(positions.length, 12);
    await closed.dispose();
    await assert.rejects(worker.fracture(closed), /disposed/);
    await assert.rejects(worker.load(new Uint8Array([1, 2]), ".glb"), { status: "malformed_file" });
    await assert.rejects(worker.fracture({}), { status: "invalid_argument" });
});

/** The same with shared memory and without: there a new worker takes the place of the busy one. */
for (const shared of [true, false]) {
    test(`a signal cancels, ${shared ? "through shared memory" : "by a new worker"}`, async () => {
        const memory = globalThis.SharedArrayBuffer;
        if (!shared) delete globalThis.SharedArrayBuffer;
        try {
            const statue = await worker.shape("statue");
            const expected = (await worker.fracture(statue, { sites: 10 })).hash;
            const control = new AbortController();
            let begun = false;
            const long = worker.fracture(statue, { sites: 20000, roughness: 1 }, {
                signal: control.signal,
                onProgress() {
                    begun = true;
                    control.abort();
                },
            });
            const other = worker.fracture(statue, { sites: 10 }); // waits behind, and is done all the same
            await assert.rejects(long, { name: "AbortError" });
            assert.ok(begun);
            assert.equal((await other).hash, expected);
            assert.equal((await worker.fracture(statue, { sites: 10 })).hash, expected);
            await assert.rejects(worker.fracture(statue, {}, { signal: AbortSignal.abort() }), { name: "AbortError" });
        } finally {
            globalThis.SharedArrayBuffer = memory;
        }
    });
}

test("progress can cancel on the calling thread, too", async () => {
    const control = new AbortController();
    await assert.rejects(fracture(await shape("statue"), { sites: 500 }, { signal: control.signal, onProgress: () => control.abort() }),
        { name: "AbortError" });
});

test("a worker that was disposed of says so", async () => {
    const brief = new BrittleWorker(), mesh = await brief.shape("cube");
    const waiting = brief.fracture(mesh, { sites: 5000 });
    setTimeout(() => brief.dispose(), 5);
    await assert.rejects(waiting, /disposed/);
    await assert.rejects(brief.fracture(mesh), /disposed/);
});

test("geometries for three.js", async () => {
    const THREE = createRequire(path.resolve("build/web/package.json"))("three");
    const { meshArrays, pieceGeometry } = await import("../../build/web/brittle-fracture/three.js");
    const { Mesh } = await import("../../build/web/brittle-fracture/brittle.js");
    const box = new Mesh(...meshArrays(new THREE.BoxGeometry(1, 2, 3))); // one material a side, of six
    assert.ok(Math.abs(box.inspect().volume - 6) < 1e-12);
    const broken = await fracture(box, { sites: 12 });
    let volume = 0;
    for (const piece of broken) {
        const geometry = pieceGeometry(broken, piece.index), { position } = geometry.attributes;
        const corners = geometry.index.array;
        assert.equal(corners.length, piece.triangles.length);
        assert.equal(geometry.groups.reduce((sum, { count }) => sum + count, 0), corners.length);
        const inside = geometry.groups.at(-1), exterior = corners.length - inside.count;
        assert.equal(exterior, 3 * piece.exteriorTriangles);
        assert.ok(geometry.groups.slice(0, -1).every(({ materialIndex }) => materialIndex < inside.materialIndex));
        const at = (corner) => new THREE.Vector3().fromBufferAttribute(position, corners[corner]);
        for (let t = 0; t < corners.length; t += 3) volume += at(t).dot(at(t + 1).cross(at(t + 2))) / 6;
        assert.equal(geometry.userData.volume, piece.volume);
    }
    assert.ok(Math.abs(volume - 6) < 1e-5);
    const soup = new THREE.IcosahedronGeometry(1, 2); // without an index
    assert.equal(new Mesh(...meshArrays(soup)).inspect().refusal, null);
});

test("reading a file is cancelled, and the worker goes on with other meshes", async () => {
    const cube = await worker.shape("cube"), expected = (await worker.fracture(cube, { sites: 5 })).hash;
    const lines = Array.from({ length: 300_000 }, (_, k) => `v ${k} 0 0\n`).join("");
    const control = new AbortController(), reading = worker.load(new TextEncoder().encode(lines), ".obj", { signal: control.signal });
    setTimeout(() => control.abort(), 10);
    await assert.rejects(reading, { name: "AbortError" });
    assert.equal((await worker.fracture(cube, { sites: 5 })).hash, expected);
});

test("a worker writes files", async () => {
    const cube = await worker.shape("cube"), bytes = await worker.save(cube, { sites: 6 }, "cube.glb");
    assert.deepEqual(bytes, (await fracture(await shape("cube"), { sites: 6 })).toBytes("cube.glb"));
    await assert.rejects(worker.save(cube, {}, "cube.xyz"), { status: "unsupported_format" });
});

test("a mesh file gives the same pieces in a worker", async () => {
    const bytes = new TextEncoder().encode("v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 3 2\nf 1 2 4\nf 2 3 4\nf 1 4 3\n");
    const [here, there] = [await load(bytes, ".obj"), await worker.load(bytes, ".obj")];
    assert.equal((await fracture(here, { sites: 7 })).hash, (await worker.fracture(there, { sites: 7 })).hash);
});
