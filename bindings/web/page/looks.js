// The materials of a glTF file for the picture: base colours and their textures. The rest of a material is left out.
import {
    ClampToEdgeWrapping, LinearFilter, MeshStandardMaterial, MirroredRepeatWrapping, NearestFilter, RepeatWrapping,
    SRGBColorSpace, Texture,
} from "three";

/** Pixels of a side of a texture; larger images are reduced. */
const MOST_PIXELS = 4096;

const NEAREST = 9728, WRAPPING = { 33071: ClampToEdgeWrapping, 33648: MirroredRepeatWrapping };

/** The materials by their numbers in the file, and what cannot be shown of them, in words; null where nothing is missing. */
export async function readLooks(bytes) {
    try {
        const file = parse(bytes), faults = [];
        const materials = await Promise.all((file.json.materials ?? []).map((material) => look(material, file, faults)));
        return { materials, fault: faults.length > 0 ? sentence(faults) : null };
    } catch (error) {
        return { materials: [], fault: `Its materials cannot be shown: ${error.message}.` };
    }
}

/** The JSON of a .glb or .gltf file, its binary chunk, and a place for its images once they are decoded. */
function parse(bytes) {
    const data = new DataView(bytes), text = (from, length) => JSON.parse(new TextDecoder().decode(new Uint8Array(bytes, from, length)));
    if (data.getUint32(0, true) !== 0x46546c67) return { json: text(0), binary: null, images: [] };
    const length = data.getUint32(12, true), binary = 20 + length;
    return { json: text(20, length), images: [],
             binary: binary + 8 < bytes.byteLength ? new Uint8Array(bytes, binary + 8, data.getUint32(binary, true)) : null };
}

async function look({ name = "", pbrMetallicRoughness = {}, alphaMode, alphaCutoff = 0.5 }, file, faults) {
    const { baseColorFactor: [r, g, b, opacity] = [1, 1, 1, 1], baseColorTexture } = pbrMetallicRoughness;
    const material = new MeshStandardMaterial({ name, opacity, alphaTest: alphaMode === "MASK" ? alphaCutoff : 0, roughness: 0.82 });
    material.color.setRGB(r, g, b);
    if (!baseColorTexture) return material;
    const { source, sampler, extensions = {} } = file.json.textures[baseColorTexture.index];
    const number = source ?? Object.values(extensions).find((one) => one.source !== undefined)?.source; // WebP or AVIF
    try {
        file.images[number] ??= decode(file, file.json.images[number]);
        material.map = mapped(await file.images[number], baseColorTexture, file.json.samplers?.[sampler]);
    } catch (error) {
        faults.push(`${file.json.images?.[number]?.name || `number ${number}`} cannot be shown: ${error.message}`);
    }
    return material;
}

/** The use of a texture by a material. Clones have one image, which goes to the graphics card once. */
function mapped(base, { texCoord = 0, extensions }, { wrapS, wrapT, magFilter } = {}) {
    const map = base.clone(), transform = extensions?.KHR_texture_transform ?? {};
    map.channel = (transform.texCoord ?? texCoord) === 1 ? 1 : 0;
    map.wrapS = WRAPPING[wrapS] ?? RepeatWrapping;
    map.wrapT = WRAPPING[wrapT] ?? RepeatWrapping;
    map.magFilter = magFilter === NEAREST ? NearestFilter : LinearFilter;
    map.offset.fromArray(transform.offset ?? [0, 0]);
    map.rotation = transform.rotation ?? 0;
    map.repeat.fromArray(transform.scale ?? [1, 1]);
    map.colorSpace = SRGBColorSpace;
    map.flipY = false;
    map.needsUpdate = true;
    return map;
}

async function decode({ json, binary }, { uri, bufferView, mimeType }) {
    let content;
    if (uri) {
        content = await fetched(uri);
    } else {
        const { buffer, byteOffset = 0, byteLength } = json.bufferViews[bufferView], { uri: of } = json.buffers[buffer];
        const bytes = of ? new Uint8Array(await (await fetched(of)).arrayBuffer()) : binary;
        content = new Blob([bytes.subarray(byteOffset, byteOffset + byteLength)], { type: mimeType });
    }
    const options = { premultiplyAlpha: "none", colorSpaceConversion: "none" };
    let bitmap;
    try {
        bitmap = await createImageBitmap(content, options);
    } catch {
        throw new Error("the browser cannot decode the image");
    }
    const { width, height } = bitmap, share = MOST_PIXELS / Math.max(width, height);
    if (share < 1)
        bitmap = await createImageBitmap(bitmap, { ...options, resizeWidth: Math.ceil(width * share), resizeHeight: Math.ceil(height * share) });
    const texture = new Texture(bitmap);
    texture.userData.mimeType = content.type; // for the export
    return texture;
}

async function fetched(uri) {
    if (!uri.startsWith("data:")) throw new Error(`it lies in another file, ${uri}; a .glb file holds its images`);
    return (await fetch(uri)).blob();
}

const sentence = ([first, ...others]) =>
    `Texture ${first}${others.length > 0 ? ` (and ${others.length} more)` : ""}. The base colour of the material is shown.`;
