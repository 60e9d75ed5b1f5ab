import { heading } from './differences.js';
import { trackOf, tracks } from './tracks.js';

/** @import { Motion } from '../vendor/motionsplice.js' */

const SPREAD = 0.35; // seconds; long enough to level out a stride

/** A character's path without the sway of its steps, for the camera to follow. It uses later frames too, so it does not lag. */
export class Path {
  /** @param {Motion} motion */
  constructor(motion) {
    this.rate = motion.rate;
    const root = trackOf(motion, 0);
    this.count = root.length / 3;
    const { positions } = tracks(motion);
    const width = 3 * motion.rig.joints.length;
    const headings = new Float64Array(this.count);
    for (let frame = 0; frame < this.count; frame++) {
      const found = heading(positions.subarray(width * frame, width * (frame + 1)), motion.rig);
      const before = frame ? headings[frame - 1] : found;
      headings[frame] = found - 2 * Math.PI * Math.round((found - before) / (2 * Math.PI)); // no jump from one turn to the next
    }
    const axis = (/** @type {number} */ of) => Float64Array.from({ length: this.count }, (_, frame) => root[3 * frame + of]);
    this.values = [axis(0), axis(1), axis(2), headings].map((values) => smooth(values, SPREAD * motion.rate));
  }

  /**
   * Returns where the character is, and its heading in radians about Y.
   *
   * @param {number} time seconds
   */
  at(time) {
    const place = Math.max(0, Math.min(this.count - 1, time * this.rate));
    const before = Math.floor(place);
    const after = Math.min(before + 1, this.count - 1);
    const [x, y, z, turn] = this.values.map((values) => values[before] + (place - before) * (values[after] - values[before]));
    return { x, y, z, heading: turn };
  }
}

/**
 * Smooths values with a Gaussian. Beyond each end the curve continues as its point reflection, so straight lines stay straight.
 *
 * @param {Float64Array} values
 * @param {number} spread frames
 */
export function smooth(values, spread) {
  const last = values.length - 1;
  const reach = Math.min(last, Math.ceil(2.5 * spread));
  const weights = Array.from({ length: reach + 1 }, (_, away) => Math.exp(-0.5 * (away / Math.max(spread, 1e-6)) ** 2));
  const value = (/** @type {number} */ index) => {
    if (index < 0) return 2 * values[0] - values[-index];
    return index > last ? 2 * values[last] - values[2 * last - index] : values[index];
  };
  const total = weights.reduce((sum, weight, away) => sum + (away ? 2 : 1) * weight, 0);
  return values.map((own, index) => {
    let sum = own * weights[0];
    for (let away = 1; away <= reach; away++) sum += weights[away] * (value(index - away) + value(index + away));
    return sum / total;
  });
}
