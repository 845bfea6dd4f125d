// The interface of tools/compare for peers in JavaScript. docs/benchmark.md describes the protocol and the file format.
//
//     serve("Peer 1.2", async (task) => ({      // what is not measured
//         run: () => count,                     // what is measured: breaks the mesh; returns the count of pieces
//         pieces: () => [{ points, triangles }],
//     }));
//
// task: { mesh, sites, cells, threads, words }. A part is { points, triangles }, flat arrays; sites is flat, too.
import fs from "node:fs";
import readline from "node:readline";

export function readParts(name) {
    const bytes = fs.readFileSync(name), view = new DataView(bytes.buffer, bytes.byteOffset, bytes.length), parts = [];
    let at = 4;
    for (let k = view.getUint32(0, true); k > 0; --k) {
        const points = new Float64Array(3 * view.getUint32(at, true)), triangles = new Uint32Array(3 * view.getUint32(at + 4, true));
        at += 8;
        for (let i = 0; i < points.length; ++i, at += 8) points[i] = view.getFloat64(at, true);
        for (let i = 0; i < triangles.length; ++i, at += 4) triangles[i] = view.getUint32(at, true);
        parts.push({ points, triangles });
    }
    return parts;
}

export function writeParts(name, parts) {
    const view = new DataView(new ArrayBuffer(parts.reduce((sum, part) => sum + 8 + 8 * part.points.length + 4 * part.triangles.length, 4)));
    let at = 4;
    view.setUint32(0, parts.length, true);
    for (const { points, triangles } of parts) {
        view.setUint32(at, points.length / 3, true);
        view.setUint32(at + 4, triangles.length / 3, true);
        at += 8;
        for (const x of points) { view.setFloat64(at, x, true); at += 8; }
        for (const v of triangles) { view.setUint32(at, v, true); at += 4; }
    }
    fs.writeFileSync(name, new Uint8Array(view.buffer));
}

export async function serve(version, prepare) {
    const say = (line) => fs.writeSync(1, `${line}\n`);
    const [mesh, sites, cells, threads, ...words] = process.argv.slice(2);
    let job = null;
    try {
        job = await prepare({ mesh: readParts(mesh)[0], sites: fs.readFileSync(sites, "utf8").trim().split(/\s+/).map(Number),
            cells: readParts(cells), threads: Number(threads), words });
    } catch (error) {
        say(`failed ${String(error.message).replaceAll("\n", " ")}`);
        process.exit(1);
    }
    say(`ready ${version}`);
    for await (const line of readline.createInterface({ input: process.stdin })) {
        try {
            if (line === "run") {
                const begin = performance.now(), count = await job.run();
                say(`done ${performance.now() - begin} ${count}`);
            } else if (line.startsWith("write ")) {
                writeParts(line.slice(6), job.pieces());
                say("written");
            }
        } catch (error) {
            say(`failed ${String(error.message ?? error).replaceAll("\n", " ")}`);
        }
    }
}
