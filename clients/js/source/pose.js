import { bind } from './bones.js';
import { RigError } from './errors.js';

/** @import { Frames } from './frames.js' */
/** @import { Rig } from './rig.js' */
/** @import { Target } from './rest.js' */

/** A character at one moment. */
export class Pose {
  /**
   * @param {Rig} rig
   * @param {boolean} isLocal whether there are rotations
   * @param {boolean} isWorld whether there are positions of all joints
   */
  constructor(rig, isLocal, isWorld) {
    this.rig = rig;
    /** Position of the root [3]. */
    this.root = new Float32Array(3);
    /** Rotations [J][4] in the parents' frames, x, y, z, w; undefined with the parts `world`. */
    this.rotations = isLocal ? new Float32Array(4 * rig.joints.length) : undefined;
    /** Positions [J][3] of all joints, as sent; undefined with the parts `local`. */
    this.positions = isWorld ? new Float32Array(3 * rig.joints.length) : undefined;
  }

  /**
   * Returns a pose that can hold one of a message's.
   *
   * @param {Frames} frames
   */
  static for(frames) {
    return new Pose(frames.rig, frames.rotations !== undefined, frames.worldPositions !== undefined);
  }

  /**
   * Whether this pose can hold one of a message's.
   *
   * @param {Frames} frames
   */
  fits(frames) {
    return this.rig === frames.rig && !this.rotations === !frames.rotations && !this.positions === !frames.worldPositions;
  }

  /**
   * Copies a pose from a message.
   *
   * @param {Frames} frames
   * @param {number} number of the frame in the message, from 0
   * @param {number} row of the character
   */
  read(frames, number, row) {
    frames.copy(number, row, this.root, this.rotations, this.positions);
  }

  /**
   * Moves this pose towards another of the same rig: positions along a line, rotations along the shorter arc's chord,
   * normalised. At 30 degrees from one to the other that differs from the arc by at most 0.03 degrees.
   *
   * @param {Pose} other
   * @param {number} share 0 to 1
   */
  mix(other, share) {
    mixNumbers(this.root, other.root, share);
    if (this.positions && other.positions) mixNumbers(this.positions, other.positions, share);
    const { rotations } = this;
    const next = other.rotations;
    if (!rotations || !next) return;
    for (let at = 0; at < rotations.length; at += 4) {
      const x = next[at], y = next[at + 1], z = next[at + 2], w = next[at + 3];
      const dot = rotations[at] * x + rotations[at + 1] * y + rotations[at + 2] * z + rotations[at + 3] * w;
      const theirs = dot < 0 ? -share : share;
      const ours = 1 - share;
      const a = ours * rotations[at] + theirs * x, b = ours * rotations[at + 1] + theirs * y;
      const c = ours * rotations[at + 2] + theirs * z, d = ours * rotations[at + 3] + theirs * w;
      const length = Math.sqrt(a * a + b * b + c * c + d * d) || 1;
      rotations[at] = a / length;
      rotations[at + 1] = b / length;
      rotations[at + 2] = c / length;
      rotations[at + 3] = d / length;
    }
  }

  /**
   * Returns the positions [J][3] of all joints: those that were sent, or computed from the rotations.
   *
   * @param {Float32Array} [out]
   */
  worldPositions(out = new Float32Array(3 * this.rig.joints.length)) {
    if (this.rotations) this.rig.worldPositions(this.root, this.rotations, out);
    else if (this.positions) out.set(this.positions);
    return out;
  }

  /**
   * Puts three.js bones into this pose.
   *
   * @param {Target} target a loaded model, a skeleton, or a list of bones; their names are those of the joints
   * @throws {RigError} if the bones do not fit the joints
   */
  apply(target) {
    if (!this.rotations) throw new RigError('the parts `world` have no rotations for bones. Ask for `local` or `both`');
    bind(this.rig, target).set(this.root, this.rotations);
  }
}

/**
 * @param {Float32Array} ours
 * @param {Float32Array} theirs
 * @param {number} share
 */
function mixNumbers(ours, theirs, share) {
  for (let at = 0; at < ours.length; at++) ours[at] += share * (theirs[at] - ours[at]);
}
