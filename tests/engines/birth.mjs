// Makes rigid bodies of files with KHR_physics_rigid_bodies in Rapier, without gravity, and prints for each file:
//   FILE bodies COUNT hulls COUNT speed M/S
// speed: of the fastest piece within half a second. Pieces that lie in each other push each other away.
//   node birth.mjs FILE.glb...
import { readFileSync } from "node:fs";
import RAPIER from "@dimforge/rapier3d-compat";

const extension = "KHR_physics_rigid_bodies";

function read(file) {
    const bytes = readFileSync(file);
    const length = bytes.readUInt32LE(12);
    const json = JSON.parse(bytes.subarray(20, 20 + length));
    const buffer = bytes.subarray(28 + length);
    const positions = (mesh) => {
        const accessor = json.accessors[json.meshes[mesh].primitives[0].attributes.POSITION];
        const begin = buffer.byteOffset + json.bufferViews[accessor.bufferView].byteOffset + accessor.byteOffset;
        return new Float32Array(buffer.buffer.slice(begin, begin + 12 * accessor.count));
    };
    return { nodes: json.nodes, positions };
}

await RAPIER.init();
for (const file of process.argv.slice(2)) {
    const { nodes, positions } = read(file);
    const world = new RAPIER.World({ x: 0, y: 0, z: 0 });
    const bodies = [];
    let hulls = 0;
    const collides = (node) => node.extensions?.[extension]?.collider;
    for (const node of nodes) {
        const motion = node.extensions?.[extension]?.motion;
        if (!motion) continue;
        const [x, y, z] = node.translation;
        const body = world.createRigidBody(RAPIER.RigidBodyDesc.dynamic().setTranslation(x, y, z));
        const colliders = [node, ...(node.children ?? []).map((child) => nodes[child])].filter(collides).map(collides);
        for (const { geometry } of colliders) {
            const shape = RAPIER.ColliderDesc.convexHull(positions(geometry.mesh));
            if (!geometry.convexHull || !shape) throw new Error(`${file}: ${node.name} has a hull that is not convex`);
            world.createCollider(shape.setMass(motion.mass / colliders.length), body);
            ++hulls;
        }
        bodies.push(body);
    }
    let speed = 0;
    for (let step = 0; step < 30; ++step) {
        world.step();
        for (const body of bodies) {
            const v = body.linvel();
            speed = Math.max(speed, Math.hypot(v.x, v.y, v.z));
        }
    }
    console.log(`${file} bodies ${bodies.length} hulls ${hulls} speed ${speed.toFixed(4)}`);
    world.free();
}
