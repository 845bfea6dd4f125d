// The page in Debian's Chromium, on its software renderer, as a visitor uses it: mouse, touch, keys, files, links.
// Pictures of each state are build/web/pictures; BRITTLE_UPDATE_GOLDENS=1 writes tests/web/goldens anew.
import assert from "node:assert/strict";
import { execFileSync, spawn } from "node:child_process";
import fs from "node:fs";
import { createRequire } from "node:module";
import path from "node:path";
import test from "node:test";

import { load, materials } from "../../build/web/brittle-fracture/brittle.js";
import { CAPS, SIDES, column, tetrahedron } from "./models.mjs";

const ROOT = new URL("../../", import.meta.url).pathname, PICTURES = path.join(ROOT, "build/web/pictures");
const { chromium } = createRequire(path.join(ROOT, "build/web/package.json"))("playwright-core");
const WEBGL = ["--use-gl=angle", "--use-angle=swiftshader", "--enable-unsafe-swiftshader", "--ignore-gpu-blocklist"];
const WAIT = { timeout: 60_000 };

fs.mkdirSync(PICTURES, { recursive: true });
const servers = [];
/** Serves the page; with `--not-isolated` without the headers that let it have threads. */
async function serve(...options) {
    const server = spawn("node", ["bindings/web/page/serve.mjs", "build/web", "build/web/page", "0", ...options], { cwd: ROOT, stdio: ["ignore", "pipe", "inherit"] });
    servers.push(server);
    return new Promise((resolve) => server.stdout.once("data", (text) => resolve(String(text).trim())));
}
const address = await serve(), plain = await serve("--not-isolated");
const launch = (args) => chromium.launch({ executablePath: "/usr/bin/chromium", args: ["--no-sandbox", "--disable-dev-shm-usage", ...args] });
const browser = await launch(WEBGL);
test.after(async () => {
    await browser.close();
    for (const server of servers) server.kill();
});

/** Opens the page, waits until a model stands there, and fails on any error of its scripts. */
async function visit(hash = "", options = {}) {
    const context = await browser.newContext({ viewport: { width: 960, height: 640 }, ...options }), page = await context.newPage();
    page.errors = [];
    page.on("pageerror", (error) => page.errors.push(error.message));
    page.on("console", (message) => message.type() === "error" && page.errors.push(message.text()));
    page.setDefaultTimeout(WAIT.timeout);
    await page.goto(`${address}?fixed${hash}`);
    await page.waitForSelector("body[data-opened]", WAIT);
    page.leave = async () => {
        assert.deepEqual(page.errors, []);
        await context.close();
    };
    return page;
}

const ready = (page) => page.waitForSelector('body[data-state="ready"]', WAIT);
/** A number of all poses, when nothing moves any more. */
const rested = async (page) => {
    await page.waitForSelector('body[data-moving="false"][data-poses]', { timeout: 120_000 });
    return page.evaluate(() => document.body.dataset.poses);
};
const text = (page, id) => page.locator(`#${id}`).innerText();
const broken = async (page) => {
    await page.waitForSelector("#certificate:not([hidden])", WAIT);
    await ready(page);
    return { pieces: Number((await text(page, "c-pieces")).replace(",", "")), closed: await text(page, "c-closed"), hash: await text(page, "c-hash") };
};
const middle = { x: 320, y: 300 };

/** Compares the picture with the golden, text and panel masked: the mean difference of small, blurred versions. */
async function golden(page, name) {
    const file = path.join(PICTURES, `${name}.png`), expected = path.join(ROOT, "tests/web/goldens", `${name}.png`);
    await page.screenshot({ path: path.join(PICTURES, `${name}_all.png`) });
    await page.screenshot({ path: file, mask: ["#panel", "#hint", "#certificate", "#notice"].map((id) => page.locator(id)), maskColor: "#808080" });
    if (process.env.BRITTLE_UPDATE_GOLDENS === "1") fs.copyFileSync(file, expected);
    const small = (of) => execFileSync("convert", [of, "-resize", "120x", "-depth", "8", "rgb:-"], { maxBuffer: 1 << 24 });
    const [a, b] = [small(file), small(expected)];
    assert.equal(a.length, b.length);
    const far = a.reduce((sum, value, k) => sum + (Math.abs(value - b[k]) > 24 ? 1 : 0), 0) / a.length;
    assert.ok(far < 0.004, `${file} differs from ${expected} in ${(100 * far).toFixed(2)} % of its pixels`);
}

