/** Where joints of a motion are at all of its frames. */

/** @import { Motion } from '../vendor/motionsplice.js' */

/** @type {WeakMap<Motion, { count: number, positions: Float32Array, turns: Float32Array }>} */
const TRACKS = new WeakMap();

/**
 * Returns the places [F][J][3] and the rotations [F][J][4] of all joints in the world, at the frames that are there now.
 *
 * @param {Motion} motion
 */
export function tracks(motion) {
  const known = TRACKS.get(motion);
  const count = motion.held.length;
  if (known?.count === count) return known;
  const joints = motion.rig.joints.length;
  const positions = new Float32Array(3 * joints * count);
  const turns = new Float32Array(4 * joints * count);
  for (let frame = 0; frame < count; frame++) {
    const pose = motion.pose(frame / motion.rate);
    if (!pose?.rotations) continue;
    const places = positions.subarray(3 * joints * frame, 3 * joints * (frame + 1));
    turns.set(motion.rig.worldPositions(pose.root, pose.rotations, places), 4 * joints * frame);
  }
  const found = { count, positions, turns };
  TRACKS.set(motion, found);
  return found;
}

/**
 * Returns the places of one joint [F][3].
 *
 * @param {Motion} motion
 * @param {number} joint
 */
export function trackOf(motion, joint) {
  const { count, positions } = tracks(motion);
  const width = 3 * motion.rig.joints.length;
  const out = new Float32Array(3 * count);
  for (let frame = 0; frame < count; frame++) out.set(positions.subarray(width * frame + 3 * joint, width * frame + 3 * joint + 3), 3 * frame);
  return out;
}
