// The page: panel, mouse, touch, keys, files and links around Destruction and View.
import { BrittleWorker } from "brittle-fracture/worker";
import { Destruction } from "./destruction.js";
import { DEFAULTS, read, rounded, write } from "./link.js";
import { EXTENSIONS, GALLERY, openFile, openGallery, verdict } from "./models.js";
import { View } from "./view.js";

const $ = (id) => document.getElementById(id);
const fixed = new URLSearchParams(location.search).has("fixed"); // for tests: no adaptation, and time runs fast

// How materials break where they are hit: the pattern around a blow, beside what the library knows of them.
const MATERIALS = {
    stone: { label: "Stone", local: () => ({ pattern: "clustered" }) },
    concrete: { label: "Concrete", local: () => ({ pattern: "clustered" }) },
    ceramic: { label: "Ceramic", local: () => ({ pattern: "clustered" }) },
    glass: { label: "Glass", local: ({ along }) => ({ pattern: "radial", axis: along }) },
    wood: { label: "Wood" },
    brick: { label: "Brick" },
};
const SITES = { of: (x) => Math.round(5 * 400 ** (x / 100)), back: (n) => Math.round(100 * Math.log(n / 5) / Math.log(400)) };

const link = read(location.hash);
const settings = link.settings;
const worker = new BrittleWorker({ threads: "auto" });
let view = null, destruction = null;
let materials = {};   // what the library knows of them
let awaited = null;   // the name of a file that the link is for
let opened = null;    // the mesh of the worker that stands there
let work = null;      // AbortController of what runs in the worker
let replaying = false, paused = false, slow = 1, last = 0, pointer = null, pressed = null;

/* ---- Messages ---------------------------------------------------------------------------------------------------- */

function state(name) { document.body.dataset.state = name; }
function hint(text) { $("hint").textContent = text; }
function notice(text, mend = null) {
    $("notice").hidden = !text;
    $("notice").firstElementChild.textContent = text ?? "";
    $("mend").hidden = mend === null;
    $("mend").textContent = mend?.label ?? "";
    $("mend").onclick = mend?.run ?? null;
}
$("close").onclick = () => notice(null);

/** Runs what takes time in the worker, with progress and a way to cancel; false where it failed. */
async function working(text, task) {
    work?.abort();
    const mine = work = new AbortController();
    const shown = setTimeout(() => {
        $("progress").hidden = false;
        $("progress").firstElementChild.textContent = text;
    }, 150);
    state("working");
    try {
        await task(mine.signal, (share) => $("progress").firstElementChild.textContent = `${text} ${Math.round(100 * share)} %`);
        return true;
    } catch (error) {
        if (mine.signal.aborted) hint("Cancelled");
        else notice(`${error.message}`);
        return false;
    } finally {
        clearTimeout(shown);
        if (work === mine) {
            work = null;
            $("progress").hidden = true;
            state("ready");
        }
    }
}
$("cancel").onclick = () => work?.abort();

/* ---- Models ------------------------------------------------------------------------------------------------------ */

/** Waits for a promise that knows no signal. */
const until = (signal, promise) => Promise.race([promise, new Promise((_, refuse) =>
    signal.addEventListener("abort", () => refuse(signal.reason), { once: true }))]);

/**
 * Opens what `read` gives, a mesh and perhaps its looks, and shows it; what stands there stays where that fails. What was
 * tried on the mesh is not offered again.
 */
async function open(name, read, tried = []) {
    let followUp = null;
    const done = await working(`Opening ${name}`, async (signal) => {
        const { mesh, looks = { materials: [], fault: null } } = await until(signal, read(signal));
        const found = verdict(await until(signal, mesh.inspect()), tried);
        const run = () => {
            notice(null);
            open(name, async (stop) => ({ mesh: await mesh[found.mend]({ signal: stop }), looks }), [...tried, found.mend]);
        };
        const texts = [found?.text, looks.fault].filter(Boolean);
        if (texts.length > 0) followUp = { text: `${name}: ${texts.join(" ")}`, mend: found?.mend && { label: found.label, run } };
        if (found && !found.optional) return;
        await show(mesh, looks.materials, signal);
        settings.model = name;
        pressGallery();
        address();
    });
    if (done) notice(followUp?.text ?? null, followUp?.mend);
    if (done && opened && awaited === name) {
        awaited = null;
        await replay();
    }
}

async function show(mesh, looks, signal) {
    const arrays = await until(signal, mesh.arrays());
    const old = opened;
    opened = mesh;
    await destruction.place(mesh, arrays, looks);
    if (old && old !== mesh) old.dispose();
    certificate();
    hint("Click to break it");
}

