// Compiled, not run: what the declarations of the npm package promise.
import * as THREE from "three";
import { BrittleError, Mesh, fracture, init, load, threads, type Fracture, type Piece } from "brittle-fracture";
import { meshArrays, pieceGeometry } from "brittle-fracture/three";
import { BrittleWorker } from "brittle-fracture/worker";

export async function use(bytes: ArrayBuffer): Promise<string> {
    await init({ threads: "auto" });
    const count: number = threads();
    const mesh: Mesh = await load(bytes, ".obj");
    const broken: Fracture = await fracture(mesh, { sites: 100, material: "stone", focus: [0, 0.5, 1] },
        { onProgress: (share: number) => console.log(share) });
    const piece: Piece = broken.piece(0);
    const hull: Float32Array = broken.hulls(piece.index)[0].points;
    const object = new THREE.Mesh(pieceGeometry(broken, 0), new THREE.MeshBasicMaterial());
    const worker = new BrittleWorker({ threads: 4 });
    const there: number = await worker.threads();
    const remote = await (await worker.mesh(...meshArrays(object.geometry))).repair();
    const pieces = await worker.fracture(remote, { sites: Float64Array.of(0, 0, 0) }, { hulls: { parts: 2 }, signal: AbortSignal.timeout(1000) });
    // @ts-expect-error threads are counted
    await init({ threads: "many" });
    // @ts-expect-error there is no such material
    await fracture(mesh, { material: "rubber" });
    // @ts-expect-error a mesh of the worker is none of this thread
    await fracture(remote);
    try {
        return pieces.hash + pieces.milliseconds.toFixed(1) + hull.length + count + there + broken.toBytes("a.glb").length;
    } catch (error) {
        return error instanceof BrittleError ? error.status : "";
    }
}
