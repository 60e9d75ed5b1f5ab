import { Shape, along } from './shape.js';
import { addFoot } from './foot.js';
import { addHand } from './hand.js';
import { Limb } from './limb.js';
import { between, minus, norm, plus, times } from './vectors.js';

/** @import { Anatomy, Half } from './anatomy.js' */

/** How much lighter the left limbs are than the trunk, and darker the right ones. */
export const SHADE = { left: 0.21, right: -0.42 };

// Tables of places and half widths in metres of a body of 1.78 m.
const UPPER_ARM = [[0, 0.052, 0.054], [0.3, 0.049, 0.051], [0.6, 0.044, 0.046], [1, 0.04, 0.04]];
const FOREARM = [[0, 0.037, 0.037], [0.22, 0.043, 0.041], [0.6, 0.036, 0.033], [1, 0.027, 0.021]];
const THIGH = [[0, 0.071, 0.074], [0.14, 0.081, 0.088], [0.35, 0.078, 0.084], [0.7, 0.062, 0.066], [1, 0.053, 0.055]];
const SHIN = [[0, 0.05, 0.052], [0.12, 0.05, 0.054], [0.3, 0.055, 0.06], [0.65, 0.042, 0.044], [1, 0.035, 0.038]];
const SHIN_FORWARD = [[0, 0], [0.12, 0.002], [0.32, -0.016], [0.65, -0.006], [1, 0]]; // the calf is behind the bone
const COLLAR = [[0, 0.052, 0.05], [0.5, 0.05, 0.048], [1, 0.052, 0.05]];
// Share of the way from the hips to the shoulders; half width, half depth, metres forward.
const TRUNK = [
  [-0.15, 0.06, 0.05, -0.004], [-0.11, 0.11, 0.074, -0.01], [-0.02, 0.157, 0.108, -0.01], [0.08, 0.158, 0.113, -0.012], [0.22, 0.145, 0.1, -0.004],
  [0.4, 0.134, 0.092, 0.008], [0.55, 0.143, 0.102, 0.01], [0.75, 0.166, 0.119, 0.01], [0.88, 0.173, 0.114, 0.004], [0.97, 0.15, 0.093, -0.006],
  [1.04, 0.1, 0.072, -0.01], [1.1, 0.055, 0.058, -0.006],
];
const RINGS = 36; // of the trunk
const TRUNK_LENGTH = 0.515; // metres from the hips to the shoulders in a body of 1.78 m
// Metres over the joint of the head; half width, half depth, metres forward.
const HEAD = [
  [-0.052, 0.024, 0.028, 0.058], [-0.044, 0.039, 0.042, 0.05], [-0.02, 0.053, 0.064, 0.036], [0.02, 0.065, 0.084, 0.022], [0.06, 0.073, 0.095, 0.014],
  [0.1, 0.076, 0.099, 0.006], [0.135, 0.069, 0.09, 0.002], [0.16, 0.053, 0.069, 0], [0.172, 0.038, 0.05, 0], [0.18, 0.02, 0.027, 0],
];

/**
 * Returns the surface of a mannequin in a rig's proportions.
 *
 * @param {Anatomy} anatomy
 * @param {Shape} [shape] to which it is added
 */
export function mannequin(anatomy, shape = new Shape()) {
  const limb = new Limb(anatomy, shape);
  addTrunk(anatomy, shape);
  addHead(anatomy, shape);
  for (const half of /** @type {Half[]} */ (['left', 'right'])) {
    const shade = SHADE[half];
    const role = (/** @type {string} */ name) => anatomy.role(`${half}_${name}`);
    const collar = anatomy.path(anatomy.chest, role('shoulder'));
    const isBound = collar.length > 2; // has a joint of its own
    limb.add(isBound ? collar.slice(1) : collar, COLLAR, { shade: 0, from: isBound ? 0.3 : 0.35 });
    limb.add(anatomy.path(role('shoulder'), role('elbow')), UPPER_ARM, { shade, fade: 0.2 });
    limb.add(anatomy.path(role('elbow'), role('wrist')), FOREARM, { shade, v: anatomy.left, u: anatomy.forward });
    addHand(anatomy, shape, half, shade);
    const foot = anatomy.foot(half);
    limb.add(anatomy.path(role('hip'), role('knee')), THIGH, { shade, fade: 0.22, sides: 22, u: foot.left, v: foot.forward });
    limb.add(anatomy.path(role('knee'), role('ankle')), SHIN, { shade, u: foot.left, v: foot.forward, shift: SHIN_FORWARD });
    addFoot(anatomy, shape, half, shade);
  }
  return shape;
}

