// Rapier as npm ships it, WebAssembly on one thread, for tools/compare --physics: its defaults, at the scene's step.
import RAPIER from "@dimforge/rapier3d-compat";
import { serve } from "./physics.mjs";

const vector = ([x, y, z]) => ({ x, y, z }), quaternion = ([x, y, z, w]) => ({ x, y, z, w });
const MULTIPLY = RAPIER.CoefficientCombineRule.Multiply;

await RAPIER.init();
await serve(`Rapier ${RAPIER.version()}`, (scene) => {
    const world = new RAPIER.World(vector(scene.gravity)), bodies = [];
    world.timestep = scene.step;
    const add = (shape, friction, restitution, body) => world.createCollider(shape.setDensity(0).setFriction(friction)
        .setRestitution(restitution).setFrictionCombineRule(MULTIPLY).setRestitutionCombineRule(MULTIPLY), body);
    if (scene.ground) {
        // A large box holds bodies better than Rapier's half-space.
        const box = RAPIER.ColliderDesc.cuboid(50, 1, 50).setTranslation(0, -1, 0);
        add(box, scene.groundFriction, scene.groundRestitution);
    }
    for (const of of scene.bodies) {
        const kind = of.fixed ? RAPIER.RigidBodyDesc.fixed() : RAPIER.RigidBodyDesc.dynamic();
        const body = world.createRigidBody(kind.setTranslation(...of.position).setRotation(quaternion(of.orientation))
            .setLinvel(...of.velocity).setAngvel(vector(of.angularVelocity)).setCanSleep(false)
            .setAdditionalMassProperties(of.mass, { x: 0, y: 0, z: 0 }, vector(of.moments),
                { x: 0, y: 0, z: 0, w: 1 }));
        const shape = RAPIER.ColliderDesc.convexHull(Float32Array.from(of.corners));
        if (!shape) throw new Error("Rapier makes no hull of a body");
        add(shape, of.friction, of.restitution, body);
        bodies.push(body);
    }
    return {
        step: () => world.step(),
        pose(k) {
            const p = bodies[k].translation(), q = bodies[k].rotation();
            return [p.x, p.y, p.z, q.x, q.y, q.z, q.w];
        },
        free: () => world.free(),
    };
});
