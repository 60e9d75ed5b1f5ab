import { MOUSE, TOUCH, Vector3 } from '../vendor/three.js';

/** @import { Stage } from './stage.js' */

/** @typedef {'free' | 'front' | 'side' | 'top'} ViewName */
/** @typedef {{ x: number, y: number, z: number }} Place */

/** Direction from the character to the camera: left, up, ahead. The side view shows the character's left. */
const FROM = { front: [0, 0, 1], side: [1, 0, 0], top: [0, 1, 0] };
const DISTANCE = 30; // metres of an orthographic camera; only decides what is clipped
const TALL = 2.35; // metres from top to bottom that the free camera shows at first, around the character
const ARMS = 1.1; // metres that are seen beyond the middles of bodies beside each other
const CROWD_RISE = 0.36; // and at a crowd
const RISE = 0.2; // radians by which the free camera looks down at first

const UP = new Vector3(0, 1, 0);

/**
 * The camera. `free` orbits the character; `front`, `side` and `top` are orthographic. With `follow`, the camera moves exactly
 * as the character does, so the character stays in place on the screen.
 */
export class View {
  /** Called while the user moves the camera; draw again. */
  onchange = () => {};
  /** Called when the user lets go of the camera; store `text`. */
  onend = () => {};
  #stage;
  /** @type {ViewName} */
  #name = 'free';
  #isFollowing = true;
  #place = new Vector3(0, 0.9, 0);
  #heading = 0;
  #hasPlace = false;
  #isOurs = false; // whether a change is not the user's
  #mustCentre = false;
  #width = 0;
  #deep = 0;
  #isTouched = false; // whether the user or the address has set the camera

