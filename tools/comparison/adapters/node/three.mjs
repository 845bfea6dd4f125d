// three-pinata and three-bvh-csg for tools/compare, by the first word. Both compute in float.
//
//     node three.mjs MESH SITES CELLS 1 pinata   Voronoi fracture at the given sites
//     node three.mjs MESH SITES CELLS 1 csg      the mesh meets each given cell, with the triangulation that its manual
//                                                names for exact borders
import { DestructibleMesh, FractureOptions } from "@dgreenheck/three-pinata";
import { BufferAttribute, BufferGeometry, Vector3 } from "three";
import { Brush, Evaluator, INTERSECTION } from "three-bvh-csg";
import { serve } from "./adapter.mjs";

function geometryOf({ points, triangles }) {
    const geometry = new BufferGeometry();
    geometry.setAttribute("position", new BufferAttribute(Float32Array.from(points), 3));
    geometry.setAttribute("uv", new BufferAttribute(new Float32Array(points.length / 3 * 2), 2));
    geometry.setIndex(new BufferAttribute(Uint32Array.from(triangles), 1));
    geometry.computeVertexNormals();
    return geometry;
}

function partOf({ attributes, index, drawRange }, offset = [0, 0, 0]) {
    const total = index ? index.count : attributes.position.count, start = drawRange.start;
    const count = Math.min(total - start, Number.isFinite(drawRange.count) ? drawRange.count : total);
    return { points: Float64Array.from(attributes.position.array, (x, k) => x + offset[k % 3]),
        triangles: Uint32Array.from({ length: count }, (_, k) => index ? index.array[start + k] : start + k) };
}

const JOBS = {
    pinata(task) {
        const seedPoints = Array.from({ length: task.sites.length / 3 }, (_, k) => new Vector3().fromArray(task.sites, 3 * k));
        let pieces = [];
        return {
            run() {
                // A fractured mesh is not used again.
                const mesh = new DestructibleMesh(geometryOf(task.mesh));
                pieces = mesh.fracture(new FractureOptions({ fractureMethod: "voronoi", fragmentCount: seedPoints.length,
                    voronoiOptions: { mode: "3D", seedPoints } }));
                return pieces.length;
            },
            pieces: () => pieces.map(({ geometry, position }) => partOf(geometry, position.toArray())),
        };
    },
    csg(task) {
        const brush = new Brush(geometryOf(task.mesh));
        const cells = task.cells.filter(({ triangles }) => triangles.length > 0).map((cell) => new Brush(geometryOf(cell)));
        for (const one of [brush, ...cells]) one.updateMatrixWorld();
        const evaluator = new Evaluator();
        evaluator.useGroups = false;
        evaluator.attributes = ["position", "normal"];
        evaluator.useCDTClipping = true;
        let results = [];
        return {
            run() {
                results = cells.map((cell) => partOf(evaluator.evaluate(brush, cell, INTERSECTION, new Brush()).geometry));
                results = results.filter(({ triangles }) => triangles.length > 0);
                return results.length;
            },
            pieces: () => results,
        };
    },
};

const job = process.argv[6];
if (!JOBS[job]) throw new Error(`three.mjs needs the word pinata or csg, not ${job}`);
await serve(job === "csg" ? "three-bvh-csg 0.0.18" : "three-pinata 2.0.1", JOBS[job]);
