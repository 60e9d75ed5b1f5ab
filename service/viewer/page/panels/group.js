import { DEFAULTS } from '../state.js';
import { button, make, newId } from './dom.js';
import { hint } from './fields.js';

/** @import { Field } from './fields.js' */
/** @import { Key, State, Values } from '../state.js' */

/** A group of fields under a heading that folds them, with a button that resets their values. */
export class Group {
  /**
   * @param {State} state
   * @param {string} title
   * @param {Key[]} keys the values that a reset sets to their defaults
   * @param {Field[]} fields
   * @param {(values: Values) => string} [reason] the reason if the fields have no effect, else an empty text
   */
  constructor(state, title, keys, fields, reason = () => '') {
    this.state = state;
    this.keys = keys;
    this.fields = fields;
    this.reason = reason;
    const id = newId();
    this.why = hint(state, reason);
    this.set = make('fieldset', { 'aria-label': title }, ...fields.map((field) => field.element));
    const body = make('div', { class: 'body', id }, this.why.element, this.set);
    const fold = button(title, () => {
      body.hidden = !body.hidden;
      fold.ariaExpanded = String(!body.hidden);
    }, { class: 'fold', 'aria-expanded': 'true', 'aria-controls': id });
    this.reset = button('Reset', () => {
      state.set(Object.fromEntries(keys.map((key) => [key, DEFAULTS[key]])));
      fold.focus({ preventScroll: true }); // the button disappears
    }, { class: 'reset', 'aria-label': `Reset ${title}` });
    this.element = make('section', { class: 'group' }, make('header', {}, make('h2', {}, fold), this.reset), body);
    this.sync();
  }

  sync() {
    const { values } = this.state;
    for (const field of [this.why, ...this.fields]) field.sync();
    this.reset.hidden = this.keys.every((key) => values[key] === DEFAULTS[key]);
    this.set.disabled = this.reason(values) !== '';
  }
}
