/** @import { Player } from '../player.js' */

const SHORTEST = 8; // frames that are visible at least

/** @type {WeakMap<Player, Span>} */
const spans = new WeakMap();

/** The visible seconds. All time axes of a player share them, so that a moment is at the same place in all of them. */
export class Span {
  from = 0;
  to = 1;
  /** @type {Set<() => void>} */
  #listeners = new Set();

  /** @param {Player} player */
  constructor(player) {
    this.player = player;
    this.duration = 1;
  }

  /** @param {Player} player */
  static of(player) {
    const span = spans.get(player) ?? new Span(player);
    spans.set(player, span);
    return span;
  }

  /** @param {() => void} changed */
  on(changed) {
    this.#listeners.add(changed);
  }

  get isWhole() {
    return this.from <= 0 && this.to >= this.duration;
  }

  /**
   * Takes the duration of another motion. Keeps the visible seconds if they are zoomed in and within it, else shows all.
   *
   * @param {number} duration seconds
   */
  resize(duration) {
    const wasWhole = this.isWhole;
    this.duration = Math.max(duration, 1e-3);
    if (wasWhole || this.to > this.duration) this.#set(0, this.duration);
  }

  /** Shows all. */
  fit() {
    this.#set(0, this.duration);
  }

  /**
   * Shows more or less, and keeps a moment where it is.
   *
   * @param {number} moment seconds
   * @param {number} factor above 1 shows more
   */
  zoom(moment, factor) {
    const shortest = Math.min(this.duration, SHORTEST / this.player.rate);
    const length = Math.max(shortest, Math.min(this.duration, (this.to - this.from) * factor));
    const share = (moment - this.from) / (this.to - this.from);
    this.#place(moment - share * length, length);
  }

  /** @param {number} seconds */
  pan(seconds) {
    this.#place(this.from + seconds, this.to - this.from);
  }

  /**
   * Turns the page when a moment is not visible.
   *
   * @param {number} moment
   */
  reveal(moment) {
    const length = this.to - this.from;
    if (moment < this.from || moment > this.to) this.#place(moment - 0.05 * length, length);
  }

  /**
   * @param {number} from
   * @param {number} length
   */
  #place(from, length) {
    const first = Math.max(0, Math.min(this.duration - length, from));
    this.#set(first, first + length);
  }

  /**
   * @param {number} from
   * @param {number} to
   */
  #set(from, to) {
    if (from === this.from && to === this.to) return;
    this.from = from;
    this.to = to;
    for (const changed of this.#listeners) changed();
  }
}
