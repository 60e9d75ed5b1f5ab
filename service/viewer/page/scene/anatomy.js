import { across, cross, dot, minus, norm, plus, times, unit } from './vectors.js';

/** @import { Rig } from '../vendor/motionsplice.js' */
/** @import { Vector } from './vectors.js' */

/** @typedef {'left' | 'right'} Half */

/** A rig's body parts in its bind pose. There the frames of all joints are aligned with the world. */
export class Anatomy {
  /** @param {Rig} rig */
  constructor(rig) {
    this.rig = rig;
    /** Place of each joint in the bind pose, with the root at the origin. @type {Vector[]} */
    this.places = [];
    /** @type {number[][]} */
    this.children = rig.joints.map(() => []);
    rig.joints.forEach((_, joint) => {
      const parent = rig.parents[joint];
      const offset = /** @type {Vector} */ ([...rig.offsets.subarray(3 * joint, 3 * joint + 3)]);
      this.places.push(parent < 0 ? [0, 0, 0] : plus(this.places[parent], offset));
      if (parent >= 0) this.children[parent].push(joint);
    });
    const [leftHip, rightHip] = [this.role('left_hip'), this.role('right_hip')];
    const neck = this.role('neck', 'head');
    /** Joint that carries both legs and the spine. */
    this.hips = this.#above(leftHip, rightHip, neck);
    /** Joint that carries both arms and the neck. */
    this.chest = this.#above(this.role('left_shoulder'), this.role('right_shoulder'), neck);
    this.head = this.role('head', 'neck');
    this.middle = times(plus(this.places[leftHip], this.places[rightHip]), 0.5);
    /** Up and to the left of the trunk. */
    this.up = unit(minus(this.places[neck], this.middle));
    this.left = across(minus(this.places[leftHip], this.places[rightHip]), this.up);
    this.forward = cross(this.left, this.up);
    /** Size relative to a body of 1.78 m. */
    this.size = (this.legLength('left') + this.legLength('right')) / 2 / LEG;
  }

  /**
   * Returns the joint of the first of some roles that the rig has; the root if it has none of them.
   *
   * @param {...string} roles
   */
  role(...roles) {
    for (const role of roles) {
      const name = this.rig.roles[role];
      const joint = typeof name === 'string' ? this.rig.joints.indexOf(name) : -1;
      if (joint >= 0) return joint;
    }
    return 0;
  }

  /** @param {string} role */
  has(role) {
    return typeof this.rig.roles[role] === 'string';
  }

  /**
   * Returns the joints from one down to another, both included.
   *
   * @param {number} from
   * @param {number} to
   */
  path(from, to) {
    const path = [to];
    for (let joint = to; joint !== from && this.rig.parents[joint] >= 0;) path.unshift((joint = this.rig.parents[joint]));
    return path;
  }

  /** @param {number} joint */
  parent(joint) {
    return this.rig.parents[joint];
  }

  /**
   * Returns the joints below one.
   *
   * @param {number} joint
   * @returns {number[]}
   */
  below(joint) {
    return this.children[joint].flatMap((child) => [child, ...this.below(child)]);
  }

  /** @param {Half} half */
  legLength(half) {
    const path = this.path(this.role(`${half}_hip`), this.role(`${half}_ankle`));
    return path.slice(1).reduce((sum, joint) => sum + norm(minus(this.places[joint], this.places[this.parent(joint)])), 0) || LEG;
  }

  /** Height of a place over the hips, along the trunk. @param {Vector} place */
  height(place) {
    return dot(minus(place, this.middle), this.up);
  }

  /**
   * Returns the axes of a foot in the bind pose: forward, left, and down through the sole. Some rigs bind the legs pointing
   * up, so the shin decides what is down.
   *
   * @param {Half} half
   */
  foot(half) {
    const [knee, ankle, toe] = [this.role(`${half}_knee`), this.role(`${half}_ankle`), this.role(`${half}_toe`)];
    const shin = unit(minus(this.places[ankle], this.places[knee]));
    const toes = this.has(`${half}_toe`) ? minus(this.places[toe], this.places[ankle]) : this.forward;
    const isUpright = -dot(shin, this.up) > 0.77; // 40 degrees
    const left = across(cross(times(shin, -1), toes), shin, this.left);
    const down = isUpright ? across(times(this.up, -1), left) : shin;
    const forward = cross(left, times(down, -1));
    // Rigs that bind all limbs along one axis bind the toes along it too, not along the foot.
    const toesForward = isUpright ? forward : shin;
    return { left, down, forward, reach: dot(toes, forward), drop: dot(toes, down), toesForward, toesDown: cross(left, toesForward) };
  }

  /** The lowest joint above some joints. @param {...number} joints */
  #above(...joints) {
    const paths = joints.map((joint) => this.path(0, joint));
    let depth = 0;
    while (paths.every((path) => path[depth + 1] !== undefined && path[depth + 1] === paths[0][depth + 1])) depth++;
    return paths[0][depth];
  }
}

const LEG = 0.874; // metres from the hip to the ankle in a body of 1.78 m
