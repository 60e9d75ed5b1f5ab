import { Limb } from './limb.js';
import { across, cross, dot, minus, norm, plus, times, unit } from './vectors.js';

/** @import { Anatomy, Half } from './anatomy.js' */
/** @import { Ring, Shape } from './shape.js' */
/** @import { Vector } from './vectors.js' */

// Metres from the wrist; half width, half thickness, metres towards the palm.
const MITTEN = [
  [-0.01, 0.026, 0.02, 0], [0.02, 0.033, 0.018, 0], [0.055, 0.041, 0.017, 0.001], [0.09, 0.042, 0.015, 0.004], [0.125, 0.038, 0.012, 0.012],
  [0.155, 0.031, 0.01, 0.024], [0.175, 0.018, 0.007, 0.034],
];
const FINGER = [[0, 0.0095, 0.009], [1, 0.0085, 0.0078]];
const THUMB = [[0, 0.0135, 0.012], [1, 0.0115, 0.01]];

/**
 * Adds a hand: fingers where the rig has joints for three or more, else a mitten with a thumb.
 *
 * @param {Anatomy} anatomy
 * @param {Shape} shape
 * @param {Half} half
 * @param {number} shade
 */
export function addHand(anatomy, shape, half, shade) {
  const wrist = anatomy.role(`${half}_wrist`);
  const place = anatomy.places[wrist];
  const bases = anatomy.children[wrist].filter((joint) => norm(minus(anatomy.places[joint], place)) > 0.005 * anatomy.size
    && anatomy.children[joint].length > 0);
  const fingers = bases.filter((joint) => !/thumb/i.test(anatomy.rig.joints[joint]));
  const forearm = unit(minus(place, anatomy.places[anatomy.parent(wrist)]));
  if (fingers.length < 3) {
    const thumb = across(anatomy.forward, forearm);
    addMitten(anatomy, shape, { joint: wrist, place, ahead: forearm, thumb, palm: palmOf(half, forearm, thumb) }, shade);
    return;
  }
  const knuckles = fingers.map((joint) => anatomy.places[joint]);
  const ahead = unit(minus(knuckles.reduce((sum, knuckle) => plus(sum, times(knuckle, 1 / knuckles.length)), /** @type {Vector} */ ([0, 0, 0])), place));
  const thumbs = bases.filter((joint) => !fingers.includes(joint));
  const side = across(thumbs.length ? minus(anatomy.places[thumbs[0]], place) : anatomy.forward, ahead);
  const spread = across(farthest(knuckles, side), ahead, side);
  addPalm(anatomy, shape, { joint: wrist, place, ahead, thumb: dot(spread, side) < 0 ? times(spread, -1) : spread, palm: side }, knuckles, shade);
  const limb = new Limb(anatomy, shape);
  for (const base of bases) {
    const isThumb = !fingers.includes(base);
    for (const joint of [base, ...anatomy.below(base)]) {
      const from = anatomy.parent(joint);
      if (from !== wrist || isThumb) limb.add([from, joint], isThumb ? THUMB : FINGER, { shade, sides: 8 });
      if (!anatomy.children[joint].length) addTip(anatomy, shape, joint, isThumb ? 0.0105 : 0.008, shade);
    }
  }
}

/**
 * A hand in the bind pose.
 *
 * @typedef {object} Hand
 * @property {number} joint
 * @property {Vector} place
 * @property {Vector} ahead the way the fingers point
 * @property {Vector} thumb across, towards the thumb
 * @property {Vector} palm the way the palm looks
 */

/**
 * @param {Anatomy} anatomy
 * @param {Shape} shape
 * @param {Hand} hand
 * @param {number} shade
 */
