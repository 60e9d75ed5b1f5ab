import { Color, Group, Mesh, PlaneGeometry, ShaderMaterial, ShadowMaterial, Vector3 } from '../vendor/three.js';

const REACH = 30; // metres around what is looked at
const BEHIND = 15; // metres from there to the wall

const VERTEX = /* glsl */ `
  uniform vec3 middle;
  uniform vec3 right;
  varying vec2 place;
  varying vec2 away;
  void main() {
    vec4 world = modelMatrix * vec4(position, 1.0);
    #ifdef WALL
      place = vec2(dot(world.xyz, right), world.y - middle.y);
      away = vec2(dot(world.xyz - middle, right), place.y);
    #else
      place = world.xz;
      away = world.xz - middle.xz;
    #endif
    gl_Position = projectionMatrix * viewMatrix * world;
  }`;

// Lines are as wide as a pixel, or fainter where they would be denser than pixels.
const FRAGMENT = /* glsl */ `
  uniform vec3 colour;
  uniform float reach;
  uniform float strength;
  varying vec2 place;
  varying vec2 away;
  float lines(float metres, float pixels) {
    vec2 at = place / metres;
    vec2 wide = max(fwidth(at), 1e-6);
    vec2 off = abs(fract(at - 0.5) - 0.5) / wide;
    vec2 drawn = clamp(0.5 * pixels + 0.5 - off, 0.0, 1.0) * clamp(0.35 / wide, 0.0, 1.0);
    return max(drawn.x, drawn.y);
  }
  void main() {
    float alpha = max(0.32 * lines(1.0, 1.0), 0.75 * lines(5.0, 1.4));
    #ifdef WALL
      alpha = max(0.2 * lines(0.5, 1.0), 0.75 * clamp(1.2 - abs(place.y) / max(fwidth(place.y), 1e-6), 0.0, 1.0));
      if (place.y < -0.004) alpha = 0.0;
    #endif
    alpha *= (1.0 - smoothstep(0.25, 1.0, length(away) / reach)) * strength;
    if (alpha < 0.004) discard;
    gl_FragColor = vec4(colour, alpha);
    #include <colorspace_fragment>
  }`;

/** The floor: lines each metre, stronger each five, fading away; and the shadows on it. A wall has lines too, for cameras that see the floor edge-on. */
export class Ground {
  object = new Group();
  /** Height of the floor, in metres. */
  level = 0;
  #lines = linesOf(false);
  #wallLines = linesOf(true);
  #wall = new Mesh(new PlaneGeometry(2 * REACH, 2 * REACH), this.#wallLines);
  #shadow = new ShadowMaterial({ opacity: 0.2, depthWrite: false });

  constructor() {
    for (const [material, size, order] of /** @type {const} */ ([[this.#lines, 2 * REACH, -3], [this.#shadow, 14, -2]])) {
      const mesh = new Mesh(new PlaneGeometry(size, size).rotateX(-Math.PI / 2), material);
      mesh.receiveShadow = material === this.#shadow;
      mesh.renderOrder = order;
      this.object.add(mesh);
    }
    this.#wall.renderOrder = -3;
    this.#wall.visible = false;
    this.object.add(this.#wall);
  }

  /** @param {string} line @param {number} shadow @param {number} strength */
  theme(line, shadow, strength) {
    for (const { uniforms } of [this.#lines, this.#wallLines]) {
      uniforms.colour.value.set(line);
      uniforms.strength.value = strength;
    }
    this.#shadow.opacity = shadow;
  }

  /** Covers a floor so wide, in metres, that a crowd stands on it. @param {number} width */
  reach(width) {
    const [lines, shadow] = this.object.children;
    const far = Math.max(REACH, width + 20);
    lines.scale.setScalar(far / REACH);
    this.#lines.uniforms.reach.value = far;
    shadow.scale.setScalar(Math.max(1, (width + 6) / 14));
  }

  /** Moves the floor under a place. The lines stay where they are. @param {number} x @param {number} z */
  at(x, z) {
    this.object.position.set(x, this.level, z);
    for (const { uniforms } of [this.#lines, this.#wallLines]) uniforms.middle.value.set(x, this.level, z);
  }

  /** Shows the wall behind the character, or hides it. @param {number | undefined} heading of the camera about Y */
  wall(heading) {
    this.#wall.visible = heading !== undefined;
    if (heading === undefined) return;
    this.#wall.rotation.y = heading;
    this.#wall.position.set(-BEHIND * Math.sin(heading), 0, -BEHIND * Math.cos(heading));
    this.#wallLines.uniforms.right.value.set(Math.cos(heading), 0, -Math.sin(heading));
  }
}

/** @param {boolean} isWall */
function linesOf(isWall) {
  return new ShaderMaterial({
    vertexShader: VERTEX, fragmentShader: FRAGMENT, transparent: true, depthWrite: false, defines: isWall ? { WALL: 1 } : {},
    uniforms: {
      colour: { value: new Color() }, middle: { value: new Vector3() }, right: { value: new Vector3(1, 0, 0) }, reach: { value: REACH },
      strength: { value: 1 },
    },
  });
}
