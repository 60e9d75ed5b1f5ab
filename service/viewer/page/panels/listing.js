import { centimetres, make } from './dom.js';

/** @import { Clip } from '../catalogue.js' */
/** @import { State } from '../state.js' */

/**
 * A list that offers clips for one value of the state.
 *
 * @typedef {object} Offer
 * @property {string} title
 * @property {'locomotion' | 'action' | 'hands'} key the value of the state that the list sets
 * @property {string} [none] label of the option for no clip; without it, a clip is always chosen
 */

const BADLY = 0.12; // metres: clips with a larger mean mismatch are marked
const LONG = 20; // letters of a name that needs lines of its own: takes differ in their last letters
const MARKS = /** @type {const} */ ({ second: 'mix', truth: 'truth' });

/**
 * One list of clips: a listbox whose selection follows the focus, so each arrow key plays the next clip.
 * While an arrow key is held down, only the focus moves; on release, the focused clip plays.
 */
export class Listing {
  /** @type {Map<string, HTMLElement>} */
  #options = new Map();
  /** @type {HTMLElement | undefined} */
  #active;
  #isHeld = false; // whether an arrow key repeats
  /** @type {string[]} */
  names = [];

  /**
   * @param {Offer} offer
   * @param {State} state
   * @param {(name: string, row: HTMLElement) => void} onMenu
   */
  constructor(offer, state, onMenu) {
    this.offer = offer;
    this.state = state;
    this.count = make('span', { class: 'count' });
    this.box = make('div', { role: 'listbox', 'aria-label': offer.title, class: 'options' });
    this.empty = make('p', { class: 'hint', hidden: true }, 'No clip has all these words.');
    this.element = make('section', { class: `listing ${offer.key}` }, make('h2', {}, offer.title, this.count), this.box, this.empty);
    this.box.addEventListener('click', (event) => {
      const row = rowOf(event);
      if (!row) return;
      if (event.target instanceof Element && event.target.closest('.more')) onMenu(nameOf(row), row);
      else this.choose(row);
    });
    this.box.addEventListener('contextmenu', (event) => {
      const row = rowOf(event);
      if (!row || !nameOf(row)) return;
      event.preventDefault();
      onMenu(nameOf(row), row);
    });
    this.box.addEventListener('keydown', (event) => this.#key(event));
    this.box.addEventListener('keyup', () => {
      if (this.#isHeld && this.#active) this.#play(this.#active);
      this.#isHeld = false;
    });
  }

  /**
   * Shows clips. A list without any is hidden.
   *
   * @param {string[]} names
   * @param {Map<string, Clip>} clips their details, where known
   */
  fill(names, clips) {
    const hadFocus = this.box.contains(document.activeElement);
    this.names = names;
    this.#options = new Map();
    if (this.offer.none) this.#options.set('', make('div', { role: 'option', tabindex: -1, class: 'none' }, this.offer.none));
    for (const name of names) this.#options.set(name, option(name, clips.get(name)));
    for (const [name, row] of this.#options) row.dataset.name = name;
    this.box.replaceChildren(...this.#options.values());
    this.element.hidden = !names.length;
    this.sync();
    if (hadFocus) this.#active?.focus();
  }

  /**
   * Shows only some of the clips.
   *
   * @param {Set<string>} names
   */
  filter(names) {
    let found = 0;
    for (const [name, row] of this.#options) {
      row.hidden = name !== '' && !names.has(name);
      if (name && !row.hidden) found += 1;
    }
    const total = this.names.length;
    this.count.textContent = found === total ? String(total) : `${found} of ${total}`;
    this.empty.hidden = found > 0;
    this.box.hidden = !this.#rows().length;
    if (this.#active?.hidden) this.#activate(this.#rows().find(nameOf) ?? this.#rows()[0]); // a clip that was found, before none
  }

  /** Shows which clip is chosen, which one is mixed in and which one is the truth. */
  sync() {
    const { values } = this.state;
    const chosen = values[this.offer.key];
    for (const [name, row] of this.#options) {
      const isChosen = name === chosen;
      if (row.ariaSelected !== String(isChosen)) row.ariaSelected = String(isChosen);
      if (isChosen && this.#active !== row) this.#activate(row);
      mark(row, values);
    }
    if (!this.#active?.isConnected) this.#activate(this.#rows()[0]);
  }

  /** @returns {string} name of the first clip that is visible, without the choice of none */
  get first() {
    const row = this.#rows().find(nameOf);
    return row ? nameOf(row) : '';
  }

  /**
   * Chooses the clip that is so many rows further.
   *
   * @param {number} by
   */
  step(by) {
    const row = this.#beside(by);
    if (row) this.choose(row);
  }

  /** @param {HTMLElement} row */
  choose(row) {
    const hasFocus = this.box.contains(document.activeElement);
    this.#activate(row);
    if (hasFocus) row.focus();
    this.#play(row);
  }

  /** Scrolls to the row that has the focus, or would get it. */
  reveal() {
    this.#active?.scrollIntoView?.({ block: 'nearest' });
  }

  /** Moves the focus into the list. */
  focus() {
    this.#active?.focus();
  }

  #rows() {
    return [...this.#options.values()].filter((row) => !row.hidden);
  }

  /** @param {number} by */
  #beside(by) {
    const rows = this.#rows();
    const now = this.#active ? rows.indexOf(this.#active) : -1;
    return rows[Math.max(0, Math.min(rows.length - 1, now + by))];
  }

  /** @param {HTMLElement | undefined} row */
  #activate(row) {
    if (this.#active) this.#active.tabIndex = -1;
    this.#active = row;
    if (!row) return;
    row.tabIndex = 0;
    this.reveal();
  }

  /** @param {HTMLElement} row */
  #play(row) {
    this.state.set({ [this.offer.key]: nameOf(row) });
  }

  /** @param {KeyboardEvent} event */
  #key(event) {
    if (event.ctrlKey || event.metaKey || event.altKey) return;
    const steps = { ArrowDown: 1, ArrowUp: -1, PageDown: 10, PageUp: -10, Home: -Infinity, End: Infinity };
    if (event.key === 'Enter' && this.#active) this.#play(this.#active);
    else if (event.key in steps) {
      const row = this.#beside(steps[/** @type {keyof typeof steps} */ (event.key)]);
      this.#activate(row);
      row?.focus();
      this.#isHeld = event.repeat;
      if (row && !event.repeat) this.#play(row);
    } else return;
    event.preventDefault();
  }
}

/**
 * @param {string} name
 * @param {Clip | undefined} clip
 */
function option(name, clip) {
  const row = make('div', { role: 'option', tabindex: -1, title: clip ? summary(clip).join('\n') : name }, make('span', { class: 'name' }, name));
  if (!clip) return row;
  row.classList.toggle('long', name.length > LONG);
  row.append(
    make('span', { class: 'marks' }),
    make('span', { class: 'sign' }, ...warningSign(clip)),
    clip.stands ? make('span', { class: 'mismatch' }, 'stands') : make('span', { class: clip.mean_mismatch > BADLY ? 'mismatch bad' : 'mismatch' },
      make('span', { class: 'unseen' }, ' mismatch '), centimetres(clip.mean_mismatch)),
    make('span', { class: 'seconds' }, ` ${clip.duration.toFixed(1)} s`),
    make('span', { class: 'more', 'aria-hidden': 'true', title: 'Mix in, compare as truth ... (Menu key)' }, '⋯'),
  );
  if (clip.tags.length) row.append(make('span', { class: 'tags' }, clip.tags.join(' · ')));
  return row;
}

/** @param {Clip} clip */
function warningSign({ warnings }) {
  if (!warnings.length) return [];
  return [make('span', { 'aria-hidden': 'true' }, '⚠'), make('span', { class: 'unseen' }, ` warning: ${warnings.join('; ')} `)];
}

/**
 * Marks a row as mixed in or as the truth.
 *
 * @param {HTMLElement} row
 * @param {{ second: string, truth: string }} values
 */
function mark(row, values) {
  const keys = /** @type {(keyof typeof MARKS)[]} */ (Object.keys(MARKS));
  const marks = keys.filter((key) => values[key] && values[key] === row.dataset.name).map((key) => MARKS[key]);
  if ((row.dataset.marks ?? '') === marks.join()) return;
  row.dataset.marks = marks.join();
  row.querySelector('.marks')?.replaceChildren(...marks.map((one) => make('span', { class: 'mark' }, one)));
}

/**
 * Describes a clip in a few lines. The first is its name.
 *
 * @param {Clip} clip
 */
export function summary(clip) {
  const names = [clip.name, ...clip.warnings.map((one) => `⚠ ${one}`)];
  const length = `${clip.duration.toFixed(2)} s at ${Number(clip.rate.toFixed(2))} frames/s`;
  if (clip.stands) {
    const uses = clip.uses.map((part) => part.replaceAll('_', ' ')).join(', ');
    return [...names, length, 'Captured standing: plays at its own speed', ...(uses ? [`Uses ${uses}`] : [])];
  }
  return [
    ...names,
    `${length}, ${clip.cycles.toFixed(1)} strides`,
    `Legs differ from the baseline's by ${centimetres(clip.mean_mismatch)} on average, ${centimetres(clip.worst_mismatch)} at worst`,
    clip.loop ? `Repeats by ${clip.loop} ${clip.loop === 1 ? 'stride' : 'strides'}` : 'Does not repeat',
  ];
}

/** @param {Event} event */
function rowOf(event) {
  const target = event.target instanceof Element ? event.target.closest('[role=option]') : null;
  return target instanceof HTMLElement ? target : undefined;
}

/** @param {HTMLElement} row */
function nameOf(row) {
  return row.dataset.name ?? '';
}
