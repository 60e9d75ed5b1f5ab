import { FormatError } from './errors.js';
import { Pose } from './pose.js';

/** @import { Frames } from './frames.js' */
/** @import { Rig } from './rig.js' */

/** The frames of a splice, which can be shown at any time. */
export class Motion {
  /** @type {[Frames, number][]} */
  held = [];
  /** @type {[Pose, Pose] | undefined} */
  poses = undefined;

  /**
   * @param {Rig} rig
   * @param {number} rate frames per second
   */
  constructor(rig, rate) {
    this.rig = rig;
    this.rate = rate;
  }

  /** Seconds from the first frame that is there to the last. */
  get duration() {
    return Math.max(0, this.held.length - 1) / this.rate;
  }

  /**
   * Adds a message of frames, which follows those that are there.
   *
   * @param {Frames} frames
   */
  add(frames) {
    const last = this.held.at(-1);
    const next = last ? last[0].frame + last[1] + 1 : frames.frame;
    if (frames.frame !== next) throw new FormatError(`frame: expected ${next}, found ${frames.frame}`);
    for (let index = 0; index < frames.count; index++) this.held.push([frames, index]);
    return this;
  }

  /**
   * Returns the pose at a time, between two frames; undefined if there are none. The next call changes it.
   *
   * @param {number} seconds since the first frame; the first and the last pose are held
   */
  pose(seconds) {
    if (!this.held.length) return undefined;
    const place = Math.max(0, Math.min(this.held.length - 1, seconds * this.rate));
    const before = Math.floor(place);
    const [a, b] = [this.held[before], this.held[Math.min(before + 1, this.held.length - 1)]];
    const [shown, next] = (this.poses ??= [Pose.for(a[0]), Pose.for(a[0])]);
    shown.read(a[0], a[1], 0);
    if (place > before) {
      next.read(b[0], b[1], 0);
      shown.mix(next, place - before);
    }
    return shown;
  }
}
