/** Reads curves over frames that have gaps and jumps. */

const BACK = 1.5; // frames by which a clock that goes back has looped
const MOST = 0.45; // strides in a frame; more is a cut

/**
 * Returns the first and last frames of each part of an action's clock. It is cut where the action is missing, and where it
 * loops.
 *
 * @param {ArrayLike<number>} times seconds into the action at each frame; NaN without one
 * @param {number} rate frames per second
 * @returns {[number, number][]}
 */
export function clockPieces(times, rate) {
  return pieces(times, (before, after) => after < before - BACK / rate || after > before + 0.5);
}

/**
 * Returns the first and last frames of the parts of a curve that have values.
 *
 * @param {ArrayLike<number>} values
 * @param {(before: number, after: number) => boolean} [isCut] between two values
 * @returns {[number, number][]}
 */
export function pieces(values, isCut = () => false) {
  /** @type {[number, number][]} */
  const found = [];
  let first = -1;
  for (let frame = 0; frame <= values.length; frame++) {
    const isThere = frame < values.length && !Number.isNaN(values[frame]);
    const goesOn = isThere && first >= 0 && !(frame > first && isCut(values[frame - 1], values[frame]));
    if (first >= 0 && !goesOn) found.push([first, frame - 1]);
    if (!isThere) first = -1;
    else if (!goesOn) first = frame;
  }
  return found;
}

/**
 * Returns how fast an action's clock runs at a frame: 1 is as captured; NaN without an action.
 *
 * @param {[number, number][]} parts of the clock, see `clockPieces`
 * @param {ArrayLike<number>} times
 * @param {number} rate
 * @param {number} frame
 */
export function pace(parts, times, rate, frame) {
  const piece = parts.find(([first, last]) => first <= frame && frame <= last);
  if (!piece || piece[0] === piece[1]) return NaN;
  const before = Math.max(piece[0], frame - 1), after = Math.min(piece[1], frame + 1);
  return ((times[after] - times[before]) * rate) / (after - before);
}

/**
 * Whether a moment is within one of some intervals.
 *
 * @param {[number, number][]} intervals seconds
 * @param {number} time
 */
export function isWithin(intervals, time) {
  return intervals.some(([from, to]) => from <= time + 1e-4 && time <= to + 1e-4);
}

/**
 * Returns the phase as ramps from 0 to 1, one a stride: places in frames, and levels. A locomotion that loops goes back by
 * whole strides, which does not break a ramp.
 *
 * @param {ArrayLike<number>} phases strides at each frame
 */
export function ramps(phases) {
  /** @type {[number, number][][]} */
  const found = [];
  let level = NaN;
  for (let frame = 0; frame < phases.length; frame++) {
    const fraction = phases[frame] - Math.floor(phases[frame]);
    const change = phases[frame] - phases[frame - 1]; // NaN at first
    const step = change - (change < 0 ? Math.floor(change) : 0);
    if (step < MOST && level + step >= 1) {
      const crossing = frame - 1 + (1 - level) / step;
      found[found.length - 1].push([crossing, 1]);
      found.push([[crossing, 0]]);
    } else if (!(step < MOST)) found.push([]);
    found[found.length - 1].push([frame, fraction]);
    level = fraction;
  }
  return found;
}

/**
 * Returns a repeated range of whole frames, as the state holds it: 0 and 0 for all, and 0 as the end for the last frame.
 *
 * @param {number} a seconds, in any order
 * @param {number} b
 * @param {number} duration
 * @param {number} rate
 */
export function rangeOf(a, b, duration, rate) {
  const [from, to] = [Math.min(a, b), Math.max(a, b)].map((time) => Math.round(Math.max(0, Math.min(duration, time)) * rate) / rate);
  return { from, to: to >= duration - 0.5 / rate ? 0 : to };
}
