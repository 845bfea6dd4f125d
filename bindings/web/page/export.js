// The pieces as a GLB file, where they lie now.
import { BufferAttribute, BufferGeometry, Color, Group, Mesh, MeshStandardMaterial, Quaternion, Vector3 } from "three";
import { GLTFExporter } from "three/addons/exporters/GLTFExporter.js";
import { starts } from "./outside.js";

export async function exportGlb(destruction, colours) {
    const { bodies, frame, outside } = destruction;
    const colour = (name) => Object.assign(new MeshStandardMaterial({ color: new Color().setRGB(...colours[name]), roughness: 0.8 }), { name });
    const materials = [...outside.looks, colour("outside"), colour("inside")], root = new Group();
    root.name = "pieces";
    for (const { pieces, pose: { rotation, translation } } of bodies) {
        const q = new Quaternion(...rotation);
        for (const piece of pieces) {
            const mesh = new Mesh(geometry(outside.surface(piece), outside.attributes), materials);
            mesh.name = `piece_${String(piece.id).padStart(4, "0")}`;
            mesh.scale.setScalar(frame.scale);
            mesh.quaternion.copy(q);
            mesh.position.set(...destruction.world(piece.centre)).applyQuaternion(q).add(new Vector3(...translation));
            root.add(mesh);
        }
    }
    return new GLTFExporter().parseAsync(root, { binary: true, onlyVisible: false });
}

function geometry({ positions, attributes, indices, counts }, kinds) {
    const made = new BufferGeometry(), first = starts(counts);
    made.setAttribute("position", new BufferAttribute(positions, 3));
    kinds.forEach(({ name, size }, k) => made.setAttribute(name, new BufferAttribute(attributes[k], size)));
    made.setIndex(new BufferAttribute(indices, 1));
    counts.forEach((count, material) => count > 0 && made.addGroup(first[material], count, material));
    return made;
}
