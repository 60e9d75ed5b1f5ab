import { matcher } from '../words.js';
import { make } from './dom.js';
import { Listing, summary } from './listing.js';
import { RowMenu } from './row_menu.js';

/** @import { Catalogue } from '../catalogue.js' */
/** @import { State } from '../state.js' */

/** The left column: a search field, the lists of locomotions, actions and hands, and details of the clip chosen last. */
export class Lists {
  /**
   * @param {HTMLElement} element
   * @param {Catalogue} catalogue
   * @param {State} state
   */
  constructor(element, catalogue, state) {
    this.catalogue = catalogue;
    this.state = state;
    this.menu = new RowMenu(state);
    /** @param {string} name @param {HTMLElement} row */
    const onMenu = (name, row) => this.menu.open(this.catalogue, name, row);
    this.locomotions = new Listing({ title: 'Locomotions', key: 'locomotion' }, state, onMenu);
    this.actions = new Listing({ title: 'Actions', key: 'action', none: 'No action' }, state, onMenu);
    this.hands = new Listing({ title: 'Hands', key: 'hands', none: "The clips' own hands" }, state, onMenu);
    this.all = [this.locomotions, this.actions, this.hands];
    /** The list that was used last. */
    this.current = this.actions;
    const label = 'Search clips and tags';
    this.search = make('input', { type: 'search', placeholder: label, 'aria-label': label, 'aria-keyshortcuts': '/' });
    this.details = make('div', { class: 'details' });
    const lists = this.all.map((one) => one.element);
    element.replaceChildren(make('div', { class: 'search' }, this.search), ...lists, this.details, this.menu.element);
    this.search.addEventListener('input', () => this.#filter());
    this.search.addEventListener('keydown', (event) => this.#key(event));
    for (const one of this.all) one.element.addEventListener('focusin', () => { this.current = one; });
    state.on((changed) => {
      for (const one of [this.locomotions, this.actions]) {
        const chosen = state.values[one.offer.key];
        if (this.catalogue.clips.has(chosen) && !one.names.includes(chosen)) this.#fill(one);
      }
      if (changed.has('locomotion') || changed.has('action')) this.#fillHands();
      this.#sync();
    });
    this.reload(catalogue);
  }

  /**
   * Shows other clips, after the bank has changed.
   *
   * @param {Catalogue} catalogue
   */
  reload(catalogue) {
    this.catalogue = catalogue;
    for (const one of [this.locomotions, this.actions]) this.#fill(one);
    this.#fillHands();
    this.#sync();
    for (const one of this.all) one.reveal(); // now that each list has the room that it keeps
  }

  /**
   * Plays the next or previous clip of the list that was used last.
   *
   * @param {number} by
   */
  step(by) {
    (this.current.element.hidden ? this.actions : this.current).step(by);
  }

  /** Moves the focus to the search. */
  find() {
    this.search.focus();
    this.search.select();
  }

  /**
   * Offers the clips of a list's kind. Any clip can be the locomotion or the action, so a list also offers its current choice, and
   * all clips if the bank has none of its kind.
   *
   * @param {Listing} list
   */
  #fill(list) {
    const { clips } = this.catalogue;
    const { key } = list.offer;
    const own = [...clips.values()].filter((clip) => clip.kind === key).map((clip) => clip.name);
    const names = own.length ? own : [...clips.keys()];
    const chosen = this.state.values[key];
    list.fill(clips.has(chosen) && !names.includes(chosen) ? [...names, chosen] : names, clips);
  }

  /** Offers the hands that fit the action or the locomotion. */
  #fillHands() {
    const { action, locomotion, hands } = this.state.values;
    const names = [...new Set([action, locomotion].flatMap((name) => this.catalogue.clips.get(name)?.hands ?? []))];
    this.hands.fill(names, new Map());
    if (hands && !names.includes(hands)) this.state.set({ hands: '' });
    this.#filter();
  }

  #filter() {
    const names = new Set(this.catalogue.search(this.search.value).map((clip) => clip.name));
    this.locomotions.filter(names);
    this.actions.filter(names);
    this.hands.filter(new Set(this.hands.names.filter(matcher(this.search.value))));
  }

  #sync() {
    for (const one of this.all) one.sync();
    const { values } = this.state;
    const { clips } = this.catalogue;
    const clip = clips.get(values[this.current.offer.key]) ?? clips.get(values.action) ?? clips.get(values.locomotion);
    const [name, ...lines] = clip ? summary(clip) : [''];
    const text = [name, ...lines].join('\n');
    if (this.details.dataset.text === text) return;
    this.details.dataset.text = text;
    const paragraphs = lines.map((line) => make('p', { class: line.startsWith('⚠') ? 'warning' : '' }, line));
    this.details.replaceChildren(make('strong', {}, name), ...paragraphs);
  }

  /** @param {KeyboardEvent} event */
  #key(event) {
    if (event.key === 'Escape') {
      if (this.search.value) this.search.value = '';
      else this.search.blur();
      this.#filter();
    } else if (event.key === 'ArrowDown') {
      this.#found?.focus();
    } else if (event.key === 'Enter') {
      const list = this.#found;
      if (list?.first) this.state.set({ [list.offer.key]: list.first });
    } else return;
    event.preventDefault();
  }

  /** The list used last if the search finds a clip in it, else the first list with a match. */
  get #found() {
    return [this.current, ...this.all].find((one) => !one.element.hidden && one.first);
  }
}
