// What breaks and moves: bodies of pieces that hold together by bonds, in a world of Rapier. Meshes keep the coordinates
// of their file; `frame` scales and moves them into the world. A body's pose turns and moves that rest state.
import { CUT, OUTSIDE, Outside } from "./outside.js";

let RAPIER = null;

const STEP = 1 / 60;          // s
const DENSITY = 2400;         // kg/m^3
const SMALLEST = 1 / 3000;    // of the object's volume: smaller pieces are not cut again

const add = (a, b, f = 1) => [a[0] + f * b[0], a[1] + f * b[1], a[2] + f * b[2]];
const length = (a) => Math.hypot(a[0], a[1], a[2]);
const distance = (a, b) => Math.hypot(a[0] - b[0], a[1] - b[1], a[2] - b[2]);

/** v turned by the quaternion q, or back. */
export function turn(q, v, back = false) {
    const [x, y, z] = back ? [-q[0], -q[1], -q[2]] : q, w = q[3];
    const t = [2 * (y * v[2] - z * v[1]), 2 * (z * v[0] - x * v[2]), 2 * (x * v[1] - y * v[0])];
    return [v[0] + w * t[0] + y * t[2] - z * t[1], v[1] + w * t[1] + z * t[0] - x * t[2],
            v[2] + w * t[2] + x * t[1] - y * t[0]];
}

/** A piece, or a whole mesh. `origins`: the triangle of the whole mesh in which each triangle lies, -1 on cuts. `recut`: it is a
 *  part of another piece. */
class Piece {
    constructor(id, { index, positions, triangles, volume, centre, origins, hulls, source = null, recut = false }) {
        Object.assign(this, { id, index, positions, triangles, volume, centre: Array.from(centre), origins, hulls, source, recut });
        this.set = null; // of the view
        this.body = null;
        this.colliders = [];
        this.min = [Infinity, Infinity, Infinity];
        this.max = [-Infinity, -Infinity, -Infinity];
        for (let v = 0; v < positions.length; v += 3)
            for (let k = 0; k < 3; ++k) {
                this.min[k] = Math.min(this.min[k], positions[v + k]);
                this.max[k] = Math.max(this.max[k], positions[v + k]);
            }
    }

    /** The share of the ray at which it meets the surface, with the normal; null where it misses. */
    meet(from, direction) {
        let near = 0, far = Infinity;
        for (let k = 0; k < 3; ++k) {
            const a = (this.min[k] - from[k]) / direction[k], b = (this.max[k] - from[k]) / direction[k];
            near = Math.max(near, Math.min(a, b));
            far = Math.min(far, Math.max(a, b));
        }
        if (!(near <= far)) return null;
        const { positions: p, triangles } = this, [dx, dy, dz] = direction;
        let best = Infinity, normal = null;
        for (let t = 0; t < triangles.length; t += 3) {
            const a = 3 * triangles[t], b = 3 * triangles[t + 1], c = 3 * triangles[t + 2];
            const ux = p[b] - p[a], uy = p[b + 1] - p[a + 1], uz = p[b + 2] - p[a + 2];
            const vx = p[c] - p[a], vy = p[c + 1] - p[a + 1], vz = p[c + 2] - p[a + 2];
            const hx = dy * vz - dz * vy, hy = dz * vx - dx * vz, hz = dx * vy - dy * vx;
            const determinant = ux * hx + uy * hy + uz * hz;
            if (determinant <= 0) continue; // seen from behind
            const sx = from[0] - p[a], sy = from[1] - p[a + 1], sz = from[2] - p[a + 2];
            const u = sx * hx + sy * hy + sz * hz;
            if (u < 0 || u > determinant) continue;
            const qx = sy * uz - sz * uy, qy = sz * ux - sx * uz, qz = sx * uy - sy * ux;
            const v = dx * qx + dy * qy + dz * qz;
            if (v < 0 || u + v > determinant) continue;
            const at = (vx * qx + vy * qy + vz * qz) / determinant;
            if (at > 0 && at < best) {
                best = at;
                normal = [uy * vz - uz * vy, uz * vx - ux * vz, ux * vy - uy * vx];
            }
        }
        return normal && { at: best, normal: normal.map((n) => n / length(normal)) };
    }
}

export class Destruction {
    #worker;
    #view;
    #world = null;
    #mesh = null;
    #accumulated = 0;
    #moving = false;

    constructor(worker, view) {
        this.#worker = worker;
        this.#view = view;
        this.pieces = [];
        this.bodies = [];
        this.bonds = [];
        this.blows = [];
        this.steps = 0;
        this.certificate = null;
        this.milliseconds = 0;
        this.busy = false;
        this.explode = 0;
    }

