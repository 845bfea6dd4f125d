// What is broken, and how, in the address: a link that breaks the same thing in the same way elsewhere.

/** The settings of the page, and what they are without a link. */
export const DEFAULTS = { model: "statue", material: "stone", sites: 100, roughness: 0.8, seed: 1, radius: 0.18 };

const MOST_BLOWS = 40;
const MOST_STEPS = 36_000; // ten minutes
const fixed = (x, digits) => String(Math.round(x * 10 ** digits) / 10 ** digits);

/** What a link can hold of a blow. Blows are rounded to this before they strike, so that the link gives the same bits. */
export function rounded({ piece, point, along, radius, speed }, { middle, size }) {
    return { piece, radius: Number(fixed(radius, 3)), speed: Number(fixed(speed, 2)),
             point: point.map((x, k) => middle[k] + size * Number(fixed((x - middle[k]) / size, 4))),
             along: along.map((x) => Number(fixed(x, 3))) };
}

export function write({ model, material, sites, roughness, seed }, blows, hash, { middle, size }) {
    const link = new URLSearchParams({ model, material, sites, roughness, seed });
    if (blows.length > 0) {
        link.set("blows", blows.slice(0, MOST_BLOWS).map((blow) => [blow.step, blow.piece, fixed(blow.radius, 3), fixed(blow.speed, 2),
            ...blow.point.map((x, k) => fixed((x - middle[k]) / size, 4)), ...blow.along.map((x) => fixed(x, 3))].join("_")).join("*"));
        link.set("hash", hash);
    }
    return `#${link}`;
}

/** The settings and blows of an address. What is damaged in it is left out; `faults` names that. */
export function read(hash) {
    const link = new URLSearchParams(hash.replace(/^#/, "")), settings = { ...DEFAULTS }, faults = [];
    const number = (name, least, most, whole) => {
        if (!link.has(name)) return;
        const value = Number(link.get(name));
        if (Number.isFinite(value) && value >= least && value <= most && (!whole || Number.isInteger(value))) settings[name] = value;
        else faults.push(`${name}=${link.get(name)}`);
    };
    if (link.has("model")) settings.model = link.get("model").slice(0, 100);
    if (link.has("material")) settings.material = link.get("material").slice(0, 20);
    number("sites", 2, 5000, true);
    number("roughness", 0, 1, false);
    number("seed", 0, 0xffffffff, true);
    const blows = [];
    for (const text of (link.get("blows") ?? "").split("*").filter(Boolean)) {
        const values = text.split("_").map(Number);
        const [step, piece, radius, speed, ...rest] = values;
        const sound = values.length === 10 && Number.isInteger(step) && step >= (blows.at(-1)?.step ?? 0) && step <= MOST_STEPS
            && Number.isInteger(piece) && radius > 0 && radius <= 2 && speed >= 0 && speed <= 20
            && rest.every((x) => Math.abs(x) <= 2);
        if (!sound || blows.length === MOST_BLOWS) {
            faults.push(`blow ${blows.length + 1}`);
            break;
        }
        blows.push({ step, piece, radius, speed, at: rest.slice(0, 3), along: rest.slice(3) });
    }
    return { settings, blows, hash: link.get("hash"), faults };
}
