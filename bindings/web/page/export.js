// The pieces as a GLB file, where they lie now.
import { Color, Group, Mesh, MeshStandardMaterial, Quaternion, Vector3 } from "three";
import { GLTFExporter } from "three/addons/exporters/GLTFExporter.js";
import { pieceGeometry } from "brittle-fracture/three";

export async function exportGlb(destruction, { outside, inside }) {
    const colour = (name, rgb) => Object.assign(new MeshStandardMaterial({ color: new Color().setRGB(...rgb), roughness: 0.8 }), { name });
    const cut = colour("inside", inside), materials = [colour("outside", outside), cut, cut], root = new Group();
    root.name = "pieces";
    for (const { pieces, pose: { rotation, translation } } of destruction.bodies) {
        const q = new Quaternion(...rotation);
        for (const piece of pieces) {
            const mesh = new Mesh(pieceGeometry(piece.source, piece.index), materials);
            mesh.name = `piece_${String(piece.id).padStart(4, "0")}`;
            mesh.scale.setScalar(destruction.frame.scale);
            mesh.quaternion.copy(q);
            mesh.position.set(...destruction.world(piece.centre)).applyQuaternion(q).add(new Vector3(...translation));
            root.add(mesh);
        }
    }
    return new GLTFExporter().parseAsync(root, { binary: true, onlyVisible: false });
}
