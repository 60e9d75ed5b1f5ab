import { BufferAttribute, BufferGeometry, Color, DoubleSide, Mesh, ShaderMaterial, Vector2 } from '../vendor/three.js';

/**
 * How a ribbon is drawn.
 *
 * @typedef {object} Look
 * @property {Color} colour
 * @property {number} width pixels
 * @property {number} before opacity of what was
 * @property {number} after opacity of what comes
 * @property {number} span seconds until it has faded; 0: never
 */

/** A line of constant width on the screen, which fades away from the current time. */
export class Ribbon {
  #material;
  #geometry = new BufferGeometry();

  /**
   * @param {Float32Array} places [F][3]
   * @param {number} rate frames per second
   * @param {Look} look
   */
  constructor(places, rate, { colour, width, before, after, span }) {
    const count = places.length / 3;
    const frames = new Float32Array(2 * count), sides = new Float32Array(2 * count);
    const [own, back, next] = [0, 1, 2].map(() => new Float32Array(6 * count));
    const indices = [];
    for (let frame = 0; frame < count; frame++) {
      for (const side of [0, 1]) {
        const to = 2 * frame + side;
        frames[to] = frame / rate;
        sides[to] = 2 * side - 1;
        own.set(places.subarray(3 * frame, 3 * frame + 3), 3 * to);
        const [from, until] = [Math.max(0, frame - 1), Math.min(count - 1, frame + 1)];
        back.set(places.subarray(3 * from, 3 * from + 3), 3 * to);
        next.set(places.subarray(3 * until, 3 * until + 3), 3 * to);
      }
      if (frame) indices.push(2 * frame - 2, 2 * frame - 1, 2 * frame, 2 * frame - 1, 2 * frame + 1, 2 * frame);
    }
    this.#geometry.setIndex(indices);
    for (const [name, values] of Object.entries({ position: own, back, next, time: frames, side: sides })) {
      this.#geometry.setAttribute(name, new BufferAttribute(values, values.length / (2 * count)));
    }
    this.#material = new ShaderMaterial({
      vertexShader: VERTEX, fragmentShader: FRAGMENT, transparent: true, depthWrite: false, side: DoubleSide,
      uniforms: {
        colour: { value: colour }, width: { value: width }, now: { value: 0 }, span: { value: span },
        opacity: { value: new Vector2(before, after) }, size: { value: new Vector2(1, 1) },
      },
    });
    this.object = new Mesh(this.#geometry, this.#material);
    this.object.frustumCulled = false;
    this.object.renderOrder = 2;
    this.object.onBeforeRender = (renderer) => void renderer.getSize(this.#material.uniforms.size.value);
  }

  /** @param {number} time seconds */
  at(time) {
    this.#material.uniforms.now.value = time;
  }

  dispose() {
    this.#geometry.dispose();
    this.#material.dispose();
  }
}

const VERTEX = /* glsl */ `
  attribute vec3 back;
  attribute vec3 next;
  attribute float time;
  attribute float side;
  uniform vec2 size;
  uniform vec2 opacity;
  uniform float width;
  uniform float now;
  uniform float span;
  varying float alpha;
  varying float across;
  vec4 project(vec3 place) { return projectionMatrix * modelViewMatrix * vec4(place, 1.0); }
  void main() {
    vec4 at = project(position), from = project(back), to = project(next);
    vec2 way = (to.xy / to.w - from.xy / from.w) * size;
    vec2 normal = length(way) > 1e-4 ? normalize(vec2(-way.y, way.x)) : vec2(0.0, 1.0);
    float away = time - now;
    alpha = (away < 0.0 ? opacity.x : opacity.y) * (span > 0.0 ? 1.0 - smoothstep(0.15, 1.0, abs(away) / span) : 1.0);
    across = side * (width + 1.0);
    at.xy += normal * side * (width + 1.0) / size * at.w;
    gl_Position = alpha < 0.004 ? vec4(2.0, 2.0, 2.0, 1.0) : at;
  }`;

// The edge is smoothed over a pixel, because multisampling alone leaves thin lines ragged.
const FRAGMENT = /* glsl */ `
  uniform vec3 colour;
  uniform float width;
  varying float alpha;
  varying float across;
  void main() {
    gl_FragColor = vec4(colour, alpha * clamp(width + 1.0 - abs(across), 0.0, 1.0));
    #include <colorspace_fragment>
  }`;
