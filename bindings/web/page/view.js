// The picture: one draw for each material of the pieces of a fracture. Vertices stay where they were at rest; the shader
// moves them by the pose of their piece, which lies in a texture.
import {
    AmbientLight, BufferAttribute, BufferGeometry, Color, DataTexture, DataUtils, DirectionalLight,
    EquirectangularReflectionMapping, FloatType, HalfFloatType, HemisphereLight, LineBasicMaterial, LineLoop, LinearFilter, Mesh,
    MeshDepthMaterial, MeshStandardMaterial, NearestFilter, PCFShadowMap, PerspectiveCamera, PlaneGeometry, PMREMGenerator,
    Quaternion, Raycaster, RGBADepthPacking, RGBAFormat, Scene, ShadowMaterial, SRGBColorSpace, Vector2, Vector3, WebGLRenderer,
} from "three";
import { OrbitControls } from "three/addons/controls/OrbitControls.js";
import { starts } from "./outside.js";

const TEXELS = 3;  // of a piece: rotation; translation, 1 where it is visible; rest centre
const ACROSS = 64; // pieces in a row of the texture
const WHITE = new Color(0xffffff);

const MOVE = `
    attribute float piece; // twice its number, + 1 on cuts
    uniform highp sampler2D poses;
    uniform float explode;
    uniform vec3 middle;
    varying float onCut;
    varying float tone;
    vec4 poseTexel(int k) {
        int number = int(piece) / 2;
        return texelFetch(poses, ivec2(number % ${ACROSS} * ${TEXELS} + k, number / ${ACROSS}), 0);
    }
    vec3 turned(vec4 q, vec3 v) { return v + 2.0 * cross(q.xyz, cross(q.xyz, v) + q.w * v); }
`;
const MOVE_NORMAL = `
    onCut = mod(piece, 2.0);
    tone = fract(sin(floor(piece * 0.5) * 12.9898) * 43758.5453);
    objectNormal = turned(poseTexel(0), objectNormal);
`;
const MOVE_POINT = `
    {
        vec4 place = poseTexel(1);
        vec3 apart = (poseTexel(2).xyz - middle) * explode;
        transformed = place.w * (turned(poseTexel(0), transformed + apart) + place.xyz);
    }
`;

export class View {
    #renderer;
    #scene = new Scene();
    #camera = new PerspectiveCamera(40, 1, 0.02, 100);
    #sets = [];
    #uniforms = { explode: { value: 0 }, middle: { value: new Vector3() }, outside: { value: new Color() }, inside: { value: new Color() } };
    #ring;
    #frames = [];
    #ratio = Math.min(globalThis.devicePixelRatio ?? 1, 2);
    #fixed;
    #surroundings; // what metal mirrors; made for the first one
    dirty = true;

