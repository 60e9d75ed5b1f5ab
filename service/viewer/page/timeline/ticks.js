/** Where axes have their ticks. */

const STEPS = [0.02, 0.05, 0.1, 0.2, 0.5, 1, 2, 5, 10, 20, 30, 60];
const LABEL = 76; // pixels between labelled ticks
const MARK = 5; // pixels between ticks

/**
 * Returns seconds between labelled ticks and between small ones, which are frames where frames have room.
 *
 * @param {number} pixels of a second
 * @param {number} rate frames per second
 */
export function timeSteps(pixels, rate) {
  const major = STEPS.find((step) => step * pixels >= LABEL) ?? 60;
  const minor = [1 / rate, major / 10, major / 5, major / 2].find((step) => step * pixels >= MARK && step <= major) ?? major;
  return { major, minor };
}

/**
 * Yields the multiples of a step from one number to another.
 *
 * @param {number} from
 * @param {number} to
 * @param {number} step above 0
 */
export function* multiples(from, to, step) {
  const last = Math.floor(to / step + 1e-6);
  for (let number = Math.ceil(from / step - 1e-6); number <= last; number++) yield number * step;
}

const TOPS = [[1, 0.5], [1.5, 0.5], [2, 1], [3, 1], [4, 2], [6, 2], [8, 4], [10, 5]]; // and steps

/**
 * Returns the top of an axis that begins at 0, and its step: two or three steps, and little room above the values.
 *
 * @param {number} largest value
 * @param {number} least top
 */
export function axis(largest, least) {
  const most = Math.max(Number.isFinite(largest) ? largest : 0, least);
  const power = 10 ** Math.floor(Math.log10(most));
  const [top, step] = TOPS.find(([top]) => top * power >= most * (1 - 1e-6)) ?? TOPS[TOPS.length - 1];
  return { top: top * power, step: step * power };
}

/**
 * Writes a number without more digits than its step needs.
 *
 * @param {number} value
 * @param {number} step
 */
export function plain(value, step) {
  return value.toFixed(Math.max(0, Math.min(3, -Math.floor(Math.log10(step) + 1e-9))));
}

/** @param {ArrayLike<number>} values */
export function largest(values) {
  let most = 0;
  for (let at = 0; at < values.length; at++) if (values[at] > most) most = values[at]; // NaN is not
  return most;
}

const USUAL = 0.98; // share of the values
const FAR = 3; // times a usual value, from which others are outliers
const ROOM = 1.5; // times a usual value that are visible beside outliers

/**
 * Returns the largest value that an axis should show. A few outliers, as of a clip whose first frame is a T-pose, are cut off
 * so that the rest stays readable.
 *
 * @param {ArrayLike<number>[]} curves
 */
export function readable(curves) {
  const sorted = Float64Array.from(curves.flatMap((values) => Array.from(values)).filter((value) => !Number.isNaN(value))).sort();
  const most = sorted[sorted.length - 1] ?? 0, usual = sorted[Math.floor(USUAL * (sorted.length - 1))] ?? 0;
  return usual > 0 && most > FAR * usual ? ROOM * usual : most;
}
