/**
 * All that the page shows, as its address holds it: a link shows a colleague the same.
 *
 * @typedef {typeof DEFAULTS} Values
 * @typedef {keyof Values} Key
 */

export const DEFAULTS = {
  locomotion: '', // a clip; the baseline at first
  second: '', // a locomotion that is mixed in
  share: 0.5, // how much of it
  action: '', // a clip that gives the upper body; none at first
  hands: '',
  at: 0, // seconds after which the action is asked for
  when: 'now',
  start: 0,
  blend: 0,
  weight: 1,
  mask: 'upper_body',
  posture: 'relative',
  mirror: false, // whether left and right of the action are exchanged
  mirror_locomotion: false, // and of the locomotions
  lock_feet: false, // whether standing feet stay where they are
  look: false, // whether the head turns to the point
  chest: false, // and what else aims at it
  left_arm: false,
  right_arm: false,
  steady: false, // whether the hands of an aimed chest swivel less
  turned: 1, // how much of this is visible
  point: '', // metres; none: a little ahead of the character
  own: false, // whether the action plays by its own clock
  once: false, // whether the action ends instead of repeating
  length: 0, // seconds of the take; 0: as long as the locomotion, or as the action if that is longer
  show: 'splice,naive', // sides, see sides.js
  truth: '', // a clip that shows what the splice should be
  layout: 'beside', // or `over` each other
  against: '', // side from which distances are measured and coloured
  time: 0,
  from: 0, // what is repeated
  to: 0, // 0: to the end
  speed: 1,
  playing: true,
  view: 'free', // or front, side, top
  follow: true,
  camera: '', // place and target of the free camera
  body: 'mannequin', // or stick, or own: the user's character, which no link can hold
  trails: false,
  path: true,
  contacts: true,
  joint: '', // whose curves are shown
  crowd: 0, // characters that are shown instead, live; 0: none
};

/** The values of the page. Listeners hear which of them have changed, at most once a picture. */
export class State {
  /** @type {Set<(changed: Set<Key>) => void>} */
  #listeners = new Set();
  /** @type {Set<Key>} */
  #changed = new Set();
  /** @type {Values} */
  values;

  /** @param {URLSearchParams} query */
  constructor(query) {
    this.values = { ...DEFAULTS };
    for (const key of /** @type {Key[]} */ (Object.keys(DEFAULTS))) {
      const text = query.get(key);
      if (text !== null) this.#put(key, parsed(text, DEFAULTS[key]));
    }
    this.#changed.clear();
  }

  /**
   * Changes values. What is not a valid value of its kind is left as it is.
   *
   * @param {Partial<Values>} values
   */
  set(values) {
    const before = this.#changed.size;
    for (const [key, value] of Object.entries(values)) this.#put(/** @type {Key} */ (key), value);
    if (this.#changed.size && !before) queueMicrotask(() => this.#tell());
  }

  /** @param {(changed: Set<Key>) => void} listener */
  on(listener) {
    this.#listeners.add(listener);
  }

  /** Returns what the address needs: the values that differ from the defaults. */
  get query() {
    const query = new URLSearchParams();
    for (const [key, value] of Object.entries(this.values)) {
      const normal = DEFAULTS[/** @type {Key} */ (key)];
      if (value !== normal) query.set(key, typeof value === 'number' ? String(Number(value.toFixed(4))) : String(value));
    }
    return query;
  }

  #tell() {
    const changed = this.#changed;
    this.#changed = new Set();
    for (const listener of this.#listeners) listener(changed);
  }

  /**
   * @param {Key} key
   * @param {unknown} value
   */
  #put(key, value) {
    if (typeof value !== typeof DEFAULTS[key] || (typeof value === 'number' && !Number.isFinite(value)) || value === this.values[key]) return;
    Object.assign(this.values, { [key]: value });
    this.#changed.add(key);
  }
}

/**
 * @param {string} text
 * @param {string | number | boolean} normal
 */
function parsed(text, normal) {
  if (typeof normal === 'number') return Number(text);
  return typeof normal === 'boolean' ? text === 'true' : text;
}
