// Tests of the npm package in node: tools/test-web builds it and runs them.
import assert from "node:assert/strict";
import { execFileSync } from "node:child_process";
import fs from "node:fs";
import os from "node:os";
import path from "node:path";
import test from "node:test";

import { BrittleError, Mesh, fracture, init, load, shape, version } from "../../build/web/brittle-fracture/brittle.js";
import { column, tetrahedron } from "./models.mjs";

const ROOT = new URL("../../", import.meta.url).pathname;
const BUNNY = "/usr/share/glmark2/models/bunny.obj";
const TETRAHEDRON = [[0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 1], [0, 2, 1, 0, 1, 3, 1, 2, 3, 0, 3, 2]];

await init();
const bunny = await load(fs.readFileSync(BUNNY), ".obj");

/** The hash that the command line prints. */
function commandHash(mesh, ...options) {
    const folder = fs.mkdtempSync(path.join(os.tmpdir(), "brittle-"));
    try {
        const printed = execFileSync(path.join(ROOT, "build/release/bin/brittle"),
            ["fracture", mesh, "-o", path.join(folder, "pieces.ply"), ...options], { encoding: "utf8" });
        return /^ *hash +([0-9a-f]{16})/m.exec(printed)[1];
    } finally {
        fs.rmSync(folder, { recursive: true });
    }
}

function volume(positions, triangles) {
    let sum = 0;
    for (let t = 0; t < triangles.length; t += 3) {
        const [a, b, c] = [0, 1, 2].map((k) => positions.subarray(3 * triangles[t + k], 3 * triangles[t + k] + 3));
        sum += a[0] * (b[1] * c[2] - b[2] * c[1]) + a[1] * (b[2] * c[0] - b[0] * c[2]) + a[2] * (b[0] * c[1] - b[1] * c[0]);
    }
    return sum / 6;
}

function isClosed(triangles) {
    const edges = new Set();
    for (let t = 0; t < triangles.length; t += 3)
        for (let k = 0; k < 3; ++k) {
            const edge = `${triangles[t + k]} ${triangles[t + (k + 1) % 3]}`;
            if (edges.has(edge)) return false;
            edges.add(edge);
        }
    return [...edges].every((edge) => edges.has(edge.split(" ").reverse().join(" ")));
}

for (const [settings, options] of [
    [{ sites: 100 }, ["-n", "100"]],
    [{ sites: 1000, seed: 5 }, ["-n", "1000", "--seed", "5"]],
    [{ sites: 100, roughness: 0.3 }, ["-n", "100", "--roughness", "0.3"]],
    [{ sites: 60, pattern: "radial", focus: [0.2, 0.5, 0.9] }, ["-n", "60", "--pattern", "radial", "--focus", "0.2,0.5,0.9"]],
    ...["stone", "wood", "brick"].map((material) => [{ sites: 40, material }, ["-n", "40", "--material", material]]),
]) {
    test(`the hash is that of the command line: ${JSON.stringify(settings)}`, async () => {
        const broken = await fracture(bunny, settings);
        assert.equal(broken.hash, commandHash(BUNNY, ...options));
        broken.dispose();
    });
}

test("pieces are closed and fill the mesh", async () => {
    const torus = await shape("torus"), broken = await fracture(torus, { sites: 30, seed: 4 });
    let sum = 0;
    for (const piece of broken) {
        assert.ok(isClosed(piece.triangles));
        assert.ok(Math.abs(volume(piece.positions, piece.triangles) - piece.volume) < 1e-9);
        sum += piece.volume;
    }
    assert.ok(Math.abs(sum - volume(torus.positions, torus.triangles)) < 1e-9);
    assert.ok(broken.certificate.closed && broken.certificate.openPieces === 0);
    assert.throws(() => broken.piece(broken.length), /there is no piece/);
});

test("arrays of the caller, sites and weights", async () => {
    const mesh = new Mesh(...TETRAHEDRON);
    const halves = await fracture(mesh, { sites: [-0.2, 0.2, 0.2, 0.6, 0.2, 0.2] });
    assert.deepEqual([...halves.bonds], [0, 1]);
    assert.ok(Math.abs(halves.volumes[0] + halves.volumes[1] - 1 / 6) < 1e-12);
    const heavier = await fracture(mesh, { sites: [-0.2, 0.2, 0.2, 0.6, 0.2, 0.2], weights: [0.1, 0] });
    assert.ok(heavier.volumes[0] > halves.volumes[0]);
    const soup = new Float32Array(TETRAHEDRON[1].flatMap((v) => TETRAHEDRON[0].slice(3 * v, 3 * v + 3)));
    const joined = new Mesh(soup, Uint16Array.from({ length: 12 }, (_, k) => k), { weld: true });
    assert.equal(joined.positions.length, 12);
});

test("buffers for drawing, and export", async () => {
    const broken = await fracture(await shape("icosphere:3"), { sites: 12 });
    for (const piece of broken) {
        const parts = broken.surface(piece.index);
        const outside = parts.filter((part) => !part.interior).reduce((sum, part) => sum + part.triangles.length / 3, 0);
        assert.equal(outside, piece.exteriorTriangles);
        for (const part of parts)
            for (let v = 0; v < part.vertices.length; ++v)
                for (let k = 0; k < 3; ++k)
                    assert.equal(part.positions[3 * v + k],
                        Math.fround(piece.positions[3 * part.vertices[v] + k] - piece.centre[k]));
    }
    const glb = broken.toBytes("pieces.glb");
    assert.equal(new TextDecoder().decode(glb.subarray(0, 4)), "glTF");
    const back = await load(glb, ".glb");
    assert.ok(Math.abs(volume(back.positions, back.triangles) - broken.certificate.volumeSum) < 1e-4);
});

