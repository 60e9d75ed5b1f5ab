/** What the page computes from the report: its columns, their order, and the links to the viewer. */

import { matcher } from '../words.js';

/**
 * @typedef {object} Method
 * @property {string} method
 * @property {number | null} error cm
 * @property {number | null} worst_error cm, 95th percentile
 * @property {number | null} ratio
 * @property {number | null} posture degrees
 * @property {number | null} lag degrees of a stride
 * @property {number | null} jitter
 * @property {number | null} mismatch cm
 */

/**
 * @typedef {object} Pair
 * @property {string} locomotion
 * @property {string} action
 * @property {string} truth
 * @property {string} example
 * @property {number | null} oracle cm
 * @property {number | null} floor cm
 * @property {Method[]} methods
 * @property {'error' | 'legs'} measure
 * @property {Record<string, number[]>} over_time cm
 * @property {{ time: number, value: number }} worst
 */

/** @typedef {{ what: string, found: string, wanted: string, met: boolean }} Target */
/** @typedef {{ bank: string, version: string, rate: number, targets: Target[], pairs: Pair[] }} Report */

/**
 * A column of numbers. `bounds` are the values up to which a number is good, and fair.
 *
 * @typedef {object} Column
 * @property {string} key
 * @property {string} label
 * @property {string} help
 * @property {number} digits
 * @property {[number, number]} [bounds]
 * @property {(pair: Pair) => number | null | undefined} value
 */

/** @param {string} name @param {keyof Method} key @returns {(pair: Pair) => number | null | undefined} */
const of = (name, key) => (pair) => /** @type {number | null | undefined} */ (pair.methods.find(({ method }) => method === name)?.[key]);

/** @type {Column[]} */
export const COLUMNS = [
  { key: 'worst', label: 'Worst\ncm', digits: 1, help: 'Value at the worst moment', value: (pair) => pair.worst.value },
  { key: 'naive', label: 'Naive\ncm', digits: 1, help: 'Mean error of plain replacement: how far its upper body is from the truth', value: of('naive', 'error') },
  { key: 'splice', label: 'Splice\ncm', digits: 1, help: "Mean error of the bank's splice", value: of('splice', 'error') },
  { key: 'high', label: 'p95\ncm', digits: 1, help: "95th percentile of the splice's error", value: of('splice', 'worst_error') },
  { key: 'ratio', label: 'Ratio', digits: 2, bounds: [0.45, 0.7], help: "The splice's error divided by plain replacement's", value: of('splice', 'ratio') },
  { key: 'floor', label: 'Floor\ncm', digits: 1, help: 'How much the truth differs from itself one stride later', value: (pair) => pair.floor },
  { key: 'oracle', label: 'Oracle\ncm', digits: 1, help: 'Error of a splice that knows the truth and picks the best frames', value: (pair) => pair.oracle },
  { key: 'lag', label: 'Lag\n°', digits: 0, bounds: [15, 30], help: "Timing of the arms from the truth's (or the locomotion's), in degrees of a stride", value: of('splice', 'lag') },
  { key: 'legs', label: 'Legs\ncm', digits: 1, help: 'Distance of the legs at aligned frames', value: of('splice', 'mismatch') },
  { key: 'posture', label: 'Posture\n°', digits: 1, bounds: [1.5, 3], help: 'Angle from the posture that the form promises', value: of('splice', 'posture') },
  { key: 'jitter', label: 'Jitter', digits: 2, bounds: [1.1, 1.5], help: "Jerk of the neck divided by the larger source's", value: of('splice', 'jitter') },
];

/**
 * @param {Column} column
 * @param {number} value
 * @returns {'' | 'good' | 'fair' | 'bad'}
 */
export function grade({ bounds }, value) {
  if (!bounds) return '';
  return value <= bounds[0] ? 'good' : value <= bounds[1] ? 'fair' : 'bad';
}

/**
 * Returns the pairs in the order of a column; those without a value come last either way.
 *
 * @param {Pair[]} pairs
 * @param {string} key of a column, `locomotion` or `action`
 * @param {boolean} isDown from the largest
 */
export function sorted(pairs, key, isDown) {
  const sign = isDown ? -1 : 1;
  const column = COLUMNS.find((one) => one.key === key);
  if (!column) {
    const name = (/** @type {Pair} */ pair) => (key === 'action' ? `${pair.action}\0${pair.locomotion}` : `${pair.locomotion}\0${pair.action}`);
    return [...pairs].sort((a, b) => sign * name(a).localeCompare(name(b), undefined, { numeric: true }));
  }
  return [...pairs].sort((a, b) => {
    const [one, other] = [column.value(a) ?? null, column.value(b) ?? null];
    if (one === null || other === null) return Number(one === null) - Number(other === null);
    return sign * (one - other);
  });
}

/**
 * Returns the pairs that have all words of a text in the names of their clips or in their title.
 *
 * @param {Pair[]} pairs
 * @param {string} text
 */
export function filtered(pairs, text) {
  const matches = matcher(text);
  return pairs.filter(({ locomotion, action, truth, example }) => matches([locomotion, action, truth, example].join(' ')));
}

/**
 * Returns the mean of a column over the pairs that have a value; undefined if none has.
 *
 * @param {Pair[]} pairs
 * @param {string} key
 */
export function meanOf(pairs, key) {
  const column = COLUMNS.find((one) => one.key === key);
  const values = pairs.map((pair) => column?.value(pair)).filter((value) => typeof value === 'number');
  return values.length ? values.reduce((sum, value) => sum + value, 0) / values.length : undefined;
}

/**
 * Returns the address of the viewer at a moment of a pair; undefined if the bank does not have its clips.
 *
 * @param {Pair} pair
 * @param {{ has(name: string): boolean }} clips of the bank that is served
 * @param {number} [time] seconds
 */
export function linkTo(pair, clips, time = pair.worst.time) {
  const { locomotion, action, truth, measure } = pair;
  if (!clips.has(locomotion) || !clips.has(action)) return undefined;
  const query = new URLSearchParams({ locomotion, action });
  if (clips.has(truth)) {
    query.set('truth', truth);
    query.set('show', 'splice,naive,truth');
  }
  if (measure === 'error') query.set('against', clips.has(truth) ? 'truth' : 'naive');
  query.set('time', String(Number(time.toFixed(4))));
  query.set('playing', 'false');
  return `./?${query}`;
}
