import { cross, dot, minus, plus, times } from './vectors.js';

/** @import { Vector } from './vectors.js' */

/**
 * A ring of a tube.
 *
 * @typedef {object} Ring
 * @property {Vector} at its centre in the bind pose
 * @property {Vector} u axis of its first radius
 * @property {Vector} v axis of its second radius
 * @property {number} a first radius; 0 closes the tube
 * @property {number} b second radius
 * @property {[number, number][]} joints that move it, with their weights; at most 4
 * @property {[number, number, number]} between the joints whose values colour it, and the share of the second
 * @property {number} [shade] instead of the tube's
 * @property {number} [power] of the ellipse: 2 is round, more is squarer
 */

/** A surface of tubes that joints move. */
export class Shape {
  /** @type {number[]} */
  positions = [];
  /** @type {number[]} */
  indices = [];
  /** @type {number[]} */
  skinIndices = [];
  /** @type {number[]} */
  skinWeights = [];
  /** Joints whose values colour a vertex [V][2]. @type {number[]} */
  colourJoints = [];
  /** Share of the second of them [V]. @type {number[]} */
  colourShares = [];
  /** Lightness of a vertex against the body's colour [V], -1 to 1. @type {number[]} */
  shades = [];

  /**
   * Adds a tube through rings.
   *
   * @param {Ring[]} rings
   * @param {number} shade
   * @param {number} [sides]
   */
  tube(rings, shade, sides = 16) {
    const isInside = dot(cross(rings[0].u, rings[0].v), minus(rings[rings.length - 1].at, rings[0].at)) < 0;
    let before = this.#ring(rings[0], shade, sides);
    for (const ring of rings.slice(1)) {
      const next = this.#ring(ring, shade, sides);
      for (let side = 0; side < sides; side++) {
        const other = (side + 1) % sides;
        const [a, b] = before.length > 1 ? [before[side], before[other]] : [before[0], before[0]];
        const [c, d] = next.length > 1 ? [next[side], next[other]] : [next[0], next[0]];
        if (a !== b) this.indices.push(...(isInside ? [a, d, b] : [a, b, d]));
        if (c !== d) this.indices.push(...(isInside ? [a, c, d] : [a, d, c]));
      }
      before = next;
    }
  }

  /**
   * @param {Ring} ring
   * @param {number} shade
   * @param {number} sides
   */
  #ring({ at, u, v, a, b, joints, between, power = 2, shade: own }, shade, sides) {
    const count = a > 0 && b > 0 ? sides : 1;
    return Array.from({ length: count }, (_, side) => {
      const angle = (2 * Math.PI * side) / sides;
      const x = count > 1 ? a * rounded(Math.cos(angle), power) : 0;
      const y = count > 1 ? b * rounded(Math.sin(angle), power) : 0;
      this.positions.push(...plus(at, plus(times(u, x), times(v, y))));
      for (let slot = 0; slot < 4; slot++) {
        this.skinIndices.push(joints[slot]?.[0] ?? 0);
        this.skinWeights.push(joints[slot]?.[1] ?? 0);
      }
      this.colourJoints.push(between[0], between[1]);
      this.colourShares.push(between[2]);
      this.shades.push(own ?? shade);
      return this.shades.length - 1;
    });
  }
}

/**
 * @param {number} value
 * @param {number} power
 */
function rounded(value, power) {
  return Math.sign(value) * Math.abs(value) ** (2 / power);
}

/**
 * Returns a value of a table at a place, smoothly between its rows. Each row is a place and its values.
 *
 * @param {number[][]} table
 * @param {number} place
 */
export function along(table, place) {
  const last = table.length - 1;
  if (place <= table[0][0]) return table[0].slice(1);
  if (place >= table[last][0]) return table[last].slice(1);
  const next = table.findIndex((row) => row[0] > place);
  const [from, to] = [table[next - 1], table[next]];
  const share = (place - from[0]) / (to[0] - from[0]);
  const slope = (/** @type {number} */ row, /** @type {number} */ column) => {
    const [before, after] = [table[Math.max(0, row - 1)], table[Math.min(last, row + 1)]];
    return ((after[column] - before[column]) / (after[0] - before[0])) * (to[0] - from[0]);
  };
  return from.slice(1).map((start, index) => { // a cubic curve through all rows
    const column = index + 1;
    const [m, n] = [slope(next - 1, column), slope(next, column)];
    const s = share, end = to[column];
    return (2 * s ** 3 - 3 * s ** 2 + 1) * start + (s ** 3 - 2 * s ** 2 + s) * m + (3 * s ** 2 - 2 * s ** 3) * end + (s ** 3 - s ** 2) * n;
  });
}
