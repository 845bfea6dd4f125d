// Loads files without textures with the GLTFLoader of three.js and prints for each file:
//   FILE pieces COUNT volume CUBIC_METRES wrong COUNT normals COUNT
// wrong: pieces whose volume is not that of their extras. normals: vertices whose normal is not a unit vector.
//   node three.mjs FILE.glb...
import { readFileSync } from "node:fs";
import { Vector3 } from "three";
import { GLTFLoader } from "three/addons/loaders/GLTFLoader.js";

const VOLUME_TOLERANCE = 1e-4; // relative; positions are 32-bit floats

function volume_of(mesh) {
    const { index, attributes: { position } } = mesh.geometry;
    const corner = (k) => new Vector3().fromBufferAttribute(position, index.getX(k));
    let sum = 0;
    for (let k = 0; k < index.count; k += 3) sum += corner(k).dot(corner(k + 1).cross(corner(k + 2))) / 6;
    return sum;
}

for (const file of process.argv.slice(2)) {
    const { scene } = await new GLTFLoader().parseAsync(new Uint8Array(readFileSync(file)).buffer, "");
    let pieces = 0, volume = 0, wrong = 0, normals = 0;
    scene.traverse((thing) => {
        const own = thing.userData.brittle?.volume;
        if (own === undefined) return;
        // A piece of several materials is a group. Hulls are its children, too.
        const meshes = (thing.isMesh ? [thing] : thing.children)
            .filter((one) => one.isMesh && !one.name.startsWith("UCX_"));
        let found = 0;
        for (const mesh of meshes) {
            found += volume_of(mesh);
            const { normal } = mesh.geometry.attributes;
            for (let v = 0; v < normal.count; ++v)
                normals += Math.abs(new Vector3().fromBufferAttribute(normal, v).length() - 1) < 1e-3 ? 0 : 1;
        }
        ++pieces;
        volume += found;
        wrong += Math.abs(found - own) <= VOLUME_TOLERANCE * own ? 0 : 1;
    });
    console.log(`${file} pieces ${pieces} volume ${volume.toPrecision(9)} wrong ${wrong} normals ${normals}`);
}
