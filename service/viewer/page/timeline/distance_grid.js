/** How alike the legs of two motions are, as the alignment measures it: see "When" in docs/method.md. */

import { tracks } from '../scene/tracks.js';

/** @import { Motion } from '../vendor/motionsplice.js' */

const POINTS = 3; // root, left knee, right knee
const SIZE = 3 * POINTS;

/**
 * Clouds of a motion's legs: of each frame x of all points, then z, then y, in metres about the cloud's mean.
 *
 * @typedef {{ values: Float32Array, count: number, rate: number }} Clouds
 */

/**
 * Distances of frames of one motion (columns) to frames of another (rows).
 *
 * @typedef {object} DistanceGrid
 * @property {number} columns
 * @property {number} rows
 * @property {Float32Array} values metres, row by row
 */

/**
 * Returns the clouds of a motion.
 *
 * @param {Motion} motion
 * @returns {Clouds}
 */
export function legClouds(motion) {
  const { rig, rate } = motion;
  const { count, positions } = tracks(motion);
  const width = 3 * rig.joints.length;
  const joints = ['root', 'left_knee', 'right_knee'].map((role) => rig.joints.indexOf(/** @type {string} */ (rig.roles[role])));
  const values = new Float32Array(SIZE * count);
  for (let frame = 0; frame < count; frame++) write(values, SIZE * frame, joints, positions.subarray(width * frame, width * (frame + 1)));
  return { values, count, rate };
}

/**
 * @param {Float32Array} values
 * @param {number} at
 * @param {number[]} joints
 * @param {Float32Array} places of all joints
 */
function write(values, at, joints, places) {
  [0, 2, 1].forEach((coordinate, block) => {
    const mean = joints.reduce((sum, joint) => sum + places[3 * joint + coordinate], 0) / POINTS;
    joints.forEach((joint, point) => { values[at + POINTS * block + point] = places[3 * joint + coordinate] - mean; });
  });
}

/**
 * Returns how far the points of two clouds are apart, in metres: the root mean square over the points, least over all turns
 * about Y and all shifts. The closed form is that of Kovar, Gleicher and Pighin 2002. The clouds are centred in height too,
 * so that steps on a stair compare with steps on the floor.
 *
 * @param {Float32Array} a
 * @param {number} i where the cloud begins
 * @param {Float32Array} b
 * @param {number} j
 */
export function cloudDistance(a, i, b, j) {
  let squares = 0, along = 0, across = 0, heights = 0;
  for (let point = 0; point < POINTS; point++) {
    const ax = a[i + point], az = a[i + POINTS + point], ay = a[i + 2 * POINTS + point];
    const bx = b[j + point], bz = b[j + POINTS + point], by = b[j + 2 * POINTS + point];
    squares += ax * ax + ay * ay + az * az + bx * bx + by * by + bz * bz;
    along += ax * bx + az * bz;
    across += ax * bz - az * bx;
    heights += ay * by;
  }
  return Math.sqrt(Math.max(0, squares - 2 * (Math.sqrt(along * along + across * across) + heights)) / POINTS);
}

/**
 * Returns the distances of all frames to all frames, or of evenly chosen frames where there are many.
 *
 * @param {Clouds} a
 * @param {Clouds} b
 * @param {number} [most] columns and rows
 * @returns {DistanceGrid}
 */
export function distanceGrid(a, b, most = 200) {
  const columns = Math.min(most, a.count), rows = Math.min(most, b.count);
  const values = new Float32Array(columns * rows);
  for (let row = 0; row < rows; row++) {
    const j = SIZE * chosen(row, rows, b.count);
    for (let column = 0; column < columns; column++) {
      values[row * columns + column] = cloudDistance(a.values, SIZE * chosen(column, columns, a.count), b.values, j);
    }
  }
  return { columns, rows, values };
}

/**
 * Returns the frame that a column or row shows.
 *
 * @param {number} index
 * @param {number} indices
 * @param {number} count of frames
 */
export function chosen(index, indices, count) {
  return indices > 1 ? Math.round((index * (count - 1)) / (indices - 1)) : 0;
}

/**
 * Returns how far the legs are apart at each frame of a locomotion, in metres; NaN where there is no action.
 *
 * @param {Clouds} locomotion
 * @param {Clouds} action
 * @param {ArrayLike<number>} times seconds into the action at each frame; NaN without one
 */
export function alignedDistances(locomotion, action, times) {
  const distances = new Float32Array(Math.min(locomotion.count, times.length)).fill(NaN);
  const between = new Float32Array(SIZE);
  for (let frame = 0; frame < distances.length; frame++) {
    const place = times[frame] * action.rate;
    if (!(place >= 0 && place <= action.count)) continue; // the seam after the clip is not in its frames
    const before = Math.min(Math.floor(place), action.count - 1), after = Math.min(before + 1, action.count - 1);
    for (let at = 0; at < SIZE; at++) {
      const value = action.values[SIZE * before + at];
      between[at] = value + (place - before) * (action.values[SIZE * after + at] - value);
    }
    distances[frame] = cloudDistance(locomotion.values, SIZE * frame, between, 0);
  }
  return distances;
}
