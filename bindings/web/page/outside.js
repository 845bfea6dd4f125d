// The outside of a model as its file gives it: normals, texture coordinates and colours of the corners, and materials.
// Pieces, and pieces of pieces, take all of these from the triangles of the whole model in which they lie.
import { MeshStandardMaterial } from "three";
import { texturesOf } from "./looks.js";

/** Materials of the mesh of a piece that is cut again: its outside, and its cuts. */
export const OUTSIDE = 0, CUT = 1;

export class Outside {
    #positions;
    #triangles;
    #look;

    /** Of the arrays of a mesh of the worker. `looks`: materials of three.js by their numbers in the file. */
    constructor({ positions, triangles, normals, uv, uv2, colours, materials }, looks) {
        const coloured = colours.length > 0, textured = looks.some((look) => texturesOf(look).length > 0);
        this.#positions = positions;
        this.#triangles = triangles;
        /** Materials of three.js. The colours of corners without a material show on white. */
        this.looks = coloured ? [...looks, new MeshStandardMaterial({ name: "colours", roughness: 0.82 })] : looks;
        for (const look of this.looks) look.vertexColors = coloured;
        // Of each triangle. Without colours `looks.length` is that of the chosen material.
        this.#look = Uint32Array.from({ length: triangles.length / 3 }, (_, t) => Math.min(materials[t] ?? looks.length, looks.length));
        /** Attributes of corners by their names in three.js; `without` is their value on cuts. */
        this.attributes = [
            { name: "normal", size: 3, values: complete(normals, positions, triangles), without: 0 },
            { name: "uv", size: 2, values: textured ? uv : [], without: 0 },
            { name: "uv1", size: 2, values: textured ? uv2 : [], without: 0 },
            { name: "color", size: 4, values: colours, without: 1 },
        ].filter(({ values }) => values.length > 0);
    }

    /** Frees what the graphics card holds. */
    dispose() {
        for (const look of this.looks) for (const texture of texturesOf(look)) texture.dispose();
    }