test("a click breaks the statue where it strikes, another one breaks it further", async () => {
    const page = await visit("#sites=60");
    assert.equal(await page.locator("#certificate").isVisible(), false);
    await golden(page, "whole");
    await page.mouse.click(middle.x, middle.y);
    const first = await broken(page);
    assert.ok(first.pieces >= 55 && first.pieces <= 90, `${first.pieces} pieces`);
    assert.equal(first.closed, "all");
    await rested(page);
    await page.mouse.click(320, 560);
    await page.waitForFunction((hash) => document.getElementById("c-hash").textContent !== hash, first.hash, WAIT);
    const second = await broken(page);
    assert.equal(second.closed, "all");
    assert.ok(page.url().includes("blows=0_0_"));
    assert.equal(new URLSearchParams(new URL(page.url()).hash.slice(1)).get("blows").split("*").length, 2);
    await page.leave();
});

test("a drag turns the view and breaks nothing; R makes whole again; B breaks all; Enter strikes the middle", async () => {
    const page = await visit("#model=vase&material=ceramic&sites=30");
    await page.mouse.move(middle.x, middle.y);
    await page.mouse.down();
    await page.mouse.move(middle.x + 120, middle.y, { steps: 5 });
    await page.mouse.up();
    await page.waitForTimeout(300);
    assert.equal(await page.locator("#certificate").isVisible(), false);
    await page.keyboard.press("b");
    await broken(page);
    assert.match(page.url(), /blows=/);
    await page.keyboard.press("r");
    await page.waitForSelector("#certificate", { state: "hidden" });
    assert.doesNotMatch(page.url(), /blows=/);
    await page.locator("#view").focus();
    await page.keyboard.press("Enter");
    await broken(page);
    for (const key of ["ArrowLeft", "ArrowUp", "+", "-", "x", "Space"]) await page.keyboard.press(key);
    assert.equal(await page.locator("#explode").inputValue(), "0.6");
    assert.equal(await page.locator('output[for="speed"]').innerText(), "paused");
    await page.leave();
});

test("a touch breaks it on a phone; the settings unfold", async () => {
    const page = await visit("#model=vase&material=ceramic&sites=60&roughness=0.3", { viewport: { width: 390, height: 780 }, hasTouch: true, isMobile: true });
    assert.equal(await page.locator("#controls").isVisible(), false);
    await page.touchscreen.tap(195, 330);
    await broken(page);
    await rested(page);
    await golden(page, "phone");
    await page.locator("#fold").tap();
    await page.locator("#gallery").getByText("Knot").tap();
    await page.waitForFunction(() => location.hash.includes("model=torus_knot"), undefined, WAIT);
    const box = await page.locator("#panel").boundingBox();
    assert.ok(box.y >= 0 && box.y + box.height <= 780 && box.x >= 0 && box.x + box.width <= 390);
    assert.ok(await page.evaluate(() => document.documentElement.scrollWidth <= innerWidth));
    await page.leave();
});

test("settings change the break; the seed too", async () => {
    const page = await visit("#model=animal&sites=20&roughness=0"), hashes = new Set();
    const once = async () => {
        await page.mouse.click(middle.x, middle.y);
        hashes.add((await broken(page)).hash);
        await page.keyboard.press("r");
        await page.waitForSelector("#certificate", { state: "hidden" });
    };
    await once();
    await once(); // equal settings, equal pieces
    assert.equal(hashes.size, 1);
    await page.locator("#seed").fill("7");
    await page.locator("#seed").press("Tab");
    await page.locator("#view").focus();
    await once();
    await page.locator("#material").selectOption("wood");
    assert.equal(await page.locator("#roughness").inputValue(), String((await materials()).wood.roughness));
    await page.locator("#view").focus();
    await once();
    assert.equal(hashes.size, 3);
    await page.leave();
});

