import { withSide } from './compared.js';
import { button, make } from './dom.js';

/** @import { Catalogue } from '../catalogue.js' */
/** @import { State, Values } from '../state.js' */

/** The menu of a clip: mix it in, compare it as the truth, or play it as the locomotion or the action. */
export class RowMenu {
  /** @type {HTMLElement | undefined} */
  #row;

  /** @param {State} state */
  constructor(state) {
    this.state = state;
    this.element = make('div', { class: 'menu', popover: 'auto', role: 'menu' });
    this.element.addEventListener('keydown', (event) => this.#key(event));
  }

  /**
   * @param {Catalogue} catalogue
   * @param {string} name
   * @param {HTMLElement} row that it belongs to
   */
  open(catalogue, name, row) {
    const clip = catalogue.clips.get(name);
    if (!clip) return;
    const { values } = this.state;
    this.#row = row;
    this.element.ariaLabel = name;
    this.element.replaceChildren(
      values.second === name
        ? this.#item('No longer mix in', { second: '' })
        : this.#item('Mix in with the locomotion', { second: name }, name === values.locomotion),
      values.truth === name
        ? this.#item('No longer compare as truth', { truth: '', show: withSide(values.show, 'truth', false) })
        : this.#item('Compare as truth', { truth: name, show: withSide(values.show, 'truth', true) }),
      this.#item('Play as locomotion', { locomotion: name }, values.locomotion === name),
      this.#item('Play as action', { action: name }, values.action === name),
    );
    this.element.showPopover();
    const { left, bottom, top } = row.getBoundingClientRect();
    const { offsetHeight, offsetWidth } = this.element;
    this.element.style.left = `${Math.max(4, Math.min(left + 16, innerWidth - offsetWidth - 4))}px`;
    this.element.style.top = `${bottom + offsetHeight < innerHeight ? bottom : Math.max(4, top - offsetHeight)}px`;
    this.#items[0]?.focus();
  }

  /** @returns {HTMLButtonElement[]} */
  get #items() {
    return [...this.element.querySelectorAll('button')].filter((one) => !one.disabled);
  }

  /**
   * @param {string} label
   * @param {Partial<Values>} values
   * @param {boolean} [isDone] whether the state has these values already
   */
  #item(label, values, isDone = false) {
    return button(label, () => {
      this.state.set(values);
      this.#close();
    }, { role: 'menuitem', disabled: isDone, tabindex: '-1' });
  }

  #close() {
    this.element.hidePopover();
    this.#row?.focus();
  }

  /** @param {KeyboardEvent} event */
  #key(event) {
    const items = this.#items;
    const now = items.findIndex((one) => one === document.activeElement);
    if (event.key === 'ArrowDown') items[(now + 1) % items.length]?.focus();
    else if (event.key === 'ArrowUp') items[(now - 1 + items.length) % items.length]?.focus();
    else if (event.key === 'Escape' || event.key === 'Tab') this.#close();
    else return;
    event.preventDefault();
  }
}
