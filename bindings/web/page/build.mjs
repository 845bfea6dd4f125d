// Bundles the page: node build.mjs NPM PACKAGE OUT. NPM: folder with node_modules; PACKAGE: the built npm package.
import { createHash } from "node:crypto";
import fs from "node:fs";
import { createRequire } from "node:module";
import path from "node:path";
import { fileURLToPath } from "node:url";
import { gzipSync } from "node:zlib";

const [npm, library, out] = process.argv.slice(2).map((folder) => path.resolve(folder));
const here = path.dirname(fileURLToPath(import.meta.url)), require = createRequire(path.join(npm, "package.json"));
const { build } = require("esbuild");
const MODELS = "/usr/share/glmark2/models"; // of Debian's glmark2-data

fs.rmSync(out, { recursive: true, force: true });
fs.mkdirSync(path.join(out, "models"), { recursive: true });

const rapier = path.join(npm, "node_modules/@dimforge/rapier3d/rapier_wasm3d_bg.wasm");
const resolve = {
    name: "resolve",
    setup(build) {
        build.onResolve({ filter: /^brittle-fracture\/worker$/ }, () => ({ path: path.join(library, "client.js") }));
        // Rapier imports its machine code as a module, which browsers do not do: fetch it.
        build.onLoad({ filter: /rapier_wasm3d\.js$/ }, () => ({ contents: `
            import * as glue from "./rapier_wasm3d_bg.js";
            const { instance } = await WebAssembly.instantiateStreaming(fetch(new URL("rapier.wasm", import.meta.url)),
                { "./rapier_wasm3d_bg.js": glue });
            glue.__wbg_set_wasm(instance.exports);
            instance.exports.__wbindgen_start?.();
            export * from "./rapier_wasm3d_bg.js";` }));
    },
};
const common = { bundle: true, minify: true, format: "esm", target: "es2022", outdir: out, legalComments: "eof", logLevel: "warning",
                 nodePaths: [path.join(npm, "node_modules")], plugins: [resolve], external: ["node:*"] };
await build({ ...common, entryPoints: [path.join(here, "main.js")], splitting: true });
await build({ ...common, entryPoints: ["worker.js", "thread.js"].map((file) => path.join(library, file)), splitting: true });

for (const file of ["index.html", "style.css", "icon.svg"]) fs.copyFileSync(path.join(here, file), path.join(out, file));
for (const file of ["brittle_wasm.wasm", "brittle_wasm_threads.wasm"]) fs.copyFileSync(path.join(library, file), path.join(out, file));
fs.copyFileSync(rapier, path.join(out, "rapier.wasm"));
for (const file of ["bunny.obj", "horse.3ds", "cat.3ds"]) fs.copyFileSync(path.join(MODELS, file), path.join(out, "models", file));

const files = fs.readdirSync(out, { recursive: true }).filter((file) => fs.statSync(path.join(out, file)).isFile()).sort();
const hash = createHash("sha256");
for (const file of files) hash.update(file).update(fs.readFileSync(path.join(out, file)));
const offline = fs.readFileSync(path.join(here, "offline.js"), "utf8").replace("__VERSION__", `brittle-${hash.digest("hex").slice(0, 16)}`)
    .replace("__FILES__", JSON.stringify(["./", ...files]));
fs.writeFileSync(path.join(out, "offline.js"), offline);
let code = 0; // a visit loads one of the two modules
for (const file of [...files, "offline.js"]) {
    const packed = gzipSync(fs.readFileSync(path.join(out, file)), { level: 9 });
    fs.writeFileSync(path.join(out, `${file}.gz`), packed);
    if (!file.startsWith("models/") && file !== "brittle_wasm_threads.wasm") code += packed.length;
}
console.log(`${out}: ${(code / 1e6).toFixed(2)} MB without the models, compressed`);
