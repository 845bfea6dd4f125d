// The interface of tools/compare --physics for peers in JavaScript. docs/benchmark-physics.md has protocol and files.
//
//     await serve("Peer 1.2", (scene, words) => ({   // what is not measured
//         step() {},                                 // what is measured
//         pose: (body) => [x, y, z, qx, qy, qz, qw],
//         free() {},                                 // optional
//     }));
//
// scene: { steps, stepsARecord, ground, threads, gravity, step, groundFriction, groundRestitution, bodies }. A body is
// { fixed, mass, moments, position, orientation, velocity, angularVelocity, friction, restitution, corners }.
import fs from "node:fs";
import readline from "node:readline";

const magics = { scene: "scene 1\n", poses: "poses 1\n" };

export function readScene(name) {
    const bytes = fs.readFileSync(name), view = new DataView(bytes.buffer, bytes.byteOffset, bytes.length);
    if (bytes.toString("latin1", 0, 8) !== magics.scene) throw new Error(`${name}: does not begin with 'scene 1'`);
    let at = 8;
    const take = (count, size, read) => {
        if (at + count * size > bytes.length) throw new Error(`${name}: ends early; write it again`);
        return Array.from({ length: count }, () => read((at += size) - size));
    };
    const integers = (count) => take(count, 4, (from) => view.getUint32(from, true));
    const doubles = (count) => take(count, 8, (from) => view.getFloat64(from, true));
    const [steps, stepsARecord, ground, count] = integers(4), gravity = doubles(3);
    const [step, groundFriction, groundRestitution] = doubles(3);
    const bodies = Array.from({ length: count }, () => {
        const [fixed, corners] = integers(2), [mass] = doubles(1);
        const [moments, position, orientation, velocity, angularVelocity] = [3, 3, 4, 3, 3].map(doubles);
        const [friction, restitution] = doubles(2);
        return { fixed: fixed !== 0, mass, moments, position, orientation, velocity, angularVelocity, friction,
            restitution, corners: doubles(3 * corners) };
    });
    return { steps, stepsARecord, ground: ground !== 0, gravity, step, groundFriction, groundRestitution, bodies };
}

function writePoses(name, bodies, records) {
    const view = new DataView(new ArrayBuffer(16 + 56 * bodies * records.length));
    for (let k = 0; k < 8; ++k) view.setUint8(k, magics.poses.charCodeAt(k));
    view.setUint32(8, bodies, true);
    view.setUint32(12, records.length, true);
    records.flat(2).forEach((value, k) => view.setFloat64(16 + 8 * k, value, true));
    fs.writeFileSync(`${name}.new`, view);
    fs.renameSync(`${name}.new`, name);
}

export async function serve(version, prepare) {
    const say = (line) => fs.writeSync(1, `${line}\n`);
    const reason = (error) => String(error.message ?? error).replaceAll("\n", " ");
    const [name, threads, ...words] = process.argv.slice(2);
    let scene = null, records = [];
    try {
        scene = { ...readScene(name), threads: Number(threads) };
    } catch (error) {
        say(`failed ${reason(error)}`);
        process.exit(1);
    }
    say(`ready ${version}`);
    for await (const line of readline.createInterface({ input: process.stdin })) {
        try {
            if (line === "run") {
                const simulation = await prepare(scene, words), times = [];
                const record = () => records.push(scene.bodies.map((_, k) => simulation.pose(k)));
                records = [];
                record();
                for (let step = 1; step <= scene.steps; ++step) {
                    const begin = performance.now();
                    simulation.step();
                    times.push(performance.now() - begin);
                    if (step % scene.stepsARecord === 0) record();
                }
                simulation.free?.();
                times.sort((a, b) => a - b);
                const share = (percent) => times[Math.ceil((times.length * percent) / 100) - 1] ?? 0;
                say(`done ${share(50)} ${share(95)} ${share(100)}`);
            } else if (line.startsWith("write ")) {
                writePoses(line.slice(6), scene.bodies.length, records);
                say("written");
            }
        } catch (error) {
            say(`failed ${reason(error)}`);
        }
    }
}
