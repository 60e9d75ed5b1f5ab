import {
  BufferAttribute, BufferGeometry, Color, DoubleSide, Group, InstancedBufferAttribute, InstancedMesh, Matrix4, ShaderMaterial, Vector3,
} from '../vendor/three.js';

/** @import { Anatomy } from './anatomy.js' */
/** @import { Stance } from './stances.js' */

// Metres ahead of the ankle, and the edges of a left sole: inner, outer.
const SOLE = [
  [-0.068, 0.006, 0.006], [-0.064, 0.018, 0.018], [-0.05, 0.03, 0.03], [-0.02, 0.034, 0.034], [0.03, 0.03, 0.037], [0.08, 0.036, 0.044],
  [0.12, 0.05, 0.046], [0.16, 0.053, 0.043], [0.19, 0.05, 0.034], [0.205, 0.042, 0.02], [0.212, 0.028, 0.002],
];
const STEP = 0.06; // metres of a ground that is drawn as a step
const RISER = 0.17; // metres of a step that are drawn

/** Marks on the ground where feet stand, lit while they do. Ground that is raised is drawn as a step. */
export class Footprints {
  object = new Group();
  #stances;
  #lit;
  #marks;
  #steps;

  /**
   * @param {Stance[]} stances
   * @param {Anatomy} anatomy
   * @param {Color} colour
   * @param {number} floor metres
   */
  constructor(stances, anatomy, colour, floor) {
    this.#stances = stances;
    this.#lit = new Float32Array(stances.length);
    const sole = soleOf(anatomy);
    sole.setAttribute('lit', new InstancedBufferAttribute(this.#lit, 1));
    this.#marks = new InstancedMesh(sole, flat(MARK, colour), stances.length);
    const raised = stances.filter(({ at }) => at[1] - floor > STEP);
    this.#steps = new InstancedMesh(boxOf(anatomy.size), flat(SIDE, colour), raised.length);
    const turn = new Matrix4();
    stances.forEach(({ half, at: [x, y, z], heading }, index) => {
      turn.makeRotationY(heading).scale(new Vector3(half === 'left' ? 1 : -1, 1, 1)).setPosition(x, y + 0.006, z);
      this.#marks.setMatrixAt(index, turn);
    });
    raised.forEach(({ at: [x, y, z], heading }, index) => {
      this.#steps.setMatrixAt(index, turn.makeRotationY(heading).setPosition(x, y, z).scale(new Vector3(1, Math.min(RISER, y - floor), 1)));
    });
    for (const [mesh, order] of /** @type {const} */ ([[this.#steps, 0], [this.#marks, 1]])) {
      mesh.frustumCulled = false;
      mesh.renderOrder = order;
      this.object.add(mesh);
    }
  }

  /** @param {number} time seconds */
  at(time) {
    let isChanged = false;
    this.#stances.forEach(({ from, to }, index) => {
      const lit = Number(time >= from - 1e-3 && time <= to + 1e-3);
      isChanged ||= lit !== this.#lit[index];
      this.#lit[index] = lit;
    });
    if (isChanged) this.#marks.geometry.getAttribute('lit').needsUpdate = true;
  }

  dispose() {
    for (const mesh of [this.#marks, this.#steps]) {
      mesh.geometry.dispose();
      mesh.material.dispose();
      mesh.dispose();
    }
  }
}

/** @param {Anatomy} anatomy */
function soleOf(anatomy) {
  const { size } = anatomy;
  const stretch = anatomy.has('left_toe') ? anatomy.foot('left').reach / (0.135 * size) : 1;
  const places = SOLE.flatMap(([ahead, inner, outer]) => {
    const z = size * (ahead > 0 ? Math.min(ahead, 0.135) * stretch + Math.max(0, ahead - 0.135) : ahead);
    return [-inner * size, 0, z, outer * size, 0, z];
  });
  const geometry = new BufferGeometry();
  geometry.setAttribute('position', new BufferAttribute(Float32Array.from(places), 3));
  geometry.setIndex(SOLE.slice(1).flatMap((_, row) => [2 * row, 2 * row + 2, 2 * row + 1, 2 * row + 1, 2 * row + 2, 2 * row + 3]));
  return geometry;
}

/** A step one metre high, without a bottom, under the ground. @param {number} size */
function boxOf(size) {
  const [wide, back, front] = [0.16 * size, -0.1 * size, 0.22 * size];
  const corners = [[-wide, back], [wide, back], [wide, front], [-wide, front]];
  const places = [-1, 0].flatMap((y) => corners.flatMap(([x, z]) => [x, y, z]));
  const geometry = new BufferGeometry();
  geometry.setAttribute('position', new BufferAttribute(Float32Array.from(places), 3));
  geometry.setIndex([4, 7, 6, 4, 6, 5, ...[0, 1, 2, 3].flatMap((side) => {
    const other = (side + 1) % 4;
    return [side, side + 4, other, other, side + 4, other + 4];
  })]);
  return geometry;
}

/**
 * @param {string} alpha
 * @param {Color} colour
 */
function flat(alpha, colour) {
  return new ShaderMaterial({
    uniforms: { colour: { value: colour } }, transparent: true, depthWrite: false, side: DoubleSide,
    vertexShader: /* glsl */ `
      ${alpha === MARK ? 'attribute float lit;' : 'const float lit = 0.0;'}
      varying float shown;
      varying float height;
      void main() {
        shown = lit;
        height = position.y;
        gl_Position = projectionMatrix * modelViewMatrix * instanceMatrix * vec4(position, 1.0);
      }`,
    fragmentShader: /* glsl */ `
      uniform vec3 colour;
      varying float shown;
      varying float height;
      void main() {
        gl_FragColor = vec4(colour, ${alpha});
        #include <colorspace_fragment>
      }`,
  });
}

const MARK = 'mix(0.3, 0.95, shown)';
const SIDE = 'mix(0.0, 0.26, 1.0 + height)';
