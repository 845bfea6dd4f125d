// Manifold as npm ships it, WebAssembly on one thread, for tools/compare: each given cell meets the mesh, and the result
// is decomposed. Many cells meet parts of the mesh, which boxes around groups of them have cut out first.
import Module from "manifold-3d";
import { serve } from "./adapter.mjs";

const BOXED = 8; // cells of a group, which the mesh is cut out for

await serve("Manifold 3.5.4 (npm)", async (task) => {
    const wasm = await Module();
    wasm.setup();
    const { Manifold, Mesh } = wasm;
    const solidOf = ({ points, triangles }) => new Manifold(new Mesh({ numProp: 3, vertProperties: Float32Array.from(points), triVerts: triangles }));
    const solid = solidOf(task.mesh), cells = task.cells.filter(({ triangles }) => triangles.length > 0).map(solidOf);
    let made = [];

    // Halves the cells along the longest side of their box until few are left.
    const work = (part, group) => {
        if (part.isEmpty()) return;
        if (group.length <= BOXED) {
            for (const cell of group) {
                const meeting = Manifold.intersection(part, cell);
                if (!meeting.isEmpty()) made.push(...meeting.decompose());
                meeting.delete();
            }
            return;
        }
        const middle = ({ min, max }, k) => (min[k] + max[k]) / 2, boxes = new Map(group.map((cell) => [cell, cell.boundingBox()]));
        const spread = [0, 1, 2].map((k) => { const at = group.map((cell) => middle(boxes.get(cell), k)); return Math.max(...at) - Math.min(...at); });
        const axis = spread.indexOf(Math.max(...spread));
        const sorted = [...group].sort((a, b) => middle(boxes.get(a), axis) - middle(boxes.get(b), axis));
        for (const half of [sorted.slice(0, sorted.length >> 1), sorted.slice(sorted.length >> 1)]) {
            const low = [0, 1, 2].map((k) => Math.min(...half.map((cell) => boxes.get(cell).min[k])) - 1e-3);
            const size = [0, 1, 2].map((k) => Math.max(...half.map((cell) => boxes.get(cell).max[k])) + 1e-3 - low[k]);
            const box = Manifold.cube(size).translate(low), inside = Manifold.intersection(part, box);
            work(inside, half);
            box.delete();
            inside.delete();
        }
    };
    return {
        run() {
            for (const piece of made) piece.delete();
            made = [];
            work(solid, cells);
            // Booleans are evaluated when a result is asked for.
            return made.filter((piece) => piece.numTri() > 0).length;
        },
        pieces: () => made.map((piece) => {
            const { vertProperties, triVerts, numProp } = piece.getMesh();
            return { points: Float64Array.from({ length: vertProperties.length / numProp * 3 },
                (_, k) => vertProperties[Math.floor(k / 3) * numProp + k % 3]), triangles: triVerts };
        }),
    };
});
