// Models with colours, as files.

/** An OFF file of a tetrahedron whose corners have these colours, each three numbers from 0 to 255. */
export const tetrahedron = (...colours) => `COFF
4 4 6
${["0 0 0", "1 0 0", "0 1 0", "0 0 1"].map((corner, k) => `${corner} ${colours[k]} 255`).join("\n")}
3 0 2 1
3 0 1 3
3 1 2 3
3 2 0 3
`;

export const SIDES = 8, CAPS = 2; // m^2, of a column

/**
 * A GLB file of a column of 1 x 2 x 1 m: its caps are green, material 0; its sides, material 1, have an image from their upper
 * to their lower end. The vertices of its faces are apart, as exporters write them. `sides` replaces the material of the sides.
 */
export function column(image, sides = { pbrMetallicRoughness: { metallicFactor: 0, baseColorTexture: { index: 0 } } }) {
    const corners = [[[0, 0, 1], [1, 0, 1], [1, 2, 1], [0, 2, 1]], [[1, 0, 1], [1, 0, 0], [1, 2, 0], [1, 2, 1]],
                     [[1, 0, 0], [0, 0, 0], [0, 2, 0], [1, 2, 0]], [[0, 0, 0], [0, 0, 1], [0, 2, 1], [0, 2, 0]],
                     [[0, 2, 1], [1, 2, 1], [1, 2, 0], [0, 2, 0]], [[0, 0, 0], [1, 0, 0], [1, 0, 1], [0, 0, 1]]];
    const positions = Float32Array.from(corners.flat(2)), uv = Float32Array.from(corners.flatMap(() => [0, 1, 1, 1, 1, 0, 0, 0]));
    const normals = Float32Array.from([[0, 0, 1], [1, 0, 0], [0, 0, -1], [-1, 0, 0], [0, 1, 0], [0, -1, 0]].flatMap((n) => [n, n, n, n].flat()));
    const indices = Uint16Array.from(corners.flatMap((_, face) => [0, 1, 2, 0, 2, 3].map((k) => 4 * face + k)));
    const parts = [positions, normals, uv, indices, image].map(({ buffer, byteOffset, byteLength }) => Buffer.from(buffer, byteOffset, byteLength));
    const views = parts.map((part, k) => ({ buffer: 0, byteLength: part.length,
        byteOffset: parts.slice(0, k).reduce((sum, { length }) => sum + length, 0) }));
    const view = (bufferView, type, componentType, count, byteOffset = 0) => ({ bufferView, type, componentType, count, byteOffset });
    const primitive = (indices, material) => ({ attributes: { POSITION: 0, NORMAL: 1, TEXCOORD_0: 2 }, indices, material });
    const json = Buffer.from(JSON.stringify({
        asset: { version: "2.0" }, scenes: [{ nodes: [0] }], nodes: [{ mesh: 0 }],
        meshes: [{ primitives: [primitive(3, 1), primitive(4, 0)] }],
        materials: [{ name: "caps", pbrMetallicRoughness: { baseColorFactor: [0, 1, 0, 1], metallicFactor: 0 } },
                    { name: "sides", ...sides }],
        textures: [{ source: 0, sampler: 0 }], samplers: [{ magFilter: 9728 }], images: [{ name: "flag", bufferView: 4, mimeType: "image/png" }],
        accessors: [view(0, "VEC3", 5126, 24), view(1, "VEC3", 5126, 24), view(2, "VEC2", 5126, 24), view(3, "SCALAR", 5123, 24),
                    view(3, "SCALAR", 5123, 12, 48)],
        bufferViews: views, buffers: [{ byteLength: views[4].byteOffset + image.length }],
    }));
    const chunk = (type, content, filler) => {
        const padded = Buffer.alloc(4 * Math.ceil(content.length / 4), filler), head = Buffer.alloc(8);
        content.copy(padded);
        head.writeUInt32LE(padded.length, 0);
        head.writeUInt32LE(type, 4);
        return Buffer.concat([head, padded]);
    };
    const head = Buffer.alloc(12), chunks = [chunk(0x4e4f534a, json, " "), chunk(0x004e4942, Buffer.concat(parts), 0)];
    head.write("glTF");
    head.writeUInt32LE(2, 4);
    head.writeUInt32LE(12 + chunks[0].length + chunks[1].length, 8);
    return Buffer.concat([head, ...chunks]);
}
