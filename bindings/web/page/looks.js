// The materials of a glTF file for the picture: base colour, metal, roughness, normals, occlusion, glow, blending, cut-outs.
import {
    ClampToEdgeWrapping, DoubleSide, LinearFilter, MeshStandardMaterial, MirroredRepeatWrapping, NearestFilter, NoColorSpace,
    RepeatWrapping, SRGBColorSpace, Texture,
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

async function look({ name = "", pbrMetallicRoughness: surface = {}, alphaMode = "OPAQUE", alphaCutoff = 0.5, doubleSided = false,
                      normalTexture, occlusionTexture, emissiveTexture, emissiveFactor = [0, 0, 0], extensions = {} }, file, faults) {
    const { baseColorFactor: [r, g, b, opacity] = [1, 1, 1, 1], metallicFactor: metalness = 1, roughnessFactor: roughness = 1 } = surface;
    const material = new MeshStandardMaterial({
        name, opacity, metalness, roughness, alphaTest: alphaMode === "MASK" ? alphaCutoff : 0,
        transparent: alphaMode === "BLEND", depthWrite: alphaMode !== "BLEND",
        emissiveIntensity: extensions.KHR_materials_emissive_strength?.emissiveStrength ?? 1,
        aoMapIntensity: occlusionTexture?.strength ?? 1,
    });
    material.color.setRGB(r, g, b);
    material.emissive.setRGB(...emissiveFactor);
    if (doubleSided && alphaMode !== "OPAQUE") material.side = DoubleSide;
    // Without tangents the picture takes those of the texture coordinates, which run the other way along v.
    material.normalScale.set(normalTexture?.scale ?? 1, -(normalTexture?.scale ?? 1));
    const use = async (texture, colours, ...places) => {
        if (!texture) return;
        const map = await read(texture, colours, file, faults);
        for (const place of places) material[place] = map;
    };
    await Promise.all([
        use(surface.baseColorTexture, true, "map"), use(surface.metallicRoughnessTexture, false, "metalnessMap", "roughnessMap"),
        use(normalTexture, false, "normalMap"), use(occlusionTexture, false, "aoMap"), use(emissiveTexture, true, "emissiveMap"),
    ]);
    return material;
}

/** The textures of a material of three.js, each once. */
export const texturesOf = (material) => [...new Set(Object.values(material).filter((value) => value?.isTexture))];

/** A texture of the file as a material uses it; null, and a fault, where it cannot be shown. */
async function read(texture, colours, file, faults) {
    const { source, sampler, extensions = {} } = file.json.textures?.[texture.index] ?? {};
    const number = source ?? Object.values(extensions).find((one) => one.source !== undefined)?.source; // WebP or AVIF
    try {
        if (!file.json.images?.[number]) throw new Error("the file has no image for it");
        file.images[number] ??= decode(file, file.json.images[number]);
        return mapped(await file.images[number], texture, file.json.samplers?.[sampler], colours);
    } catch (error) {
        faults.push(`${file.json.images?.[number]?.name || `number ${number ?? texture.index}`} cannot be shown: ${error.message}`);
        return null;
    }
}

/** The use of a texture by a material. Clones have one image, which goes to the graphics card once. */
function mapped(base, { texCoord = 0, extensions }, { wrapS, wrapT, magFilter } = {}, colours) {
    const map = base.clone(), transform = extensions?.KHR_texture_transform ?? {};
    map.channel = (transform.texCoord ?? texCoord) === 1 ? 1 : 0;
    map.wrapS = WRAPPING[wrapS] ?? RepeatWrapping;
    map.wrapT = WRAPPING[wrapT] ?? RepeatWrapping;
    map.magFilter = magFilter === NEAREST ? NearestFilter : LinearFilter;
    map.offset.fromArray(transform.offset ?? [0, 0]);
    map.rotation = transform.rotation ?? 0;
    map.repeat.fromArray(transform.scale ?? [1, 1]);
    map.colorSpace = colours ? SRGBColorSpace : NoColorSpace;
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
    `Texture ${first}${others.length > 0 ? ` (and ${others.length} more)` : ""}. The material is shown without it.`;