    /** Puts a whole mesh there. `arrays`: those of `mesh`, a mesh of the worker. `looks`: materials of three.js. */
    async place(mesh, arrays, looks) {
        RAPIER ??= await import("@dimforge/rapier3d");
        this.#mesh = mesh;
        this.arrays = arrays;
        this.outside?.dispose();
        this.outside = new Outside(arrays, looks);
        this.reset();
    }

    get ready() { return this.#mesh !== null; }
    get broken() { return this.steps > 0 || this.pieces.length > 1; }

    /** Whole again. */
    reset() {
        this.#world?.free();
        this.#world = new RAPIER.World({ x: 0, y: -9.81, z: 0 });
        this.#world.timestep = STEP;
        // Hulls of adjacent pieces may overlap a little: they part slowly.
        this.#world.integrationParameters.normalizedMaxCorrectiveVelocity = 1;
        this.#world.createCollider(RAPIER.ColliderDesc.cuboid(200, 1, 200).setTranslation(0, -1, 0).setFriction(0.7));
        Object.assign(this, { pieces: [], bodies: [], bonds: [], blows: [], steps: 0, certificate: null });
        this.#accumulated = 0;
        this.#view.clear();
        const { positions, triangles } = this.arrays;
        const whole = new Piece(0, { index: 0, positions, triangles, volume: 0, centre: [0, 0, 0],
                                     origins: Int32Array.from({ length: triangles.length / 3 }, (_, t) => t), hulls: [] });
        const size = Math.max(...whole.max.map((most, k) => most - whole.min[k])), scale = 2 / size;
        const middle = whole.min.map((least, k) => (least + whole.max[k]) / 2);
        this.frame = { scale, offset: [-scale * middle[0], -scale * whole.min[1], -scale * middle[2]], size };
        this.middle = middle;
        whole.centre = middle;
        let volume = 0;
        for (let t = 0; t < triangles.length; t += 3) {
            const [a, b, c] = [triangles[t], triangles[t + 1], triangles[t + 2]].map((v) => positions.subarray(3 * v, 3 * v + 3));
            volume += a[0] * (b[1] * c[2] - b[2] * c[1]) + a[1] * (b[2] * c[0] - b[0] * c[2]) + a[2] * (b[0] * c[1] - b[1] * c[0]);
        }
        this.volume = whole.volume = volume / 6;
        whole.set = this.#view.add([whole], this.outside, this.frame, middle);
        this.pieces.push(whole);
        this.bodies.push(whole.body = { rigid: null, pieces: [whole], pose: rest(), before: rest() });
    }

    world(point) { return add(this.frame.offset, point, this.frame.scale); }

    #offset(piece) { return add(piece.centre, this.middle, -1).map((c) => c * this.explode); }

    /** The first surface that a ray of the world meets: the piece, and the point in the coordinates of the file. */
    pick(origin, direction) {
        const { scale, offset } = this.frame;
        let best = null;
        for (const body of this.bodies) {
            const q = body.pose.rotation;
            const from = turn(q, add(origin, body.pose.translation, -1), true).map((x, k) => (x - offset[k]) / scale);
            const along = turn(q, direction, true);
            for (const piece of body.pieces) {
                const moved = this.#offset(piece), hit = piece.meet(add(from, moved, -1), along);
                if (!hit || best && hit.at * scale >= best.distance) continue;
                const point = add(add(from, moved, -1), along, hit.at);
                best = { piece, point, normal: turn(q, hit.normal), distance: hit.at * scale, local: hit.normal,
                         along, world: add(origin, direction, hit.at * scale) };
            }
        }
        return best;
    }

    /**
     * Strikes piece number `piece` at `point` along `along`, both in the coordinates of the file. Cuts the piece where it
     * is large, frees what lies within `radius` (a share of the object's size), and pushes it.
     */
    async blow(given, settings, onProgress, signal) {
        const blow = { ...given, step: this.steps };
        const piece = this.pieces[blow.piece];
        if (this.busy || !piece?.body) return false;
        this.busy = true;
        try {
            const radius = blow.radius * this.frame.size;
            if (piece.volume > SMALLEST * this.volume) {
                const share = Math.sqrt(piece.volume / this.volume);
                const count = Math.max(6, Math.round(settings.sites * share));
                const bodySize = piece.max.map((most, k) => most - piece.min[k]);
                const focus = blow.point.map((x, k) => Math.min(1, Math.max(0, (x - piece.min[k]) / (bodySize[k] || 1))));
                const focused = settings.local ? { ...settings.local(blow), focus } : {};
                const { local, ...rest } = settings;
                const cut = { ...rest, ...focused, sites: count, seed: settings.seed + piece.id };
                const mesh = piece.id === 0 ? this.#mesh : await this.#worker.mesh(piece.positions, piece.triangles,
                    { materials: Uint32Array.from(piece.origins, (origin) => origin < 0 ? CUT : OUTSIDE) });
                try {
                    const broken = await this.#worker.fracture(mesh, cut, { onProgress, signal, hulls: { parts: 4, vertices: 32 } });
                    this.#divide(piece, broken);
                } finally {
                    if (mesh !== this.#mesh) await mesh.dispose();
                }
            }
            this.blows.push(blow);
            this.#strike(piece.body ?? this.pieces[this.pieces.length - 1].body, blow, radius);
            return true;
        } finally {
            this.busy = false;
        }
    }

    #divide(piece, broken) {
        const { body } = piece, first = this.pieces.length;
        const sources = broken.array("triangleSources"), ranges = broken.array("triangleRanges");
        for (const part of broken) {
            const origins = new Int32Array(part.triangles.length / 3).fill(-1);
            for (let t = 0; t < part.exteriorTriangles; ++t) origins[t] = piece.origins[sources[ranges[2 * part.index] + t]];
            this.pieces.push(new Piece(this.pieces.length, { ...part, origins, hulls: broken.hulls(part.index), source: broken,
                                                             recut: piece.id !== 0 }));
        }
        const made = this.pieces.slice(first), set = this.#view.add(made, this.outside, this.frame, this.middle);
        for (const part of made) part.set = set;
        // A bond of the old piece goes to the nearest of its parts.
        for (const bond of this.bonds)
            for (const side of ["a", "b"])
                if (bond[side] === piece) bond[side] = nearest(made, bond.point);
        const { bonds, bondCentroids } = broken;
        for (let k = 0; k < bonds.length / 2; ++k)
            this.bonds.push({ a: made[bonds[2 * k]], b: made[bonds[2 * k + 1]],
                              point: Array.from(bondCentroids.subarray(3 * k, 3 * k + 3)) });
        this.#view.hide(piece);
        if (!body.rigid) body.rigid = this.#world.createRigidBody(damped());
        for (const collider of piece.colliders) this.#world.removeCollider(collider, false);
        body.pieces = body.pieces.filter((other) => other !== piece).concat(made);
        piece.body = null;
        for (const part of made) this.#join(part, body);
        this.certificate = broken.certificate;
        this.milliseconds = broken.milliseconds;
    }

