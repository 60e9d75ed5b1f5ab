import { FormatError } from './errors.js';

/** @typedef {'gltf' | 'unity' | 'unreal' | 'godot' | 'blender'} Axes */

/**
 * The fields of a message that describe a rig.
 *
 * @typedef {object} RigMessage
 * @property {string} bank
 * @property {string[]} joints
 * @property {number[]} parents
 * @property {number[][]} offsets
 * @property {Record<string, string | string[] | null>} roles
 */

/** A bank's joints. Parents come before their children, and the first joint is the root. */
export class Rig {
  /**
   * @param {RigMessage} message an event `welcome` or `bank`, a stream's header, or a skeleton and its bank
   * @param {Axes} axes of the offsets, and of everything that is posed with them
   */
  constructor(message, axes) {
    const { bank, joints, parents, offsets, roles } = message;
    const count = Array.isArray(joints) ? joints.length : 0;
    const areParents = Array.isArray(parents) && parents.length === count
      && parents.every((parent, joint) => Number.isInteger(parent) && parent < joint && (joint ? parent >= 0 : parent === -1));
    const areOffsets = Array.isArray(offsets) && offsets.length === count
      && offsets.every((offset) => Array.isArray(offset) && offset.length === 3 && offset.every(Number.isFinite));
    if (typeof bank !== 'string' || count === 0) throw new FormatError('a rig has no bank or no joints');
    if (!areParents) throw new FormatError(`a rig of ${count} joints has other parents`);
    if (!areOffsets) throw new FormatError(`a rig of ${count} joints has other offsets`);
    this.axes = axes;
    /** Digest of the bank. */
    this.bank = bank;
    /** Names of the joints. */
    this.joints = joints;
    /** Index of each joint's parent; -1 for the root. */
    this.parents = Int32Array.from(parents);
    /** Where each joint is in its parent's frame, [J][3]. */
    this.offsets = Float64Array.from(offsets.flat());
    /** Name of the joint or joints of each role, as `hips` and `left_arm`. */
    this.roles = roles;
    this.scratch = new Float64Array(7 * count); // of worldPositions
  }

  /**
   * Computes where all joints are.
   *
   * @param {ArrayLike<number>} root position of the root, [3]
   * @param {ArrayLike<number>} rotations of the joints in their parents' frames, [J][4]
   * @param {Float32Array} out receives positions, [J][3]
   * @returns {Float64Array} the joints' rotations in the world, [J][4], which the next call changes
   */
  worldPositions(root, rotations, out) {
    const { parents, offsets, scratch } = this;
    const turns = 3 * parents.length; // where the world rotations begin, after the positions
    for (let joint = 0; joint < parents.length; joint++) {
      const at = 3 * joint;
      const turn = turns + 4 * joint;
      const x = rotations[4 * joint], y = rotations[4 * joint + 1], z = rotations[4 * joint + 2], w = rotations[4 * joint + 3];
      if (joint === 0) {
        scratch.set([root[0], root[1], root[2]]);
        scratch.set([x, y, z, w], turn);
        continue;
      }
      const parent = turns + 4 * parents[joint];
      const from = 3 * parents[joint];
      const px = scratch[parent], py = scratch[parent + 1], pz = scratch[parent + 2], pw = scratch[parent + 3];
      const a = offsets[at], b = offsets[at + 1], c = offsets[at + 2];
      const u = 2 * (py * c - pz * b), v = 2 * (pz * a - px * c), t = 2 * (px * b - py * a); // twice the cross product
      scratch[at] = scratch[from] + a + pw * u + py * t - pz * v;
      scratch[at + 1] = scratch[from + 1] + b + pw * v + pz * u - px * t;
      scratch[at + 2] = scratch[from + 2] + c + pw * t + px * v - py * u;
      scratch[turn] = pw * x + px * w + py * z - pz * y;
      scratch[turn + 1] = pw * y - px * z + py * w + pz * x;
      scratch[turn + 2] = pw * z + px * y - py * x + pz * w;
      scratch[turn + 3] = pw * w - px * x - py * y - pz * z;
    }
    out.set(scratch.subarray(0, turns));
    return scratch.subarray(turns);
  }
}