/**
 * @param {Anatomy} anatomy
 * @param {Shape} shape
 */
function addTrunk(anatomy, shape) {
  const { size, left, forward, chest, hips } = anatomy;
  const top = shoulderHeight(anatomy);
  const spine = anatomy.path(hips, chest);
  const hipWidth = norm(minus(anatomy.places[anatomy.role('left_hip')], anatomy.places[anatomy.role('right_hip')])) / 2 || 0.09 * size;
  const hipScale = Math.min(1.25, Math.max(0.85, hipWidth / (0.09 * size)));
  const narrow = Math.max(0.85, Math.min(1.1, Math.sqrt(top / (TRUNK_LENGTH * size)))); // a short trunk is narrower too
  const rings = [];
  for (let step = 0; step <= RINGS; step++) {
    const share = -0.15 + (1.25 * step) / RINGS;
    const [a, b, ahead] = along(TRUNK, share);
    const wide = share < 0.4 ? 1 + (hipScale - 1) * Math.min(1, (0.4 - share) / 0.3) : 1;
    const at = plus(axisAt(anatomy, share * top), times(forward, ahead * size));
    const joints = weights(anatomy, spine, share * top);
    rings.push({ at, u: left, v: forward, a: a * size * wide * narrow, b: b * size * narrow, joints, between: strongest(joints), power: 2.3 });
  }
  shape.tube([closing(rings[0], anatomy, -0.02), ...rings, closing(rings[RINGS], anatomy, 0.01)], 0, 28);
}

/**
 * @param {Anatomy} anatomy
 * @param {Shape} shape
 */
function addHead(anatomy, shape) {
  const { size, left, forward, head, places, chest } = anatomy;
  const neck = anatomy.path(chest, head);
  const [low, high] = [0.93 * shoulderHeight(anatomy), anatomy.height(places[head])];
  const rings = [];
  for (let step = 0; step <= 8; step++) {
    const height = low + ((high + 0.02 * size - low) * step) / 8;
    const joints = weights(anatomy, neck, height);
    const wide = (0.06 - 0.01 * Math.min(1, step / 4)) * size;
    rings.push({ at: axisAt(anatomy, height), u: left, v: forward, a: wide, b: wide, joints, between: strongest(joints) });
  }
  shape.tube(rings, 0);
  const own = { joints: /** @type {[number, number][]} */ ([[head, 1]]), between: /** @type {[number, number, number]} */ ([head, head, 0]) };
  const lowest = HEAD[0][0], span = HEAD[HEAD.length - 1][0] - lowest;
  const skull = Array.from({ length: 21 }, (_, step) => {
    const up = lowest + span * Math.sin((step / 20) * (Math.PI / 2)); // closer together where the top is round
    return [up, ...along(HEAD, up)];
  }).map(([up, a, b, ahead]) => ({
    at: plus(places[head], plus(times(anatomy.up, up * size), times(forward, ahead * size))), u: left, v: forward, a: a * size, b: b * size, ...own,
  }));
  shape.tube([closing(skull[0], anatomy, -0.004), ...skull, closing(skull[skull.length - 1], anatomy, 0.006)], 0.05, 28);
  const nose = [[0.045, 0.006, 0.006], [0.022, 0.011, 0.014], [0.004, 0.013, 0.018], [-0.004, 0.008, 0.01]].map(([up, a, b]) => ({
    at: plus(places[head], plus(times(anatomy.up, (up + 0.02) * size), times(forward, 0.105 * size))), u: left, v: forward, a: a * size, b: b * size, ...own,
  }));
  shape.tube([closing(nose[0], anatomy, 0.006), ...nose, closing(nose[3], anatomy, -0.003)], 0.05, 8);
}

