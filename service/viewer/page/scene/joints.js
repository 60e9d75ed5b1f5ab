import { DataTexture, FloatType, RGBAFormat, Skeleton } from '../vendor/three.js';

/** @import { Vector } from './vectors.js' */

/** The joints' matrices of a body, in a texture for the vertex shader. */
export class Joints extends Skeleton {
  /** @param {Vector[]} places of the joints in the bind pose */
  constructor(places) {
    super([]);
    this.places = Float32Array.from(places.flat());
    const size = 4 * Math.ceil(Math.sqrt(4 * places.length) / 4); // a joint's four texels are in one row
    this.matrices = new Float32Array(4 * size * size);
    this.boneMatrices = this.matrices;
    this.boneTexture = new DataTexture(this.matrices, size, size, RGBAFormat, FloatType);
  }

  /**
   * Writes the matrices that take each joint from the bind pose to the world.
   *
   * @param {Float32Array} positions [J][3]
   * @param {ArrayLike<number>} turns [J][4]
   * @param {ArrayLike<number>} offset metres, [3]
   */
  set(positions, turns, offset) {
    const { places, matrices: out } = this;
    const [ox, oy, oz] = [offset[0], offset[1], offset[2]];
    for (let at = 0, turn = 0, to = 0; at < places.length; at += 3, turn += 4, to += 16) {
      const x = turns[turn], y = turns[turn + 1], z = turns[turn + 2], w = turns[turn + 3];
      const a = places[at], b = places[at + 1], c = places[at + 2];
      const xx = 1 - 2 * (y * y + z * z), xy = 2 * (x * y + w * z), xz = 2 * (x * z - w * y);
      const yx = 2 * (x * y - w * z), yy = 1 - 2 * (x * x + z * z), yz = 2 * (y * z + w * x);
      const zx = 2 * (x * z + w * y), zy = 2 * (y * z - w * x), zz = 1 - 2 * (x * x + y * y);
      out[to] = xx, out[to + 1] = xy, out[to + 2] = xz;
      out[to + 4] = yx, out[to + 5] = yy, out[to + 6] = yz;
      out[to + 8] = zx, out[to + 9] = zy, out[to + 10] = zz;
      out[to + 12] = positions[at] + ox - (xx * a + yx * b + zx * c);
      out[to + 13] = positions[at + 1] + oy - (xy * a + yy * b + zy * c);
      out[to + 14] = positions[at + 2] + oz - (xz * a + yz * b + zz * c);
      out[to + 15] = 1;
    }
    /** @type {DataTexture} */ (this.boneTexture).needsUpdate = true;
  }

  /** Nothing: `set` has written the matrices. @override */
  update() {}
}
