import { Color, Group } from '../vendor/three.js';
import { Anatomy } from './anatomy.js';
import { Footprints } from './footprints.js';
import { SHADE } from './mannequin.js';
import { Ribbon } from './ribbon.js';
import { floorOf, groundOf, stancesOf } from './stances.js';
import { trackOf } from './tracks.js';

/** @import { Side } from '../sides.js' */
/** @import { Contacts } from './stances.js' */

const SPAN = 1; // seconds of a trail before and after the current time

/** The traces of a side: its path on the ground, trails of feet and hands, and marks where its feet stand. */
export class Traces {
  object = new Group();
  #trails = new Group();
  #path = new Group();
  #contacts = new Group();
  /** @type {Ribbon[]} */
  #ribbons = [];
  #footprints;
  /** Height of the clip's own floor, in metres: set `Stage.floor` to it. */
  floor;

  /**
   * @param {Pick<Side, 'motion' | 'colour'>} side
   * @param {Contacts} [contacts] of the motion, in its seconds
   */
  constructor(side, contacts = { left: [], right: [] }) {
    const { motion } = side;
    const anatomy = new Anatomy(motion.rig);
    const colour = new Color(side.colour);
    const stances = stancesOf(motion, contacts);
    this.floor = floorOf(stances);
    this.object.add(this.#path, this.#contacts, this.#trails);
    for (const half of /** @type {const} */ (['left', 'right'])) {
      const shade = SHADE[half];
      const own = colour.clone().lerp(new Color(shade > 0 ? 'white' : 'black'), 0.8 * Math.abs(shade));
      const ends = [anatomy.role(`${half}_wrist`), anatomy.role(`${half}_toe`, `${half}_ankle`)];
      for (const joint of ends) this.#add(this.#trails, trackOf(motion, joint), motion.rate, { colour: own, width: 2.5, before: 0.95, after: 0.4, span: SPAN });
    }
    const ground = trackOf(motion, 0);
    groundOf(stances, ground.length / 3, motion.rate).forEach((height, frame) => (ground[3 * frame + 1] = height + 0.008));
    this.#add(this.#path, ground, motion.rate, { colour, width: 2, before: 0.9, after: 0.4, span: 0 });
    this.#footprints = new Footprints(stances, anatomy, colour, this.floor);
    this.#contacts.add(this.#footprints.object);
    this.show({ trails: false, path: true, contacts: true });
  }

  /** @param {{ trails: boolean, path: boolean, contacts: boolean }} shown */
  show({ trails, path, contacts }) {
    this.#trails.visible = trails;
    this.#path.visible = path;
    this.#contacts.visible = contacts;
  }

  /** @param {number} time seconds */
  at(time) {
    for (const ribbon of this.#ribbons) ribbon.at(time);
    this.#footprints.at(time);
  }

  /** @param {ArrayLike<number>} offset metres, [3] */
  offset(offset) {
    this.object.position.set(offset[0], offset[1], offset[2]);
  }

  dispose() {
    this.object.removeFromParent();
    for (const ribbon of this.#ribbons) ribbon.dispose();
    this.#footprints.dispose();
  }

  /**
   * @param {Group} group
   * @param {Float32Array} places
   * @param {number} rate
   * @param {import('./ribbon.js').Look} look
   */
  #add(group, places, rate, look) {
    const ribbon = new Ribbon(places, rate, look);
    this.#ribbons.push(ribbon);
    group.add(ribbon.object);
  }
}
