// What can be broken: shapes that the library makes, models that come with the page, and files of the visitor.
import { readLooks } from "./looks.js";

export const GALLERY = [
    { name: "statue", label: "Statue" },
    { name: "vase", label: "Vase" },
    { name: "bunny", label: "Bunny", file: "models/bunny.obj" },
    { name: "animal", label: "Animal" },
    { name: "horse", label: "Horse", file: "models/horse.3ds", repair: true },
    { name: "cat", label: "Cat", file: "models/cat.3ds", repair: true },
    { name: "torus_knot", label: "Knot" },
    { name: "wall", label: "Wall" },
    { name: "pane", label: "Pane" },
    { name: "menger_sponge", label: "Sponge" },
];

export const EXTENSIONS = [".glb", ".gltf", ".obj", ".stl", ".ply", ".off", ".3ds"];

/** Formats whose materials are shown. */
const LOOKS = [".glb", ".gltf"];

/** Of a file; the memory of a browser ends there. */
const MOST_BYTES = 1.5e9;

/** A mesh of the worker, for a name of the gallery. */
export async function openGallery(worker, name, base, signal) {
    const entry = GALLERY.find((one) => one.name === name);
    if (!entry) throw new Error(`there is no model ${name} in the gallery; drop the file onto the page`);
    if (!entry.file) return { mesh: await worker.shape(name) };
    const response = await fetch(new URL(entry.file, base), { signal });
    if (!response.ok) throw new Error(`${entry.file} did not come: ${response.status} ${response.statusText}`);
    const mesh = await worker.load(await response.arrayBuffer(), entry.file.slice(entry.file.lastIndexOf(".")), { signal });
    return { mesh: entry.repair ? await mesh.repair({ signal }) : mesh };
}

/** A mesh of the worker, of a file that was dropped or chosen, and its looks (looks.js). */
export async function openFile(worker, file, signal) {
    const extension = file.name.slice(file.name.lastIndexOf(".")).toLowerCase();
    if (!file.name.includes(".") || !EXTENSIONS.includes(extension))
        throw new Error(`${file.name} is no mesh that this page reads; it reads ${EXTENSIONS.join(", ")}`);
    if (file.size > MOST_BYTES)
        throw new Error(`${file.name} has ${(file.size / 1e9).toFixed(1)} GB; a page can read ${MOST_BYTES / 1e9} GB`);
    const bytes = await file.arrayBuffer();
    const [mesh, looks] = await Promise.all([worker.load(bytes, extension, { signal }), LOOKS.includes(extension) ? readLooks(bytes) : undefined]);
    return { mesh, looks };
}

/**
 * What the visitor should know of a mesh: the fault, and the call that mends it unless it is among those that were tried;
 * null where there is nothing.
 */
export function verdict(found, tried) {
    if (found.refusal === "inside_out" || found.refusal === "not_closed" || found.refusal === "non_manifold"
        || found.refusal === "not_oriented" || found.refusal === "no_volume" || found.refusal === "inverted_part")
        return { mend: tried.includes("repair") ? null : "repair", label: "Repair", text: sentence(found) };
    if (found.refusal) return { mend: null, text: sentence(found) };
    // United parts that touch may still cross by the rounding of their corners.
    if (found.components > 1 && found.intersections > 0 && !tried.includes("unite"))
        return { mend: "unite", label: "Unite", optional: true,
                 text: `${found.components} parts pass through each other. Their pieces would overlap; united, they are one solid.` };
    return null;
}

function sentence(found) {
    const lines = found.report.split("\n").map((line) => line.trim().split(/ {2,}/));
    const faults = lines.find(([key]) => key === "faults")?.[1], refused = lines.find(([key]) => key === "fracture")?.[1];
    return [faults && `${faults[0].toUpperCase()}${faults.slice(1)}.`, refused?.replace(/ brittle repair.*/, "").replace(/^refuses it: /, "It cannot be broken: ")]
        .filter(Boolean).join(" ") || `It cannot be broken: ${found.refusal}.`;
}
