import { along } from './shape.js';
import { plus, times } from './vectors.js';

/** @import { Anatomy, Half } from './anatomy.js' */
/** @import { Ring, Shape } from './shape.js' */
/** @import { Vector } from './vectors.js' */

const TOE_REACH = 0.135; // metres from the ankle to the ball of the foot
const TOE_HEIGHT = 0.02; // of the joint in the ball, over the sole
const ANKLE_HEIGHT = 0.07; // over the sole, in rigs without toes
// Metres ahead of the ankle; half width, lower edge and upper edge over the sole, metres inwards.
const FOOT = [
  [-0.066, 0.018, 0.014, 0.04, 0], [-0.058, 0.028, 0.004, 0.058, 0], [-0.035, 0.034, 0, 0.082, 0], [0, 0.036, 0, 0.094, 0], [0.035, 0.037, 0, 0.083, 0],
  [0.08, 0.041, 0, 0.062, 0.003], [0.12, 0.046, 0, 0.047, 0.006], [0.15, 0.047, 0, 0.04, 0.007],
];
const TOES = [
  [-0.02, 0.045, 0, 0.042, 0.007], [0.02, 0.046, 0, 0.037, 0.007], [0.045, 0.042, 0, 0.032, 0.009], [0.065, 0.032, 0.002, 0.027, 0.011], [0.076, 0.018, 0.006, 0.02, 0.013],
];

/**
 * How high the joints of a foot are over its sole, in metres.
 *
 * @param {Anatomy} anatomy
 * @param {Half} half
 */
export function heightsOverSole(anatomy, half) {
  const toe = TOE_HEIGHT * anatomy.size;
  const hasToe = anatomy.has(`${half}_toe`);
  return { toe, ankle: hasToe ? Math.max(0.04 * anatomy.size, anatomy.foot(half).drop + toe) : ANKLE_HEIGHT * anatomy.size };
}

/**
 * Adds a foot, and toes that the joint of the toes moves.
 *
 * @param {Anatomy} anatomy
 * @param {Shape} shape
 * @param {Half} half
 * @param {number} shade
 */
export function addFoot(anatomy, shape, half, shade) {
  const { size } = anatomy;
  const { left, forward, down, reach, toesForward, toesDown } = anatomy.foot(half);
  const [ankle, toe] = [anatomy.role(`${half}_ankle`), anatomy.role(`${half}_toe`, `${half}_ankle`)];
  const hasToe = toe !== ankle;
  const over = heightsOverSole(anatomy, half);
  const ball = hasToe ? reach : TOE_REACH * size;
  const inwards = times(left, half === 'left' ? -1 : 1);
  const tall = Math.max(0.75, Math.min(1.3, over.ankle / (0.066 * size))); // so that the ankle is inside
  /** @type {(row: number[], joint: number, origin: Vector, axes: [Vector, Vector], over: number, stretch: number) => Ring} */
  const ring = ([ahead, wide, low, high, inner], joint, origin, [front, below], height, stretch) => {
    const lift = high * (joint === ankle && ahead < 0.1 ? tall : 1);
    const at = plus(origin, plus(times(front, ahead * stretch), plus(times(below, height - (size * (low + lift)) / 2), times(inwards, inner * size))));
    const b = (size * (lift - low)) / 2;
    return { at, u: left, v: below, a: wide * size, b, joints: [[joint, 1]], between: [joint, joint, 0], power: 2.7 };
  };
  const stretch = ball / TOE_REACH;
  const back = [];
  for (let step = 0; step <= 12; step++) {
    const ahead = -0.066 + (0.216 * step) / 12;
    back.push(ring([ahead, ...along(FOOT, ahead)], ankle, anatomy.places[ankle], [forward, down], over.ankle, ahead < 0 ? size : stretch));
  }
  const base = hasToe ? anatomy.places[toe] : plus(anatomy.places[ankle], times(forward, ball));
  const axes = /** @type {[Vector, Vector]} */ (hasToe ? [toesForward, toesDown] : [forward, down]);
  const front = TOES.map((row) => ring(row, toe, base, axes, hasToe ? over.toe : over.ankle, size));
  const tip = front[front.length - 1];
  shape.tube([pointOf(back[0]), ...back, pointOf(back[12])], shade);
  shape.tube([pointOf(front[0]), ...front, { ...pointOf(tip), at: plus(tip.at, times(axes[0], 0.004 * size)) }], shade);
}

/** @param {Ring} ring @returns {Ring} */
function pointOf(ring) {
  return { ...ring, a: 0, b: 0 };
}