test("a link breaks the same pieces in the same way, in the dark too", async () => {
    const page = await visit("#model=vase&material=stone&sites=30&roughness=0.3&seed=4");
    await page.mouse.click(320, 300);
    await broken(page);
    await page.waitForTimeout(700);
    await page.mouse.click(320, 250);
    await page.waitForFunction(() => location.hash.includes("*"), undefined, WAIT);
    await ready(page);
    const link = new URL(page.url()).hash, poses = await rested(page);
    await page.leave();
    const other = await visit(link);
    assert.match(await text(other, "c-same"), /bit for bit/);
    assert.equal(await rested(other), poses, "the pieces lie elsewhere");
    await other.leave();
    const dark = await visit("#model=statue&material=stone&sites=40&roughness=0.4&seed=1&blows=0_0_0.18_2.5_0.0474_0.0786_0.036_-0.539_-0.174_-0.824",
        { colorScheme: "dark" });
    await broken(dark);
    assert.equal(await dark.locator("#c-same").isVisible(), false); // the link has no hash
    await rested(dark);
    await golden(dark, "dark");
    await dark.leave();
    const damaged = await visit("#model=vase&sites=many&material=stone&blows=1_2_x");
    assert.match(await text(damaged, "notice"), /damaged.*sites=many, blow 1/s);
    await damaged.leave();
    const endless = await visit("#model=vase&blows=999999999_0_0.2_2_0_0_0_0_0_1");
    assert.match(await text(endless, "notice"), /damaged.*blow 1/s);
    await endless.leave();
});

/** A file as the visitor chooses it. */
const choose = (page, name, buffer) => page.locator("#file").setInputFiles({ name, mimeType: "", buffer });

test("files: broken ones say so and nothing is lost; open ones are repaired; crossing ones united", async () => {
    const page = await visit("#model=vase");
    const noticed = async (words) => {
        await page.waitForSelector("#notice:not([hidden])", WAIT);
        assert.match(await text(page, "notice"), words);
        await ready(page);
    };
    const close = () => page.locator("#close").click();
    await choose(page, "damaged.glb", Buffer.from("glTF but not quite"));
    await noticed(/damaged|truncated|GLB|glTF/i);
    await close();
    await choose(page, "notes.txt", Buffer.from("hello"));
    await noticed(/notes\.txt is no mesh/);
    await close();
    await choose(page, "empty.obj", Buffer.alloc(0));
    await noticed(/triangle|empty/i);
    await close();
    assert.match(page.url(), /model=vase/); // still there
    await page.mouse.click(middle.x, middle.y);
    await broken(page);

    const cube = (x) => [[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0], [0, 0, 1], [1, 0, 1], [1, 1, 1], [0, 1, 1]]
        .map(([a, b, c]) => `v ${a + x} ${b + x / 3} ${c + x / 5}`).join("\n");
    const faces = (first) => ["1 4 3 2", "5 6 7 8", "1 2 6 5", "2 3 7 6", "3 4 8 7", "4 1 5 8"]
        .map((face) => `f ${face.split(" ").map((v) => Number(v) + first).join(" ")}`);
    await choose(page, "open.obj", Buffer.from([cube(0), ...faces(0).slice(1)].join("\n")));
    await noticed(/open\.obj: 4 open edges.*holes/is);
    await page.locator("#mend").click();
    await page.waitForFunction(() => location.hash.includes("model=open.obj"), undefined, WAIT);
    await page.locator("#view").focus();
    await page.keyboard.press("b");
    assert.equal((await broken(page)).closed, "all");

    // Parts that cross, and turned ones that touch: united, these still cross by the rounding of their corners.
    const turned = (x, y, z, side) => cube(0).split("\n").map((line) => {
        const [a, b, c] = line.slice(2).split(" ").map(Number), [p, q, r] = [side * a + x, side * b + y, side * c + z];
        const [co, so, ci, si] = [Math.cos(3.6), Math.sin(3.6), Math.cos(13.32), Math.sin(13.32)];
        return `v ${co * p - so * ci * q + so * si * r} ${so * p + co * ci * q - co * si * r} ${si * q + ci * r}`;
    }).join("\n");
    const touching = [turned(0, 0, 0, 1), ...faces(0)];
    for (let k = 0; k < 3; ++k) touching.push(turned(0.05 + 0.3 * k, 0.2, 1, 0.25), ...faces(8 * (k + 1)));
    for (const [name, parts, kit] of [["kit.obj", 2, [cube(0), ...faces(0), cube(0.4), ...faces(8)]], ["touching.obj", 4, touching]]) {
        await choose(page, name, Buffer.from(kit.join("\n")));
        await noticed(new RegExp(`${parts} parts pass through each other`));
        await page.locator("#mend").click();
        await ready(page);
        assert.equal(await page.locator("#notice").isHidden(), true, `${name}: united once, and not offered again`);
        await page.keyboard.press("b");
        assert.equal((await broken(page)).closed, "all");
    }
    await page.leave();
});