test("a mesh gives the normals, texture coordinates, colours and materials of its file", async () => {
    const mesh = await load(column(Buffer.from("no image")), ".glb");
    const { positions, triangles, normals, uv, materials } = mesh;
    assert.equal(positions.length, 3 * 8); // welded, but the corners stay apart
    assert.deepEqual([...materials], [1, 1, 1, 1, 1, 1, 1, 1, 0, 0, 0, 0]);
    for (let corner = 0; corner < triangles.length; ++corner) {
        if (materials[Math.floor(corner / 3)] === 1) assert.equal(uv[2 * corner + 1], 1 - positions[3 * triangles[corner] + 1] / 2);
        const face = [0, 1, 2].map((k) => triangles[3 * Math.floor(corner / 3) + k]);
        const axis = [0, 1, 2].findIndex((k) => face.every((v) => positions[3 * v + k] === positions[3 * face[0] + k]));
        const expected = [0, 0, 0];
        expected[axis] = positions[3 * face[0] + axis] > 0 ? 1 : -1;
        assert.deepEqual([...normals.subarray(3 * corner, 3 * corner + 3)].map((x) => x + 0), expected);
    }
    assert.equal(uv.length, 2 * triangles.length);
    assert.deepEqual([mesh.uv2.length, mesh.colours.length], [0, 0]);
    const red = "255 0 0", coloured = await load(Buffer.from(tetrahedron(red, "0 0 255", red, red)), ".off");
    assert.deepEqual([...coloured.colours], [...coloured.triangles].flatMap((v) => v === 1 ? [0, 0, 1, 1] : [1, 0, 0, 1]));
    assert.deepEqual([coloured.uv.length, coloured.materials.length], [0, 0]);
});

test("refusals have a status and say what to do", async () => {
    const refusal = async (work, status, words) => {
        await assert.rejects(async () => work(), (error) => {
            assert.ok(error instanceof BrittleError, String(error));
            assert.equal(error.status, status);
            assert.match(error.message, words);
            return true;
        });
    };
    const open = new Mesh(TETRAHEDRON[0], TETRAHEDRON[1].slice(3));
    assert.equal(open.inspect().refusal, "not_closed");
    await refusal(() => fracture(open), "not_closed", /3 open edges.*repair/);
    assert.equal(open.repair().inspect().refusal, null);
    await refusal(() => load(new Uint8Array([1, 2, 3]), ".glb"), "malformed_file", /./);
    await refusal(() => load(new Uint8Array(0), ".xyz"), "unsupported_format", /xyz/);
    await refusal(() => shape("duck"), "invalid_argument", /torus/);
    await refusal(() => fracture(bunny, { material: "rubber" }), "invalid_argument", /glass, stone/);
    await refusal(() => fracture(bunny, { sights: 3 }), "invalid_setting", /there is no setting sights/);
    await refusal(() => fracture(bunny, { roughness: 7 }), "invalid_setting", /roughness/);
    await refusal(() => fracture(bunny, { sites: -1 }), "invalid_argument", /sites is -1/);
    await refusal(() => fracture(bunny, { sites: [NaN, 0, 0] }), "invalid_sites", /./);
    await refusal(() => fracture({}), "invalid_argument", /Mesh/);
    await refusal(() => new Mesh([0, 0], [0, 1, 2]), "invalid_argument", /positions/);
    await refusal(() => new Mesh(TETRAHEDRON[0], [0, 1, 9]), "invalid_mesh", /9/);
    const gone = await shape("cube");
    gone.dispose();
    gone.dispose();
    await refusal(() => gone.inspect(), "invalid_argument", /disposed/);
});

test("the example of the documentation runs", () => {
    const page = fs.readFileSync(path.join(ROOT, "docs/bindings.md"), "utf8");
    const example = /^```javascript\n(.*?)^```$/ms.exec(page)[1];
    const folder = fs.mkdtempSync(path.join(os.tmpdir(), "brittle-"));
    try {
        fs.mkdirSync(path.join(folder, "node_modules"));
        fs.symlinkSync(path.join(ROOT, "build/web/brittle-fracture"), path.join(folder, "node_modules/brittle-fracture"));
        fs.copyFileSync(BUNNY, path.join(folder, "bunny.obj"));
        fs.writeFileSync(path.join(folder, "example.mjs"), example);
        const printed = execFileSync("node", ["example.mjs"], { cwd: folder, encoding: "utf8" });
        assert.match(printed, /closed: true/);
        assert.ok(fs.statSync(path.join(folder, "javascript.glb")).size > 1e6);
    } finally {
        fs.rmSync(folder, { recursive: true });
    }
});

test("the version is that of the package", async () => {
    const { version: expected } = JSON.parse(fs.readFileSync(path.join(ROOT, "bindings/web/package/package.json"), "utf8"));
    assert.equal(await version(), expected);
});
