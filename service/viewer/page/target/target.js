import { PARTS, pointOf } from '../takes.js';
import { Group, Mesh, MeshBasicMaterial, Vector3 } from '../vendor/three.js';
import { Gizmo } from './gizmo.js';
import { ball, lathe } from './lathe.js';

/** @import { Anatomy } from '../scene/anatomy.js' */
/** @import { Body } from '../scene/body.js' */
/** @import { Stage } from '../scene/stage.js' */
/** @import { Values } from '../state.js' */

/**
 * A character that looks or aims.
 *
 * @typedef {{ body: Body, offset: number[], shrink: number }} Aiming
 */

const COLOUR = '#c2308f';
const UP = new Vector3(0, 1, 0);
const ROD = lathe([[0, 1], [1, 1]]);
const BALL = ball(0.035);

/** The point that characters look and aim at: arrows that move it, lines to it, and where it is above the floor. */
export class Target {
  /** Called when it has moved: with the new value of the state. @type {(point: string) => void} */
  onmove = () => {};
  /** The value that the state is to have, until it is told. @type {string | undefined} */
  #moved;
  #stage;
  #gizmo;
  #material = new MeshBasicMaterial({ color: COLOUR, transparent: true, opacity: 0.55 });
  #marks = new Group();

  /**
   * @param {Stage} stage
   * @param {() => void} onchange draw again
   */
  constructor(stage, onchange) {
    this.#stage = stage;
    this.#gizmo = new Gizmo(stage);
    this.#gizmo.onchange = onchange;
    stage.add(this.#gizmo.object);
    stage.add(this.#marks);
  }

  /** Where it is, in metres. */
  get place() {
    return this.#gizmo.place;
  }

  /** Whether it was dragged to a place that the state does not know yet. */
  get isMoved() {
    return this.#moved !== undefined;
  }

  /** Tells where it was dragged to. */
  tell() {
    if (this.#moved !== undefined) this.onmove(this.#moved);
    this.#moved = undefined;
  }

  /**
   * Shows it for each character that looks or aims; the first one's is the one that is dragged.
   *
   * @param {Aiming[]} aiming
   * @param {Values} values
   */
  at(aiming, values) {
    const parts = PARTS.filter((part) => values[part]);
    const point = parts.length && pointOf(values.point);
    this.#gizmo.object.visible = Boolean(point && aiming.length);
    this.#marks.clear();
    if (!point) return;
    aiming.forEach(({ body, offset, shrink }, index) => {
      const place = (/** @type {ArrayLike<number>} */ from, at = 0) => new Vector3().fromArray(from, at).multiplyScalar(shrink).add(new Vector3().fromArray(offset));
      if (!index) this.#follow(place(point), offset, shrink);
      const to = index ? place(point) : this.#gizmo.place;
      if (index) this.#marks.add(new Mesh(BALL, this.#material)).children.at(-1)?.position.copy(to);
      this.#line(new Vector3(to.x, this.#stage.floor, to.z), to, 0.003);
      for (const part of parts) this.#line(place(body.positions, 3 * jointOf(part, body.anatomy)), to, 0.005);
    });
  }

  /**
   * @param {Vector3} place
   * @param {number[]} offset
   * @param {number} shrink
   */
  #follow(place, offset, shrink) {
    const gizmo = this.#gizmo;
    if (!gizmo.held && !this.isMoved) gizmo.place.copy(place);
    gizmo.ondrag = () => {
      const point = gizmo.place.clone().sub(new Vector3().fromArray(offset)).divideScalar(shrink);
      this.#moved = point.toArray().map((metres) => String(Number(metres.toFixed(3)))).join(' ');
      gizmo.onchange();
    };
    gizmo.fit();
  }

  /**
   * @param {Vector3} from
   * @param {Vector3} to
   * @param {number} radius
   */
  #line(from, to, radius) {
    const along = to.clone().sub(from), length = along.length();
    const mesh = new Mesh(ROD, this.#material);
    mesh.position.copy(from);
    mesh.quaternion.setFromUnitVectors(UP, along.divideScalar(Math.max(length, 1e-6)));
    mesh.scale.set(radius, length, radius);
    this.#marks.add(mesh);
  }
}

/**
 * Returns the joint from which a part looks or aims.
 *
 * @param {typeof PARTS[number]} part
 * @param {Anatomy} anatomy
 */
function jointOf(part, anatomy) {
  if (part === 'look') return anatomy.head;
  return part === 'chest' ? anatomy.chest : anatomy.role(part === 'left_arm' ? 'left_shoulder' : 'right_shoulder');
}