    #join(piece, body) {
        const { scale } = this.frame, mass = piece.volume * scale ** 3 * DENSITY, [x, y, z] = this.world(piece.centre);
        piece.body = body;
        piece.colliders = [];
        for (const { points, margin } of piece.hulls) {
            const shape = RAPIER.ColliderDesc.convexHull(Float32Array.from(points, (p) => p * scale))
                ?? RAPIER.ColliderDesc.ball(Math.max(margin * scale, 1e-3));
            shape.setTranslation(x, y, z).setFriction(0.6).setRestitution(0.1).setMass(mass / piece.hulls.length)
                .setContactSkin(margin * scale);
            piece.colliders.push(this.#world.createCollider(shape, body.rigid));
        }
    }

    #strike(struck, blow, radius) {
        this.bonds = this.bonds.filter(({ a, b, point }) => a.body !== struck || distance(point, blow.point) > radius);
        // What still holds together stays a body; the largest keeps the old one.
        const root = new Map(struck.pieces.map((piece) => [piece, piece]));
        const find = (piece) => {
            while (root.get(piece) !== piece) {
                root.set(piece, root.get(root.get(piece)));
                piece = root.get(piece);
            }
            return piece;
        };
        for (const { a, b } of this.bonds)
            if (a.body === struck && b.body === struck) root.set(find(a), find(b));
        const groups = new Map();
        for (const piece of struck.pieces) {
            const of = find(piece);
            if (!groups.has(of)) groups.set(of, []);
            groups.get(of).push(piece);
        }
        const [kept, ...freed] = [...groups.values()].sort((a, b) => b.length - a.length || a[0].id - b[0].id);
        const { rigid } = struck, spin = xyz(rigid.angvel()), speed = xyz(rigid.linvel()), centre = xyz(rigid.worldCom());
        const { rotation: [x, y, z, w], translation } = struck.pose;
        for (const group of freed) {
            const body = { pieces: group, pose: struck.pose, before: struck.pose, rigid: this.#world.createRigidBody(
                damped().setTranslation(...translation).setRotation({ x, y, z, w })) };
            for (const piece of group) {
                for (const collider of piece.colliders) this.#world.removeCollider(collider, false);
                this.#join(piece, body);
            }
            body.rigid.recomputeMassPropertiesFromColliders();
            const arm = add(xyz(body.rigid.worldCom()), centre, -1);
            body.rigid.setLinvel(vector(add(speed, [spin[1] * arm[2] - spin[2] * arm[1], spin[2] * arm[0] - spin[0] * arm[2],
                spin[0] * arm[1] - spin[1] * arm[0]])), true);
            body.rigid.setAngvel(vector(spin), true);
            this.bodies.push(body);
        }
        struck.pieces = kept;
        rigid.recomputeMassPropertiesFromColliders();
        rigid.wakeUp();
        const q = struck.pose.rotation, reach = 1.5 * radius;
        for (const group of [kept, ...freed])
            for (const piece of group) {
                const away = add(piece.centre, blow.point, -1), far = length(away);
                if (!(far < reach)) continue;
                const push = blow.speed * (1 - far / reach) * piece.volume * this.frame.scale ** 3 * DENSITY;
                const outward = add(blow.along.map((d) => 0.8 * d), away, 0.5 / Math.max(far, 1e-9));
                const at = add(turn(q, this.world(piece.centre)), translation);
                piece.body.rigid.applyImpulseAtPoint(vector(turn(q, outward).map((d) => d * push)), vector(at), true);
            }
    }

    /** Lets time pass, in whole steps, at most `most` of them; true while something moves. `share`: slow motion. */
    advance(seconds, share = 1, most = 4) {
        const moving = this.bodies.some(({ rigid }) => rigid && !rigid.isSleeping());
        if (this.busy) return false;
        if (!moving) {
            if (this.#moving) this.show();
            this.#accumulated = 0;
            return this.#moving = false;
        }
        this.#moving = true;
        this.#accumulated = Math.min(this.#accumulated + seconds * share, most * STEP);
        while (this.#accumulated >= STEP) {
            this.step();
            this.#accumulated -= STEP;
        }
        this.show(this.#accumulated / STEP);
        return true;
    }

    step() {
        this.#world.step();
        ++this.steps;
        for (const body of this.bodies) {
            if (!body.rigid) continue;
            const t = body.rigid.translation(), r = body.rigid.rotation();
            body.before = body.pose;
            body.pose = { translation: [t.x, t.y, t.z], rotation: [r.x, r.y, r.z, r.w] };
        }
    }

    /** A number of all poses: equal where all pieces lie alike, bit for bit. */
    fingerprint() {
        let hash = 0x811c9dc5;
        for (const { pose: { translation, rotation } } of this.bodies)
            for (const word of new Uint32Array(Float32Array.of(...translation, ...rotation).buffer)) hash = Math.imul(hash ^ word, 0x01000193) >>> 0;
        return hash;
    }

    /** Hands all poses to the view, between the last two steps. */
    show(share = 1) {
        for (const { pieces, pose, before } of this.bodies) {
            const same = pose.rotation.reduce((sum, x, k) => sum + x * before.rotation[k], 0) < 0 ? -1 : 1;
            const rotation = pose.rotation.map((x, k) => share * x + (1 - share) * same * before.rotation[k]);
            const size = Math.hypot(...rotation);
            const between = { rotation: rotation.map((x) => x / size),
                              translation: pose.translation.map((x, k) => share * x + (1 - share) * before.translation[k]) };
            for (const piece of pieces) this.#view.pose(piece, between);
        }
    }
}

const damped = () => RAPIER.RigidBodyDesc.dynamic().setAngularDamping(0.4).setLinearDamping(0.02);
const rest = () => ({ translation: [0, 0, 0], rotation: [0, 0, 0, 1] });
const xyz = ({ x, y, z }) => [x, y, z];
const vector = ([x, y, z]) => ({ x, y, z });

function nearest(pieces, point) {
    let best = null, least = Infinity;
    for (const piece of pieces)
        for (let v = 0; v < piece.positions.length; v += 3) {
            const far = Math.hypot(piece.positions[v] - point[0], piece.positions[v + 1] - point[1], piece.positions[v + 2] - point[2]);
            if (far < least) [best, least] = [piece, far];
        }
    return best;
}