    /**
     * The surface of a piece about its centre. Its triangles are sorted: those of each look, those of the chosen material, and
     * cuts; `counts` has the number of indices of each. Vertices from `firstCut` on lie on cuts.
     */
    surface({ index, positions, triangles, centre, origins, source, recut }) {
        const cuts = source ? source.surface(index).filter(({ interior, material }) => interior || recut && material === CUT) : [];
        const counts = new Uint32Array(this.looks.length + 2);
        for (const origin of origins)
            if (origin >= 0) counts[this.#look[origin]] += 3;
        const corners = counts.reduce((sum, count) => sum + count, 0);
        const most = corners + cuts.reduce((sum, part) => sum + part.vertices.length, 0);
        const out = { positions: new Float32Array(3 * most),
                      attributes: this.attributes.map(({ size, without }) => new Float32Array(size * most).fill(without)) };
        counts[this.looks.length + 1] = cuts.reduce((sum, part) => sum + part.triangles.length, 0);
        const indices = new Uint32Array(corners + counts[this.looks.length + 1]), next = starts(counts);
        // Corners at one vertex of the piece share a vertex here where their attributes are equal.
        const first = new Int32Array(positions.length / 3).fill(-1), other = new Int32Array(corners);
        let vertices = 0;
        for (let k = 0; k < 3 * origins.length; ++k) {
            const origin = origins[Math.floor(k / 3)], v = triangles[k];
            if (origin < 0) continue;
            this.#interpolate(origin, positions, 3 * v, out.attributes, vertices);
            let same = first[v];
            while (same >= 0 && !this.#equal(out.attributes, same, vertices)) same = other[same];
            if (same < 0) {
                for (let axis = 0; axis < 3; ++axis) out.positions[3 * vertices + axis] = positions[3 * v + axis] - centre[axis];
                other[vertices] = first[v];
                same = first[v] = vertices++;
            }
            indices[next[this.#look[origin]]++] = same;
        }
        const firstCut = vertices;
        for (const part of cuts) {
            for (const corner of part.triangles) indices[next[this.looks.length + 1]++] = vertices + corner;
            out.positions.set(part.positions, 3 * vertices);
            this.attributes.forEach(({ name, size, without }, k) => {
                if (name === "normal") out.attributes[k].set(part.normals, 3 * vertices);
                else out.attributes[k].fill(without, size * vertices, size * (vertices + part.vertices.length));
            });
            vertices += part.vertices.length;
        }
        return { counts, firstCut, indices, positions: out.positions.subarray(0, 3 * vertices),
                 attributes: out.attributes.map((values, k) => values.subarray(0, this.attributes[k].size * vertices)) };
    }

    /** Writes the attributes of a point of triangle `t` of the model to vertex `to`. */
    #interpolate(t, points, at, out, to) {
        const p = this.#positions, a = 3 * this.#triangles[3 * t], b = 3 * this.#triangles[3 * t + 1], c = 3 * this.#triangles[3 * t + 2];
        const ux = p[b] - p[a], uy = p[b + 1] - p[a + 1], uz = p[b + 2] - p[a + 2];
        const vx = p[c] - p[a], vy = p[c + 1] - p[a + 1], vz = p[c + 2] - p[a + 2];
        const x = points[at] - p[a], y = points[at + 1] - p[a + 1], z = points[at + 2] - p[a + 2];
        const nx = uy * vz - uz * vy, ny = uz * vx - ux * vz, nz = ux * vy - uy * vx, area = nx * nx + ny * ny + nz * nz || 1;
        const ofB = clamp(((y * vz - z * vy) * nx + (z * vx - x * vz) * ny + (x * vy - y * vx) * nz) / area, 1);
        const ofC = clamp(((uy * z - uz * y) * nx + (uz * x - ux * z) * ny + (ux * y - uy * x) * nz) / area, 1 - ofB);
        const ofA = 1 - ofB - ofC;
        for (let k = 0; k < out.length; ++k) {
            const { size, values } = this.attributes[k], from = 3 * t * size;
            for (let n = 0; n < size; ++n)
                out[k][size * to + n] = ofA * values[from + n] + ofB * values[from + size + n] + ofC * values[from + 2 * size + n];
        }
        const normals = out[0], n = 3 * to, length = Math.sqrt(normals[n] ** 2 + normals[n + 1] ** 2 + normals[n + 2] ** 2) || 1;
        for (let k = n; k < n + 3; ++k) normals[k] /= length;
    }

    #equal(attributes, a, b) {
        for (let k = 0; k < attributes.length; ++k) {
            const { size } = this.attributes[k], values = attributes[k];
            for (let n = 0; n < size; ++n)
                if (values[size * a + n] !== values[size * b + n]) return false;
        }
        return true;
    }
}

const clamp = (x, most) => Math.min(Math.max(x, 0), most);

/** Where each of lists of these lengths begins, one after another. */
export function starts(counts) {
    const first = new Uint32Array(counts.length);
    for (let k = 1; k < counts.length; ++k) first[k] = first[k - 1] + counts[k - 1];
    return first;
}

/** The normals of the file; where it has none, those of crease(). */
function complete(given, positions, triangles) {
    const normals = crease(positions, triangles);
    for (let k = 0; k < given.length; k += 3)
        if (given[k] !== 0 || given[k + 1] !== 0 || given[k + 2] !== 0) normals.set(given.subarray(k, k + 3), k);
    return normals;
}

/** Normals of the corners of all triangles: the mean of the triangles around a vertex that differ by less than 40 degrees. */
function crease(positions, triangles) {
    const p = positions, count = triangles.length / 3, faces = new Float32Array(3 * count), sizes = new Float32Array(count);
    for (let t = 0; t < count; ++t) {
        const a = 3 * triangles[3 * t], b = 3 * triangles[3 * t + 1], c = 3 * triangles[3 * t + 2], f = 3 * t;
        const ux = p[b] - p[a], uy = p[b + 1] - p[a + 1], uz = p[b + 2] - p[a + 2];
        const vx = p[c] - p[a], vy = p[c + 1] - p[a + 1], vz = p[c + 2] - p[a + 2];
        faces[f] = uy * vz - uz * vy;
        faces[f + 1] = uz * vx - ux * vz;
        faces[f + 2] = ux * vy - uy * vx;
        sizes[t] = Math.sqrt(faces[f] ** 2 + faces[f + 1] ** 2 + faces[f + 2] ** 2);
    }
    const first = new Uint32Array(positions.length / 3 + 1);
    for (const vertex of triangles) ++first[vertex + 1];
    for (let v = 1; v < first.length; ++v) first[v] += first[v - 1];
    const next = first.slice(), near = new Uint32Array(triangles.length);
    for (let k = 0; k < triangles.length; ++k) near[next[triangles[k]]++] = Math.floor(k / 3);
    const normals = new Float32Array(3 * triangles.length);
    for (let k = 0; k < triangles.length; ++k) {
        const own = Math.floor(k / 3), nx = faces[3 * own], ny = faces[3 * own + 1], nz = faces[3 * own + 2], vertex = triangles[k];
        let x = 0, y = 0, z = 0;
        for (let n = first[vertex]; n < first[vertex + 1]; ++n) {
            const f = 3 * near[n];
            if (nx * faces[f] + ny * faces[f + 1] + nz * faces[f + 2] < 0.77 * sizes[own] * sizes[near[n]]) continue;
            x += faces[f];
            y += faces[f + 1];
            z += faces[f + 2];
        }
        const all = Math.sqrt(x * x + y * y + z * z) || 1;
        normals[3 * k] = x / all;
        normals[3 * k + 1] = y / all;
        normals[3 * k + 2] = z / all;
    }
    return normals;
}
