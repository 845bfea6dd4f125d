// Compares the tangents of files with those that the reference implementation of MikkTSpace makes of the same
// triangles, each primitive by itself, and prints for each file:
//   FILE primitives COUNT vertices COUNT turned DEGREES flipped COUNT
// turned: the largest angle between tangents. flipped: vertices whose sign of the bitangent differs.
//   node tangents.mjs FILE.glb...
import { readFileSync } from "node:fs";
import { createRequire } from "node:module";

const { generateTangents } = createRequire(import.meta.url)("mikktspace");

function read(file) {
    const bytes = readFileSync(file), length = bytes.readUInt32LE(12);
    const json = JSON.parse(bytes.subarray(20, 20 + length)), begin = bytes.byteOffset + 28 + length;
    const types = { 5123: Uint16Array, 5125: Uint32Array, 5126: Float32Array };
    const sizes = { SCALAR: 1, VEC2: 2, VEC3: 3, VEC4: 4 };
    const values = (index) => {
        const { bufferView, byteOffset, componentType, count, type } = json.accessors[index];
        const Type = types[componentType];
        const at = begin + json.bufferViews[bufferView].byteOffset + byteOffset;
        return new Type(bytes.buffer.slice(at, at + count * sizes[type] * Type.BYTES_PER_ELEMENT));
    };
    const primitives = json.meshes.flatMap((mesh) => mesh.primitives).filter((one) => "TANGENT" in one.attributes);
    return primitives.map(({ attributes, indices }) => ({
        indices: values(indices), position: values(attributes.POSITION), normal: values(attributes.NORMAL),
        uv: values(attributes.TEXCOORD_0), tangent: values(attributes.TANGENT) }));
}

const spread = (values, indices, size) => Float32Array.from({ length: indices.length * size },
    (_, k) => values[indices[Math.floor(k / size)] * size + k % size]);

for (const file of process.argv.slice(2)) {
    let vertices = 0, least = 1, flipped = 0;
    const primitives = read(file);
    for (const { indices, position, normal, uv, tangent } of primitives) {
        const expected = generateTangents(spread(position, indices, 3), spread(normal, indices, 3),
            spread(uv, indices, 2));
        const found = spread(tangent, indices, 4);
        for (let at = 0; at < found.length; at += 4, ++vertices) {
            const dot = [0, 1, 2].reduce((sum, k) => sum + found[at + k] * expected[at + k], 0);
            least = Math.min(least, dot);
            // The image of glTF has v down, the opposite of the reference implementation.
            flipped += found[at + 3] === -expected[at + 3] ? 0 : 1;
        }
    }
    const turned = Math.acos(Math.min(least, 1)) * 180 / Math.PI;
    console.log(`${file} primitives ${primitives.length} vertices ${vertices} turned ${turned.toFixed(4)} `
        + `flipped ${flipped}`);
}