    /** Throws where the browser has no WebGL. `fixed`: the resolution does not adapt to the speed. */
    constructor(canvas, fixed) {
        this.#fixed = fixed;
        this.#renderer = new WebGLRenderer({ canvas, antialias: true, alpha: true });
        this.#renderer.outputColorSpace = SRGBColorSpace;
        this.#renderer.shadowMap.enabled = true;
        this.#renderer.shadowMap.type = PCFShadowMap;
        this.sun = new DirectionalLight(0xfff4e0, 2.6);
        this.sun.position.set(-3, 5, 2.2);
        this.sun.castShadow = true;
        this.sun.shadow.mapSize.set(2048, 2048);
        Object.assign(this.sun.shadow.camera, { left: -3, right: 3, top: 3, bottom: -3, near: 1, far: 12 });
        this.sun.shadow.normalBias = 0.02;
        const fill = new DirectionalLight(0xc8dcff, 0.5);
        fill.position.set(4, 2, 1);
        this.#scene.add(this.sun, fill, new HemisphereLight(0xdfe9ff, 0x8a7f70, 1.1), new AmbientLight(0xffffff, 0.15));
        const ground = new Mesh(new PlaneGeometry(60, 60), new ShadowMaterial({ opacity: 0.28 }));
        ground.rotation.x = -Math.PI / 2;
        ground.receiveShadow = true;
        const ring = new BufferGeometry().setFromPoints(Array.from({ length: 64 }, (_, k) =>
            new Vector3(Math.cos(k * Math.PI / 32), Math.sin(k * Math.PI / 32), 0)));
        this.#ring = new LineLoop(ring, new LineBasicMaterial({ color: 0xe8590c, depthTest: false, transparent: true, opacity: 0.9 }));
        this.#ring.visible = false;
        this.#scene.add(ground, this.#ring);
        this.#camera.position.set(2.4, 1.9, 3.6);
        this.controls = new OrbitControls(this.#camera, canvas);
        this.controls.target.set(0, 0.85, 0);
        this.controls.enableDamping = true;
        this.controls.maxPolarAngle = Math.PI * 0.52;
        this.controls.minDistance = 0.6;
        this.controls.maxDistance = 14;
        this.controls.addEventListener("change", () => this.dirty = true);
        canvas.addEventListener("webglcontextrestored", () => {
            this.#surroundings = undefined;
            for (const material of this.#sets.flatMap(({ mesh }) => mesh.material)) if (material.envMap) this.#mirror(material);
            this.dirty = true;
        });
        this.#material = this.#moved(new MeshStandardMaterial({ roughness: 0.82 }), true);
        this.#depth = this.#moved(new MeshDepthMaterial({ depthPacking: RGBADepthPacking }), false);
    }
    #material;
    #depth;

    #moved(material, coloured) {
        material.onBeforeCompile = (shader) => {
            Object.assign(shader.uniforms, this.#uniforms, { poses: { value: null } });
            shader.vertexShader = MOVE + shader.vertexShader.replace("#include <begin_vertex>", `#include <begin_vertex>${MOVE_POINT}`)
                .replace("#include <beginnormal_vertex>", `#include <beginnormal_vertex>${coloured ? MOVE_NORMAL : ""}`);
            if (coloured)
                shader.fragmentShader = "varying float onCut; varying float tone; uniform vec3 outside; uniform vec3 inside;\n"
                    + shader.fragmentShader.replace("#include <color_fragment>", `#include <color_fragment>
                    diffuseColor.rgb *= mix(outside, inside, step(0.5, onCut)) * (0.94 + 0.12 * tone);`);
        };
        return material;
    }

    set theme(dark) {
        this.#scene.background = new Color(dark ? 0x17191d : 0xe9ecef);
        this.dirty = true;
    }
    set colours({ outside, inside }) {
        this.#uniforms.outside.value.setRGB(...outside);
        this.#uniforms.inside.value.setRGB(...inside);
        this.dirty = true;
    }
    set explode(value) {
        this.#uniforms.explode.value = value;
        this.dirty = true;
    }

    clear() {
        for (const { mesh, poses } of this.#sets) {
            this.#scene.remove(mesh);
            mesh.geometry.dispose();
            for (const material of mesh.material) material.dispose();
            mesh.customDepthMaterial.dispose();
            poses.dispose();
        }
        this.#sets = [];
        this.dirty = true;
    }

    /** Pieces of one fracture, or the whole model as one piece. `outside`: of the model. */
    add(pieces, outside, frame, middle) {
        const rows = Math.ceil(pieces.length / ACROSS), values = new Float32Array(4 * TEXELS * ACROSS * rows);
        pieces.forEach(({ centre }, number) => {
            const at = place(number);
            values[at + 3] = values[at + 7] = 1;
            for (let k = 0; k < 3; ++k) values[at + 8 + k] = frame.offset[k] + frame.scale * centre[k];
        });
        const poses = new DataTexture(values, TEXELS * ACROSS, rows, RGBAFormat, FloatType);
        poses.magFilter = poses.minFilter = NearestFilter;
        poses.needsUpdate = true;
        this.#uniforms.middle.value.set(...middle.map((m, k) => frame.offset[k] + frame.scale * m));
        const looks = outside.looks.map((look) => {
            const copy = this.#clone(look, true, { poses: { value: poses }, outside: { value: WHITE } });
            if (look.metalness > 0) this.#mirror(copy);
            return copy;
        });
        const mesh = new Mesh(geometry(pieces, outside, frame), [...looks, this.#clone(this.#material, true, { poses: { value: poses } })]);
        mesh.customDepthMaterial = this.#clone(this.#depth, false, { poses: { value: poses } });
        mesh.frustumCulled = false;
        mesh.castShadow = mesh.receiveShadow = true;
        this.#scene.add(mesh);
        const set = { mesh, poses, values };
        this.#sets.push(set);
        this.dirty = true;
        return set;
    }

    #mirror(material) {
        material.envMap = this.#surroundings ??= surroundings(this.#renderer);
    }

    #clone(material, coloured, uniforms) {
        const copy = this.#moved(material.clone(), coloured), compile = copy.onBeforeCompile;
        copy.onBeforeCompile = (shader) => {
            compile(shader);
            Object.assign(shader.uniforms, uniforms);
        };
        copy.customProgramCacheKey = () => `moved ${coloured}`;
        return copy;
    }

    pose({ set, index }, { rotation, translation }) {
        const at = place(index);
        set.values.set(rotation, at);
        set.values.set(translation, at + 4);
        set.poses.needsUpdate = true;
        this.dirty = true;
    }

    hide({ set, index }) {
        set.values[place(index) + 7] = 0;
        set.poses.needsUpdate = true;
        this.dirty = true;
    }

    /** The ring that shows what a blow would reach. */
    mark(hit, radius) {
        const shown = this.#ring.visible;
        this.#ring.visible = hit !== null;
        if (hit) {
            this.#ring.position.set(...hit.world).addScaledVector(new Vector3(...hit.normal), 0.01);
            this.#ring.quaternion.setFromUnitVectors(new Vector3(0, 0, 1), new Vector3(...hit.normal));
            this.#ring.scale.setScalar(radius);
        }
        this.dirty ||= shown || hit !== null;
    }

    /** The ray through a point of the canvas: origin and unit direction. */
    ray(x, y) {
        const canvas = this.#renderer.domElement, caster = new Raycaster();
        caster.setFromCamera(new Vector2(2 * x / canvas.clientWidth - 1, 1 - 2 * y / canvas.clientHeight), this.#camera);
        return [caster.ray.origin.toArray(), caster.ray.direction.toArray()];
    }

    turn(degrees, up = 0, zoom = 1) {
        const offset = this.#camera.position.clone().sub(this.controls.target).multiplyScalar(zoom);
        offset.applyQuaternion(new Quaternion().setFromAxisAngle(new Vector3(0, 1, 0), degrees * Math.PI / 180));
        const side = new Vector3().crossVectors(new Vector3(0, 1, 0), offset).normalize();
        offset.applyQuaternion(new Quaternion().setFromAxisAngle(side, -up * Math.PI / 180));
        this.#camera.position.copy(this.controls.target).add(offset);
        this.controls.update();
    }

    /** Shows the model, 2.4 wide and 2.6 high, in the part of the window that the panel leaves free. */
    resize(width, height, covered = { right: 0, bottom: 0 }) {
        const high = 1.3 * height / (height - covered.bottom), wide = 1.2 * height / (width - covered.right);
        this.#camera.aspect = width / height;
        this.#camera.fov = 360 / Math.PI * Math.atan(Math.max(high, wide) / 4.6);
        this.#camera.setViewOffset(width, height, covered.right / 2, covered.bottom / 2, width, height);
        this.#camera.updateProjectionMatrix();
        this.#renderer.setPixelRatio(this.#ratio);
        this.#renderer.setSize(width, height, false);
        this.dirty = true;
    }

    /** Draws where something changed; true if it did. */
    draw() {
        this.controls.update();
        if (!this.dirty) {
            this.#frames.length = 0;
            return false;
        }
        this.dirty = false;
        this.#renderer.render(this.#scene, this.#camera);
        if (!this.#fixed) this.#adapt();
        return true;
    }

    // Slow devices get fewer pixels, then no shadows; fast ones get their pixels back.
    #adapt() {
        this.#frames.push(performance.now());
        if (this.#frames.length < 30) return;
        const frame = (this.#frames.at(-1) - this.#frames[0]) / (this.#frames.length - 1);
        this.#frames.length = 0;
        const most = Math.min(globalThis.devicePixelRatio ?? 1, 2), before = this.#ratio;
        if (frame > 24 && this.#ratio > 0.5) this.#ratio = Math.max(0.5, this.#ratio * 0.75);
        else if (frame > 40 && this.sun.castShadow) this.sun.castShadow = false;
        else if (frame < 12 && this.#ratio < most) this.#ratio = Math.min(most, this.#ratio * 1.15);
        if (this.#ratio !== before) {
            this.#renderer.setPixelRatio(this.#ratio);
            this.dirty = true;
        }
    }
}

const place = (number) => 4 * TEXELS * (Math.floor(number / ACROSS) * ACROSS + number % ACROSS);

/** A bright sky with clouds along the horizon over a floor, for metal, which without it would be black. */
function surroundings(renderer) {
    const wide = 64, high = 32, values = new Uint16Array(4 * wide * high);
    for (let row = 0; row < high; ++row)
        for (let column = 0; column < wide; ++column) {
            const up = 2 * (row + 0.5) / high - 1, around = 2 * Math.PI * column / wide; // the first row is the lowest
            const cloud = Math.max(0, 1 - Math.abs(up - 0.15) * 5) * (0.75 + 0.25 * Math.cos(3 * around));
            const colour = up < 0 ? [0.42, 0.4, 0.37].map((c) => c * (1 + 0.6 * up)) : [0.75, 0.85, 1].map((c) => c * (0.55 + 0.55 * up) + 1.6 * cloud);
            colour.forEach((c, k) => values[4 * (row * wide + column) + k] = DataUtils.toHalfFloat(c));
            values[4 * (row * wide + column) + 3] = DataUtils.toHalfFloat(1);
        }
    const sky = new DataTexture(values, wide, high, RGBAFormat, HalfFloatType, EquirectangularReflectionMapping);
    sky.magFilter = sky.minFilter = LinearFilter;
    sky.needsUpdate = true;
    const generator = new PMREMGenerator(renderer), { texture } = generator.fromEquirectangular(sky);
    generator.dispose();
    sky.dispose();
    return texture;
}

/** The surfaces of pieces in the world, at rest. Groups: the looks, then the chosen material, which the cuts have too. */
function geometry(pieces, outside, frame) {
    const surfaces = pieces.map((piece) => outside.surface(piece));
    const total = (name) => surfaces.reduce((sum, surface) => sum + surface[name].length, 0);
    const positions = new Float32Array(total("positions")), vertices = positions.length / 3, piece = new Float32Array(vertices);
    const indices = new Uint32Array(total("indices")), attributes = outside.attributes.map(({ size }) => new Float32Array(size * vertices));
    const counts = surfaces[0].counts.map((_, group) => surfaces.reduce((sum, surface) => sum + surface.counts[group], 0));
    const next = starts(counts);
    let first = 0;
    surfaces.forEach((surface, number) => {
        const { centre } = pieces[number], count = surface.positions.length / 3;
        for (let v = 0; v < count; ++v) {
            piece[first + v] = 2 * number + (v < surface.firstCut ? 0 : 1);
            for (let k = 0; k < 3; ++k)
                positions[3 * (first + v) + k] = frame.offset[k] + frame.scale * (centre[k] + surface.positions[3 * v + k]);
        }
        attributes.forEach((values, k) => values.set(surface.attributes[k], outside.attributes[k].size * first));
        let at = 0;
        surface.counts.forEach((length, group) => {
            for (const end = at + length; at < end; ++at) indices[next[group]++] = first + surface.indices[at];
        });
        first += count;
    });
    const made = new BufferGeometry(), looks = outside.looks.length, shown = starts(counts);
    made.setAttribute("position", new BufferAttribute(positions, 3));
    made.setAttribute("piece", new BufferAttribute(piece, 1));
    outside.attributes.forEach(({ name, size }, k) => made.setAttribute(name, new BufferAttribute(attributes[k], size)));
    made.setIndex(new BufferAttribute(indices, 1));
    for (let group = 0; group < looks; ++group)
        if (counts[group] > 0) made.addGroup(shown[group], counts[group], group);
    made.addGroup(shown[looks], counts[looks] + counts[looks + 1], looks);
    return made;
}
