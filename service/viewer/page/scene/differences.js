/** How far apart two poses are, and the colours that show it. */

/** @import { Rig } from '../vendor/motionsplice.js' */

/** @typedef {'world' | 'root'} From */

/** Distance in metres at which the colours end. */
export const FULL = 0.2;

/** Colours of 0, 5, 10, 15 and 20 cm. They darken evenly, so that they can be distinguished without colour vision. */
export const STOPS = ['#dde3ea', '#f3c64b', '#ec7d2c', '#c8323f', '#7a1261'];

/**
 * Returns how far each joint of one pose is from that of another, in metres [J].
 *
 * @param {Float32Array} a positions of the joints in the world [J][3]
 * @param {Float32Array} b of the other pose
 * @param {Rig} rig of both
 * @param {From} [from] `world`: as they are; `root`: with the roots at the same place and the hips in the same heading
 * @param {Float32Array} [out] receives the distances
 */
export function distances(a, b, rig, from = 'world', out = new Float32Array(rig.joints.length)) {
  const isLocal = from === 'root';
  const turn = isLocal ? heading(a, rig) - heading(b, rig) : 0;
  const cos = Math.cos(turn), sin = Math.sin(turn);
  const [ax, ay, az, bx, by, bz] = isLocal ? [a[0], a[1], a[2], b[0], b[1], b[2]] : [0, 0, 0, 0, 0, 0];
  for (let joint = 0; joint < out.length; joint++) {
    const at = 3 * joint;
    const x = b[at] - bx, z = b[at + 2] - bz;
    out[joint] = Math.hypot(a[at] - ax - (cos * x + sin * z), a[at + 1] - ay - (b[at + 1] - by), a[at + 2] - az - (cos * z - sin * x));
  }
  return out;
}

/**
 * Returns the heading of the hips in radians about Y: 0 faces Z, and more is further to the left.
 *
 * @param {Float32Array} positions [J][3]
 * @param {Rig} rig
 */
export function heading(positions, rig) {
  const [left, right] = [jointOf(rig, 'left_hip'), jointOf(rig, 'right_hip')];
  return Math.atan2(-(positions[3 * left + 2] - positions[3 * right + 2]), positions[3 * left] - positions[3 * right]);
}

/**
 * Returns the joints of the upper body: all joints except the legs and their ancestors.
 *
 * @param {Rig} rig
 */
export function upperBody(rig) {
  const lower = new Set([0]);
  const hips = [jointOf(rig, 'left_hip'), jointOf(rig, 'right_hip')];
  for (const hip of hips) for (let joint = hip; joint >= 0; joint = rig.parents[joint]) lower.add(joint);
  return rig.joints.map((_, joint) => joint).filter((joint) => !lower.has(joint) && !isBelow(rig, joint, hips));
}

/**
 * Returns the joint with the largest distance among the given ones, and that distance.
 *
 * @param {Float32Array} values metres of each joint
 * @param {number[]} joints
 */
export function worst(values, joints) {
  const joint = joints.reduce((best, next) => (values[next] > values[best] ? next : best), joints[0] ?? 0);
  return { joint, metres: values[joint] ?? 0 };
}

/**
 * Returns the mean distance of the given joints, in metres.
 *
 * @param {Float32Array} values metres of each joint
 * @param {number[]} joints
 */
export function mean(values, joints) {
  return joints.length ? joints.reduce((sum, joint) => sum + values[joint], 0) / joints.length : 0;
}

/**
 * Returns the share of the colours' range of each distance, 0 to 1, as `Body.colours` takes them.
 *
 * @param {Float32Array} values metres
 * @param {Float32Array} [out]
 */
export function shares(values, out = new Float32Array(values.length)) {
  for (let index = 0; index < values.length; index++) out[index] = Math.min(1, values[index] / FULL);
  return out;
}

/**
 * Colours of 256 shares from 0 to 1: red, green and blue of light, 0 to 1 [256][3]. Equal steps look equal: they are mixed in
 * OKLab (B. Ottosson, A perceptual color space for image processing, 2020).
 */
export const COLOURS = colours();

function colours() {
  const stops = STOPS.map((stop) => lab([1, 3, 5].map((at) => light(parseInt(stop.slice(at, at + 2), 16) / 255))));
  const table = new Float32Array(256 * 3);
  for (let index = 0; index < 256; index++) {
    const place = (index / 255) * (stops.length - 1);
    const before = Math.min(stops.length - 2, Math.floor(place));
    table.set(rgb(stops[before].map((value, axis) => value + (place - before) * (stops[before + 1][axis] - value))), 3 * index);
  }
  return table;
}

/** @param {number} value of sRGB, 0 to 1 */
function light(value) {
  return value <= 0.04045 ? value / 12.92 : ((value + 0.055) / 1.055) ** 2.4;
}

/** @param {number[]} colour */
function lab([r, g, b]) {
  const l = Math.cbrt(0.4122214708 * r + 0.5363325363 * g + 0.0514459929 * b);
  const m = Math.cbrt(0.2119034982 * r + 0.6806995451 * g + 0.1073969566 * b);
  const s = Math.cbrt(0.0883024619 * r + 0.2817188376 * g + 0.6299787005 * b);
  return [
    0.2104542553 * l + 0.793617785 * m - 0.0040720468 * s, 1.9779984951 * l - 2.428592205 * m + 0.4505937099 * s,
    0.0259040371 * l + 0.7827717662 * m - 0.808675766 * s,
  ];
}

/** @param {number[]} colour */
function rgb([lightness, a, b]) {
  const l = (lightness + 0.3963377774 * a + 0.2158037573 * b) ** 3;
  const m = (lightness - 0.1055613458 * a - 0.0638541728 * b) ** 3;
  const s = (lightness - 0.0894841775 * a - 1.291485548 * b) ** 3;
  return [
    4.0767416621 * l - 3.3077115913 * m + 0.2309699292 * s, -1.2684380046 * l + 2.6097574011 * m - 0.3413193965 * s,
    -0.0041960863 * l - 0.7034186147 * m + 1.707614701 * s,
  ].map((value) => Math.max(0, Math.min(1, value)));
}

/**
 * @param {Rig} rig
 * @param {string} role
 */
function jointOf(rig, role) {
  return Math.max(0, rig.joints.indexOf(/** @type {string} */ (rig.roles[role])));
}

/**
 * @param {Rig} rig
 * @param {number} joint
 * @param {number[]} tops
 */
function isBelow(rig, joint, tops) {
  for (let above = rig.parents[joint]; above >= 0; above = rig.parents[above]) if (tops.includes(above)) return true;
  return false;
}