test("a file of 100 MB is read, and can be cancelled", async () => {
    const page = await visit("#model=vase"), triangles = 2_000_000, stl = Buffer.alloc(84 + 50 * triangles);
    stl.writeUInt32LE(triangles, 80);
    for (let t = 0; t < triangles; ++t) // tetrahedra in a row
        for (let k = 0; k < 3; ++k) {
            const corner = [[0, 2, 1], [0, 1, 3], [1, 2, 3], [2, 0, 3]][t & 3][k], at = 84 + 50 * t + 12 + 12 * k;
            stl.writeFloatLE((corner === 1 ? 1 : 0) + 2 * (t >> 2), at);
            stl.writeFloatLE(corner === 2 ? 1 : 0, at + 4);
            stl.writeFloatLE(corner === 3 ? 1 : 0, at + 8);
        }
    const file = path.join(ROOT, "build/web/large.stl");
    fs.writeFileSync(file, stl);
    try {
        await page.locator("#file").setInputFiles(file);
        await page.waitForSelector("#progress:not([hidden])", WAIT);
        await page.keyboard.press("Escape");
        await ready(page);
        assert.equal(await text(page, "hint"), "Cancelled");
        assert.match(page.url(), /model=vase/);
        await page.mouse.click(middle.x, middle.y);
        assert.equal((await broken(page)).closed, "all");
    } finally {
        fs.rmSync(file);
    }
    await page.leave();
});

test("the export holds the pieces where they lie", async () => {
    const page = await visit("#model=animal&sites=15&roughness=0");
    await page.mouse.click(middle.x, middle.y);
    await broken(page);
    await rested(page);
    const pieces = await page.evaluate(() => Number(document.getElementById("c-pieces").textContent));
    const [download] = await Promise.all([page.waitForEvent("download"), page.keyboard.press("e")]);
    assert.equal(download.suggestedFilename(), "animal_pieces.glb");
    const bytes = fs.readFileSync(await download.path());
    const json = JSON.parse(bytes.subarray(20, 20 + bytes.readUInt32LE(12)).toString());
    assert.equal(json.nodes.filter(({ name }) => /^piece_\d{4}$/.test(name)).length, pieces);
    assert.deepEqual(json.materials.map(({ name }) => name).sort(), ["inside", "outside"]);
    const mesh = await load(bytes, ".glb"), { min } = mesh.inspect();
    assert.ok(min[1] > -0.02, `the lowest point is at ${min[1]}`); // nothing sank into the ground
    await page.leave();
});

/** Red above blue. */
const flag = () => execFileSync("convert", ["-size", "2x1", "xc:red", "xc:blue", "-append", "png24:-"]);
/** An image of one colour. */
const one = (colour) => execFileSync("convert", ["-size", "2x2", `xc:${colour}`, "png24:-"]);

