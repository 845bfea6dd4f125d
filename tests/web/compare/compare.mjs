// Brittle beside three-pinata and three-bvh-csg in one run of Chromium: time, open pieces, error of the volume.
//   tools/test-web --compare
import { spawn } from "node:child_process";
import fs from "node:fs";
import { createRequire } from "node:module";
import path from "node:path";
import { fileURLToPath } from "node:url";

const here = path.dirname(fileURLToPath(import.meta.url)), root = path.join(here, "../../.."), out = path.join(root, "build/web/compare");
const require = createRequire(path.join(root, "build/web/package.json"));
const library = path.join(root, "build/web/brittle-fracture");
await require("esbuild").build({ entryPoints: [path.join(here, "peers.js"), path.join(library, "worker.js"), path.join(library, "thread.js")], outdir: path.join(out, "page"),
    entryNames: "[name]", bundle: true, format: "esm",
    target: "es2022", nodePaths: [path.join(out, "node_modules")], alias: {
        "brittle-fracture": path.join(library, "brittle.js"), "brittle-fracture/worker": path.join(library, "client.js") }, external: ["node:*"], logLevel: "error" });
fs.writeFileSync(path.join(out, "page/index.html"), '<!doctype html><title>compare</title><script type="module" src="peers.js"></script>');
for (const file of ["brittle_wasm.wasm", "brittle_wasm_threads.wasm"]) fs.copyFileSync(path.join(library, file), path.join(out, "page", file));
fs.copyFileSync("/usr/share/glmark2/models/bunny.obj", path.join(out, "page/bunny.obj"));

const server = spawn("node", [path.join(root, "bindings/web/page/serve.mjs"), path.join(root, "build/web"), path.join(out, "page"), "0"], { stdio: ["ignore", "pipe", "inherit"] });
const address = await new Promise((resolve) => server.stdout.once("data", (text) => resolve(String(text).trim())));
const browser = await require("playwright-core").chromium.launch({ executablePath: "/usr/bin/chromium", args: ["--no-sandbox", "--disable-gpu"] });
console.log(`Chromium ${browser.version()}\n`);
console.log("| mesh | sites | | time, ms | pieces | open | volume error |\n|---|---|---|---|---|---|---|");
try {
    for (const model of ["statue", "bunny.obj"])
        for (const count of [10, 100])
            for (const runner of ["brittle", "three-pinata", "three-bvh-csg"]) {
                const page = await browser.newPage();
                page.setDefaultTimeout(0);
                await page.goto(address);
                await page.waitForFunction(() => globalThis.compare);
                const runs = runner === "brittle" ? 15 : count === 10 ? 3 : 1;
                const row = await page.evaluate((given) => globalThis.compare(given).catch((error) => ({ failed: error.message })), { runner, model, count, runs });
                if (row.failed) console.log(`| ${model} | ${count} | ${runner} | fails: ${row.failed} | | | |`);
                else {
                    const time = row.times.sort((a, b) => a - b)[Math.floor(row.times.length / 2)];
                    console.log(`| ${model} | ${count} | ${runner} | ${time < 1000 ? time.toFixed(0) : Math.round(time).toLocaleString("en")} | ${row.pieces} | ${row.open} | ${row.error.toExponential(1)} |`);
                }
                await page.close();
            }
    const page = await browser.newPage();
    await page.goto(address);
    await page.waitForFunction(() => globalThis.pauses);
    const { quiet, busy, pieces } = await page.evaluate(() => globalThis.pauses({ model: "bunny.obj", count: 1000 }));
    console.log(`\nLongest pause of the page while a worker breaks the bunny into ${pieces} pieces: ${busy.toFixed(1)} ms; of an idle page: ${quiet.toFixed(1)} ms`);
    console.log("\n| bunny, sites | 1 thread, ms | 2 threads | 4 threads |\n|---|---|---|---|");
    for (const count of [10, 100, 1000, 10000]) {
        const times = [];
        for (const threads of [1, 2, 4])
            times.push(await page.evaluate((given) => globalThis.threaded(given), { model: "bunny.obj", count, threads, runs: count > 5000 ? 5 : 25 }));
        console.log(`| ${count} | ${times.map((time) => time.toFixed(0)).join(" | ")} |`);
    }
} finally {
    await browser.close();
    server.kill();
}
