/** How a joint turns and moves. */

import { trackOf } from '../scene/tracks.js';

/** @import { Motion } from '../vendor/motionsplice.js' */

/**
 * Curves of a joint, one value a frame.
 *
 * @typedef {object} JointCurves
 * @property {Float32Array} angle degrees from the bind pose, in the parent's frame, 0 to 180
 * @property {Float32Array} turning degrees per second, in the parent's frame
 * @property {Float32Array} speed metres per second, in the world
 */

const DEGREES = 180 / Math.PI;

/**
 * Returns the curves of a joint; undefined if the rig does not have it. Speeds are differences over two frames, and over one
 * at the ends. In the bind pose all rotations are the identity.
 *
 * @param {Motion} motion
 * @param {string} name of the joint
 * @returns {JointCurves | undefined}
 */
export function jointCurves(motion, name) {
  const joint = motion.rig.joints.indexOf(name);
  if (joint < 0) return undefined;
  const rotations = turnsOf(motion, joint), places = trackOf(motion, joint);
  const count = motion.held.length;
  const curves = { angle: new Float32Array(count), turning: new Float32Array(count), speed: new Float32Array(count) };
  for (let frame = 0; frame < count; frame++) {
    const before = Math.max(0, frame - 1), after = Math.min(count - 1, frame + 1);
    const perSecond = after > before ? motion.rate / (after - before) : 0;
    curves.angle[frame] = turn(IDENTITY, 0, rotations, 4 * frame);
    curves.turning[frame] = turn(rotations, 4 * before, rotations, 4 * after) * perSecond;
    const [dx, dy, dz] = [0, 1, 2].map((axis) => places[3 * after + axis] - places[3 * before + axis]);
    curves.speed[frame] = perSecond * Math.hypot(dx, dy, dz);
  }
  return curves;
}

const IDENTITY = [0, 0, 0, 1];

/**
 * Returns a joint's rotation in its parent's frame at each frame [F][4].
 *
 * @param {Motion} motion
 * @param {number} joint
 */
function turnsOf(motion, joint) {
  const count = motion.held.length;
  const rotations = new Float32Array(4 * count);
  for (let frame = 0; frame < count; frame++) {
    const pose = motion.pose(frame / motion.rate);
    if (!pose?.rotations) break;
    rotations.set(pose.rotations.subarray(4 * joint, 4 * joint + 4), 4 * frame);
  }
  return rotations;
}

/**
 * Returns the degrees from one rotation to another, the shorter way. By the arctangent, for the arccosine is imprecise at
 * small angles.
 *
 * @param {ArrayLike<number>} a
 * @param {number} i where the first quaternion begins
 * @param {ArrayLike<number>} b
 * @param {number} j
 */
function turn(a, i, b, j) {
  const ax = -a[i], ay = -a[i + 1], az = -a[i + 2], aw = a[i + 3];
  const bx = b[j], by = b[j + 1], bz = b[j + 2], bw = b[j + 3];
  const x = aw * bx + ax * bw + ay * bz - az * by;
  const y = aw * by - ax * bz + ay * bw + az * bx;
  const z = aw * bz + ax * by - ay * bx + az * bw;
  const w = aw * bw - ax * bx - ay * by - az * bz;
  return 2 * DEGREES * Math.atan2(Math.hypot(x, y, z), Math.abs(w));
}