/** The mean colour of a part of the picture, 0 to 255. */
async function mean(page, clip) {
    const rgb = execFileSync("convert", ["png:-", "-depth", "8", "rgb:-"], { input: await page.screenshot({ clip }), maxBuffer: 1 << 24 });
    return [0, 1, 2].map((k) => rgb.reduce((sum, value, at) => at % 3 === k ? sum + value : sum, 0) * 3 / rgb.length);
}

/** How many pixels of the picture of the model fulfil a condition, and their mean height from the top. */
async function pixels(page, condition) {
    const [width, height] = [640, 640], clip = { x: 0, y: 0, width, height };
    const rgb = execFileSync("convert", ["png:-", "-depth", "8", "rgb:-"], { input: await page.screenshot({ clip }), maxBuffer: 1 << 24 });
    let count = 0, sum = 0;
    for (let k = 0; k < width * height; ++k)
        if (condition(...rgb.subarray(3 * k, 3 * k + 3))) {
            ++count;
            sum += Math.floor(k / width);
        }
    return { count, height: sum / count };
}
const RED = (r, g, b) => r > 3 * g && r > 3 * b && r > 50, GREEN = (r, g, b) => g > 3 * r && g > 3 * b && g > 50;
const BLUE = (r, g, b) => b > 3 * r && b > 3 * g && b > 50, YELLOW = (r, g, b) => r > 3 * b && g > 3 * b && r > 50 && g > 50;

test("a model keeps its colours and textures on the outside of pieces and of their pieces, also in the export", async () => {
    const page = await visit("#model=vase&sites=30&roughness=0.3");
    await choose(page, "column.glb", column(flag()));
    await page.waitForFunction(() => location.hash.includes("model=column.glb"), undefined, WAIT);
    await ready(page);
    assert.equal(await page.locator("#notice").isVisible(), false);
    await page.locator("#view").focus();
    for (let k = 0; k < 3; ++k) await page.keyboard.press("ArrowUp");
    await page.waitForTimeout(300);
    const [red, blue, green] = [await pixels(page, RED), await pixels(page, BLUE), await pixels(page, GREEN)];
    assert.ok(red.count > 10_000 && blue.count > 10_000 && green.count > 2000, `${red.count} red, ${blue.count} blue, ${green.count} green`);
    assert.ok(green.height < red.height && red.height < blue.height); // the image is not upside down
    await page.mouse.click(middle.x, middle.y);
    const { hash } = await broken(page);
    await rested(page);
    await page.mouse.click(320, 480);
    await page.waitForFunction((before) => document.getElementById("c-hash").textContent !== before, hash, WAIT);
    await ready(page);
    await rested(page);
    await golden(page, "column");

    const [download] = await Promise.all([page.waitForEvent("download"), page.keyboard.press("e")]);
    const bytes = fs.readFileSync(await download.path()), length = bytes.readUInt32LE(12), binary = bytes.subarray(28 + length);
    const json = JSON.parse(bytes.subarray(20, 20 + length).toString());
    assert.deepEqual(json.materials.map(({ name }) => name).sort(), ["caps", "inside", "sides"]);
    const numbers = (index) => {
        const { bufferView, byteOffset = 0, count, type, componentType } = json.accessors[index];
        const at = json.bufferViews[bufferView].byteOffset + byteOffset, columns = { SCALAR: 1, VEC2: 2, VEC3: 3 }[type];
        const read = { 5123: (k) => binary.readUInt16LE(at + 2 * k), 5125: (k) => binary.readUInt32LE(at + 4 * k),
                       5126: (k) => binary.readFloatLE(at + 4 * k) }[componentType];
        return Array.from({ length: columns * count }, (_, k) => read(k));
    };
    const areas = { caps: 0, sides: 0, inside: 0 };
    for (const { mesh } of json.nodes.filter((node) => node.mesh !== undefined))
        for (const { attributes: { POSITION, TEXCOORD_0 }, indices, material } of json.meshes[mesh].primitives) {
            const p = numbers(POSITION), uv = numbers(TEXCOORD_0), corners = numbers(indices), { name } = json.materials[material];
            for (let t = 0; t < corners.length; t += 3) {
                const [a, b, c] = corners.slice(t, t + 3), [u, v] = [b, c].map((to) => [0, 1, 2].map((k) => p[3 * to + k] - p[3 * a + k]));
                areas[name] += Math.hypot(u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2], u[0] * v[1] - u[1] * v[0]) / 2;
                if (name === "sides")
                    for (const to of [b, c]) assert.ok(Math.abs(uv[2 * to + 1] - uv[2 * a + 1] + (p[3 * to + 1] - p[3 * a + 1]) / 2) < 1e-5);
            }
        }
    assert.ok(Math.abs(areas.sides - SIDES) < 1e-4 && Math.abs(areas.caps - CAPS) < 1e-4, JSON.stringify(areas));
    const { source } = json.textures[json.materials.find(({ name }) => name === "sides").pbrMetallicRoughness.baseColorTexture.index];
    const { byteOffset, byteLength } = json.bufferViews[json.images[source].bufferView];
    const image = execFileSync("convert", ["png:-", "-depth", "8", "rgb:-"], { input: binary.subarray(byteOffset, byteOffset + byteLength) });
    assert.deepEqual([...image], [255, 0, 0, 255, 0, 0, 0, 0, 255, 0, 0, 255]);
    await page.leave();
});