  /** @param {Stage} stage */
  constructor(stage) {
    this.#stage = stage;
    const { controls } = stage;
    Object.assign(controls, { minDistance: 0.5, maxDistance: 40, minZoom: 0.1, maxZoom: 12, maxPolarAngle: 0.497 * Math.PI, zoomSpeed: 1.4 });
    controls.addEventListener('change', () => this.#isOurs || this.onchange());
    controls.addEventListener('end', () => {
      this.#isTouched = true;
      this.onend();
    });
    stage.onsize = () => { if (!this.#isTouched) this.#reset(); };
    this.#reset();
  }

  /** @param {ViewName} name */
  set(name) {
    if (name === this.#name) return;
    this.#name = name;
    const { controls, perspective, orthographic } = this.#stage;
    const isFree = name === 'free';
    controls.object = this.#stage.camera = isFree ? perspective : orthographic;
    controls.enableRotate = isFree;
    controls.maxPolarAngle = isFree ? 0.497 * Math.PI : Math.PI;
    controls.mouseButtons.LEFT = isFree ? MOUSE.ROTATE : MOUSE.PAN;
    controls.touches.ONE = isFree ? TOUCH.ROTATE : TOUCH.PAN;
    this.#reset();
  }

  /** Shows the view as it was at first. */
  home() {
    this.#reset();
  }

  /**
   * Sets the distance between the outer bodies. The camera fits them all, unless the user has moved it.
   *
   * @param {number} metres
   * @param {number} [deep] metres from the front of a crowd to its back
   */
  wide(metres, deep = 0) {
    if (metres === this.#width && deep === this.#deep) return;
    this.#width = metres;
    this.#deep = deep;
    this.#stage.controls.maxDistance = Math.max(40, 4 * metres);
    this.#stage.perspective.far = Math.max(120, 6 * metres);
    this.#stage.perspective.updateProjectionMatrix();
    if (!this.#isTouched) this.#reset();
  }

  /** @param {boolean} isOn */
  follow(isOn) {
    if (isOn && !this.#isFollowing) this.#mustCentre = true;
    this.#isFollowing = isOn;
  }

  /**
   * Sets the place of the character.
   *
   * @param {Place} target the middle of the body, from `Path` for a smooth camera
   * @param {number} heading radians about Y
   */
  at(target, heading) {
    const { controls, camera } = this.#stage;
    const next = new Vector3(target.x, target.y, target.z);
    if (!this.#hasPlace && !this.#isTouched) {
      this.#hasPlace = true;
      this.#place.copy(next);
      this.#heading = heading;
      this.#reset();
      return;
    }
    const moved = next.clone().sub(this.#mustCentre ? controls.target : this.#place);
    if (this.#isFollowing || !this.#hasPlace) {
      controls.target.add(moved);
      camera.position.add(moved);
      if (this.#name !== 'free') this.#turn(next, heading - this.#heading);
      this.#heading = heading;
    }
    this.#place.copy(next);
    this.#mustCentre = false;
    this.#hasPlace = true;
    this.#update();
  }

  /** The view for the address: positions of the camera and its target, relative to the character if it is followed, and the zoom. */
  get text() {
    const { controls, camera } = this.#stage;
    const from = this.#isFollowing ? this.#place : new Vector3();
    const numbers = [...camera.position.clone().sub(from).toArray(), ...controls.target.clone().sub(from).toArray(), camera.zoom];
    return numbers.map((number) => String(Number(number.toFixed(2)))).join(' ');
  }

  set text(text) {
    const numbers = text.trim().split(/\s+/).map(Number);
    if (numbers.length !== 7 || !numbers.every(Number.isFinite) || numbers[6] <= 0) return;
    const { controls, camera } = this.#stage;
    const from = this.#isFollowing ? this.#place : new Vector3();
    camera.position.fromArray(numbers, 0).add(from);
    controls.target.fromArray(numbers, 3).add(from);
    camera.zoom = numbers[6];
    camera.updateProjectionMatrix();
    this.#isTouched = true;
    this.#hasPlace ||= !this.#isFollowing;
    this.#update();
  }

  #reset() {
    const { controls, camera, perspective, orthographic } = this.#stage;
    controls.target.copy(this.#place);
    this.#isTouched = false;
    if (this.#name === 'free') {
      const turn = this.#heading + 0.58 / (1 + 0.5 * this.#width); // more from the front, so that no body hides another
      const tall = Math.max(TALL, (this.#width + ARMS) / perspective.aspect);
      const rise = this.#deep ? CROWD_RISE : RISE;
      const away = tall / 2 / Math.tan((perspective.fov * Math.PI) / 360) + (this.#deep ? 0.52 : 0.35) * this.#width;
      camera.position.set(Math.sin(turn) * Math.cos(rise), Math.sin(rise), Math.cos(turn) * Math.cos(rise)).multiplyScalar(away).add(this.#place);
    } else {
      const [left, up, ahead] = FROM[this.#name];
      const across = orthographic.right - orthographic.left, high = orthographic.top - orthographic.bottom;
      orthographic.zoom = Math.min(1, this.#width ? across / (this.#width + ARMS) : 1, this.#name === 'top' && this.#deep ? high / (this.#deep + ARMS) : 1);
      orthographic.updateProjectionMatrix();
      camera.position.set(left, up, ahead + (up ? 1e-3 : 0)).applyAxisAngle(UP, this.#heading).multiplyScalar(DISTANCE).add(this.#place);
    }
    this.#update();
  }

  /**
   * Turns the camera about the character.
   *
   * @param {Vector3} middle
   * @param {number} angle
   */
  #turn(middle, angle) {
    const { controls, camera } = this.#stage;
    for (const place of [controls.target, camera.position]) place.sub(middle).applyAxisAngle(UP, angle).add(middle);
  }

  #update() {
    const isLevel = this.#name === 'front' || this.#name === 'side';
    this.#isOurs = true;
    this.#stage.controls.update();
    this.#isOurs = false;
    this.#stage.aim(this.#place.x, this.#place.z, isLevel ? this.#stage.controls.getAzimuthalAngle() : undefined);
  }
}