function reset() {
    if (!destruction?.ready) return;
    work?.abort();
    replaying = false;
    destruction.reset();
    $("explode").value = 0;
    sliders();
    certificate();
    address();
    hint("Click to break it");
}

/* ---- Blows ------------------------------------------------------------------------------------------------------- */

function cutSettings() {
    const { sites, roughness, seed, material } = settings;
    return { sites, roughness, seed, material, local: MATERIALS[material].local };
}

async function strike(blow) {
    const done = await working("Breaking", (signal, onProgress) =>
        destruction.blow(rounded(blow, { middle: destruction.middle, size: destruction.frame.size }), cutSettings(), onProgress, signal));
    if (!done) return;
    destruction.show();
    certificate();
    address();
    hint("");
}

function breakAt(x, y) {
    if (!destruction?.ready || destruction.busy || replaying) return;
    const hit = destruction.pick(...view.ray(x, y));
    if (!hit) return;
    strike({ piece: hit.piece.id, point: hit.point, along: hit.along, radius: settings.radius, speed: 2.5 });
}

function breakAll() {
    if (!destruction?.ready || destruction.busy || replaying) return;
    const largest = destruction.pieces.reduce((best, piece) => piece.body && piece.volume > (best?.volume ?? 0) ? piece : best, null);
    strike({ piece: largest.id, point: destruction.middle, along: [0, 0, 0], radius: 2, speed: 0.6 });
}

/** Breaks what a link says, at the steps at which it was broken. */
async function replay() {
    replaying = true;
    try {
        await replayBlows();
    } finally {
        replaying = false;
    }
}

async function replayBlows() {
    for (const { at, ...blow } of link.blows) {
        while (destruction.steps < blow.step && replaying) {
            const before = destruction.steps;
            for (let k = 0; k < 4 && destruction.steps < blow.step; ++k) destruction.step();
            destruction.show();
            await new Promise(requestAnimationFrame);
            if (destruction.steps === before) break;
        }
        if (!replaying) return; // reset by the visitor
        const { middle, frame: { size } } = destruction;
        await strike({ ...blow, point: at.map((x, k) => middle[k] + size * x) });
    }
    if (link.hash && destruction.certificate) {
        const same = destruction.certificate.hash === link.hash;
        $("c-same").hidden = false;
        $("c-same").textContent = same ? "The same pieces as of the link, bit for bit" : "Other pieces than those of the link";
    }
}

function certificate() {
    const found = destruction.certificate;
    $("certificate").hidden = !found;
    $("c-same").hidden = true;
    if (!found) return;
    $("c-pieces").textContent = found.pieces.toLocaleString("en");
    $("c-closed").textContent = found.closed ? "all" : `all but ${found.openPieces}`;
    $("c-error").textContent = found.volumeError === 0 ? "0" : Math.abs(found.volumeError).toExponential(1);
    $("c-time").textContent = `${destruction.milliseconds.toFixed(1)} ms`;
    $("c-hash").textContent = found.hash;
}

/* ---- Panel ------------------------------------------------------------------------------------------------------- */

function pressGallery() {
    for (const button of $("gallery").children) button.ariaPressed = String(button.dataset.name === settings.model);
}
for (const { name, label } of GALLERY) {
    const button = Object.assign(document.createElement("button"), { type: "button", textContent: label });
    button.dataset.name = name;
    button.onclick = () => open(name, (signal) => openGallery(worker, name, document.baseURI, signal));
    $("gallery").append(button);
}
for (const [value, { label }] of Object.entries(MATERIALS)) $("material").append(new Option(label, value));
if (!MATERIALS[settings.material]) {
    link.faults.push(`material=${settings.material}`);
    settings.material = DEFAULTS.material;
}

function sliders() {
    const text = { sites: settings.sites, roughness: settings.roughness.toFixed(2), radius: `${Math.round(100 * settings.radius)} %`,
                   speed: paused ? "paused" : slow === 1 ? "real" : `${Math.round(100 * slow)} %`, explode: Number($("explode").value).toFixed(2) };
    for (const output of document.querySelectorAll("output")) output.textContent = text[output.htmlFor.value];
    if (view) view.explode = Number($("explode").value);
    if (destruction) destruction.explode = Number($("explode").value);
}

function fill() {
    $("material").value = settings.material;
    $("sites").value = SITES.back(settings.sites);
    $("roughness").value = settings.roughness;
    $("radius").value = settings.radius;
    $("seed").value = settings.seed;
    sliders();
}

const colours = () => ({ outside: materials[settings.material].exterior, inside: materials[settings.material].interior });

