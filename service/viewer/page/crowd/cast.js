/** Who is in a crowd, and where. All of it follows from a character's number, so a link shows the same crowd. */

/** @import { Clip } from '../catalogue.js' */

/**
 * One character of a crowd.
 *
 * @typedef {object} Member
 * @property {string} locomotion
 * @property {string | undefined} action undefined if the bank has none
 * @property {number} time seconds into the locomotion at which it begins, so that no two are in step
 * @property {number} heading radians
 * @property {number} colour index of the locomotion, so that all who walk alike have one colour
 */

const APART = 1.5; // metres between neighbours
const STRAY = 0.28; // metres by which they are off the grid
const TURN = 0.5; // radians to either side

/** @typedef {{ locomotions: Clip[], actions: Clip[] }} Repertoire what a crowd can play, by name */

/**
 * @param {Iterable<Clip>} clips of the bank
 * @returns {Repertoire}
 */
export function repertoireOf(clips) {
  const sorted = [...clips].sort((a, b) => (a.name < b.name ? -1 : 1));
  return { locomotions: sorted.filter(({ kind }) => kind === 'locomotion'), actions: sorted.filter(({ kind }) => kind === 'action') };
}

/**
 * Returns a character of a crowd. A larger crowd has the characters of a smaller one, and more.
 *
 * @param {number} number from 0
 * @param {Repertoire} repertoire
 * @returns {Member}
 */
export function member(number, { locomotions, actions }) {
  const random = generator(number);
  const colour = Math.floor(random() * locomotions.length);
  const { name, duration } = locomotions[colour];
  return {
    locomotion: name, time: random() * duration, colour, action: actions[Math.floor(random() * actions.length)]?.name, heading: (2 * random() - 1) * TURN,
  };
}

/**
 * Returns where a character of a crowd stands: on a grid around the origin, a little off its place.
 *
 * @param {number} number from 0
 * @param {number} count of the crowd
 * @returns {[number, number]} x and z in metres
 */
export function placeOf(number, count) {
  if (count === 1) return [0, 0];
  const columns = Math.ceil(Math.sqrt(count)), rows = Math.ceil(count / columns);
  const random = generator(number + 0.5);
  const x = (number % columns) - (columns - 1) / 2, z = Math.floor(number / columns) - (rows - 1) / 2;
  return [APART * x + (2 * random() - 1) * STRAY, APART * z + (2 * random() - 1) * STRAY];
}

/** Metres from one side of a crowd to the other. @param {number} count */
export function widthOf(count) {
  return APART * (Math.ceil(Math.sqrt(count)) - 1);
}

/**
 * Returns a function that returns random numbers from 0 to 1: the same ones for the same seed (mulberry32).
 *
 * @param {number} seed
 */
function generator(seed) {
  let state = Math.imul(2 * seed + 1, 0x9e3779b1);
  return () => {
    state = (state + 0x6d2b79f5) | 0;
    let bits = Math.imul(state ^ (state >>> 15), state | 1);
    bits ^= bits + Math.imul(bits ^ (bits >>> 7), bits | 61);
    return ((bits ^ (bits >>> 14)) >>> 0) / 2 ** 32;
  };
}
