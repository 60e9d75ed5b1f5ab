import { Group, Mesh, MeshBasicMaterial, Vector3 } from '../vendor/three.js';
import { ball, lathe } from './lathe.js';
import { alongAxis, onPlane, rayAt } from './rays.js';

/** @import { Stage } from '../scene/stage.js' */
/** @import { Ray } from './rays.js' */

/** @typedef {'x' | 'y' | 'z' | 'middle'} Handle */

const COLOURS = { x: '#e5484d', y: '#3fa34d', z: '#3e7bfa', middle: '#c2308f' };
const LENGTH = 70; // pixels of an arrow
const REACH = 11; // pixels around a handle that take hold of it; a finger needs more
const FINGER = 22;
const ARROW = /** @type {[number, number][]} */ ([[0.14, 0], [0.14, 0.018], [0.78, 0.018], [0.78, 0.07], [1, 0]]);

/** A point that can be dragged: by an arrow along an axis of the world, by its middle in the plane of the picture. */
export class Gizmo {
  object = new Group();
  /** Called while it is dragged. */
  ondrag = () => {};
  /** Called when another part is below the pointer: draw again. */
  onchange = () => {};
  /** The handle that is held. @type {Handle | undefined} */
  held;
  #stage;
  /** @type {Handle | undefined} */
  #over;
  #grip = new Vector3(); // from the place where it was taken hold of to the point
  /** @type {Map<Handle, MeshBasicMaterial>} */
  #materials = new Map();

  /** @param {Stage} stage */
  constructor(stage) {
    this.#stage = stage;
    const arrow = lathe(ARROW);
    for (const handle of /** @type {Handle[]} */ (Object.keys(COLOURS))) {
      const material = new MeshBasicMaterial({ color: COLOURS[handle], depthTest: false, transparent: true });
      const mesh = new Mesh(handle === 'middle' ? ball(0.1) : arrow, material);
      mesh.renderOrder = 2;
      if (handle === 'x') mesh.rotation.z = -Math.PI / 2;
      if (handle === 'z') mesh.rotation.x = Math.PI / 2;
      this.#materials.set(handle, material);
      this.object.add(mesh);
    }
    const { canvas } = stage;
    canvas.addEventListener('pointerdown', (event) => this.#take(event), true); // before the camera takes it
    canvas.addEventListener('pointermove', (event) => (this.held ? this.#drag(event) : this.#hover(event)));
    for (const end of ['pointerup', 'pointercancel']) canvas.addEventListener(end, () => { this.held = undefined; });
  }

  /** The point, in metres. */
  get place() {
    return this.object.position;
  }

  /** Keeps its size on the screen. */
  fit() {
    const { camera, canvas } = this.#stage;
    const tall = 'fov' in camera
      ? 2 * Math.tan((camera.fov * Math.PI) / 360) * camera.position.distanceTo(this.place)
      : (camera.top - camera.bottom) / camera.zoom;
    this.object.scale.setScalar((LENGTH * tall) / Math.max(1, canvas.clientHeight));
    for (const [handle, material] of this.#materials) material.opacity = handle === (this.held ?? this.#over) ? 1 : 0.75;
  }

  /** @param {PointerEvent} event */
  #take(event) {
    const handle = event.button === 0 && event.isPrimary ? this.#at(event) : undefined;
    if (!handle) return;
    event.stopImmediatePropagation();
    this.#stage.canvas.setPointerCapture(event.pointerId);
    this.held = handle;
    this.#grip.copy(this.place).sub(this.#found(handle, rayAt(event, this.#stage)) ?? this.place);
  }

  /** @param {PointerEvent} event */
  #drag(event) {
    const found = this.held && this.#found(this.held, rayAt(event, this.#stage));
    if (!found) return;
    this.place.copy(found).add(this.#grip);
    this.ondrag();
  }

  /** @param {PointerEvent} event */
  #hover(event) {
    const over = event.buttons ? undefined : this.#at(event);
    if (over === this.#over) return;
    this.#over = over;
    this.#stage.canvas.style.cursor = over ? 'grab' : '';
    this.onchange();
  }

  /**
   * Returns the place on a handle's line or plane that a ray shows.
   *
   * @param {Handle} handle
   * @param {Ray} ray
   */
  #found(handle, ray) {
    if (handle === 'middle') return onPlane(ray, this.place, this.#stage.camera.getWorldDirection(new Vector3()));
    return alongAxis(ray, this.place, handle);
  }

  /**
   * Returns the handle below the pointer.
   *
   * @param {PointerEvent} event
   * @returns {Handle | undefined}
   */
  #at(event) {
    if (!this.object.visible) return undefined;
    const reach = event.pointerType === 'touch' ? FINGER : REACH;
    const middle = this.#seen(this.place);
    if (Math.hypot(event.offsetX - middle[0], event.offsetY - middle[1]) < reach) return 'middle';
    /** @param {'x' | 'y' | 'z'} axis */
    const away = (axis) => {
      const tip = this.place.clone();
      tip[axis] += this.object.scale.x;
      return fromLine([event.offsetX, event.offsetY], middle, this.#seen(tip));
    };
    const [nearest] = /** @type {const} */ (['x', 'y', 'z']).map((axis) => ({ axis, away: away(axis) })).sort((a, b) => a.away - b.away);
    return nearest.away < reach ? nearest.axis : undefined;
  }

  /**
   * Returns where a place is seen, in pixels of the canvas.
   *
   * @param {Vector3} place
   * @returns {[number, number]}
   */
  #seen(place) {
    const { clientWidth, clientHeight } = this.#stage.canvas;
    const { x, y } = place.clone().project(this.#stage.camera);
    return [((x + 1) / 2) * clientWidth, ((1 - y) / 2) * clientHeight];
  }
}

/**
 * Returns the distance of a point from the line between two others. A line that is seen end-on is no handle.
 *
 * @param {[number, number]} point
 * @param {[number, number]} from
 * @param {[number, number]} to
 */
function fromLine([x, y], [fromX, fromY], [toX, toY]) {
  const [alongX, alongY] = [toX - fromX, toY - fromY];
  const squared = alongX ** 2 + alongY ** 2;
  if (squared < 64) return Infinity;
  const share = Math.max(0, Math.min(1, ((x - fromX) * alongX + (y - fromY) * alongY) / squared));
  return Math.hypot(x - fromX - share * alongX, y - fromY - share * alongY);
}
