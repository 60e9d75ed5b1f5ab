import { along } from './shape.js';
import { across, cross, minus, norm, plus, times, unit } from './vectors.js';

/** @import { Anatomy } from './anatomy.js' */
/** @import { Ring, Shape } from './shape.js' */
/** @import { Vector } from './vectors.js' */

/**
 * How a limb is drawn.
 *
 * @typedef {object} Look
 * @property {number} shade
 * @property {Vector} [u] axis of the table's first width
 * @property {Vector} [v] of its second
 * @property {number[][]} [shift] how far the limb is moved along v
 * @property {number} [from] share at which it begins
 * @property {number} [fade] share over which the shade sets in, which hides the edge between limb and trunk
 * @property {number} [sides]
 * @property {number} [scale] of the widths; the body's by default
 */

/** Adds limbs, each a tube from one joint to another. Twist joints between them move their part of it. */
export class Limb {
  /**
   * @param {Anatomy} anatomy
   * @param {Shape} shape
   */
  constructor(anatomy, shape) {
    this.anatomy = anatomy;
    this.shape = shape;
  }

  /**
   * @param {number[]} path joints, each below the one before
   * @param {number[][]} table share of the length, and two half widths
   * @param {Look} look
   */
  add(path, table, look) {
    const { places, size } = this.anatomy;
    const { shade, shift, fade = 0, from = 0, sides = 14, scale = size } = look;
    const lengths = path.slice(1).map((joint, index) => norm(minus(places[joint], places[path[index]])));
    const whole = lengths.reduce((sum, length) => sum + length, 0);
    if (whole < 1e-4) return;
    let done = 0;
    lengths.forEach((length, index) => {
      const [first, last] = [done / whole, (done + length) / whole];
      done += length;
      if (length < 1e-4 || last <= from) return;
      const [start, end] = [places[path[index]], places[path[index + 1]]];
      const axis = unit(minus(end, start));
      const v = across(look.v ?? cross(axis, look.u ?? [0, 0, 1]), axis, [0, 0, 1]);
      const u = cross(v, axis);
      /** @type {(share: number, along: number, narrow: number) => Ring} */
      const ring = (share, beyond, narrow) => {
        const [a, b] = along(table, share);
        const at = plus(plus(start, times(minus(end, start), (share - first) / (last - first))), times(axis, beyond * b * scale));
        const moved = shift ? along(shift, share)[0] * scale : 0;
        const joints = /** @type {[number, number][]} */ ([[path[index], 1]]);
        return {
          at: plus(at, times(v, moved)), u, v, a: a * scale * narrow, b: b * scale * narrow, joints,
          between: [path[0], path[path.length - 1], Math.max(0, Math.min(1, share))],
          shade: shade * (fade ? Math.max(0, Math.min(1, (share - 0.3 * fade) / fade)) : 1),
        };
      };
      const begin = Math.max(first, from);
      const steps = Math.max(2, Math.ceil(8 * (last - begin)));
      const rings = CAP.map(([beyond, narrow]) => ring(begin, -beyond, narrow));
      for (let step = 0; step <= steps; step++) rings.push(ring(begin + ((last - begin) * step) / steps, 0, 1));
      rings.push(...CAP.map(([beyond, narrow]) => ring(last, beyond, narrow)).reverse());
      this.shape.tube(rings, shade, sides);
    });
  }
}

const CAP = [90, 65, 42, 20].map((angle) => [Math.sin((angle * Math.PI) / 180), angle === 90 ? 0 : Math.cos((angle * Math.PI) / 180)]);