test("a model without a readable texture shows its base colour, and says so", async () => {
    const page = await visit("#model=vase");
    await choose(page, "column.glb", column(Buffer.from("no image"), { pbrMetallicRoughness: {
        baseColorFactor: [1, 1, 0, 1], metallicFactor: 0, baseColorTexture: { index: 0 } } }));
    await page.waitForSelector("#notice:not([hidden])", WAIT);
    assert.match(await text(page, "notice"), /column\.glb: Texture flag cannot be shown/);
    await ready(page);
    await page.locator("#close").click();
    await page.waitForTimeout(300);
    assert.ok((await pixels(page, YELLOW)).count > 10_000);
    await page.mouse.click(middle.x, middle.y);
    assert.equal((await broken(page)).closed, "all");
    await page.leave();
});

test("metal mirrors, glowing materials glow, glass lets the background through, and normal maps turn the light", async () => {
    const page = await visit("#model=vase&sites=20"), surface = { baseColorFactor: [0.5, 0.5, 0.5, 1], metallicFactor: 0, roughnessFactor: 0.9 };
    const show = async (name, sides, image = flag()) => {
        await choose(page, `${name}.glb`, column(image, sides));
        await page.waitForFunction((model) => location.hash.includes(`model=${model}`), `${name}.glb`, WAIT);
        await ready(page);
        await page.waitForTimeout(300);
        assert.equal(await page.locator("#notice").isVisible(), false);
        await page.screenshot({ path: path.join(PICTURES, `${name}.png`) });
        return mean(page, { x: 280, y: 280, width: 80, height: 80 });
    };
    const plain = await show("plain", { pbrMetallicRoughness: surface });
    const metal = await show("metal", { pbrMetallicRoughness: { ...surface, baseColorFactor: [1, 0.75, 0.3, 1], metallicFactor: 1, roughnessFactor: 0.2 } });
    assert.ok(metal[0] > 60 && metal[0] > 1.5 * metal[2], `metal ${metal}`); // gold, and not black
    const glowing = await show("glowing", { pbrMetallicRoughness: { ...surface, baseColorFactor: [0, 0, 0, 1] }, emissiveFactor: [1, 0, 0],
                            extensions: { KHR_materials_emissive_strength: { emissiveStrength: 2 } } });
    assert.ok(glowing[0] > 240 && glowing[1] < 40, `glowing ${glowing}`);
    await show("emissive_map", { pbrMetallicRoughness: { ...surface, baseColorFactor: [0, 0, 0, 1] }, emissiveFactor: [1, 1, 1], emissiveTexture: { index: 0 } });
    assert.ok((await pixels(page, RED)).count > 10_000 && (await pixels(page, BLUE)).count > 10_000);
    const glass = await show("glass", { pbrMetallicRoughness: { ...surface, baseColorFactor: [0, 0, 0, 0.1] }, alphaMode: "BLEND" });
    const opaque = await show("black", { pbrMetallicRoughness: { ...surface, baseColorFactor: [0, 0, 0, 1] } });
    assert.ok(glass[1] > opaque[1] + 80, `glass ${glass}, black ${opaque}`);
    // The sun stands on the left, above: normals that lean up or to the left meet it.
    const leaning = (name, colour) => show(name, { pbrMetallicRoughness: surface, normalTexture: { index: 0 } }, one(colour));
    const [up, down] = [await leaning("up", "#80d9d9"), await leaning("down", "#8027d9")];
    const [left, right] = [await leaning("left", "#2780d9"), await leaning("right", "#d980d9")];
    assert.ok(up[1] > plain[1] + 5 && plain[1] > down[1] + 5, `up ${up}, plain ${plain}, down ${down}`);
    assert.ok(left[1] > plain[1] + 5 && plain[1] > right[1] + 5, `left ${left}, plain ${plain}, right ${right}`);
    const texture = { index: 0 };
    await show("all", { pbrMetallicRoughness: { baseColorFactor: [1, 1, 1, 0.5], metallicFactor: 0.75, roughnessFactor: 0.25, metallicRoughnessTexture: texture },
                        normalTexture: texture, occlusionTexture: texture, emissiveTexture: texture, emissiveFactor: [0.5, 0.5, 0.5], alphaMode: "BLEND" });
    await page.mouse.click(middle.x, middle.y);
    assert.equal((await broken(page)).closed, "all");
    const [download] = await Promise.all([page.waitForEvent("download"), page.keyboard.press("e")]);
    const bytes = fs.readFileSync(await download.path()), { materials } = JSON.parse(bytes.subarray(20, 20 + bytes.readUInt32LE(12)).toString());
    const sides = materials.find(({ name }) => name === "sides"), { pbrMetallicRoughness } = sides;
    assert.deepEqual([pbrMetallicRoughness.metallicFactor, pbrMetallicRoughness.roughnessFactor, sides.alphaMode, sides.emissiveFactor],
                     [0.75, 0.25, "BLEND", [0.5, 0.5, 0.5]]);
    for (const map of [pbrMetallicRoughness.metallicRoughnessTexture, sides.normalTexture, sides.occlusionTexture, sides.emissiveTexture])
        assert.ok(map, JSON.stringify(sides));
    await page.leave();
});

