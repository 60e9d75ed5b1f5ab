/** @import { State } from './state.js' */

/** The time that is shown: played, repeated, scrubbed or stepped. */
export class Player {
  rate = 60; // frames per second of what is shown
  duration = 0; // seconds
  #time = 0;

  /** @param {State} state */
  constructor(state) {
    this.state = state;
    this.#time = state.values.time;
  }

  get time() {
    return this.#time;
  }

  /** What is repeated: from and to, in seconds. All, if the range begins after the end. @returns {[number, number]} */
  get range() {
    const { from, to } = this.state.values;
    if (from < 0 || from >= this.duration) return [0, this.duration];
    return [from, to > from ? Math.min(to, this.duration) : this.duration];
  }

  /**
   * Plays another motion, at the same time if it is as long.
   *
   * @param {number} rate frames per second
   * @param {number} duration seconds
   */
  begin(rate, duration) {
    this.rate = rate;
    this.duration = duration;
    this.#time = Math.max(0, Math.min(duration, this.#time));
  }

  /**
   * Moves on by the seconds that have passed. Returns the time.
   *
   * @param {number} passed
   */
  advance(passed) {
    if (!this.state.values.playing) return this.#time;
    const [from, to] = this.range;
    this.#time += passed * this.state.values.speed;
    if (this.#time > to || this.#time < from) this.#time = to > from ? from + ((this.#time - from) % (to - from) + (to - from)) % (to - from) : from;
    return this.#time;
  }

  /**
   * Shows a moment, and stays there.
   *
   * @param {number} time
   */
  seek(time) {
    this.#time = Math.max(0, Math.min(this.duration, time));
    this.state.set({ time: this.#time, playing: false });
  }

  /**
   * Returns the time of the nearest frame.
   *
   * @param {number} time
   */
  whole(time) {
    return Math.max(0, Math.min(this.duration, Math.round(time * this.rate) / this.rate));
  }

  /**
   * Shows the frame that is so many frames later.
   *
   * @param {number} frames
   */
  step(frames) {
    this.seek((Math.round(this.#time * this.rate) + frames) / this.rate);
  }

  /** Plays, or pauses at the frame that is shown. */
  toggle() {
    if (this.state.values.playing) this.seek(this.whole(this.#time));
    else this.state.set({ playing: true });
  }
}
