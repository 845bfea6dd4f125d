// The pieces of a fracture as plain arrays: what a worker sends, and what the library itself gives out.
import { BrittleError } from "./error.js";

/** The arrays of the C interface, brittle_pieces_array(), by their numbers there. */
export const ARRAYS = { positions: 1, triangles: 2, triangleSources: 3, vertexRanges: 4, triangleRanges: 5, exteriorTriangles: 6, sites: 7,
                        volumes: 8, areas: 9, centres: 10, inertias: 11, bonds: 12, bondAreas: 13, bondCentroids: 14,
                        bondNormals: 15 };

/** Columns of the table of surface parts. */
const PIECE = 0, MATERIAL = 1, INTERIOR = 2, FIRST_VERTEX = 3, VERTICES = 4, FIRST_TRIANGLE = 5, TRIANGLES = 6,
      TEXTURED = 7;
export const PART_COLUMNS = 8;
const NO_MATERIAL = 0xffffffff;

/**
 * Pieces and what belongs to them. `data` has `arrays`, by the names above, the `certificate`, and, where they were asked
 * for, `surfaces` and `hulls`.
 */
export class Pieces {
    #data;
    #firstParts = null;
    #firstHulls = null;
    constructor(data) { this.#data = data; }
    array(name) { return this.#data.arrays[name]; }
    get length() { return this.array("volumes").length; }
    get volumes() { return this.array("volumes"); }
    get areas() { return this.array("areas"); }
    get centres() { return this.array("centres"); }
    get inertias() { return this.array("inertias"); }
    get sites() { return this.array("sites"); }
    get bonds() { return this.array("bonds"); }
    get bondAreas() { return this.array("bondAreas"); }
    get bondCentroids() { return this.array("bondCentroids"); }
    get bondNormals() { return this.array("bondNormals"); }
    get certificate() { return this.#data.certificate; }
    get hash() { return this.certificate.hash; }
    get surfaces() { return this.#asked("surfaces"); }
    get hullArrays() { return this.#asked("hulls"); }
    #asked(name) {
        const value = this.#data[name];
        if (!value) throw new BrittleError("invalid_argument", `these pieces came without ${name}; ask the worker for them`);
        return value;
    }
    #check(index) {
        if (!Number.isInteger(index) || index < 0 || index >= this.length)
            throw new BrittleError("invalid_argument", `there is no piece ${index}; there are ${this.length}`);
    }
    piece(index) {
        this.#check(index);
        const [vertices, triangles] = [this.array("vertexRanges"), this.array("triangleRanges")];
        return {
            index,
            positions: this.array("positions").subarray(3 * vertices[2 * index], 3 * vertices[2 * index + 1]),
            triangles: this.array("triangles").subarray(3 * triangles[2 * index], 3 * triangles[2 * index + 1]),
            exteriorTriangles: this.array("exteriorTriangles")[index],
            volume: this.volumes[index],
            centre: this.centres.subarray(3 * index, 3 * index + 3),
        };
    }
    *[Symbol.iterator]() {
        for (let index = 0; index < this.length; ++index) yield this.piece(index);
    }
    surface(index) {
        this.#check(index);
        const { parts, positions, normals, uv, triangles, vertices } = this.surfaces;
        this.#firstParts ??= firsts(parts, PART_COLUMNS, PIECE, this.length);
        const out = [];
        for (let part = this.#firstParts[index]; part < this.#firstParts[index + 1]; ++part) {
            const row = parts.subarray(PART_COLUMNS * part, PART_COLUMNS * (part + 1));
            const [v, end] = [row[FIRST_VERTEX], row[FIRST_VERTEX] + row[VERTICES]];
            const [t, last] = [row[FIRST_TRIANGLE], row[FIRST_TRIANGLE] + row[TRIANGLES]];
            out.push({ material: row[MATERIAL] === NO_MATERIAL ? null : row[MATERIAL], interior: row[INTERIOR] === 1,
                       positions: positions.subarray(3 * v, 3 * end), normals: normals.subarray(3 * v, 3 * end),
                       uv: uv.subarray(2 * v, row[TEXTURED] ? 2 * end : 2 * v), triangles: triangles.subarray(3 * t, 3 * last),
                       vertices: vertices.subarray(v, end) });
        }
        return out;
    }
    hulls(index) {
        this.#check(index);
        const { points, ranges, pieces, margins } = this.hullArrays;
        this.#firstHulls ??= firsts(pieces, 1, 0, this.length);
        const out = [];
        for (let hull = this.#firstHulls[index]; hull < this.#firstHulls[index + 1]; ++hull)
            out.push({ points: points.subarray(3 * ranges[2 * hull], 3 * ranges[2 * hull + 1]), margin: margins[hull] });
        return out;
    }
}

/** The first row of each piece, and the end, in rows that ascend by piece. */
function firsts(rows, columns, column, pieces) {
    const first = new Uint32Array(pieces + 1);
    for (let at = column; at < rows.length; at += columns) ++first[rows[at] + 1];
    for (let piece = 0; piece < pieces; ++piece) first[piece + 1] += first[piece];
    return first;
}
