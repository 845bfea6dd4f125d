// Runs in the page: the same mesh and sites through Brittle and through what else breaks meshes in a browser. A runner
// gets positions, triangles and sites, and gives the positions of the triangles of each piece, three corners each.
import { DestructibleMesh, FractureOptions } from "@dgreenheck/three-pinata";
import { BufferAttribute, BufferGeometry, Vector3 } from "three";
import { Brush, Evaluator, INTERSECTION } from "three-bvh-csg";
import { Mesh, fracture, init, load, shape } from "brittle-fracture";
import { BrittleWorker } from "brittle-fracture/worker";

const corners = (positions, triangles) => Float64Array.from({ length: 3 * triangles.length },
    (_, k) => positions[3 * triangles[Math.floor(k / 3)] + k % 3]);
const soup = (geometry) => geometry.index ? corners(geometry.attributes.position.array, geometry.index.array)
    : Float64Array.from(geometry.attributes.position.array);

function geometryOf(positions, triangles) {
    const geometry = new BufferGeometry();
    geometry.setAttribute("position", new BufferAttribute(Float32Array.from(positions), 3));
    geometry.setAttribute("uv", new BufferAttribute(new Float32Array(positions.length / 3 * 2), 2));
    geometry.setIndex(new BufferAttribute(Uint32Array.from(triangles), 1));
    geometry.computeVertexNormals();
    return geometry;
}

// Each prepares what is not measured, and returns the work that is.
const RUNNERS = {
    async brittle({ positions, triangles, sites }) {
        const mesh = new Mesh(positions, triangles);
        return async () => {
            const broken = await fracture(mesh, { sites });
            return () => Array.from(broken, (piece) => corners(piece.positions, piece.triangles));
        };
    },
    async "three-pinata"({ positions, triangles, sites }) {
        const mesh = new DestructibleMesh(geometryOf(positions, triangles));
        const seedPoints = Array.from({ length: sites.length / 3 }, (_, k) => new Vector3().fromArray(sites, 3 * k));
        const options = new FractureOptions({ fractureMethod: "voronoi", fragmentCount: seedPoints.length, voronoiOptions: { mode: "3D", seedPoints } });
        return async () => {
            const pieces = mesh.fracture(options);
            return () => pieces.map(({ geometry, position }) => soup(geometry).map((x, k) => x + position.getComponent(k % 3)));
        };
    },
    // It intersects meshes; the cells come from a large box that Brittle breaks at the same sites.
    async "three-bvh-csg"({ positions, triangles, sites }) {
        const brush = new Brush(geometryOf(positions, triangles)), size = 4 * Math.max(...positions.map(Math.abs));
        const box = new Mesh([0, 1, 2, 3, 4, 5, 6, 7].flatMap((c) => [c & 1, c >> 1 & 1, c >> 2].map((x) => (2 * x - 1) * size)),
            [0, 2, 3, 0, 3, 1, 4, 5, 7, 4, 7, 6, 0, 1, 5, 0, 5, 4, 2, 6, 7, 2, 7, 3, 0, 4, 6, 0, 6, 2, 1, 3, 7, 1, 7, 5]);
        const cells = Array.from(await fracture(box, { sites }), (cell) => new Brush(geometryOf(cell.positions, cell.triangles)));
        for (const one of [brush, ...cells]) one.updateMatrixWorld();
        const evaluator = new Evaluator();
        evaluator.useGroups = false;
        evaluator.attributes = ["position", "normal"];
        return async () => {
            const pieces = cells.map((cell) => {
                const result = evaluator.evaluate(brush, cell, INTERSECTION, new Brush()), { start, count } = result.geometry.drawRange;
                const all = soup(result.geometry);
                return all.slice(9 * Math.floor(start / 3), Number.isFinite(count) ? 3 * (start + count) : all.length);
            });
            return () => pieces.filter(({ length }) => length > 0);
        };
    },
};

