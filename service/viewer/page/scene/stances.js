import { Anatomy } from './anatomy.js';
import { heightsOverSole } from './foot.js';
import { tracks } from './tracks.js';
import { cross, plus, times } from './vectors.js';

/** @import { Motion } from '../vendor/motionsplice.js' */
/** @import { Half } from './anatomy.js' */
/** @import { Vector } from './vectors.js' */

/** @typedef {{ left: [number, number][], right: [number, number][] }} Contacts seconds of each stance */

const NEAR = 0.13; // metres

/**
 * A foot that stands.
 *
 * @typedef {object} Stance
 * @property {Half} half
 * @property {number} from seconds
 * @property {number} to
 * @property {Vector} at on the ground, under the ankle
 * @property {number} heading radians about Y
 */

/**
 * Returns where the feet stand. The ground of a stance is below the lowest ankle and toe of that stance by the height of these
 * joints over the sole, so stairs come out as steps.
 *
 * @param {Motion} motion
 * @param {Contacts} contacts
 * @returns {Stance[]} in the order of time
 */
export function stancesOf(motion, contacts) {
  const { rig, rate } = motion;
  const anatomy = new Anatomy(rig);
  const { count, positions, turns } = tracks(motion);
  const joints = rig.joints.length;
  /** @type {Stance[]} */
  const stances = [];
  for (const half of /** @type {Half[]} */ (['left', 'right'])) {
    const [ankle, toe] = [anatomy.role(`${half}_ankle`), anatomy.role(`${half}_toe`, `${half}_ankle`)];
    const { forward } = anatomy.foot(half);
    const over = heightsOverSole(anatomy, half);
    for (const [from, to] of contacts[half]) {
      const first = Math.max(0, Math.ceil(from * rate - 1e-3));
      const last = Math.min(count - 1, Math.floor(to * rate + 1e-3));
      if (last < first) continue;
      let ground = Infinity, flattest = first, least = Infinity;
      for (let frame = first; frame <= last; frame++) {
        const [low, high] = [toe, ankle].map((joint) => positions[3 * (frame * joints + joint) + 1]);
        const back = high - over.ankle, front = toe === ankle ? back : low - over.toe; // height of the sole
        ground = Math.min(ground, back, front);
        const slope = Math.abs(back - front);
        const later = Math.abs(frame - (first + last) / 2) * 1e-4; // prefers the middle of equally flat frames
        if (slope + later < least) [flattest, least] = [frame, slope + later];
      }
      const row = flattest * joints + ankle;
      const [x, , z] = rotated(/** @type {number[]} */ ([...turns.subarray(4 * row, 4 * row + 4)]), forward);
      stances.push({ half, from, to, at: [positions[3 * row], ground, positions[3 * row + 2]], heading: Math.atan2(x, z) });
    }
  }
  return stances.sort((a, b) => a.from - b.from);
}

/**
 * Returns the height of the clip's own floor: the lowest ground. If that is far above 0, the clip only stands on stairs, and the floor is at 0.
 *
 * @param {Stance[]} stances
 */
export function floorOf(stances) {
  const lowest = Math.min(...stances.map(({ at }) => at[1]));
  return lowest < NEAR ? lowest : 0;
}

/**
 * Returns the height of the ground at each frame: between the steps, along lines.
 *
 * @param {Stance[]} stances in the order of time
 * @param {number} count frames
 * @param {number} rate
 */
export function groundOf(stances, count, rate) {
  const known = stances.map(({ from, to, at }) => ({ time: (from + to) / 2, height: at[1] })).sort((a, b) => a.time - b.time);
  return Float32Array.from({ length: count }, (_, frame) => {
    const time = frame / rate;
    const next = known.findIndex((stance) => stance.time > time);
    if (!known.length) return 0;
    if (next <= 0) return known[next < 0 ? known.length - 1 : 0].height;
    const [a, b] = [known[next - 1], known[next]];
    return a.height + ((time - a.time) / (b.time - a.time)) * (b.height - a.height);
  });
}

/**
 * @param {number[]} turn
 * @param {Vector} vector
 */
function rotated([x, y, z, w], vector) {
  const axis = /** @type {Vector} */ ([x, y, z]);
  const t = times(cross(axis, vector), 2);
  return plus(vector, plus(times(t, w), cross(axis, t)));
}
