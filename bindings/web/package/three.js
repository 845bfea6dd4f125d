// three.js geometries of pieces: see three.d.ts.
import { BufferAttribute, BufferGeometry } from "three";

/** The geometry of one piece about its centre of mass. */
export function pieceGeometry(pieces, index) {
    const parts = pieces.surface(index), geometry = new BufferGeometry();
    const count = (name) => parts.reduce((sum, part) => sum + part[name].length, 0);
    const vertices = count("positions") / 3, textured = count("uv") === 2 * vertices;
    const joined = { positions: new Float32Array(3 * vertices), normals: new Float32Array(3 * vertices),
                     uv: new Float32Array(textured ? 2 * vertices : 0), triangles: new Uint32Array(count("triangles")) };
    const outside = 1 + Math.max(0, ...parts.map((part) => part.material ?? 0)); // the number of materials outside
    let vertex = 0, corner = 0;
    for (const part of parts) {
        joined.positions.set(part.positions, 3 * vertex);
        joined.normals.set(part.normals, 3 * vertex);
        if (textured) joined.uv.set(part.uv, 2 * vertex);
        for (let k = 0; k < part.triangles.length; ++k) joined.triangles[corner + k] = vertex + part.triangles[k];
        geometry.addGroup(corner, part.triangles.length, part.interior ? outside : part.material ?? 0);
        vertex += part.positions.length / 3;
        corner += part.triangles.length;
    }
    geometry.setAttribute("position", new BufferAttribute(joined.positions, 3));
    geometry.setAttribute("normal", new BufferAttribute(joined.normals, 3));
    if (textured) geometry.setAttribute("uv", new BufferAttribute(joined.uv, 2));
    geometry.setIndex(new BufferAttribute(joined.triangles, 1));
    const { volume, centre } = pieces.piece(index);
    geometry.userData = { piece: index, volume, centre: Array.from(centre) };
    return geometry;
}

/** A mesh in the coordinates of the library, from a geometry with or without an index. */
export function meshArrays(geometry) {
    const { position, uv } = geometry.attributes, positions = new Float64Array(3 * position.count);
    for (let v = 0; v < position.count; ++v)
        positions.set([position.getX(v), position.getY(v), position.getZ(v)], 3 * v);
    const triangles = geometry.index ? Uint32Array.from({ length: geometry.index.count }, (_, k) => geometry.index.getX(k))
        : Uint32Array.from({ length: position.count }, (_, k) => k);
    const options = { weld: true };
    if (uv) {
        options.uv = new Float32Array(2 * position.count);
        for (let v = 0; v < position.count; ++v) options.uv.set([uv.getX(v), uv.getY(v)], 2 * v);
    }
    if (geometry.groups.length > 0) {
        options.materials = new Uint32Array(triangles.length / 3);
        for (const { start, count, materialIndex = 0 } of geometry.groups)
            options.materials.fill(materialIndex, Math.floor(start / 3), Math.floor(Math.min(start + count, triangles.length) / 3));
    }
    return [positions, triangles, options];
}
