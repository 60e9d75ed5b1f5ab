/** @import { Pose, Rig } from '../vendor/motionsplice.js' */
/** @import { Vector } from '../scene/vectors.js' */

export const NUMBERS = 12; // of a matrix: its first three rows

/** Computes the matrices of a rig's joints, which take a body from its bind pose to a pose in the world. */
export class Bones {
  #rig;
  #places;
  #turns;
  #positions;

  /**
   * @param {Rig} rig
   * @param {Vector[]} places of the joints in the bind pose
   */
  constructor(rig, places) {
    this.#rig = rig;
    this.#places = Float64Array.from(places.flat());
    this.#turns = new Float64Array(4 * places.length);
    this.#positions = new Float64Array(3 * places.length);
  }

  /**
   * Writes the matrices [J][3][4] of a pose, at a place on the floor.
   *
   * @param {Pose} pose of a character that is kept in place
   * @param {number} heading radians
   * @param {number} x metres
   * @param {number} z metres
   * @param {Float32Array} out
   * @param {number} at where the first matrix begins in `out`
   */
  write(pose, heading, x, z, out, at) {
    const { parents, offsets } = this.#rig;
    const places = this.#places, turns = this.#turns, positions = this.#positions;
    const { root } = pose;
    const local = /** @type {Float32Array} */ (pose.rotations);
    const sine = Math.sin(heading / 2), cosine = Math.cos(heading / 2);
    const along = Math.sin(heading), across = Math.cos(heading);
    for (let joint = 0, to = at; joint < parents.length; joint++, to += NUMBERS) {
      const i = 3 * joint, k = 4 * joint, parent = parents[joint];
      // The parent's turn; the root's is the heading.
      let px = 0, py = sine, pz = 0, pw = cosine;
      let cx = x + across * root[0] + along * root[2], cy = root[1], cz = z + across * root[2] - along * root[0];
      if (parent >= 0) {
        px = turns[4 * parent], py = turns[4 * parent + 1], pz = turns[4 * parent + 2], pw = turns[4 * parent + 3];
        const a = offsets[i], b = offsets[i + 1], c = offsets[i + 2];
        const u = 2 * (py * c - pz * b), v = 2 * (pz * a - px * c), t = 2 * (px * b - py * a); // twice the cross product
        cx = positions[3 * parent] + a + pw * u + py * t - pz * v;
        cy = positions[3 * parent + 1] + b + pw * v + pz * u - px * t;
        cz = positions[3 * parent + 2] + c + pw * t + px * v - py * u;
      }
      positions[i] = cx, positions[i + 1] = cy, positions[i + 2] = cz;
      const lx = local[k], ly = local[k + 1], lz = local[k + 2], lw = local[k + 3];
      const qx = pw * lx + px * lw + py * lz - pz * ly, qy = pw * ly - px * lz + py * lw + pz * lx;
      const qz = pw * lz + px * ly - py * lx + pz * lw, qw = pw * lw - px * lx - py * ly - pz * lz;
      turns[k] = qx, turns[k + 1] = qy, turns[k + 2] = qz, turns[k + 3] = qw;
      const xx = 1 - 2 * (qy * qy + qz * qz), xy = 2 * (qx * qy - qw * qz), xz = 2 * (qx * qz + qw * qy);
      const yx = 2 * (qx * qy + qw * qz), yy = 1 - 2 * (qx * qx + qz * qz), yz = 2 * (qy * qz - qw * qx);
      const zx = 2 * (qx * qz - qw * qy), zy = 2 * (qy * qz + qw * qx), zz = 1 - 2 * (qx * qx + qy * qy);
      const a = places[i], b = places[i + 1], c = places[i + 2];
      out[to] = xx, out[to + 1] = xy, out[to + 2] = xz, out[to + 3] = cx - (xx * a + xy * b + xz * c);
      out[to + 4] = yx, out[to + 5] = yy, out[to + 6] = yz, out[to + 7] = cy - (yx * a + yy * b + yz * c);
      out[to + 8] = zx, out[to + 9] = zy, out[to + 10] = zz, out[to + 11] = cz - (zx * a + zy * b + zz * c);
    }
  }
}
