import { FormatError } from './errors.js';
import { floats } from './frames.js';

/** @typedef {{ node: number, translation?: number[], rotation?: number[] }} StillNode */

/** The motion of the nodes of a character's own file: a take that was put onto its rig. */
export class Nodes {
  /** @param {any} message the answer with a `rig` */
  constructor({ rig, count, rate, node_translations, node_rotations }) {
    const areNodes = [rig.moved, rig.turned].every((nodes) => Array.isArray(nodes) && nodes.every(Number.isInteger));
    if (!areNodes || !Array.isArray(rig.still) || !(rig.scale > 0)) throw new FormatError('a rig has no nodes or no scale');
    /** Frames. @type {number} */
    this.count = count;
    /** Frames per second. @type {number} */
    this.rate = rate;
    /** Metres in a unit of the file, for legs as long as those of the bank's skeleton. @type {number} */
    this.scale = rig.scale;
    /** Numbers of the nodes that move. @type {number[]} */
    this.moved = rig.moved;
    /** Numbers of the nodes that turn. @type {number[]} */
    this.turned = rig.turned;
    /** Nodes that have the same value in all frames. @type {StillNode[]} */
    this.still = rig.still;
    /** What the rig does not show. @type {string[]} */
    this.notes = rig.notes;
    /** Of the nodes that move, in the unit of the file, [F][M][3]. */
    this.translations = floats('node_translations', node_translations, 3 * count * this.moved.length);
    /** Of the nodes that turn, in their parents' frames, [F][N][4]. */
    this.rotations = floats('node_rotations', node_rotations, 4 * count * this.turned.length);
  }
}
