import { SIDES, SIDE_NAMES, takeOf } from '../takes.js';
import { make, swatch } from './dom.js';

/** @import { Catalogue } from '../catalogue.js' */
/** @import { State } from '../state.js' */
/** @import { SideName } from '../takes.js' */
/** @import { Field } from './fields.js' */

const MISSING = { splice: 'no action', naive: 'no action', locomotion: '', action: 'no action', truth: 'no clip' };

/**
 * Shows a side, or hides it.
 *
 * @param {State} state
 * @param {SideName} side
 */
export function toggleSide(state, side) {
  const { show } = state.values;
  state.set({ show: withSide(show, side, !show.split(',').includes(side)) });
}

/**
 * Returns which sides are shown, with or without one, in their order.
 *
 * @param {string} show
 * @param {SideName} side
 * @param {boolean} isShown
 */
export function withSide(show, side, isShown) {
  const shown = show.split(',');
  return SIDE_NAMES.filter((name) => (name === side ? isShown : shown.includes(name))).join(',');
}

/**
 * Returns the checkboxes of all sides, each with its colour, its key, and the reason if it has nothing to show.
 *
 * @param {State} state
 * @param {() => Catalogue} catalogue
 * @returns {Field}
 */
export function sidesField(state, catalogue) {
  const rows = SIDE_NAMES.map((side, number) => {
    const input = make('input', { type: 'checkbox' });
    input.addEventListener('change', () => toggleSide(state, side));
    const why = make('span', { class: 'why' });
    const key = make('kbd', { 'aria-hidden': 'true' }, String(number + 1));
    const label = make('span', {}, SIDES[side].label);
    return { side, input, why, element: make('label', { class: 'toggle side' }, input, swatch(SIDES[side].colour), label, why, key) };
  });
  return {
    element: make('div', { class: 'sides', role: 'group', 'aria-label': 'Motions that are shown' }, ...rows.map((one) => one.element)),
    sync: () => {
      const shown = state.values.show.split(',');
      for (const { side, input, why } of rows) {
        input.checked = shown.includes(side);
        why.textContent = takeOf(side, state.values, catalogue()) ? '' : MISSING[side];
      }
    },
  };
}