test("textures of a .gltf file and colours of vertices are shown", async () => {
    const page = await visit("#model=vase"), glb = column(flag()), length = glb.readUInt32LE(12);
    const json = JSON.parse(glb.subarray(20, 20 + length).toString());
    json.buffers[0].uri = `data:application/octet-stream;base64,${glb.subarray(28 + length).toString("base64")}`;
    const show = async (name, content) => {
        await choose(page, name, Buffer.from(content));
        await page.waitForFunction((model) => location.hash.includes(`model=${model}`), name, WAIT);
        await ready(page);
        await page.waitForTimeout(300);
    };
    await show("within.gltf", JSON.stringify(json));
    assert.equal(await page.locator("#notice").isVisible(), false);
    assert.ok((await pixels(page, RED)).count > 10_000 && (await pixels(page, BLUE)).count > 10_000);
    json.images[0] = { uri: "flag.png" };
    await show("beside.gltf", JSON.stringify(json));
    assert.match(await text(page, "notice"), /Texture number 0 cannot be shown: it lies in another file, flag\.png/);
    await page.locator("#close").click();
    assert.equal((await pixels(page, RED)).count, 0);
    json.textures = [];
    await show("without.gltf", JSON.stringify(json));
    assert.match(await text(page, "notice"), /Texture number 0 cannot be shown: the file has no image for it/);
    await page.locator("#close").click();
    await show("painted.off", tetrahedron(...Array(4).fill("255 0 0")));
    assert.ok((await pixels(page, RED)).count > 10_000);
    await page.leave();
});