/** A setting changed: the object is whole again. */
function changed(name, value) {
    settings[name] = value;
    if (name === "material" && view) view.colours = colours();
    sliders();
    if (destruction?.ready && destruction.broken && name !== "radius") reset();
    else if (destruction?.ready) address();
}
$("material").onchange = () => {
    $("roughness").value = settings.roughness = materials[$("material").value].roughness;
    changed("material", $("material").value);
};
$("sites").oninput = () => changed("sites", SITES.of(Number($("sites").value)));
$("roughness").oninput = () => changed("roughness", Number($("roughness").value));
$("radius").oninput = () => changed("radius", Number($("radius").value));
$("seed").onchange = () => {
    const value = Math.floor(Number($("seed").value));
    $("seed").value = Number.isFinite(value) ? Math.min(Math.max(value, 0), 0xffffffff) : settings.seed;
    changed("seed", Number($("seed").value));
};
$("dice").onclick = () => {
    $("seed").value = crypto.getRandomValues(new Uint16Array(1))[0];
    changed("seed", Number($("seed").value));
};
$("speed").oninput = () => {
    slow = Number($("speed").value);
    paused = slow === 0;
    sliders();
};
$("explode").oninput = () => {
    sliders();
    destruction?.show();
};
$("reset").onclick = reset;
$("all").onclick = breakAll;
$("theme").onclick = () => {
    const theme = document.documentElement.dataset.theme === "dark" ? "light" : "dark";
    localStorage.setItem("theme", document.documentElement.dataset.theme = theme);
    if (view) view.theme = theme === "dark";
};
$("fold").onclick = () => {
    const folded = $("panel").toggleAttribute("data-folded");
    $("fold").ariaExpanded = String(!folded);
    $("fold").textContent = folded ? "▴" : "▾";
    size();
};
$("file").onchange = () => {
    const [file] = $("file").files;
    if (file) open(file.name, (signal) => openFile(worker, file, signal));
    $("file").value = "";
};

/* ---- Links and export -------------------------------------------------------------------------------------------- */

function address() {
    if (!destruction.ready) return;
    history.replaceState(null, "", write(settings, destruction.blows, destruction.certificate?.hash ?? "",
        { middle: destruction.middle, size: destruction.frame.size }));
}

$("share").onclick = async () => {
    const own = !GALLERY.some(({ name }) => name === settings.model);
    try {
        await navigator.clipboard.writeText(location.href);
        hint(own ? `Link copied; who opens it drops ${settings.model} there` : "Link copied: it breaks the same pieces elsewhere");
    } catch {
        notice(`The browser does not let this page copy. The address of the page is the link: ${location.href}`);
    }
};

$("export").onclick = () => {
    if (!destruction?.ready) return;
    if (!destruction.certificate) return hint("Break it first; the export has the pieces");
    working("Exporting", async () => {
        const { exportGlb } = await import("./export.js");
        const bytes = await exportGlb(destruction, colours());
        const at = URL.createObjectURL(new Blob([bytes], { type: "model/gltf-binary" }));
        const anchor = Object.assign(document.createElement("a"), { href: at, download: `${settings.model.replace(/\.[^.]*$/, "")}_pieces.glb` });
        anchor.click();
        setTimeout(() => URL.revokeObjectURL(at), 10_000);
        hint(`${anchor.download}: ${destruction.bodies.reduce((sum, { pieces }) => sum + pieces.length, 0)} pieces where they lie now`);
    });
};

/* ---- Mouse, touch, keys, files ----------------------------------------------------------------------------------- */

const canvas = $("view");
canvas.addEventListener("pointerdown", (event) => {
    pressed = event.isPrimary && event.button === 0 ? { x: event.offsetX, y: event.offsetY, at: event.timeStamp } : null;
});
canvas.addEventListener("pointermove", (event) => {
    pointer = event.pointerType === "mouse" && event.buttons === 0 ? [event.offsetX, event.offsetY] : null;
    if (pressed && Math.hypot(event.offsetX - pressed.x, event.offsetY - pressed.y) > 7) pressed = null;
    marked = null;
});
canvas.addEventListener("pointerleave", () => {
    pointer = null;
    view?.mark(null);
});
canvas.addEventListener("pointerup", (event) => {
    if (pressed && event.isPrimary && event.timeStamp - pressed.at < 600) breakAt(pressed.x, pressed.y);
    pressed = null;
});
let marked = null;

