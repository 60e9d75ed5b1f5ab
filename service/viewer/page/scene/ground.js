import { Color, Group, Mesh, PlaneGeometry, ShaderMaterial, ShadowMaterial } from '../vendor/three.js';

const REACH = 30; // metres around what is looked at

/** The floor: lines each metre, stronger each five, fading away; and the shadows on it. */
export class Ground {
  object = new Group();
  #lines = new ShaderMaterial({
    vertexShader: VERTEX(), fragmentShader: FRAGMENT(), transparent: true, depthWrite: false,
    uniforms: { colour: { value: new Color() }, middle: { value: [0, 0] }, reach: { value: REACH }, strength: { value: 1 } },
  });
  #shadow = new ShadowMaterial({ opacity: 0.2, depthWrite: false });

  constructor() {
    for (const [material, size, order] of /** @type {const} */ ([[this.#lines, 2 * REACH, -3], [this.#shadow, 14, -2]])) {
      const mesh = new Mesh(new PlaneGeometry(size, size).rotateX(-Math.PI / 2), material);
      mesh.receiveShadow = material === this.#shadow;
      mesh.renderOrder = order;
      this.object.add(mesh);
    }
  }

  /** @param {string} line @param {number} shadow @param {number} strength */
  theme(line, shadow, strength) {
    this.#lines.uniforms.colour.value.set(line);
    this.#lines.uniforms.strength.value = strength;
    this.#shadow.opacity = shadow;
  }

  /** Moves the floor under a place. The lines stay where they are. @param {number} x @param {number} z */
  at(x, z) {
    this.object.position.set(x, 0, z);
    this.#lines.uniforms.middle.value = [x, z];
  }

  dispose() {
    for (const mesh of this.object.children) /** @type {Mesh} */ (mesh).geometry.dispose();
    this.#lines.dispose();
    this.#shadow.dispose();
  }
}

function VERTEX() {
  return /* glsl */ `
    varying vec2 place;
    void main() {
      vec4 world = modelMatrix * vec4(position, 1.0);
      place = world.xz;
      gl_Position = projectionMatrix * viewMatrix * world;
    }`;
}

// Lines are as wide as a pixel, or fainter where they would be denser than pixels.
function FRAGMENT() {
  return /* glsl */ `
    uniform vec3 colour;
    uniform vec2 middle;
    uniform float reach;
    uniform float strength;
    varying vec2 place;
    float lines(float metres, float pixels) {
      vec2 at = place / metres;
      vec2 wide = max(fwidth(at), 1e-6);
      vec2 away = abs(fract(at - 0.5) - 0.5) / wide;
      vec2 drawn = clamp(0.5 * pixels + 0.5 - away, 0.0, 1.0) * clamp(0.35 / wide, 0.0, 1.0);
      return max(drawn.x, drawn.y);
    }
    void main() {
      float fade = 1.0 - smoothstep(0.25, 1.0, length(place - middle) / reach);
      float alpha = max(0.32 * lines(1.0, 1.0), 0.75 * lines(5.0, 1.4)) * fade * strength;
      if (alpha < 0.004) discard;
      gl_FragColor = vec4(colour, alpha);
      #include <colorspace_fragment>
    }`;
}