for (const isolated of [true, false]) {
    test(`the page works without a network after the first visit, ${isolated ? "with threads" : "not isolated, with one thread"}`, async () => {
        const context = await browser.newContext({ viewport: { width: 960, height: 640 } }), page = await context.newPage();
        const modules = [];
        page.on("request", (request) => request.url().includes("brittle_wasm") && request.url().endsWith(".wasm") && modules.push(path.basename(request.url())));
        await page.goto(isolated ? address : plain);
        await page.waitForSelector("body[data-opened]", WAIT);
        // One core has no use for threads.
        const used = isolated && await page.evaluate(() => navigator.hardwareConcurrency > 1) ? "brittle_wasm_threads.wasm" : "brittle_wasm.wasm";
        assert.deepEqual(modules, [used]);
        await page.evaluate(() => navigator.serviceWorker.ready);
        await page.waitForFunction(() => navigator.serviceWorker.controller !== null, undefined, WAIT);
        const kept = await page.evaluate(async () => {
            const cache = await caches.open((await caches.keys())[0]);
            return (await cache.keys()).map(({ url }) => url.split("/").pop()).filter((name) => /^brittle_wasm.*wasm$/.test(name));
        });
        assert.deepEqual(kept, [used]);
        await context.setOffline(true);
        // Another link in the same tab loads the page again.
        await Promise.all([page.waitForEvent("load"), page.evaluate(() => location.hash = "model=bunny")]);
        await page.waitForSelector("body[data-opened]", WAIT);
        assert.equal(await page.evaluate(() => crossOriginIsolated), isolated);
        await page.mouse.click(300, 360);
        assert.equal((await broken(page)).closed, "all");
        await context.close();
    });
}

test("without WebGL the page says what is missing", async () => {
    const bare = await launch(["--disable-gpu", "--disable-webgl", "--disable-3d-apis"]);
    try {
        const page = await bare.newPage();
        await page.goto(address);
        await page.waitForSelector('body[data-state="failed"]', WAIT);
        assert.match(await page.locator(".fatal").innerText(), /WebGL 2.*hardware acceleration/s);
    } finally {
        await bare.close();
    }
});

test("without the library the page says what is missing", async () => {
    const page = await browser.newPage();
    await page.route("**/brittle_wasm*.wasm", (route) => route.abort());
    await page.goto(`${address}?fixed`);
    await page.waitForSelector('body[data-state="failed"]', WAIT);
    assert.match(await page.locator(".fatal").innerText(), /did not start.*SIMD/s);
    await page.close();
});

test("the library gives the hashes of the command line in Chromium", async () => {
    const page = await visit("#model=vase");
    const printed = execFileSync(path.join(ROOT, "build/release/bin/brittle"),
        ["fracture", "/usr/share/glmark2/models/bunny.obj", "-n", "100", "-o", path.join(ROOT, "build/web/pieces.ply")], { encoding: "utf8" });
    await page.addScriptTag({ type: "module", content: `
        const worker = new Worker("worker.js", { type: "module" });
        const bytes = new Uint8Array(await (await fetch("models/bunny.obj")).arrayBuffer());
        worker.onmessage = ({ data }) => { if (data.call === 2 && data.value) document.body.dataset.hash = data.value.certificate.hash; };
        worker.postMessage({ call: 1, work: "load", id: 1, bytes, extension: ".obj", threads: "auto" });
        worker.postMessage({ call: 2, work: "fracture", of: 1, settings: { sites: 100 }, want: {} });` });
    await page.waitForSelector("body[data-hash]", WAIT);
    assert.equal(await page.evaluate(() => document.body.dataset.hash), /^ *hash +([0-9a-f]{16})/m.exec(printed)[1]);
    await page.leave();
});