const KEYS = {
    r: reset, b: breakAll, e: () => $("export").click(), l: () => $("share").click(), t: () => $("theme").click(),
    " ": () => {
        paused = !paused;
        sliders();
    },
    x: () => {
        $("explode").value = Number($("explode").value) > 0 ? 0 : 0.6;
        $("explode").oninput();
    },
    Enter: () => breakAt(canvas.clientWidth / 2 - covered().right / 2, canvas.clientHeight / 2 - covered().bottom / 2),
    Escape: () => work ? work.abort() : notice(null),
    ArrowLeft: () => view.turn(-8), ArrowRight: () => view.turn(8), ArrowUp: () => view.turn(0, 6), ArrowDown: () => view.turn(0, -6),
    "+": () => view.turn(0, 0, 0.9), "=": () => view.turn(0, 0, 0.9), "-": () => view.turn(0, 0, 1.1),
};
addEventListener("keydown", (event) => {
    if (event.ctrlKey || event.metaKey || event.altKey || !view) return;
    const key = event.key.length === 1 ? event.key.toLowerCase() : event.key;
    if (!KEYS[key] || event.target.matches?.("input[type=number], select")) return;
    if (event.target.closest?.("input, button, label") && (key.length > 1 && key !== "Escape" || key === " ")) return;
    event.preventDefault();
    KEYS[key]();
});

for (const name of ["dragenter", "dragover"])
    addEventListener(name, (event) => {
        event.preventDefault();
        $("drop").hidden = false;
    });
addEventListener("dragleave", (event) => {
    if (!event.relatedTarget) $("drop").hidden = true;
});
addEventListener("drop", (event) => {
    event.preventDefault();
    $("drop").hidden = true;
    const file = [...event.dataTransfer.files].find(({ name }) => EXTENSIONS.some((end) => name.toLowerCase().endsWith(end)))
        ?? event.dataTransfer.files[0];
    if (file) open(file.name, (signal) => openFile(worker, file, signal));
});

/* ---- Frames ------------------------------------------------------------------------------------------------------ */

function covered() {
    const panel = $("panel").getBoundingClientRect();
    return innerWidth > 720 ? { right: panel.width + 24, bottom: 0 } : { right: 0, bottom: panel.height + 8 };
}
function size() { view?.resize(innerWidth, innerHeight, covered()); }
addEventListener("resize", size);
addEventListener("hashchange", () => location.reload()); // another link in the same tab

function frame(now) {
    requestAnimationFrame(frame);
    const seconds = Math.min((now - last) / 1000, 0.1);
    last = now;
    const moving = destruction.ready && !paused && !replaying && (fixed ? destruction.advance(1, 1, 30) : destruction.advance(seconds, slow));
    if (moving) delete document.body.dataset.poses;
    else if (fixed && document.body.dataset.moving === "true") document.body.dataset.poses = destruction.fingerprint().toString(16);
    document.body.dataset.moving = String(moving);
    if (moving) marked = null;
    if (destruction.ready && pointer && !marked && !destruction.busy) {
        marked = destruction.pick(...view.ray(...pointer)) ?? {};
        view.mark(marked.piece ? marked : null, settings.radius * 2);
    }
    view.draw();
}

function fatal(text) {
    document.body.append(Object.assign(document.createElement("p"), { className: "fatal", textContent: text }));
    document.querySelectorAll("button, input, select").forEach((field) => field.disabled = true);
    hint("");
    state("failed");
}

async function start() {
    fill();
    if (innerWidth <= 720) $("fold").onclick();
    try {
        view = new View(canvas, fixed);
    } catch {
        fatal("This browser shows no WebGL 2, which the page draws with. Turn on hardware acceleration in its settings, or try another browser.");
        return;
    }
    view.theme = document.documentElement.dataset.theme === "dark";
    let threads;
    try {
        materials = await worker.materials();
        threads = await worker.threads();
    } catch (error) {
        fatal(`The library did not start. It needs WebAssembly with SIMD, and the files brittle_wasm*.wasm: ${error.message}`);
        return;
    }
    view.colours = colours();
    destruction = new Destruction(worker, view);
    size();
    sliders();
    requestAnimationFrame(frame);
    const model = settings.model;
    const known = GALLERY.some(({ name }) => name === model);
    if (!known) settings.model = DEFAULTS.model;
    await open(settings.model, (signal) => openGallery(worker, settings.model, document.baseURI, signal));
    if (!known) {
        awaited = model;
        notice(`The link is for ${model}, a file of whoever sent it. Drop that file here, and it breaks as it did there.`);
    }
    else if (link.faults.length > 0) notice(`The link is damaged; left out: ${link.faults.join(", ")}`);
    if (known && destruction.ready) await replay();
    if (!fixed) navigator.serviceWorker?.register(`offline.js${threads > 1 ? "?threads" : ""}`).catch(() => {});
    document.body.dataset.opened = "true";
}
start();
