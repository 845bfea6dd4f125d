/**
 * Between the library and three.js.
 *
 *     const mesh = new Mesh(...meshArrays(geometry));
 *     const broken = await fracture(mesh, { sites: 100 });
 *     for (const { index, centre } of broken) {
 *         const object = new THREE.Mesh(pieceGeometry(broken, index), [outside, inside]);
 *         object.position.fromArray(centre);
 *     }
 */
import type { BufferGeometry } from "three";
import type { Pieces } from "./brittle.js";

/**
 * The geometry of a piece about its centre of mass. Its groups: those of the outside with the materials of the mesh, 0
 * where it has none, then the cuts with the next higher number. userData: piece, volume, centre. Texture coordinates have
 * v down, as those of glTF.
 */
export function pieceGeometry(pieces: Pieces, index: number): BufferGeometry;

/** The arguments of `new Mesh()` for a geometry: welded, with its texture coordinates, its groups as materials. */
export function meshArrays(geometry: BufferGeometry):
    [Float64Array, Uint32Array, { weld: true; uv?: Float32Array; materials?: Uint32Array }];