function addMitten({ size }, shape, { joint, place, ahead, thumb, palm }, shade) {
  /** @type {(x: number, side: number, down: number, a: number, b: number) => Ring} */
  const ring = (x, side, down, a, b) => ({
    at: plus(place, plus(times(ahead, x * size), plus(times(thumb, side * size), times(palm, down * size)))),
    u: thumb, v: palm, a: a * size, b: b * size, joints: [[joint, 1]], between: [joint, joint, 0], power: a ? 2.4 : 2,
  });
  const rings = MITTEN.map(([x, a, b, down]) => ring(x, 0, down, a, b));
  shape.tube([ring(-0.012, 0, 0, 0, 0), ...rings, ring(0.181, 0, 0.037, 0, 0)], shade);
  const finger = [[0.02, 0.02, 0.002, 0.014], [0.045, 0.043, 0.006, 0.0135], [0.07, 0.056, 0.012, 0.012], [0.092, 0.062, 0.018, 0.0095]];
  const digits = finger.map(([x, side, down, wide]) => ring(x, side, down, wide, wide));
  shape.tube([ring(0.018, 0.018, 0.002, 0, 0), ...digits, ring(0.101, 0.063, 0.021, 0, 0)], shade, 10);
}

/**
 * @param {Anatomy} anatomy
 * @param {Shape} shape
 * @param {Hand} hand
 * @param {Vector[]} knuckles
 * @param {number} shade
 */
function addPalm({ size }, shape, { joint, place, ahead, thumb }, knuckles, shade) {
  const offsets = knuckles.map((knuckle) => minus(knuckle, place));
  const sides = offsets.map((offset) => dot(offset, thumb));
  const [low, high] = [Math.min(...sides) - 0.01 * size, Math.max(...sides) + 0.01 * size];
  const reach = offsets.reduce((sum, offset) => sum + dot(offset, ahead), 0) / offsets.length;
  const back = cross(ahead, thumb);
  const rows = [[-0.1, 0.55, 0.018], [0.2, 0.72, 0.018], [0.6, 0.95, 0.016], [0.95, 1, 0.0125], [1.06, 0.93, 0.009]];
  /** @type {Ring[]} */
  const rings = rows.map(([share, wide, thick]) => ({
    at: plus(place, plus(times(ahead, reach * share), times(thumb, ((low + high) / 2) * Math.max(0, share)))),
    u: thumb, v: back, a: ((high - low) / 2) * wide, b: thick * size, joints: [[joint, 1]], between: [joint, joint, 0], power: 2.8,
  }));
  shape.tube([{ ...rings[0], a: 0 }, ...rings, { ...rings[4], a: 0 }], shade);
}

/**
 * Adds the end of a finger, as long as most of the bone before it.
 *
 * @param {Anatomy} anatomy
 * @param {Shape} shape
 * @param {number} joint
 * @param {number} wide
 * @param {number} shade
 */
function addTip({ places, size, rig }, shape, joint, wide, shade) {
  const bone = minus(places[joint], places[rig.parents[joint]]);
  const axis = unit(bone);
  const u = across([0, 0, 1], axis);
  const reach = Math.min(0.8 * norm(bone), 0.026 * size);
  const rows = [[-0.006, 0], [0, 1], [0.5 * reach, 0.95], [0.85 * reach, 0.75], [reach, 0.4], [reach + 0.003 * size, 0]];
  shape.tube(rows.map(([x, share]) => ({
    at: plus(places[joint], times(axis, x)), u, v: cross(axis, u), a: wide * size * share, b: wide * size * share,
    joints: [[joint, 1]], between: [joint, joint, 0],
  })), shade, 8);
}

/**
 * Returns the way a palm looks when the thumb points across: down in a T-pose.
 *
 * @param {Half} half
 * @param {Vector} ahead
 * @param {Vector} thumb
 */
function palmOf(half, ahead, thumb) {
  return half === 'left' ? cross(ahead, thumb) : cross(thumb, ahead);
}

/**
 * Returns the vector between the two places that are farthest apart.
 *
 * @param {Vector[]} places
 * @param {Vector} fallback
 */
function farthest(places, fallback) {
  let best = times(fallback, 0.01);
  for (const a of places) for (const b of places) if (norm(minus(a, b)) > norm(best)) best = minus(a, b);
  return best;
}