/** Whether each edge of a piece has a neighbour, where vertices count as one within a millionth of the size. */
function isClosed(soup, size) {
    const grid = 1e-6 * size, vertices = new Map(), numbers = new Int32Array(soup.length / 3), edges = new Map();
    const key = (x, y, z) => `${x} ${y} ${z}`;
    for (let v = 0; v < numbers.length; ++v) {
        const at = [0, 1, 2].map((k) => soup[3 * v + k] / grid), cell = at.map(Math.floor);
        let found = -1;
        for (let n = 0; n < 27 && found < 0; ++n) {
            const list = vertices.get(key(cell[0] + n % 3 - 1, cell[1] + Math.floor(n / 3) % 3 - 1, cell[2] + Math.floor(n / 9) - 1));
            for (const other of list ?? [])
                if (Math.hypot(...at.map((x, k) => x - other.at[k])) <= 1) found = other.number;
        }
        if (found < 0) {
            found = v;
            const own = key(...cell);
            if (!vertices.has(own)) vertices.set(own, []);
            vertices.get(own).push({ at, number: v });
        }
        numbers[v] = found;
    }
    for (let t = 0; t < numbers.length; t += 3) {
        const [a, b, c] = numbers.subarray(t, t + 3);
        if (a === b || b === c || c === a) continue;
        for (const [from, to] of [[a, b], [b, c], [c, a]]) {
            const name = from < to ? `${from} ${to}` : `${to} ${from}`;
            edges.set(name, (edges.get(name) ?? 0) + (from < to ? 1 : -1));
        }
    }
    return [...edges.values()].every((sum) => sum === 0);
}

function volume(soup) {
    let sum = 0;
    for (let t = 0; t < soup.length; t += 9) {
        const [ax, ay, az, bx, by, bz, cx, cy, cz] = soup.subarray(t, t + 9);
        sum += ax * (by * cz - bz * cy) + ay * (bz * cx - bx * cz) + az * (bx * cy - by * cx);
    }
    return sum / 6;
}

globalThis.compare = async ({ runner, model, count, runs }) => {
    await init();
    const mesh = model.endsWith(".obj") ? await load(await (await fetch(model)).arrayBuffer(), ".obj") : await shape(model);
    const { positions, triangles } = mesh, whole = volume(corners(positions, triangles)), { min, max } = mesh.inspect();
    const size = Math.max(...max.map((x, k) => x - min[k]));
    // Uniform in the box, by a small generator of its own.
    let state = 12345;
    const random = () => (state = (Math.imul(state, 1664525) + 1013904223) >>> 0) / 2 ** 32;
    const sites = Float64Array.from({ length: 3 * count }, (_, k) => min[k % 3] + (max[k % 3] - min[k % 3]) * random());
    const times = [];
    let pieces = null;
    for (let run = 0; run < runs; ++run) {
        const work = await RUNNERS[runner]({ positions, triangles, sites }), begin = performance.now(), give = await work();
        times.push(performance.now() - begin);
        pieces = give();
    }
    const sum = pieces.reduce((total, piece) => total + volume(piece), 0);
    return { times, pieces: pieces.length, open: pieces.filter((piece) => !isClosed(piece, size)).length, error: Math.abs(sum - whole) / whole };
};

/** The longest pause of this thread, ms, while a worker breaks a mesh; and without it, which is the noise. */
globalThis.pauses = async ({ model, count }) => {
    const brittle = new BrittleWorker(), mesh = await brittle.load(await (await fetch(model)).arrayBuffer(), ".obj");
    await brittle.fracture(mesh, { sites: count });
    const watched = async (work) => {
        const channel = new MessageChannel();
        let last = performance.now(), longest = 0, going = true;
        channel.port1.onmessage = () => {
            const now = performance.now();
            longest = Math.max(longest, now - last);
            last = now;
            if (going) channel.port2.postMessage(0);
        };
        channel.port2.postMessage(0);
        await work();
        going = false;
        return longest;
    };
    const quiet = await watched(() => new Promise((resolve) => setTimeout(resolve, 300)));
    let pieces = 0;
    const busy = await watched(async () => pieces = (await brittle.fracture(mesh, { sites: count }, { hulls: {} })).length);
    brittle.dispose();
    return { quiet, busy, pieces };
};

/** The median time of the fracture in a worker with so many threads, ms. */
globalThis.threaded = async ({ model, count, threads, runs }) => {
    const brittle = new BrittleWorker({ threads }), mesh = await brittle.load(await (await fetch(model)).arrayBuffer(), ".obj"), times = [];
    for (let run = 0; run < runs; ++run) times.push((await brittle.fracture(mesh, { sites: count }, { surfaces: false })).milliseconds);
    brittle.dispose();
    return times.sort((a, b) => a - b)[Math.floor(runs / 2)];
};
