import { Shape } from '../scene/shape.js';

/** @import { Ring } from '../scene/shape.js' */

const FEWEST = 5; // sides of a tube

/** A surface with fewer rings and sides, for bodies that are small on the screen. */
export class CoarseShape extends Shape {
  /** @param {number} factor by which there are fewer */
  constructor(factor) {
    super();
    this.factor = factor;
  }

  /**
   * @override
   * @param {Ring[]} rings
   * @param {number} shade
   * @param {number} [sides]
   */
  tube(rings, shade, sides = 16) {
    const last = rings.length - 1;
    const some = rings.filter((ring, index) => index === 0 || index === last || index % this.factor === 0);
    super.tube(some, shade, Math.max(FEWEST, Math.round(sides / this.factor)));
  }
}
