import { stepped } from './ground.js';

/** @import { Frames } from './frames.js' */
/** @import { Placed } from './ground.js' */

/**
 * One frame that is held: the `index`-th of a message, from 0.
 *
 * @typedef {object} Held
 * @property {Frames} frames
 * @property {number} index
 * @property {number} number
 * @property {number} due seconds by the service's clock
 * @property {Float64Array} grounds place and heading of each character, [n][4]
 */

/**
 * What to show: a frame, and if they are to be interpolated the next one, and how far it is from one to the other.
 *
 * @typedef {{ a: Held, b: Held | undefined, share: number }} Moment
 */

const REMEMBERED = 10; // seconds of samples
const FEW_LATER = 0.99; // share of the messages that arrive in time
const SLEW = 0.05; // seconds by which the delay may change in a second
const FIRST_LATENESS = 0.05; // seconds, until messages have been measured
const LONGEST_GAP = 0.25; // seconds between frames that are interpolated although others between them are missing

/** Holds frames and decides which to show: the protocol's "Between frames". All times are in seconds. */
export class Playback {
  /** @type {Held[]} */
  held = [];
  /** @type {{ at: number, value: number }[]} */
  samples = [];
  offset = 0;
  lateness = 0;
  /** @type {number | undefined} */
  delay = undefined;
  before = 0;
  newest = -1; // number of a frame

  /**
   * Takes a message.
   *
   * @param {Frames} frames
   * @param {number} now by the client's clock
   * @param {(id: number) => Placed | undefined} placed where a character was put last
   */
  take(frames, now, placed) {
    const { time = 0, frame, count, rate } = frames;
    if (frame > this.newest) this.measure(now, now - time); // others repeat frames, and are sent before they are due
    this.newest = Math.max(this.newest, frame + count - 1);
    this.discard(frame);
    for (let index = 0; index < count; index++) {
      const before = this.held.at(-1);
      const grounds = stepped(frames, index, before, placed);
      this.held.push({ frames, index, number: frame + index, due: time + index / rate, grounds });
    }
    this.at(now);
  }

  /**
   * Forgets the frames from a number on, which a command has changed.
   *
   * @param {number} number
   */
  discard(number) {
    while (this.held.length && this.held[this.held.length - 1].number >= number) this.held.pop();
  }

  /**
   * @param {number} now
   * @param {number} value
   */
  measure(now, value) {
    this.samples.push({ at: now, value });
    while (now - this.samples[0].at > REMEMBERED) this.samples.shift();
    const sorted = Float64Array.from(this.samples, (sample) => sample.value).sort();
    this.offset = sorted[0];
    this.lateness = sorted[Math.floor(FEW_LATER * (sorted.length - 1))] - this.offset;
  }

  /**
   * Returns what to show now; undefined before the first message. Frames that are over are dropped.
   *
   * @param {number} now by the client's clock
   * @returns {Moment | undefined}
   */
  at(now) {
    const { held } = this;
    if (!held.length) return undefined;
    const interval = 1 / held[held.length - 1].frames.rate;
    this.delay ??= interval + FIRST_LATENESS;
    const most = SLEW * Math.max(0, now - this.before);
    this.delay += Math.max(-most, Math.min(most, interval + this.lateness - this.delay));
    this.before = now;
    const moment = now - this.offset - this.delay;
    while (held.length > 1 && held[1].due <= moment) held.shift();
    const [a, b] = held;
    const isCut = !b || a.frames.rig !== b.frames.rig || (b.number > a.number + 1 && b.due - a.due > LONGEST_GAP);
    return { a, b: isCut ? undefined : b, share: isCut ? 0 : Math.max(0, Math.min(1, (moment - a.due) / (b.due - a.due))) };
  }
}