/**
 * Height of the shoulders over the hips. In rigs whose collars are bound pointing up, that of the collars.
 *
 * @param {Anatomy} anatomy
 */
function shoulderHeight(anatomy) {
  const sides = /** @type {Half[]} */ (['left', 'right']).map((half) => {
    const path = anatomy.path(anatomy.chest, anatomy.role(`${half}_shoulder`));
    const end = anatomy.places[path[path.length - 1]];
    const start = anatomy.places[path[path.length > 2 ? path.length - 2 : 0]];
    const isRaised = path.length > 2 && anatomy.height(end) - anatomy.height(start) > 0.09 * anatomy.size;
    return anatomy.height(isRaised ? start : end);
  });
  const highest = anatomy.height(anatomy.places[anatomy.head]) - 0.06 * anatomy.size;
  return Math.min(highest, (sides[0] + sides[1]) / 2);
}

/**
 * Returns the middle of the trunk or the neck at a height over the hips.
 *
 * @param {Anatomy} anatomy
 * @param {number} height
 */
function axisAt(anatomy, height) {
  const { places, middle, up } = anatomy;
  const line = [middle, ...anatomy.path(anatomy.hips, anatomy.head).slice(1).map((joint) => places[joint])];
  let next = line.findIndex((place) => anatomy.height(place) > height);
  if (next < 0) next = line.length;
  const before = line[Math.max(0, next - 1)];
  const after = line[next];
  if (next === 0 || !after) return plus(before, times(up, height - anatomy.height(before)));
  const span = anatomy.height(after) - anatomy.height(before);
  return span > 1e-6 ? between(before, after, Math.max(0, Math.min(1, (height - anatomy.height(before)) / span))) : before;
}

/**
 * Returns how much the joints of a chain move what is at a height: half each at a joint, wholly in the middle of a bone.
 *
 * @param {Anatomy} anatomy
 * @param {number[]} chain
 * @param {number} height
 * @returns {[number, number][]}
 */
function weights(anatomy, chain, height) {
  const distinct = chain.filter((joint, index) => index === chain.length - 1
    || anatomy.height(anatomy.places[chain[index + 1]]) - anatomy.height(anatomy.places[joint]) > 1e-4);
  for (let index = 1; index < distinct.length; index++) {
    const at = anatomy.height(anatomy.places[distinct[index]]);
    const below = anatomy.height(anatomy.places[distinct[index - 1]]);
    const above = distinct[index + 1] === undefined ? at + (at - below) : anatomy.height(anatomy.places[distinct[index + 1]]);
    if (height < (at + above) / 2) {
      const share = height < at ? 0.5 + (height - at) / (at - below) : 0.5 + (height - at) / (above - at);
      const clipped = Math.max(0, Math.min(1, share));
      return [[distinct[index - 1], 1 - clipped], [distinct[index], clipped]];
    }
  }
  return [[distinct[distinct.length - 1], 1]];
}

/**
 * @param {[number, number][]} joints
 * @returns {[number, number, number]}
 */
function strongest(joints) {
  return joints.length > 1 ? [joints[0][0], joints[1][0], joints[1][1]] : [joints[0][0], joints[0][0], 0];
}

/**
 * Returns the point that closes a tube beyond a ring.
 *
 * @template {import('./shape.js').Ring} T
 * @param {T} ring
 * @param {Anatomy} anatomy
 * @param {number} beyond metres
 */
function closing(ring, anatomy, beyond) {
  return { ...ring, at: plus(ring.at, times(anatomy.up, beyond * anatomy.size)), a: 0, b: 0 };
}

