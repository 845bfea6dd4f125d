// Jolt as npm ships it, WebAssembly on one thread, for tools/compare --physics: its defaults, at the scene's step.
import initJolt from "jolt-physics";
import { serve } from "./physics.mjs";

const FIXED = 0, MOVING = 1; // layers
const Jolt = await initJolt();

// Takes a copy of a value that C++ owns then, and frees the value.
function using(value, take) {
    const result = take(value);
    Jolt.destroy(value);
    return result;
}
const withVector = ([x, y, z], take) => using(new Jolt.Vec3(x, y, z), take);

function makeInterface() {
    const settings = new Jolt.JoltSettings(), pairs = new Jolt.ObjectLayerPairFilterTable(2);
    pairs.EnableCollision(FIXED, MOVING);
    pairs.EnableCollision(MOVING, MOVING);
    const layers = new Jolt.BroadPhaseLayerInterfaceTable(2, 2);
    for (const layer of [FIXED, MOVING])
        using(new Jolt.BroadPhaseLayer(layer), (broad) => layers.MapObjectToBroadPhaseLayer(layer, broad));
    settings.mObjectLayerPairFilter = pairs;
    settings.mBroadPhaseLayerInterface = layers;
    settings.mObjectVsBroadPhaseLayerFilter = new Jolt.ObjectVsBroadPhaseLayerFilterTable(layers, 2, pairs, 2);
    return using(settings, (all) => new Jolt.JoltInterface(all));
}

// For a crumb of which Jolt makes no hull: the least box around it that has the same centre of mass.
function boxOf(corners) {
    const half = [0, 1, 2].map((axis) => Math.max(...corners.filter((_, k) => k % 3 === axis).map(Math.abs)));
    return withVector(half, (size) => new Jolt.BoxShape(size, Math.min(0.05, ...half) / 10));
}

// Hulls lie around their own centre of mass; the body's is the origin.
function hullOf(corners) {
    const settings = new Jolt.ConvexHullShapeSettings();
    for (let k = 0; k < corners.length; k += 3)
        withVector(corners.slice(k, k + 3), (at) => settings.mPoints.push_back(at));
    const made = settings.Create();
    if (made.HasError()) return boxOf(corners);
    const hull = made.Get(), middle = hull.GetCenterOfMass(), away = [middle.GetX(), middle.GetY(), middle.GetZ()];
    return withVector(away.map((x) => -x), (by) => new Jolt.OffsetCenterOfMassShape(hull, by));
}

// Jolt takes the root of the product of two frictions, and the greater restitution. Squares of frictions give the
// product; restitutions below give it where all moving bodies have the same, which is not above the ground's.
function restitutionOf(scene) {
    const all = new Set(scene.bodies.filter(({ fixed }) => !fixed).map(({ restitution }) => restitution)), [body] = all;
    if (all.size > 1 || (body > 0 && body > scene.groundRestitution && scene.ground))
        throw new Error("restitutions of this scene are no maxima, which Jolt takes of two bodies");
    return { body: scene.bodies.length > 1 ? body * body : 0, ground: body * scene.groundRestitution };
}

await serve("Jolt 1.1.0 (npm)", (scene) => {
    const jolt = makeInterface(), system = jolt.GetPhysicsSystem(), world = system.GetBodyInterface(), bodies = [];
    const restitutions = restitutionOf(scene);
    withVector(scene.gravity, (gravity) => system.SetGravity(gravity));
    const add = (shape, of, restitution) => {
        const at = new Jolt.RVec3(...of.position), turn = new Jolt.Quat(...of.orientation);
        const settings = new Jolt.BodyCreationSettings(shape, at, turn,
            of.fixed ? Jolt.EMotionType_Static : Jolt.EMotionType_Dynamic, of.fixed ? FIXED : MOVING);
        Object.assign(settings, { mFriction: of.friction ** 2, mRestitution: restitution, mLinearDamping: 0,
            mAngularDamping: 0, mAllowSleeping: false });
        if (!of.fixed) {
            settings.mOverrideMassProperties = Jolt.EOverrideMassProperties_MassAndInertiaProvided;
            settings.mMassPropertiesOverride.mMass = of.mass;
            withVector(of.moments, (v) => {
                settings.mMassPropertiesOverride.mInertia = Jolt.Mat44.prototype.sScaleVec3(v);
            });
            withVector(of.velocity, (v) => { settings.mLinearVelocity = v; });
            withVector(of.angularVelocity, (v) => { settings.mAngularVelocity = v; });
        }
        const body = world.CreateBody(settings);
        world.AddBody(body.GetID(), Jolt.EActivation_Activate);
        for (const value of [at, turn, settings]) Jolt.destroy(value);
        return body;
    };
    if (scene.ground) {
        const box = withVector([50, 1, 50], (half) => new Jolt.BoxShape(half, 0.05));
        add(box, { fixed: true, position: [0, -1, 0], orientation: [0, 0, 0, 1], friction: scene.groundFriction },
            restitutions.ground);
    }
    for (const of of scene.bodies) bodies.push(add(hullOf(of.corners), of, of.fixed ? 0 : restitutions.body));
    system.OptimizeBroadPhase();
    return {
        step: () => jolt.Step(scene.step, 1),
        pose(k) {
            const p = bodies[k].GetPosition(), q = bodies[k].GetRotation();
            return [p.GetX(), p.GetY(), p.GetZ(), q.GetX(), q.GetY(), q.GetZ(), q.GetW()];
        },
        free: () => Jolt.destroy(jolt),
    };
});
